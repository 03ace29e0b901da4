#!/usr/bin/env python3
"""Hashes every render of tactus, to show that a change of the code changes none.

    hash_renders.py FILE.tsv [--stage build/tactus] [--scenes out] [--seconds 4]   writes the hashes
                    [--keep FOLDER]                                            and keeps the patches' sounds in FOLDER
    hash_renders.py --compare BEFORE.tsv AFTER.tsv [--varying BEFORE_AGAIN.tsv]    lists the differences

Each line of the table is KIND, NAME and the SHA-256 of the bytes:
    patch   the sound of every help patch and of every patch under patches/, headless, after its play
            button has been pressed
    scene   every file that ./play has written under --scenes, except logs and pages
Renders that also differ between two tables of the same build (--varying) depend on the wall clock or on
other processes; they are counted separately.
"""
import argparse
import hashlib
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
RATE = 48000
CAPTURE = """#N canvas 0 0 300 200 10;
#X obj 20 20 inlet~;
#X obj 120 20 inlet~;
#X obj 20 60 throw~ hash-renders-1;
#X obj 120 60 throw~ hash-renders-2;
#X connect 0 0 2 0;
#X connect 1 0 3 0;
"""
DRIVER = """#N canvas 0 0 700 300 10;
#X obj 20 20 loadbang;
#X obj 20 50 t b b;
#X msg 20 80 \\; pd dsp 1;
#X obj 20 110 delay 100;
#X obj 20 140 s help-play;
#X obj 120 110 delay {milliseconds};
#X obj 120 140 t b b b;
#X msg 120 200 \\; pd quit;
#X msg 220 170 write -wave -bytes 4 {sound} hash-left hash-right;
#X obj 220 200 soundfiler;
#X obj 420 20 catch~ hash-renders-1;
#X obj 560 20 catch~ hash-renders-2;
#X obj 420 60 tabwrite~ hash-left;
#X obj 560 60 tabwrite~ hash-right;
#X obj 420 100 table hash-left {samples};
#X obj 560 100 table hash-right {samples};
#X connect 0 0 1 0;
#X connect 1 0 3 0;
#X connect 1 0 5 0;
#X connect 1 1 2 0;
#X connect 1 1 12 0;
#X connect 1 1 13 0;
#X connect 3 0 4 0;
#X connect 5 0 6 0;
#X connect 6 0 7 0;
#X connect 6 1 8 0;
#X connect 8 0 9 0;
#X connect 10 0 12 0;
#X connect 11 0 13 0;
"""


def captured(text):
    """The patch with every [dac~] replaced by one that the driver records."""
    return re.sub(r"(#X obj -?\d+ -?\d+) dac~[^;,]*", r"\1 hash_renders_dac~", text)


def hash_patch(patch, folder, stage, seconds, pd=("pd",)):
    """The hash of `seconds` of a patch's sound, rendered headless from a copy in `folder`."""
    sound = folder / "sound.wav"
    sound.unlink(missing_ok=True)
    (folder / "driver.pd").write_text(DRIVER.format(
        milliseconds=1000 * seconds, samples=int(seconds * RATE), sound=sound))
    try:
        subprocess.run([*pd, "-nogui", "-batch", "-noprefs", "-r", str(RATE), "-path", str(stage),
                        "-open", str(patch), "-open", str(folder / "driver.pd")],
                       cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, timeout=120 + 10 * seconds, check=False)
    except subprocess.TimeoutExpired:
        return "no end"
    return hashlib.sha256(sound.read_bytes()).hexdigest() if sound.exists() else "no sound file"


def hash_patches(stage, seconds, pd=("pd",), only="", keep=None):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        copies = {}
        for source in (stage, ROOT / "patches"):
            copies[source] = folder / source.name
            shutil.copytree(source, copies[source], symlinks=False,
                            ignore=shutil.ignore_patterns("__pycache__"))
        (copies[stage] / "hash_renders_dac~.pd").write_text(CAPTURE)
        for file in folder.rglob("*.pd"):
            if file.name != "hash_renders_dac~.pd":
                text = file.read_text(errors="surrogateescape")
                file.write_text(captured(text), errors="surrogateescape")
        patches = sorted(copies[stage].glob("*-help.pd")) + sorted(copies[ROOT / "patches"].rglob("*.pd"))
        for patch in patches:
            if only not in patch.name:
                continue
            digest = hash_patch(patch, folder, copies[stage], seconds, pd)
            if keep and (folder / "sound.wav").exists():
                keep.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(folder / "sound.wav", keep / f"{patch.parent.name}_{patch.stem}.wav")
            yield "patch", str(patch.relative_to(folder)), digest


def hash_scenes(scenes):
    for file in sorted(scenes.rglob("*")):
        if file.is_file() and file.suffix not in (".log", ".html", ".txt"):
            yield "scene", str(file.relative_to(scenes)), hashlib.sha256(file.read_bytes()).hexdigest()


def read(path):
    rows = (line.split("\t") for line in pathlib.Path(path).read_text().splitlines())
    return {(kind, name): digest for kind, name, digest in rows}


def compare(before, after, again):
    """Prints the differences; True if there are none, apart from renders that vary anyway."""
    varying = {key for key in before if again and before[key] != again.get(key)}
    different = [key for key in sorted(before.keys() | after.keys())
                 if before.get(key) != after.get(key) and key not in varying]
    for kind, name in different:
        print(f"different: {kind} {name}")
    same = len((before.keys() & after.keys()) - varying - set(different))
    print(f"{same} equal, {len(different)} different, {len(varying)} vary from run to run")
    return not different


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("table", nargs="?")
    parser.add_argument("--stage", type=pathlib.Path, default=ROOT / "build/tactus")
    parser.add_argument("--scenes", type=pathlib.Path, default=ROOT / "out")
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--pd", type=shlex.split, default=["pd"], metavar="COMMAND",
                        help="another system's Pd under its emulator (docs/cross_build.md)")
    parser.add_argument("--only", default="", metavar="WORD", help="only patches whose name contains WORD")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER", help="keeps the patches' sounds in FOLDER as WAV files of floats")
    parser.add_argument("--compare", nargs=2, metavar=("BEFORE", "AFTER"))
    parser.add_argument("--varying", metavar="BEFORE_AGAIN")
    arguments = parser.parse_args()
    if arguments.compare:
        before, after = map(read, arguments.compare)
        again = read(arguments.varying) if arguments.varying else None
        sys.exit(0 if compare(before, after, again) else 1)
    if not arguments.table:
        parser.error("expected the table to write, or --compare")
    with open(arguments.table, "w") as table:
        for row in [*hash_patches(arguments.stage.resolve(), arguments.seconds, arguments.pd, arguments.only, arguments.keep), *hash_scenes(arguments.scenes)]:
            table.write("\t".join(row) + "\n")
            table.flush()


if __name__ == "__main__":
    main()
