"""Help patches: what a graph draws stays within its frame, is large enough to be seen and is drawn anew at any
sample rate; and, of patches/live, no message box that is clicked makes an error."""
import re
from collections import defaultdict

import pd_file
import pytest

from harness import Patch, stage_folder
from harness.run import ROOT

slow = pytest.mark.slow
LIVE = ROOT / "patches" / "live"
# Help patch, its array, the receivers that are clicked after play, and the range: a receive name, or a number.
GRAPHS = [
    ("contact_impact~", "contact", [f"world{i}" for i in range(5)], "range"),
    ("contact_friction~", "force", [f"pair{i}" for i in range(4)], "range"),
    ("greed~", "theta", [f"choose-set {i}" for i in range(7)], "range"),
    ("particle~", "energy", [f"preset {i}" for i in (0, 7, 10)], 4),
    ("footstep~", "force", ["gait 0", "gait 1"], 2000),
]


@pytest.mark.parametrize("name, array, click, scale", [
    pytest.param(name, array, click, scale, marks=slow if i else ())
    for name, array, clicks, scale in GRAPHS for i, click in enumerate(clicks)])
def test_what_a_graph_shows_stays_within_its_frame_and_is_seen(name, array, click, scale):
    patch = Patch(opens=stage_folder() / f"{name}-help.pd", own="own")
    patch.send(100, "help-play", "bang")
    receiver, _, value = click.partition(" ")
    patch.send(1000, f"own-{receiver}", value or "bang")
    patch.array(f"own-{array}")
    patch.log("range", patch.obj("r", f"own-{scale}"))
    result = patch.render(2.2, dsp=False)
    scale = result.logs["range"][-1][1][0] if isinstance(scale, str) else scale
    assert 0.08 * scale < abs(result.arrays[f"own-{array}"]).max() < scale  # at the frame's edge it would be cut off


def test_a_slider_at_its_end_draws_nothing_outside():
    path = stage_folder() / "particle~-help.pd"
    frames = re.findall(r"#X array (\S+) \d+ float \d+;\n#X coords \S+ (\S+) \S+ (\S+) ",
                        path.read_text().replace("\\$0", "own"))
    assert len(frames) == 3
    for slider, value in (("own-shaker", 1), ("own-power", 30), ("own-decay", 3), ("own-preset", 7)):
        patch = Patch(opens=path, own="own")
        patch.send(100, "help-play", "bang")
        patch.send(1000, slider, value)
        for array, *_ in frames:
            patch.array(array)
        drawn = patch.render(1.8, dsp=False).arrays
        for array, *ends in frames:
            lowest, highest = sorted(map(float, ends))
            assert lowest <= drawn[array].min() and drawn[array].max() <= highest, (array, slider)


def canvases(canvas):
    yield canvas
    for box in canvas.boxes:
        if box.canvas:
            yield from canvases(box.canvas)


@pytest.mark.parametrize("path", sorted(stage_folder().glob("*.pd")), ids=lambda p: p.stem)
def test_a_graph_is_full_before_it_is_begun_anew_at_44100_hz(path):
    # [tabwrite~] redraws its array when it is full: begun anew before that, it never does.
    sizes, sent, writers = {}, defaultdict(list), []
    for canvas in canvases(pd_file.read(path)):
        sizes.update(canvas.arrays)
        for source, _, target, _ in canvas.cords:
            first, then = (canvas.boxes[i].plain_words() + ["", ""] for i in (source, target))
            if then[0] == "tabwrite~" and first[0] in ("metro", "r"):
                writers.append((first[0], first[1], then[1]))
            if first[0] == "metro" and then[0] == "s":
                sent[then[1]].append(first[1])
    for kind, which, array in writers:
        for ms in [which] if kind == "metro" else sent[which]:
            assert float(ms) >= 1000 * sizes.get(array, 0) / 44100, array


@pytest.mark.parametrize("path", sorted(LIVE.glob("*-help.pd")), ids=lambda p: p.stem)
def test_no_message_box_of_a_help_patch_makes_an_error(path, tmp_path):
    """Every one of its front that has neither a semicolon nor a dollar is clicked by a [r click-N]."""
    boxes = pd_file.read(path).boxes
    clicked = [i for i, box in enumerate(boxes) if box.kind == "msg" and not re.search(r"\\;|\$", " ".join(box.words))]
    assert clicked
    copy = tmp_path / path.name
    copy.write_text(path.read_text().rstrip() + "".join(
        f"\n#X obj 0 0 r click-{i};\n#X connect {len(boxes) + n} 0 {i} 0;" for n, i in enumerate(clicked)) + "\n")
    patch = Patch(opens=copy)
    patch.send(100, "help-play", "bang")
    # A file is read after it has been written.
    for n, i in enumerate(sorted(clicked, key=lambda i: boxes[i].name == "read")):
        patch.send(500 + 40 * n, f"click-{i}", "bang")
    patch.render(0.6 + 0.04 * len(clicked), path=[LIVE], timeout=100)


def test_every_abstraction_of_the_live_patches_has_a_help_patch():
    made = {p.stem for p in LIVE.glob("*.pd")
            if ("obj", "inlet") in ((box.kind, box.name) for box in pd_file.read(p).boxes)}
    assert {"tactus_preset", "tactus_osc", "tactus_keys", "tactus_pads", "keys_reed_voice", "keys_body_voice"} <= made
    assert all((LIVE / f"{name}-help.pd").is_file() for name in made)
