#!/usr/bin/python3
"""Renders the gestures by this machine's modules and by another system's of the same input, and compares them.

    compare_renders.py --reference BUILD --build BUILD --bits 32 --system windows-amd64 -- PROGRAM...

PROGRAM... runs render_gestures of the other system. Prints one line a gesture: equal, or where the first
difference is and how large it grows relative to the reference's peak. A gesture that expected.txt does
not list for this system and float size must be equal bit for bit; a listed one must stay below its limits.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

import numpy

FOLDER = pathlib.Path(__file__).resolve().parent
SAMPLES = 96000  # of each outlet


def render(command, stage, folder, *inputs):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    subprocess.run([*command, str(FOLDER / "gestures.txt"), str(stage), str(folder), *map(str, inputs)], check=True,
                   timeout=1200)


def decibels(difference, peak):
    if not difference <= numpy.finfo(float).max or not peak > 0:  # not finite, or silent here
        return numpy.inf
    return 20 * numpy.log10(difference / peak) if difference > 0 else -numpy.inf


def compare_sound(ours, theirs, until=SAMPLES):
    """(largest difference in dB of the peak or None when equal, what to print). The level is of what lies before
    sample `until` of each outlet."""
    a, b = numpy.fromfile(ours), numpy.fromfile(theirs)
    if a.size != b.size:
        return numpy.inf, f"{a.size} samples, {b.size} there"
    same = a.view(numpy.uint64) == b.view(numpy.uint64)
    if same.all():
        return None, f"equal, {a.size} samples"
    difference, peak = numpy.abs(a - b).reshape(-1, SAMPLES), numpy.abs(a).max()
    text = f"{(~same).sum()} of {a.size} samples differ, from {int(numpy.argmin(same))}, " \
           f"{decibels(difference.max(), peak):.1f} dB"
    if until == SAMPLES:
        return decibels(difference.max(), peak), text
    level = decibels(difference[:, :until].max(), peak)
    return level, f"{text}, {level:.1f} dB before sample {until}"


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
        return numpy.inf, "other messages"
    x, y = numpy.array(na), numpy.array(nb)
    finite = numpy.isfinite(x) & numpy.isfinite(y)
    if not numpy.array_equal(x[~finite], y[~finite], equal_nan=True):
        return numpy.inf, "numbers that are not finite"
    x, y = x[finite], y[finite]
    scale = numpy.maximum(numpy.abs(x), numpy.abs(y))
    worst = (numpy.abs(x - y)[scale > 0] / scale[scale > 0]).max(initial=0)
    level = 20 * numpy.log10(worst) if worst > 0 else -400.0
    return level, f"messages' numbers differ by {level:.1f} dB"


class Limits:
    """How far one gesture may differ, in dB: 'sound' before sample 'until', and 'messages'."""

    def __init__(self, words=()):
        options = dict(word.split("=") for word in words[1:])
        self.sound = float(words[0]) if words else -numpy.inf  # nothing lies below: equal bits alone
        self.until = int(options.pop("until", SAMPLES))
        self.messages = float(options.pop("messages", self.sound))
        assert not options, f"expected.txt: {options}"


def expected(system, bits):
    """gesture -> Limits, of those that differ"""
    rows = [line.split() for line in (FOLDER / "expected.txt").read_text().splitlines()
            if line and not line.startswith("#")]
    return {row[2]: Limits(row[3:]) for size in ("both", str(bits)) for row in rows if row[:2] == [system, size]}


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
    render(arguments.command, arguments.build / "tactus", theirs, ours)
    limits, failures = expected(arguments.system, arguments.bits), 0
    names = sorted(file.stem for file in theirs.glob("*.f64"))
    for name in names:
        limit = limits.get(name, Limits())
        sound, said = compare_sound(ours / f"{name}.f64", theirs / f"{name}.f64", limit.until)
        messages, told = compare_messages(ours / f"{name}.txt", theirs / f"{name}.txt")
        good = (sound is None or sound < limit.sound) and (messages is None or messages < limit.messages)
        failures += not good
        print(f"{'' if good else 'FAILED '}{name}: {said}; {told}")
    print(f"{len(names)} gestures, {failures} beyond what expected.txt says")
    sys.exit(1 if failures or not names else 0)


if __name__ == "__main__":
    main()
