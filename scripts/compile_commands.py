#!/usr/bin/env python3
"""Writes BUILD/sources/compile_commands.json with a command for each source file. In CMake's own
BUILD/compile_commands.json files that are compiled together (cmake/CombinedSources.cmake) share one command.

    compile_commands.py [BUILD]
"""
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
SOURCE = re.compile(r'^#include "(/[^"]+\.cpp)"$', re.MULTILINE)


def each_source(entries):
    """The entries, with each combined file replaced by one entry per file that it includes."""
    for entry in entries:
        path = pathlib.Path(entry["file"])
        sources = SOURCE.findall(path.read_text(encoding="utf-8")) if path.is_file() else []
        if not sources:
            yield entry
        for source in sources:
            output = re.sub(r" -o \S+", f" -o {path.stem}/{pathlib.Path(source).name}.o", entry["command"])
            yield {**entry, "file": source, "command": output.replace(f" -c {path}", f" -c {source}")}


def write_commands(build):
    """Writes the list if it has changed; returns its path."""
    entries = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    written = build / "sources/compile_commands.json"
    text = json.dumps(list(each_source(entries)), indent=1)
    if not written.exists() or written.read_text(encoding="utf-8") != text:
        written.parent.mkdir(exist_ok=True)
        written.write_text(text, encoding="utf-8")
    return written


if __name__ == "__main__":
    write_commands(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build")
