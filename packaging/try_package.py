#!/usr/bin/env python3
"""Tries a package as its users do: unpacks it, loads every object in Pd, renders every help patch.

    try_package.py PACKAGE.dek [--pd COMMAND] [--renders TABLE.tsv]

Needs Python and Pd (Debian: puredata-core, or puredata64-core with --pd pd64), nothing else. TABLE gets the hash of each help patch's
sound, to be compared with another system's by `scripts/hash_renders.py --compare`. Status 0 when every
object was made and everything that was rendered is a sound.
"""
import argparse
import hashlib
import pathlib
import shlex
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
QUIET = ["-nogui", "-batch", "-noprefs", "-nosound", "-nrt", "-stderr"]


def unpack(package, folder):
    """The library folder of a package; it must be what its .sha256 says."""
    beside = package.with_name(package.name + ".sha256")
    digest = hashlib.sha256(package.read_bytes()).hexdigest()
    if beside.exists() and beside.read_text().strip() != digest:
        sys.exit(f"{package}: its SHA-256 is {digest}, and {beside.name} says otherwise")
    with zipfile.ZipFile(package) as archive:
        archive.extractall(folder)
    tops = [path for path in folder.iterdir() if path.is_dir()]
    if len(tops) != 1:
        sys.exit(f"{package}: it holds {len(tops)} folders: expected one")
    return tops[0]


def objects(library):
    return [line.split("\t")[0] for line in (library / f"{library.name}-objects.txt").read_text().splitlines()]


def load_every_object(library, pd):
    """{object: what Pd said} of those that it could not make as [tactus/OBJECT]."""
    refused = {}
    with tempfile.TemporaryDirectory() as name:
        patch = pathlib.Path(name) / "load.pd"
        for wanted in objects(library):
            patch.write_text("#N canvas 0 0 400 300 10;\n"
                             f"#X obj 20 20 {library.name}/{wanted};\n"
                             "#X obj 20 80 loadbang;\n#X msg 20 110 \\; pd quit;\n#X connect 1 0 2 0;\n")
            done = subprocess.run([*pd, *QUIET, "-path", str(library.parent), "-open", str(patch)], capture_output=True,
                                  text=True, timeout=60, check=False)
            said = done.stdout + done.stderr
            if done.returncode != 0 or "couldn't create" in said:
                refused[wanted] = said.strip()
    return refused


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=pathlib.Path)
    parser.add_argument("--pd", type=shlex.split, default=["pd"], metavar="COMMAND")
    parser.add_argument("--renders", type=pathlib.Path, metavar="TABLE")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        library = unpack(arguments.package, pathlib.Path(name))
        wanted = objects(library)
        refused = load_every_object(library, arguments.pd)
        print(f"{len(wanted) - len(refused)} of {len(wanted)} objects are made", flush=True)
        for missing, said in refused.items():
            print(f"{missing}: {said}")
        silent = []
        if arguments.renders:
            subprocess.run([sys.executable, "-B", ROOT / "scripts/hash_renders.py", arguments.renders, "--stage", library,
                            "--scenes", pathlib.Path(name) / "none", "--only", "-help", "--pd", shlex.join(arguments.pd)], check=True)
            rows = [line.split("\t") for line in arguments.renders.read_text().splitlines()]
            silent = [patch for _, patch, digest in rows if len(digest) != 64]
            print(f"{len(rows) - len(silent)} of {len(rows)} help patches are rendered", *silent, sep="\n")
    sys.exit(1 if refused or silent else 0)


if __name__ == "__main__":
    main()
