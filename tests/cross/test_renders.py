"""The same gestures (gestures.txt) by every host, of the same input. Max computes the bits of Pd with doubles; Pd with
floats renders the same sound within its rounding. Another system's build (TACTUS_REFERENCE is then this machine's) does
all of this under its emulator, and is compared with this machine's: the bits are equal, but for what expected.txt lists.
"""
import math
import os
import pathlib
import re
import subprocess
import sys

import numpy
import pytest

FOLDER = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ["TACTUS_BUILD"])
REFERENCE = pathlib.Path(os.environ["TACTUS_REFERENCE"]) if "TACTUS_REFERENCE" in os.environ else None
EMULATOR = [word for word in os.environ.get("TACTUS_EMULATOR", "").split("|") if word]
SIZES = [int(bits) for bits in os.environ["TACTUS_FLOAT_SIZES"].split()]  # of Pd's numbers
RATE, SAMPLES, FRAMES = 48000, 96000, 64
# Pd's floats hold 24 bits, 150 dB: of its samples, and of the numbers of its messages. What bounces carries the rounding
# on from bounce to bounce: these gestures are compared until that is heard.
ROUNDED_DB, UNTIL_MS = -130, {"impact": 100, "plate": 1200}
if os.environ["TACTUS_MAX"] == "ON":
    sys.path.insert(0, str(FOLDER.parent / "max"))
    import max_host


def read_gestures():
    """name -> (object, its arguments, [(the first sample of the block that a message comes before, its words)])"""
    found = {}
    for line in (FOLDER / "gestures.txt").read_text().splitlines():
        words = line.split()
        if words and words[0] == "gesture":
            messages = []
            found[words[1].rstrip(":")] = (words[2], words[3:], messages)
        elif words and not line.startswith("#"):
            messages.append((math.ceil(float(words[0]) * RATE / 1000 / FRAMES) * FRAMES, words[1:]))
    return found


