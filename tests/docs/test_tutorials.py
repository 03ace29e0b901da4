"""The tutorials of docs/tutorials: the patch of each plays in headless Pd, and every message that its page shows, or that
stands in the patch to be clicked, is taken.

A page's ```pd blocks hold one message a line, for the object of its patch: what [r NAME] of that patch gets."""
import pathlib
import re
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "patches"))

from harness import Patch  # noqa: E402

slow = pytest.mark.slow
FOLDER = ROOT / "docs" / "tutorials"
OBJECTS = sorted(path.parent.name for path in (ROOT / "externals").glob("*/CMakeLists.txt"))
WITH_TUTORIAL = [name for name in OBJECTS if (FOLDER / f"{name}.md").exists()]  # else one test says so
# Of objects without a sound of their own, what shows that they work: a receiver, and the number of it that must move.
SHOWN = {"phantom": "phantom-force", "playability~": "playability-out", "greed_gradient~": "gradient-force",
         "playability_map": "map-progress", "stress_haptic": "stress-force"}
ON_A_NETWORK = {"haptic_server", "ioa_link"}  # loaded, not begun: they would open ports
STEP = 400  # ms between two messages


def messages(name):
    """The lines of a page's ```pd blocks, in order."""
    text = (FOLDER / f"{name}.md").read_text()
    return [line.strip() for block in re.findall(r"^```pd\n(.*?)^```", text, re.M | re.S)
            for line in block.splitlines() if line.strip()]


def receiver(name):
    """Where the page's messages go: what the patch's box of the object receives, or that of its partner without ~."""
    lines = re.split(r";\n(?=#)", (FOLDER / f"{name}-tutorial.pd").read_text())
    boxes, depth = [], 0
    for line in lines:
        depth += line.startswith("#N canvas") - line.startswith("#X restore")
        if depth == 1 and line.startswith(("#X obj", "#X msg", "#X text", "#X floatatom", "#X symbolatom", "#X restore")):
            boxes.append(line.split(" ", 4)[4].split())
    cords = [tuple(map(int, line.rstrip(";\n").split()[2:])) for line in lines if line.startswith("#X connect")]
    for kind in (name, name.rstrip("~")):
        for source, _, sink, _ in cords:
            if boxes[sink][0].rstrip(",") == kind and boxes[source][0] in ("r", "receive"):
                return boxes[source][1]
    raise AssertionError(f"{name}-tutorial.pd: expected [r NAME] above [{name}]")


def to_click(name):
    """The message boxes `; receiver words` of a patch, but the first, which begins: (receiver, words)."""
    boxes = re.findall(r"^#X msg \d+ \d+ \\; (\S+) (.*);$", (FOLDER / f"{name}-tutorial.pd").read_text(), re.M)
    assert boxes[0][0] == "pd" and len(boxes) > 3
    return boxes[1:]


def play(name, sent=(), seconds=2.0):
    """The patch begins, then gets the messages (receiver, words), one after the other."""
    patch = Patch(opens=FOLDER / f"{name}-tutorial.pd")
    patch.record("left", patch.dac(1))
    if name in SHOWN:
        patch.log("shown", patch.obj("r", SHOWN[name]))
    if name not in ON_A_NETWORK:
        patch.send(50, "tutorial-start", "bang")
    for index, (receiver, message) in enumerate(sent):
        patch.send(800 + STEP * index, receiver, message)
    return patch.render(seconds + STEP / 1000 * len(sent))


@pytest.mark.parametrize("name", WITH_TUTORIAL)
def test_it_begins_to_sound_or_move_and_the_messages_of_the_page_are_taken(name):
    sent = messages(name)
    assert sent, f"{name}.md has no ```pd block"
    # An error in Pd's window is a failure. Until the first message, 0.8 s after the start, it plays by itself.
    result = play(name, [(receiver(name), message) for message in sent])
    if name in SHOWN:
        values = {tuple(atoms) for ms, atoms in result.logs["shown"] if name == "playability_map" or ms < 800}
        assert len(values) > (0 if name == "playability_map" else 3), f"{name}: {SHOWN[name]} has {values}"
    if name.endswith("~"):
        assert 0.01 < abs(result["left"][:38400]).max() <= 0.99
        assert abs(result["left"]).max() <= 1


@slow
@pytest.mark.parametrize("name", sorted(set(OBJECTS) - ON_A_NETWORK))
def test_the_messages_to_click_are_taken(name):
    listening = set(re.findall(r"^#X obj \d+ \d+ r (\S+);|^#X obj .* hsl \S+ \S+ \S+ \S+ \S+ \S+ \S+ (\S+) ",
                               (FOLDER / f"{name}-tutorial.pd").read_text(), re.M))
    receivers = {word for pair in listening for word in pair if word}
    assert {receiver for receiver, _ in to_click(name)} <= receivers
    play(name, to_click(name))


def loudness(result, begin, end):
    """Root mean square of the sound between two times, s."""
    part = result["left"][int(48000 * begin):int(48000 * end)].astype(float)
    return (part**2).mean() ** 0.5


