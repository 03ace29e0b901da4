"""Writes one source file that includes several test files, each in its own namespace, so that their names
do not clash:

    combine_tests.py OUTPUT SOURCE...

The headers that the files include come first; the files' own #include lines then have no effect
(#pragma once). A namespace of tactus that a file opens would hide the outer one of that name, so it is
defined before, with a using-directive for the hidden namespace.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^#include ["<].*$', re.MULTILINE)
NAMESPACE = re.compile(r"^namespace (tactus(?:::\w+)*) \{", re.MULTILINE)


def outer_names(text):
    """Declarations that make the hidden outer namespaces visible in each opened namespace."""
    lines = []
    for name in sorted(set(NAMESPACE.findall(text))):
        parts = name.split("::")
        for count in range(1, len(parts) + 1):
            path = "::".join(parts[:count])
            lines.append(f"namespace {path} {{ using namespace ::{path}; }}")
    return list(dict.fromkeys(lines))


def combined(sources):
    """The text of the combined source file."""
    texts = {source: source.read_text(encoding="utf-8") for source in sources}
    lines = list(dict.fromkeys(line for text in texts.values() for line in INCLUDE.findall(text)))
    for number, (source, text) in enumerate(texts.items()):
        lines += [f"namespace file_{number} {{", *outer_names(text), f'#include "{source}"', "}"]
    return "\n".join([*lines, ""])


def main():
    output, *sources = map(pathlib.Path, sys.argv[1:])
    text = combined(sources)
    if not output.exists() or output.read_text(encoding="utf-8") != text:
        output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