GESTURES = read_gestures()


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A folder of what goes into signal inlets, by unit: a pressure swells and ebbs, a frequency wanders. No float has
    more digits, so that all hosts are given the same."""
    folder, t = tmp_path_factory.mktemp("inputs"), 2 * numpy.pi * numpy.arange(SAMPLES) / RATE
    for unit, signal in (("Pa", 4000 * abs(numpy.sin(2 * t))), ("Hz", 300 + 60 * numpy.sin(3 * t)),
                         ("other", 0.5 + 0.4 * numpy.sin(220 * t) * numpy.sin(2.5 * t))):
        signal.astype(numpy.float32).astype(numpy.float64).tofile(folder / f"{unit}.f64")
    return folder


def by_pd(build, emulator, bits, name, inputs, folder):
    """Stem of the files of a render, or None where the system lacks the object."""
    program = build / "tests" / "cross" / f"render_gesture_f{bits}"
    if program.is_dir():  # on Windows in a folder with its DLL
        program = program / f"{program.name}.exe"
    object_, arguments, messages = GESTURES[name]
    subprocess.run([*emulator, program, build / "tactus", folder / f"{name}{bits}", inputs, object_, *arguments],
                   input="".join(f"{sample} {' '.join(words)}\n" for sample, words in messages), text=True, check=True,
                   timeout=600)
    return folder / f"{name}{bits}" if (folder / f"{name}{bits}.f64").exists() else None


def by_max(name, inputs, output):
    """File of the samples."""
    object_, arguments, messages = GESTURES[name]
    declaration = max_host.declarations()[object_]

    def atoms(words):
        return " ".join(max_host.word(float(word)) if re.fullmatch(r"-?[\d.]+", word) else word for word in words)
    lines = [max_host.load(object_), f"searchpath {BUILD / 'tactus'}", f"rate {RATE}", f"vector {FRAMES}",
             f"new b {object_} {atoms(arguments)}"]
    for i, port in enumerate(declaration["inlets"]):
        file = inputs / f"{port['unit']}.f64"
        if port["kind"] == "signal":
            lines.append(f"signal b {i} file {file if file.exists() else inputs / 'other.f64'}")
    lines += ["dsp on", f"record b {output}"]
    done = 0
    for sample, words in messages:
        lines += [f"run {(sample - done) // FRAMES}", f"send b 0 {words[0]} {atoms(words[1:])}"]
        done = sample
    result = max_host.run([*lines, f"run {(SAMPLES - done) // FRAMES}", "dsp off"])
    refused = [error for error in result.of("error") if "gravity is 0" not in error]  # what impact does on purpose
    assert not refused, refused
    outlets = sum(port["kind"] == "signal" for port in declaration["outlets"])
    numpy.fromfile(output).reshape(-1, outlets).T.ravel().tofile(output)
    return output


def decibels(difference, peak):
    if not difference <= numpy.finfo(float).max or not peak > 0:  # not finite, or silent here
        return numpy.inf
    return 20 * numpy.log10(difference / peak) if difference > 0 else -numpy.inf


def compare_sound(ours, theirs, until=SAMPLES):
    """(largest difference before sample `until` of each outlet, in dB of the peak, or None when all bits are equal;
    what to print)"""
    a, b = numpy.fromfile(ours), numpy.fromfile(theirs)
    if a.size != b.size:
        return numpy.inf, f"{a.size} samples, {b.size} there"
    same = a.view(numpy.uint64) == b.view(numpy.uint64)
    if same.all():
        return None, f"equal, {a.size} samples"
    difference, peak = numpy.abs(a - b).reshape(-1, SAMPLES), numpy.abs(a).max()
    level = decibels(difference[:, :until].max(), peak)
    return level, f"{(~same).sum()} of {a.size} samples differ, from {int(numpy.argmin(same))}, " \
                  f"{decibels(difference.max(), peak):.1f} dB, before sample {until} {level:.1f} dB"


def numbers_and_words(text):
    numbers, words = [], []
    for word in text.split():
        try:
            numbers.append(float(word))
        except ValueError:
            words.append(word)
    return numpy.array(numbers), words


def compare_messages(ours, theirs):
    a, b = ours.read_text(), theirs.read_text()
    if a == b:
        return None, f"{len(a.splitlines())} messages equal"
    (x, here), (y, there) = numbers_and_words(a), numbers_and_words(b)
    if len(x) != len(y) or here != there:
        return numpy.inf, "other messages"
    finite = numpy.isfinite(x) & numpy.isfinite(y)
    if not numpy.array_equal(x[~finite], y[~finite], equal_nan=True):
        return numpy.inf, "numbers that are not finite"
    scale = numpy.maximum(numpy.abs(x), numpy.abs(y))[finite]
    worst = (numpy.abs(x - y)[finite][scale > 0] / scale[scale > 0]).max(initial=0)
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


def expected(system, bits, name):
    rows = [line.split() for line in (FOLDER / "expected.txt").read_text().splitlines()
            if line and not line.startswith("#")]
    given = {size: row[3:] for size in ("both", str(bits)) for row in rows if row[:3] == [system, size, name]}
    return Limits(given.get(str(bits), given.get("both", ())))


@pytest.mark.parametrize("name", GESTURES)
def test_every_host_renders_the_same(name, inputs, tmp_path):
    pd = {bits: by_pd(BUILD, EMULATOR, bits, name, inputs, tmp_path) for bits in SIZES}
    if REFERENCE and None in pd.values():
        pytest.skip("this system lacks the object")
    sounds = {bits: stem.with_suffix(".f64") for bits, stem in pd.items()}
    silent = GESTURES[name][0] in ("playability~", "stress_haptic")  # control outlets alone
    for sound in sounds.values():
        samples = numpy.fromfile(sound)
        assert silent == (samples.size == 0) and numpy.isfinite(samples).all() and (silent or samples.any())
    if len(SIZES) == 2 and not silent:
        until = round(UNTIL_MS.get(name, 2000) * RATE / 1000)
        level, said = compare_sound(sounds[64], sounds[32], until)
        assert level is None or level < ROUNDED_DB, f"Pd with floats: {said}"
    if 64 in SIZES and not silent and os.environ["TACTUS_MAX"] == "ON":
        level, said = compare_sound(sounds[64], by_max(name, inputs, tmp_path / "max.f64"))
        assert level is None, f"Max: {said}"
    for bits in SIZES if REFERENCE else ():
        (tmp_path / "here").mkdir(exist_ok=True)
        here = by_pd(REFERENCE, [], bits, name, inputs, tmp_path / "here")
        limits = expected(os.environ["TACTUS_SYSTEM"], bits, name)
        sound, said = compare_sound(here.with_suffix(".f64"), sounds[bits], limits.until)
        messages, told = compare_messages(here.with_suffix(".txt"), pd[bits].with_suffix(".txt"))
        print(f"{name} {bits}: {said}; {told}")
        assert (sound is None or sound < limits.sound) and (messages is None or messages < limits.messages), (said, told)


def put(at, value):
    def change(signal):
        signal[at] = value
        return signal
    return change


def test_no_limit_lets_through_sound_that_is_not_a_number_or_missing(tmp_path):
    a = numpy.sin(numpy.arange(2 * SAMPLES) / 7)
    a.tofile(tmp_path / "a.f64")

    def compare(change, until=SAMPLES):
        change(a.copy()).tofile(tmp_path / "b.f64")
        return compare_sound(tmp_path / "a.f64", tmp_path / "b.f64", until)[0]
    assert compare(lambda a: a) is None
    assert compare(lambda a: numpy.nextafter(a, 2)) == pytest.approx(-319, abs=1)
    assert compare(put(0, -0.0)) == -numpy.inf and not -numpy.inf < Limits().sound  # other bits, no difference
    assert compare(put(SAMPLES + 500, 100.0), until=501) > 0  # of the second outlet
    assert compare(put(SAMPLES + 500, 100.0), until=500) == -numpy.inf
    for wrong in (put(9, numpy.nan), put(9, numpy.inf), lambda a: a[:-1]):
        assert compare(wrong, until=500) == numpy.inf
