"""Nothing that ships is compiled with -ffast-math (it would change the floating-point mode of the whole
host) or -march=native (it would run on this machine alone).

    check_flags.py BUILD FOLDER...     sources below these folders count
"""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from compile_commands import write_commands  # noqa: E402

FORBIDDEN = ("-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-march=native", "-mcpu=native")


def main(build, folders):
    shipped = [c for c in json.loads(write_commands(pathlib.Path(build)).read_text())
               if any(pathlib.Path(c["file"]).is_relative_to(folder) for folder in folders)]
    if not shipped:
        sys.exit("no source of those folders is compiled in " + build)
    wrong = [f"{c['file']}: {flag}" for c in shipped for flag in FORBIDDEN if flag in c["command"]]
    if wrong:
        sys.exit("\n".join(wrong))


main(sys.argv[1], sys.argv[2:])
