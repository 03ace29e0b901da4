"""The same gestures (tests/cross/gestures.txt) by the Max module, by the object without a host, and by the
Pd modules of both float sizes: Max computes what the object computes, bit for bit. Another system's build does
all of this by its own C library under its emulator, and is then compared with this machine's
(TACTUS_REFERENCE), from which it may differ by what tests/cross/expected.txt says."""
import os
import pathlib
import subprocess
import sys

import numpy
import pytest

from max_host import BUILD, EMULATOR, RATE, declarations, load, run, word

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "cross"))
from compare_renders import Limits, compare_sound, expected  # noqa: E402

REFERENCE = pathlib.Path(os.environ["TACTUS_REFERENCE"]) if EMULATOR else None
GESTURES = ROOT / "tests" / "cross" / "gestures.txt"
STAGE = BUILD / "tactus"
SAMPLES, FRAMES = 96000, 64

# What bounces carries the rounding of Pd's 32-bit numbers on from bounce to bounce: these gestures are
# compared with 32-bit Pd until that is heard.
UNTIL_MS = {"impact": 100, "plate": 1200}


def gestures():
    found = {}
    for line in GESTURES.read_text().splitlines():
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "gesture":
            current = found[words[1].rstrip(":")] = {"object": words[2], "box": words[3:], "messages": []}
        else:
            current["messages"].append((float(words[0]), words[1:]))
    sounding = {d["name"] for d in declarations().values() if any(o["kind"] == "signal" for o in d["outlets"])}
    return {name: g for name, g in found.items() if g["object"] in sounding}


def atoms(words):
    def atom(text):
        try:
            return word(float(text))
        except ValueError:
            return text
    return " ".join(map(atom, words))


def first_sample(ms):
    """Of the block before which the message comes, as render_gestures sends it."""
    return next(b for b in range(0, SAMPLES + FRAMES, FRAMES) if ms * RATE <= 1e3 * b)


def pd_renders(build, emulator, bits, folder):
    """Folder of what a build's Pd modules render, and of what went into them."""
    program = build / "tests" / "cross" / f"render_gestures_f{bits}"
    if program.is_dir():  # on Windows in a folder with its DLL
        program = program / f"{program.name}.exe"
    subprocess.run([*emulator, program, GESTURES, build / "tactus", folder], check=True, timeout=600)
    return folder


@pytest.fixture(scope="module")
def pd(tmp_path_factory):
    """Folder of this build's Pd renders, by the bits of its numbers."""
    return {bits: pd_renders(BUILD, EMULATOR, bits, tmp_path_factory.mktemp(f"pd{bits}")) for bits in (32, 64)}


@pytest.fixture(scope="module")
def reference_pd(tmp_path_factory):
    """Folder of 64-bit Pd's renders by this machine's build."""
    return pd_renders(REFERENCE, [], 64, tmp_path_factory.mktemp("reference"))


def inputs(folder, name):
    return sorted(folder.glob(f"{name}.*.in"))


def by_max(gesture, files, output, late=0):
    name = gesture["object"]
    lines = [load(name), f"searchpath {STAGE}", f"rate {RATE}", f"vector {FRAMES}",
             f"new b {name} {atoms(gesture['box'])}"]
    lines += [f"signal b {i} file {file}" for i, file in enumerate(files)]
    lines += ["dsp on", f"record b {output}"]
    at = 0
    for ms, message in gesture["messages"]:
        sample = first_sample(ms) + (late if ms else 0)
        lines += [f"run {(sample - at) // FRAMES}", f"send b 0 {message[0]} {atoms(message[1:])}"]
        at = sample
    lines += [f"run {(SAMPLES - at) // FRAMES}", "dsp off"]
    result = run(lines)
    refused = [e for e in result.of("error") if "gravity is 0" not in e]  # what the gesture does on purpose
    assert not refused, refused
    outlets = sum(o["kind"] == "signal" for o in declarations()[name]["outlets"])
    return numpy.fromfile(output).reshape(-1, outlets).T.ravel()


