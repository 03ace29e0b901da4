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
sys.path[:0] = [str(ROOT / "tests" / "patches"), str(ROOT / "max" / "tools")]
import pd_file  # noqa: E402
from harness import Patch, stage_folder  # noqa: E402

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
OBJECTS = [o["name"] for o in json.loads((BUILD / "declarations.json").read_text())]
HELP = sorted(stage_folder().glob("*-help.pd"))
SECONDS = 3

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
    result = patch.render(SECONDS, dsp=False)
    sound = numpy.stack([result["1"], result["2"]])
    # Recording begins when the sound is switched on, so the end stays empty.
    assert not sound[:, -15000:].any(), "it sounds before the click"
    assert abs(sound).max() <= 1
    # Pd does not look at its sockets in a batch render: what comes over one is heard live only.
    if ("dac~" in text or "ioa_ddd_dac" in text) and path.stem != "ioa_net-help":
        half_seconds = (sound[:, :round((SECONDS - 0.5) * 48000)] ** 2).reshape(2, -1, 24000).mean(axis=2)
        level = 10 * numpy.log10(half_seconds.max() + 1e-12)
        assert level > -50, f"it is silent after the click ({level:.0f} dB)"


@pytest.mark.parametrize("path", HELP, ids=lambda p: p.stem)
def test_a_help_patch_fits_a_screen_and_keeps_its_boxes_inside(path):
    canvas = pd_file.read(path)
    assert canvas.width <= 760 and canvas.height <= 800
    for box in canvas.boxes:
        assert 0 <= box.x < canvas.width - 10 and 0 <= box.y < canvas.height - 10, box.words
