"""The computed frames, texts and cords are those that Pd draws: compared with its own drawing commands, without a
screen, and once with the pixels of a photograph."""
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


@pytest.mark.slow
@pytest.mark.skipif(any(not shutil.which(p) for p in ("Xvfb", "openbox", "xdotool", "import")),
                    reason="needs xvfb openbox xdotool imagemagick")
def test_the_corners_of_boxes_are_those_of_a_photograph(tmp_path):
    """Objects, messages and number boxes are framed in black on white: the pixels of every frame, and none beside."""
    import matplotlib.image
    boxes = ["#X obj 40 30 metro 250;", "#X msg 40 80 one two three four five six, f 14;", "#X obj 200 30 spigot;",
             "#X obj 200 80 route a b c d, f 20;",
             "#X obj 40 150 list append 10 20 30 40 50 60 70 80 90 100 110 120 130 140 150;"]
    patch = tmp_path / "frames.pd"
    patch.write_text("#N canvas 60 40 520 260 12;\n" + "\n".join(boxes) + "\n")
    done = subprocess.run([str(ROOT / "scripts" / "photograph"), str(patch), str(tmp_path / "frames.png"), "--stage",
                           str(tmp_path)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    image = matplotlib.image.imread(tmp_path / "frames.png")
    image = image if image.ndim == 2 else image[..., :3].mean(axis=2)
    menu = image.shape[0] - 260
    (drawing,) = drawings(pd_file.read(patch), STAGE)
    for drawn in drawing.boxes:
        f = drawn.frame
        left, top, bottom = int(f.left), int(f.top) + menu, int(f.bottom) + menu
        across = slice(left + 12, left + 20)  # beside inlets and outlets
        assert (image[top, across] < 0.4).all() and (image[bottom, across] < 0.4).all(), drawn.name
        assert (image[top + 1:top + 3, across] > 0.6).all() and (image[top - 1, across] > 0.6).all(), drawn.name
        assert (image[top:bottom, left] < 0.4).all() and (image[top:bottom, left - 1] > 0.6).all(), drawn.name
        if drawn.box.kind == "obj":
            middle = (top + bottom) // 2
            assert image[middle, int(f.right)] < 0.4 < 0.6 < image[middle, int(f.right) + 1], drawn.name
