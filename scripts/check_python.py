#!/usr/bin/env python3
"""Checks that each Python FILE parses; without a FILE, all files of the checkout. Names the line that does not parse;
status 1."""
import ast
import pathlib
import sys

from source_files import ROOT, source_files


def main(names):
    failed = False
    for name in names or [ROOT / name for name in source_files() if name.suffix == ".py"]:
        try:
            ast.parse(pathlib.Path(name).read_bytes(), filename=str(name))
        except SyntaxError as error:
            print(f"{name}:{error.lineno}: {error.msg}")
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