def test_the_clarinet_is_silent_and_speaks_at_the_pressures_that_the_page_names():
    result = play("greed~", [("greed-pressure", p) for p in (1400, 1400, 1400, 1400, 3500, 3500, 3500, 1500, 1500, 1500)])
    silent, loud, soft = loudness(result, 2, 2.4), loudness(result, 3.2, 3.6), loudness(result, 4.4, 4.8)
    assert silent < 1e-6 and 1e-3 < soft < 0.1 * loud


@pytest.mark.parametrize("preset", ["clarinet", "syrinx", *(pytest.param(preset, marks=slow) for preset in (
    "sax", "oboe", "trumpet", "trombone", "voice"))])
def test_every_preset_sounds_at_the_pressure_of_the_faq_and_one_below_700_pa(preset):
    faq = " ".join((ROOT / "docs" / "faq.md").read_text().split())
    assert "with `[sig~ 2000]` every preset sounds, and below 700 only the syrinx sounds" in faq
    for pressure, sounds in ((2000, True), (690, preset == "syrinx")):
        patch = Patch()
        reed = patch.obj("sig~", pressure) >> patch.obj("greed~", preset, "-tune", 1)
        patch.record("left", reed[0])
        assert (loudness(patch.render(2.5), 2, 2.5) > 1e-3) == sounds


@slow
def test_the_glass_and_the_door_sound_as_the_page_says():
    wait = ("rub-velocity", 0.4)
    result = play("contact_friction~", [wait] * 3 + [("rub-velocity", 0.08), ("rub-normal", 8)] + [wait] * 3)
    assert loudness(result, 1.6, 2) < 1e-3  # 2 N: it slides, the glass rings off
    assert loudness(result, 3.6, 4) > 0.1  # 8 N: it sings
    lines = messages("contact_friction~")
    door = next(i for i, line in enumerate(lines) if line.startswith("modes 110 "))
    bar = next(i for i, line in enumerate(lines) if line.startswith("modes 196 "))
    slow = [("rub-velocity", 0.01), ("rub-normal", 10)]
    steps = [("rub", line) for line in lines[door:bar - 2]] + slow + [slow[0]] * 4
    back = [("rub-velocity", 0.08), ("rub-normal", 2)]
    steps += [("rub", line) for line in lines[bar - 2:]] + back + [back[0]] * 4
    result = play("contact_friction~", steps)
    end = 0.8 + STEP / 1000 * len(steps)
    creak = 0.8 + STEP / 1000 * (len(lines[door:bar - 2]) + 6)
    assert loudness(result, creak - 0.4, creak) > 0.002
    assert loudness(result, end - 0.4, end) > 0.05


def test_the_felt_mallet_of_the_page_is_duller_than_the_steel_ball_and_heard():
    result = play("modal_impact~", [("modal", "hit 0 0 2.5 0.5"), ("modal", "choke 0.2"), ("modal", "choke 0"),
                                    ("modal", "hardness 1e9 2.3 1"), ("modal", "bang")])
    assert "hardness 1e9 2.3 1" in messages("modal_impact~")
    steel, felt = (abs(result["left"][int(48000 * t):int(48000 * (t + 0.35))]).max() for t in (0.8, 2.4))
    assert 0.002 < felt < 0.2 * steel


def test_the_force_of_the_gradient_is_there_at_its_edge_and_gone_where_the_reed_plays():
    result = play("greed_gradient~", [("gradient-z", 0.5)] * 4 + [("gradient-y", 0.3)] * 5 + [("gradient-y", 0.1)] * 5)
    edge, plays, beyond = ([atoms for ms, atoms in result.logs["shown"] if ms < end][-1] for end in (2300, 4300, 6300))
    assert edge[0] > 0.5 and edge[1] < -0.3
    assert max(abs(n) for n in plays) < 0.1
    assert max(abs(n) for n in beyond) < 0.01


@pytest.mark.parametrize("end", [".md", "-tutorial.pd"])  # not the object's own name: Pd would take it for the object
def test_every_object_has_a_tutorial_and_every_tutorial_an_object(end):
    found = {path.name.removesuffix(end) for path in FOLDER.glob(f"*{end}")}
    missing, extra = sorted(set(OBJECTS) - found), sorted(found - set(OBJECTS))
    assert not missing, f"write docs/tutorials/{missing[0]}{end}, like {OBJECTS[0]}'s"
    assert not extra, f"docs/tutorials/{extra[0]}{end} is of no object"


def test_the_ground_of_the_surfaces_page_is_walked_on(tmp_path):
    """The example of docs/surfaces.md, as a user would copy it."""
    text, = re.findall(r"^```surface\n(.*?)^```", (ROOT / "docs" / "surfaces.md").read_text(), re.M | re.S)
    (tmp_path / "mine.txt").write_text(text)
    for name, loudest in ((tmp_path / "mine.txt", 0.01), ("concrete", 0.001)):
        patch = Patch()
        walker = patch.obj("footstep~", "concrete")
        patch.at(0, walker, ["surface", str(name)])
        patch.at(100, walker, "walk 1")
        patch.record("sound", walker[0])
        assert loudest < abs(patch.render(3)["sound"]).max() < 1
