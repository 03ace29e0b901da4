"""The controls of every instrument and help patch, moved at random within their ranges: no error, no sample that is
not finite, no clipping."""
import random
import re

import numpy
import pytest

from harness import Patch, stage_folder

PATCHES = sorted(path for path in stage_folder().glob("*.pd") if "help-play" in path.read_text())
SECONDS, CONTROLS = 8, 70

# A widget's words: type, then where receive name, lowest and highest value stand. Number boxes without limits take
# anything, which the objects answer themselves.
WIDGETS = {"hsl": (8, 3, 4), "vsl": (8, 3, 4), "nbx": (8, 3, 4), "floatatom": (5, 1, 2),
           "hradio": (6, None, 4), "vradio": (6, None, 4), "tgl": (4, None, None), "bng": (6, None, None)}


def controls(path):
    """(receive name, kind, lowest, highest) of the widgets of all canvases of the file."""
    found = []
    for line in re.split(r"(?<!\\);\n", path.read_text()):
        words = line.split()
        kind = words[4] if words[:2] == ["#X", "obj"] and len(words) > 4 else words[1] if len(words) > 1 else ""
        if kind not in WIDGETS:
            continue
        words = words[4:] if kind != "floatatom" else [kind, *words[4:]]
        receive, low, high = WIDGETS[kind]
        name = words[receive].replace("\\$0", "own")
        lowest, highest = (float(words[low]) if low else 0, float(words[high]) if high else 1)
        if kind in ("hradio", "vradio"):
            highest -= 1
        if name not in ("empty", "-") and not name.endswith("stop") and lowest != highest:
            found.append((name, kind, min(lowest, highest), max(lowest, highest)))
    return found


def test_controls_are_found_with_their_ranges():
    found = {name: rest for name, *rest in controls(stage_folder() / "greed~-help.pd")}
    assert found["own-volume-set"] == ["hsl", 0, 1] and found["own-pressure"] == ["hsl", 0, 8000]
    assert sum(len(controls(path)) for path in PATCHES) > 150


@pytest.mark.parametrize("path", PATCHES, ids=lambda path: path.stem)
def test_moving_the_controls_makes_no_error_and_no_clipping(path):
    if path.stem == "reed_multichannel":
        pytest.skip("says itself that it needs Pd 0.54")
    choose = random.Random(path.stem)
    patch = Patch(opens=path, own="own")
    patch.send(20, "pd", "dsp 1")
    patch.send(100, "help-play", "bang")
    for n in range(CONTROLS):
        name, kind, lowest, highest = choose.choice(controls(path))
        ends = choose.random() < 0.3
        value = choose.choice([lowest, highest]) if ends else choose.uniform(lowest, highest)
        if name == "help-play" and kind == "tgl":
            continue  # DSP off would end the recording
        patch.send(600 + 100 * n, name, "bang" if kind == "bng" else round(value) if kind in ("tgl", "hradio", "vradio")
                   else value)
    for channel in (1, 2):
        patch.record(f"channel {channel}", patch.dac(channel))
    result = patch.render(SECONDS, 48000, dsp=False, timeout=300)  # an error of Pd fails here
    sound = numpy.array([result[f"channel {channel}"] for channel in (1, 2)])
    assert numpy.isfinite(sound).all()
    assert abs(sound).max() < 1
