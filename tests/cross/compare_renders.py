#!/usr/bin/env python3
"""Renders the gestures by this machine's modules and by another system's, and compares them.

    compare_renders.py --reference BUILD --build BUILD --bits 32 --system windows-amd64 -- PROGRAM...

PROGRAM... runs render_gestures of the other system. Prints one line a gesture: equal, or where the first
difference is and how large it grows relative to the reference's peak. A gesture that expected.txt does
not list for this system and float size must be equal bit for bit; a listed one must stay below its limit.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy

FOLDER = pathlib.Path(__file__).resolve().parent


def render(command, stage, folder, **environment):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    subprocess.run([*command, str(FOLDER / "gestures.txt"), str(stage), str(folder)], check=True, timeout=1200,
                   env={**os.environ, **environment})


def decibels(difference, peak):
    return 20 * numpy.log10(difference / peak) if peak > 0 else 0.0


def compare_sound(ours, theirs):
    """(largest difference in dB of the peak or None when equal, what to print)"""
    a, b = numpy.fromfile(ours), numpy.fromfile(theirs)
    if a.size != b.size:
        return 0.0, f"{a.size} samples, {b.size} there"
    same = a.view(numpy.uint64) == b.view(numpy.uint64)
    if same.all():
        return None, f"equal, {a.size} samples"
    level = decibels(numpy.abs(a - b).max(), numpy.abs(a).max())
    return level, f"{(~same).sum()} of {a.size} samples differ, from {int(numpy.argmin(same))}, {level:.1f} dB"


def numbers_and_words(text):
    numbers, words = [], []
    for word in text.split():
        try:
            numbers.append(float(word))
        except ValueError:
            words.append(word)
    return numbers, words


def compare_messages(ours, theirs):
    a, b = ours.read_text(), theirs.read_text()
    if a == b:
        return None, f"{len(a.splitlines())} messages equal"
    (na, wa), (nb, wb) = numbers_and_words(a), numbers_and_words(b)
    if len(na) != len(nb) or wa != wb:
        return 0.0, "other messages"
    x, y = numpy.array(na), numpy.array(nb)
    scale = numpy.maximum(numpy.abs(x), numpy.abs(y))
    worst = (numpy.abs(x - y)[scale > 0] / scale[scale > 0]).max()
    level = 20 * numpy.log10(worst) if worst > 0 else -400.0
    return level, f"messages' numbers differ by {level:.1f} dB"


def expected(system, bits):
    rows = [line.split() for line in (FOLDER / "expected.txt").read_text().splitlines()
            if line and not line.startswith("#")]
    return {row[2]: float(row[3]) for row in rows if row[0] == system and row[1] in (str(bits), "both")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--reference", type=pathlib.Path, required=True)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--bits", type=int, required=True)
    parser.add_argument("--system", required=True)
    parser.add_argument("command", nargs="+")
    arguments = parser.parse_args()
    renders = arguments.build / "renders"
    ours, theirs = renders / f"here-{arguments.bits}", renders / f"there-{arguments.bits}"
    program = arguments.reference / f"tests/cross/render_gestures_f{arguments.bits}"
    render([str(program)], arguments.reference / "tactus", ours)
    render(arguments.command, arguments.build / "tactus", theirs)
    limits, failures = expected(arguments.system, arguments.bits), 0
    names = sorted(file.stem for file in theirs.glob("*.f64"))
    for name in names:
        results = [compare_sound(ours / f"{name}.f64", theirs / f"{name}.f64"),
                   compare_messages(ours / f"{name}.txt", theirs / f"{name}.txt")]
        worst = max((level for level, _ in results if level is not None), default=None)
        good = worst is None or (name in limits and worst <= limits[name])
        failures += not good
        print(f"{'' if good else 'FAILED '}{name}: {'; '.join(text for _, text in results)}")
    print(f"{len(names)} gestures, {failures} beyond what expected.txt says")
    sys.exit(1 if failures or not names else 0)


if __name__ == "__main__":
    main()
