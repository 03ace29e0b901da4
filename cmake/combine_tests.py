"""Writes one source file that includes several test files, each in a namespace of its own, so that
names of one are none of another:

    combine_tests.py OUTPUT SOURCE...

The headers that the files include come first; their own #include lines then find them read already
(#pragma once). A namespace of tactus that a file opens would hide the one of that name outside, so it
is made before, with a using-directive for what it hides.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^#include ["<].*$', re.MULTILINE)
NAMESPACE = re.compile(r"^namespace (tactus(?:::\w+)*) \{", re.MULTILINE)


def outer_names(text):
    """Declarations that let each opened namespace see the one that it hides."""
    lines = []
    for name in sorted(set(NAMESPACE.findall(text))):
        parts = name.split("::")
        for count in range(1, len(parts) + 1):
            path = "::".join(parts[:count])
            lines.append(f"namespace {path} {{ using namespace ::{path}; }}")
    return list(dict.fromkeys(lines))


def combined(sources):
    """The text of the file that stands for these sources."""
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
