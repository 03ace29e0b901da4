#!/usr/bin/env python3
"""Checks that every C and C++ file is formatted as by clang-format 14 with .clang-format. Status 1 if a file is not, 77
if clang-format-14 is missing.

    check_format.py           the whole checkout
    check_format.py FILE...   these files
    check_format.py --fix     formats the files
"""
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys

from source_files import C_FAMILY, ROOT, source_files

TOOL = "clang-format-14"  # other versions format differently
FILES_A_RUN = 40


def main(arguments):
    fix = "--fix" in arguments
    names = [argument for argument in arguments if argument != "--fix"] or \
        [str(ROOT / name) for name in source_files()]
    names = [name for name in names if pathlib.Path(name).suffix in C_FAMILY]
    if not shutil.which(TOOL):
        print(f"{TOOL} is missing: install Debian's {TOOL}")
        return 77

    def run(some):
        words = [TOOL, "-i"] if fix else [TOOL, "--dry-run", "-Werror", "--ferror-limit=1"]
        return subprocess.run(words + some, check=False).returncode

    runs = [names[i:i + FILES_A_RUN] for i in range(0, len(names), FILES_A_RUN)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        failed = any(list(pool.map(run, runs)))
    if failed:
        print("Not formatted; run `scripts/check_format.py --fix`")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
