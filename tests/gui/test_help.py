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


def drawn_size(line):
    """Width and height in pixels of a box at Pd's font size 12, as far as its text tells them."""
    kind, *words = line.replace("\n", " ").split()[1:]
    words = words[2:]
    sized = {"bng": (1, 1), "tgl": (1, 1), "hsl": (1, 2), "vsl": (1, 2), "hradio": None,
             "vradio": None}
    if kind == "obj" and words and words[0] in sized:
        indices = sized[words[0]]
        return tuple(int(words[i]) for i in indices) if indices else None
    if kind not in ("obj", "msg") or words[:1] in (["cnv"], ["nbx"], ["vu"]):
        return None
    text, _, given = " ".join(words).partition(", f ")
    limit = int(given) if given else 60
    rows = 0
    longest = 0
    for part in re.split(r" ?\\; ?", text):
        row = 0
        rows += 1
        for word in part.replace("\\", "").split():
            if row and row + 1 + len(word) > limit:
                rows, row = rows + 1, 0
            row += len(word) + (1 if row else 0)
            longest = max(longest, row)
    return (limit if given else longest) * 7 + 4, rows * 15 + 6


@pytest.mark.parametrize("path", HELP, ids=lambda p: p.stem)
def test_no_box_of_a_help_patch_covers_another(path):
    boxes = [(x, y, drawn_size(line), line) for x, y, line in outermost_boxes(path.read_text())]
    boxes = [b for b in boxes if b[2]]
    for i, (x, y, (w, h), line) in enumerate(boxes):
        for x2, y2, (w2, h2), other in boxes[:i]:
            across = min(x + w, x2 + w2) - max(x, x2)
            down = min(y + h, y2 + h2) - max(y, y2)
            assert across < 4 or down < 4, f"{other!r} and {line!r} overlap by {across} x {down}"
