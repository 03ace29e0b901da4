"""Pd draws every help patch and instrument: a window of the declared size, drawn on, without a word
in the console, before and after the click that makes it sound. The pictures stay in
BUILD/photographs for people to look at."""
import json
import os
import pathlib
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor

import matplotlib.image
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
STAGE = pathlib.Path(os.environ.get("TACTUS_STAGE", BUILD / "tactus"))
PROGRAMS = ("Xvfb", "openbox", "xdotool", "import", "pd")
BAD = re.compile(r"error|couldn't create|no method|no such", re.IGNORECASE)
HELP = sorted(STAGE.glob("*-help.pd"))
INSTRUMENTS = [p for p in sorted(ROOT.glob("patches/*/*.pd")) if "pd dsp" in p.read_text()]

pytestmark = pytest.mark.skipif(any(not shutil.which(p) for p in PROGRAMS),
                                reason="needs xvfb openbox xdotool imagemagick")


def has_scroll_bar(picture):
    """Whether the right edge of the canvas is a grey bar instead of background."""
    image = matplotlib.image.imread(picture)
    image = image[..., None] if image.ndim == 2 else image[..., :3]
    pixels = image[60:-30, -12:]
    grey = (abs(pixels - pixels.mean(axis=2, keepdims=True)).max(axis=2) < 0.02) \
        & (pixels.mean(axis=2) > 0.6) & (pixels.mean(axis=2) < 0.92)
    return grey.mean() > 0.5


def take(patch, played):
    """Of one Pd: pictures before the click that makes it sound and after it, or one without a click."""
    folder = BUILD / "photographs"
    folder.mkdir(exist_ok=True)
    out = folder / f"{patch.stem}.png"
    after = folder / f"{patch.stem}-played.png"
    pictures = [str(after), "--before", str(out), "--play"] if played else [str(out)]
    return ([out, after] if played else [out]), subprocess.run(
        [str(ROOT / "scripts" / "photograph"), str(patch), *pictures, "--stage", str(STAGE)],
        capture_output=True, text=True, timeout=240)


@pytest.fixture(scope="module")
def pictures(request):
    """What is still being photographed, by patch: four at once, since most of the time goes by waiting
    for windows."""
    wanted = {item.callspec.params["patch"] for item in request.session.items if "pictures" in item.fixturenames}
    with ThreadPoolExecutor(4) as photographers:
        yield {patch: photographers.submit(take, patch, patch in HELP) for patch in wanted}
        photographers.shutdown(cancel_futures=True)


def seen_in(future):
    """The pictures' paths, once it is sure that they show the patch as it should be."""
    paths, done = future.result()
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == len(paths)
    for path, seen in zip(paths, found):
        assert not BAD.search(seen["pd_said"]), seen["pd_said"]
        width, height = seen["declared"]
        assert seen["window"][0] == width and height <= seen["window"][1] <= height + 60, seen
        assert not has_scroll_bar(path), "something lies outside the window: Pd shows scroll bars"
        assert seen["colours"] > 12 and seen["commonest"] < 0.98, f"hardly anything drawn: {seen}"
    return paths


def cases(patches, quick):
    return [pytest.param(p, id=p.stem, marks=() if p.stem == quick else pytest.mark.slow) for p in patches]


@pytest.mark.parametrize("patch", cases(HELP, "greed~-help"))
def test_a_help_patch_looks_right_and_changes_with_the_click(patch, pictures):
    before, after = seen_in(pictures[patch])
    differing = subprocess.run(["compare", "-metric", "AE", str(before), str(after), "null:"],
                               capture_output=True, text=True).stderr
    assert float(differing.split()[0]) > 20, "nothing moves on the screen after the click"


@pytest.mark.parametrize("patch", cases(INSTRUMENTS, None))
def test_an_instrument_looks_right(patch, pictures):
    seen_in(pictures[patch])
