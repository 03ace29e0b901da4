"""Every object has a help patch that loads without an error, is silent until one click and then
sounds, safely, and fits a screen."""
import json
import os
import pathlib
import re
import sys

import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "patches"))
from harness import Patch, stage_folder  # noqa: E402

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
OBJECTS = [o["name"] for o in json.loads((BUILD / "declarations.json").read_text())]
HELP = sorted(stage_folder().glob("*-help.pd"))
BOX = re.compile(r"^#X (obj|msg|text|floatatom|symbolatom|listbox) (-?\d+) (-?\d+)", re.M)


def outermost_boxes(text):
    """Places of the boxes of the patch's own window, not those of its sub-patches."""
    depth, boxes = 0, []
    for line in text.split(";\n"):
        if line.startswith("#N canvas"):
            depth += 1
        elif line.startswith("#X restore"):
            depth -= 1
        found = BOX.match(line)
        if depth == 1 and found:
            boxes.append((int(found.group(2)), int(found.group(3)), line))
    return boxes


@pytest.mark.parametrize("name", OBJECTS)
def test_the_object_has_a_help_patch(name):
    assert (stage_folder() / f"{name}-help.pd").is_file()


@pytest.mark.parametrize("path", HELP, ids=lambda p: p.stem)
def test_a_help_patch_is_silent_on_loading_and_sounds_within_one_click(path):
    text = path.read_text()
    tables = {*re.findall(r"\w+\.modal\.npz", text)}
    if any(not (stage_folder() / table).is_file() for table in tables):
        pytest.skip("its tables are made where modal_fem is built")
    assert re.search(r"bng .* help-play ", text), "a [bng] with the receive name help-play"
    patch = Patch(opens=path)
    for channel in (1, 2):
        patch.record(str(channel), patch.dac(channel))
    patch.send(500, "help-play", "bang")
    result = patch.render(5, 48000, dsp=False)
    sound = numpy.stack([result["1"], result["2"]])
    # Recording begins when the sound is switched on, so the end stays empty.
    assert not sound[:, -15000:].any(), "it sounds before the click"
    assert abs(sound).max() <= 1
    # Pd does not look at its sockets in a batch render: what comes over one is heard live only.
    if ("dac~" in text or "ioa_ddd_dac" in text) and path.stem != "ioa_net-help":
        half_seconds = (sound[:, :216000] ** 2).reshape(2, -1, 24000).mean(axis=2)
        level = 10 * numpy.log10(half_seconds.max() + 1e-12)
        assert level > -50, f"it is silent for 4 s after the click ({level:.0f} dB)"


@pytest.mark.parametrize("path", HELP, ids=lambda p: p.stem)
def test_a_help_patch_fits_a_screen_and_keeps_its_boxes_inside(path):
    text = path.read_text()
    width, height = map(int, re.match(r"#N canvas -?\d+ -?\d+ (\d+) (\d+)", text).groups())
    assert width <= 760 and height <= 800
    for x, y, line in outermost_boxes(text):
        assert 0 <= x < width - 10 and 0 <= y < height - 10, line
