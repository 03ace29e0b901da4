"""The computed frames, texts and cords are those that Pd draws, by its own drawing commands, without a screen."""
import collections
import os
import pathlib
import re
import shutil
import subprocess

import pd_drawing
import pytest
from pd_canvas import ROOT, Stage, drawings, pd_file

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
STAGE = Stage(os.environ.get("TACTUS_STAGE", BUILD / "tactus"), BUILD / "declarations.json")
# Every object's help patch and what has the most kinds of boxes; an ioa module stands for the others.
PATCHES = [p for p in STAGE.patches() if re.match(r"(?!ioa_)\w+~?-help$|ioa_(r_screen|check|mm_sound)|reed_|struck|design_"
                                                 r"|wind|finger|mass|footstep_map", p.stem)]
QUICK = ("greed~-help", "ioa_r_screen", "wind_controller")
VERSION = subprocess.run(["pd", "-version"], capture_output=True, text=True).stderr if shutil.which("pd") else ""

pytestmark = pytest.mark.skipif(not re.search(r"Pd-0\.53", VERSION), reason="reads the drawing commands of Pd 0.53")


def names_within(canvas):
    for box in canvas.boxes:
        if box.canvas and len(box.words) > 1 and not box.canvas.arrays:
            yield re.sub(r"\\(.)", r"\1", box.words[1])
        if box.canvas:
            yield from names_within(box.canvas)


def corners(numbers):
    return min(numbers[0::2]), min(numbers[1::2]), max(numbers[0::2]), max(numbers[1::2])


def missing(drawing, seen):
    """Frames and cords that are computed and that Pd does not draw."""
    frames = collections.Counter(corners(numbers) for _, numbers, _ in seen["frames"])
    lost = []
    for drawn in filter(None, drawing.boxes):
        f = drawn.frame
        wanted = tuple(int(v) for v in (f.left, f.top, f.right, f.bottom))
        in_cells = drawn.box.name in ("hradio", "vradio")  # drawn cell by cell
        if drawn.kind in ("box", "widget", "panel") and not in_cells and not frames[wanted]:
            lost.append((drawn.name, wanted))
    for drawn in filter(None, drawing.boxes):
        for text, room in drawn.lines[:1]:
            first = (int(room.left), int(room.top))
            if drawn.kind in ("box", "text") and not any(at == first and words.startswith(text[:20].rstrip())
                                                         for at, words in seen["texts"]):
                lost.append((text, first))
    cords = collections.Counter((*map(int, c.start), *map(int, c.end)) for c in drawing.cords)
    return lost + list(cords - collections.Counter(seen["cords"]))


@pytest.mark.parametrize("path", [pytest.param(p, marks=() if p.stem in QUICK else pytest.mark.slow) for p in PATCHES],
                         ids=lambda p: p.name)
def test_frames_texts_and_cords_are_where_pd_draws_them(path):
    canvas = pd_file.read(path)
    windows = pd_drawing.canvases(pd_drawing.commands(STAGE.folder, path, sorted(set(names_within(canvas)))))
    compared = 0
    for drawing in drawings(canvas, STAGE):
        title = drawing.path[-1].split(" ")[0] if drawing.path else path.name
        if "$" in title:
            continue  # its number is known to Pd only
        seen = [w for w in windows if w["title"] == title]
        assert seen, f"Pd opened no window {title}"
        lost = min((missing(drawing, w) for w in seen), key=len)
        assert not lost, f"{drawing.where}: {lost}"
        compared += sum(1 for b in drawing.boxes if b) + len(drawing.cords)
    assert compared