def by_itself(gesture, files, output, build=BUILD, emulator=EMULATOR):
    declaration = declarations()[gesture["object"]]
    messages = []
    box = list(gesture["box"])
    for argument in declaration["arguments"]:  # as core/command.hpp splits them
        if box and not box[0].startswith("-"):
            messages.append((0, [argument, box.pop(0)]))
    while box:
        end = next((i for i, w in enumerate(box[1:], 1) if w.startswith("-")), len(box))
        messages.append((0, [box[0][1:], *box[1:end]]))
        box = box[end:]
    messages += [(first_sample(ms), message) for ms, message in gesture["messages"]]
    identifier = gesture["object"].replace("~", "_tilde")
    folder = build / "tests" / "max" / "modules"
    program = folder / ("render_object.exe" if emulator else "render_object")
    subprocess.run([*emulator, program, folder / "objects" / f"{identifier}.module", build / "tactus", output, *files],
                   check=True, timeout=300, text=True,
                   input="".join(f"{sample} {' '.join(message)}\n" for sample, message in messages))
    return numpy.fromfile(output)


def late_in_pd(gesture):
    """Samples by which tests/pd's host is late: it computes a block before its logical time passes, Pd
    itself after it, and modal_impact~ strikes at the time at which a message came."""
    return FRAMES if gesture["object"] == "modal_impact~" else 0


def decibels(ours, theirs):
    peak = numpy.abs(theirs).max()
    return 20 * numpy.log10(max(numpy.abs(ours - theirs).max(), 1e-300) / peak) if peak > 0 else -numpy.inf


@pytest.mark.parametrize("name", gestures())
def test_max_computes_what_the_object_does(name, pd, tmp_path):
    gesture = gestures()[name]
    files = inputs(pd[64], name)
    ours = by_max(gesture, files, tmp_path / "max.f64")
    assert numpy.isfinite(ours).all() and numpy.abs(ours).max() > 0
    itself = by_itself(gesture, files, tmp_path / "itself.f64")
    assert ours.tobytes() == itself.tobytes(), \
        f"{(ours != itself).sum()} of {ours.size} samples differ, from {int(numpy.argmax(ours != itself))}"


@pytest.mark.parametrize("name", gestures())
def test_pd_with_doubles_renders_the_same_bits(name, pd, tmp_path):
    gesture = gestures()[name]
    ours = by_max(gesture, inputs(pd[64], name), tmp_path / "max.f64", late_in_pd(gesture))
    theirs = numpy.fromfile(pd[64] / f"{name}.f64")
    assert ours.tobytes() == theirs.tobytes(), \
        f"{(ours != theirs).sum()} of {ours.size} samples differ, from {int(numpy.argmax(ours != theirs))}: " \
        f"{decibels(ours, theirs):.1f} dB"


@pytest.mark.parametrize("name", gestures())
def test_pd_with_floats_renders_the_same_sound(name, pd, tmp_path):
    """Within -130 dB of the peak: its samples and the numbers of its messages are rounded to 24 bits, -150 dB."""
    gesture = gestures()[name]
    ours = by_max(gesture, inputs(pd[32], name), tmp_path / "max.f64", late_in_pd(gesture)).reshape(-1, SAMPLES)
    theirs = numpy.fromfile(pd[32] / f"{name}.f64").reshape(-1, SAMPLES)
    end = first_sample(UNTIL_MS[name]) if name in UNTIL_MS else SAMPLES
    assert decibels(ours[:, :end], theirs[:, :end]) < -130


@pytest.mark.skipif(not REFERENCE, reason="this build is this machine's own")
@pytest.mark.parametrize("name", gestures())
def test_another_system_differs_by_what_its_c_library_rounds(name, reference_pd, tmp_path):
    """From the object and from 64-bit Pd on this machine, of the same input. Above, the module gives its own
    system's bits, so what differs here is no matter of Max."""
    gesture, limits = gestures()[name], expected("windows-amd64", 64).get(name, Limits())
    files = inputs(reference_pd, name)
    by_itself(gesture, files, tmp_path / "itself.f64", REFERENCE, [])
    for theirs, late in ((tmp_path / "itself.f64", 0), (reference_pd / f"{name}.f64", late_in_pd(gesture))):
        by_max(gesture, files, tmp_path / "raw.f64", late).tofile(tmp_path / "max.f64")
        level, text = compare_sound(theirs, tmp_path / "max.f64", limits.until)
        print(f"{name}: {text}")
        assert level is None or level < limits.sound, text
