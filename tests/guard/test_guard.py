"""Nothing on the audio path allocates, locks or calls the system, in real Pd.

Every object that makes sound is rendered, with its parameters swept and the graph rebuilt, at
several block sizes, and so is every help patch and instrument; a preloaded library watches what
process() does. A test object that breaks each rule on demand shows that the guard sees it.
"""
import json
import os
import pathlib
import re
import sys

import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "patches"))
from harness import Patch, PdFailure  # noqa: E402

slow = pytest.mark.slow
BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
GUARD = BUILD / "tests" / "guard" / "librtguard.so"
OBJECTS = {o["name"]: o for o in json.loads((BUILD / "declarations.json").read_text())}
SOUNDING = [name for name, o in OBJECTS.items() if o["signal"]]
LEFT_OUT = {"design_part",  # needs a table; beam.pd and arm.pd open it with theirs
            "reed_multichannel"}  # needs Pd 0.54 or newer
PATCHES = [path for path in sorted([*(BUILD / "tactus").glob("*-help.pd"), *ROOT.glob("patches/*/*.pd")])
           if path.stem not in LEFT_OUT]


def guarded_calls(result):
    """How many process() calls the guard watched; it must have seen no violation."""
    found = re.search(r"rtguard: (\d+) violations in (\d+) guarded calls", result.output)
    assert found, "the guard was not there:\n" + result.output
    assert found.group(1) == "0", result.output
    return int(found.group(2))


def plausible_signal(port, samples, rate=48000):
    """Something to chew on, by the unit of the inlet."""
    t = numpy.arange(samples) / rate
    if port["unit"] == "Pa":
        return 4000 * abs(numpy.sin(2 * numpy.pi * 2 * t))
    if port["unit"] == "Hz":
        return 300 + 60 * numpy.sin(2 * numpy.pi * 3 * t)
    return 0.5 + 0.4 * numpy.sin(2 * numpy.pi * 220 * t)


def sweep_parameters(patch, box, declaration, first_ms, step_ms):
    """Sends every choice, and the lowest, highest and initial value, one after the other."""
    ms = first_ms
    for p in declaration["parameters"]:
        values = p["choices"] or p["values"] or [p["lowest"], p["highest"], p["initial"]]
        for value in values:
            patch.at(ms, box, f"{p['name']} {value}")
            ms += step_ms
    return ms


@pytest.mark.parametrize("block", [64, pytest.param(1, marks=slow), pytest.param(1024, marks=slow)])
@pytest.mark.parametrize("name", SOUNDING)
def test_an_object_keeps_the_rules_of_the_audio_path(name, block):
    declaration = OBJECTS[name]
    patch = Patch(block=block)
    box = patch.obj(name)
    end = sweep_parameters(patch, box, declaration, 100, 10)
    seconds = end / 1000 + 0.1
    for i, port in enumerate(declaration["inlets"]):
        if port["kind"] == "signal":
            patch.signal(plausible_signal(port, int(48000 * seconds))) >> box[i]
    patch.rebuild_dsp(60)
    patch.rebuild_dsp(end - 5)
    patch.record("out", box)
    result = patch.render(seconds, preload=GUARD, timeout=120)
    assert guarded_calls(result) >= int(48000 * seconds / block)


@pytest.mark.parametrize("sync", [pytest.param(0, marks=slow), 1])
def test_a_body_that_is_shaped_while_it_rings_keeps_the_rules_of_the_audio_path(sync):
    patch = Patch()
    box = patch.obj("modal_impact~", "-sync", sync)
    patch.at(20, box, "load plate.modal.npz -sync")
    for i in range(20):
        patch.at(100 + 20 * i, box, f"hit {5 * i} 40 2.5 1")
        patch.at(105 + 20 * i, box, f"shape {i - 10} {-2 * i}")
        patch.at(110 + 20 * i, box, f"cp 0 {160 + i} {100 - i} 0")
    patch.record("out", box)
    assert guarded_calls(patch.render(0.6, preload=GUARD, timeout=120)) >= int(48000 * 0.6 / 64)


@pytest.mark.parametrize("path", [pytest.param(path, marks=() if path.stem in ("reed_haptic", "wind_controller") else slow)
                                  for path in PATCHES], ids=lambda p: p.stem)
def test_a_patch_keeps_the_rules_of_the_audio_path(path):
    patch = Patch(opens=path)
    patch.record("left", patch.dac())
    patch.send(10, "help-play", "bang")
    guarded_calls(patch.render(1.5, preload=GUARD, timeout=120))


@pytest.mark.parametrize("crime", ["allocate", "lock", "write", "sleep", "syscall", "float-mode", "none"])
def test_the_guard_sees_every_crime_and_accuses_no_innocent(crime):
    patch = Patch()
    patch.record("out", patch.obj("culprit~", crime))
    where = {"preload": GUARD, "path": [BUILD / "test-objects"]}
    if crime == "none":
        assert guarded_calls(patch.render(0.1, **where)) >= 75
        return
    with pytest.raises(PdFailure, match=r"status 86[\s\S]*rtguard: .* on the audio path"):
        patch.render(0.1, **where)
