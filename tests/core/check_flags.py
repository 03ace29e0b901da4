"""Nothing that ships is compiled with -ffast-math (it would change the floating-point mode of the whole
host) or -march=native (it would run on this machine alone).

    check_flags.py COMPILE_COMMANDS FOLDER...     sources below these folders count
"""
import json
import pathlib
import sys

FORBIDDEN = ("-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-march=native", "-mcpu=native")


def main(database, folders):
    shipped = [c for c in json.loads(pathlib.Path(database).read_text())
               if any(pathlib.Path(c["file"]).is_relative_to(folder) for folder in folders)]
    if not shipped:
        sys.exit("no source of those folders in " + database)
    wrong = [f"{c['file']}: {flag}" for c in shipped for flag in FORBIDDEN if flag in c["command"]]
    if wrong:
        sys.exit("\n".join(wrong))


main(sys.argv[1], sys.argv[2:])
