"""The graphs of the help patches: what is drawn stays within the frame, is large enough to be seen, and is drawn
anew at any sample rate."""
import re
from collections import defaultdict

import pytest

from harness import Patch, stage_folder

# Help patch, its array, the receivers that are clicked after play, and the range: a receive name, or a number.
GRAPHS = [
    ("contact_impact~", "contact", [f"world{i}" for i in range(5)], "range"),
    ("contact_friction~", "force", [f"pair{i}" for i in range(4)], "range"),
    ("greed~", "theta", [f"choose-set {i}" for i in range(7)], "range"),
    ("particle~", "energy", [f"preset {i}" for i in (0, 7, 10)], 4),
    ("footstep~", "force", ["gait 0", "gait 1"], 2000),
]


@pytest.mark.parametrize("name, array, click, scale", [(n, a, c, r) for n, a, clicks, r in GRAPHS for c in clicks])
def test_what_a_graph_shows_stays_within_its_frame_and_is_seen(name, array, click, scale):
    patch = Patch(opens=stage_folder() / f"{name}-help.pd", own="own")
    patch.send(100, "help-play", "bang")
    receiver, _, value = click.partition(" ")
    patch.send(1000, f"own-{receiver}", value or "bang")
    patch.array(f"own-{array}")
    if isinstance(scale, str):
        patch.log("range", patch.obj("r", f"own-{scale}"))
    result = patch.render(2.2, 48000, dsp=False)
    if isinstance(scale, str):
        scale = result.logs["range"][-1][1][0]
    largest = abs(result.arrays[f"own-{array}"]).max()
    assert 0.08 * scale < largest < scale  # at the frame's edge it would be cut off


def frames(text):
    """Lowest and highest value of the frame of each array."""
    found = re.findall(r"#X array (\S+) \d+ float \d+;\n#X coords \S+ (\S+) \S+ (\S+) ", text)
    return {name: sorted((float(top), float(bottom))) for name, top, bottom in found}


@pytest.mark.parametrize("slider, value", [("own-shaker", 1), ("own-power", 30), ("own-decay", 3), ("own-preset", 7)])
def test_a_slider_at_its_end_draws_nothing_outside(slider, value):
    path = stage_folder() / "particle~-help.pd"
    patch = Patch(opens=path, own="own")
    patch.send(100, "help-play", "bang")
    patch.send(1000, slider, value)
    known = frames(path.read_text().replace("\\$0", "own"))
    assert len(known) == 3
    for array in known:
        patch.array(array)
    result = patch.render(1.8, 48000, dsp=False)
    for array, (lowest, highest) in known.items():
        drawn = result.arrays[array]
        assert lowest <= drawn.min() and drawn.max() <= highest, array


def canvases(text):
    """Boxes and cords of each canvas of a Pd file."""
    stack, done = [], []
    for line in re.split(r";\n", text):
        words = line.split()
        if line.startswith("#N canvas"):
            stack.append(([], []))
        elif line.startswith("#X restore"):
            done.append(stack.pop())
            stack[-1][0].append(line)
        elif line.startswith("#X connect"):
            stack[-1][1].append(tuple(map(int, words[2:6])))
        elif words[:1] == ["#X"] and words[1] != "coords":
            stack[-1][0].append(line)
    return done + stack


@pytest.mark.parametrize("path", sorted(stage_folder().glob("*.pd")), ids=lambda p: p.stem)
def test_a_graph_is_full_before_it_is_begun_anew_at_44100_hz(path):
    # [tabwrite~] redraws its array when it is full: begun anew before that, it never does.
    text = path.read_text()
    sizes = {name: int(size) for name, size in re.findall(r"#X array (\S+) (\d+) float", text)}
    sent, writers = defaultdict(list), []
    for boxes, cords in canvases(text):
        for source, _, target, _ in cords:
            metro = re.search(r" metro (\d+)$", boxes[source])
            name = re.search(r" tabwrite~ (\S+)$", boxes[target])
            send, receive = re.search(r" s (\S+)$", boxes[target]), re.search(r" r (\S+)$", boxes[source])
            if metro and name:
                writers.append((int(metro[1]), name[1]))
            if metro and send:
                sent[send[1]].append(int(metro[1]))
            if receive and name:
                writers.append((receive[1], name[1]))
    for period, array in writers:
        for ms in sent[period] if isinstance(period, str) else [period]:
            assert ms >= 1000 * sizes.get(array, 0) / 44100, array
