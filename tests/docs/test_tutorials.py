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

FOLDER = ROOT / "docs" / "tutorials"
OBJECTS = sorted(path.parent.name for path in (ROOT / "externals").glob("*/CMakeLists.txt"))
# Where the page's messages go; and, of objects without a sound of their own, what shows that they work:
# a receiver, and the number of it that must move.
RECEIVER = {"greed~": "greed", "footstep~": "footstep", "modal_impact~": "modal", "phantom": "phantom",
            "phantom~": "string", "particle~": "particle", "contact_impact~": "impact",
            "contact_friction~": "rub", "playability~": "playability", "greed_gradient~": "gradient",
            "playability_map": "map", "stress_haptic": "stress", "haptic_server": "server", "ioa_link": "link"}
SHOWN = {"phantom": "phantom-force", "playability~": "playability-out", "greed_gradient~": "gradient-force",
         "playability_map": "map-progress", "stress_haptic": "stress-force"}
ON_A_NETWORK = {"haptic_server", "ioa_link"}  # loaded, not begun: they would open ports
STEP = 400  # ms between two messages


def messages(name):
    """The lines of a page's ```pd blocks, in order."""
    text = (FOLDER / f"{name}.md").read_text()
    return [line.strip() for block in re.findall(r"^```pd\n(.*?)^```", text, re.M | re.S)
            for line in block.splitlines() if line.strip()]


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


@pytest.mark.parametrize("name", OBJECTS)
def test_begin_sounds_or_moves(name):
    result = play(name)
    if name in SHOWN:
        values = {tuple(atoms) for _, atoms in result.logs["shown"]}
        assert len(values) > (0 if name == "playability_map" else 3), f"{name}: {SHOWN[name]} has {values}"
    if name.endswith("~"):
        loudest = abs(result["left"]).max()
        assert 0.01 < loudest <= 0.99, f"{name}: {loudest}"


@pytest.mark.parametrize("name", OBJECTS)
def test_the_messages_of_the_page_are_taken(name):
    sent = messages(name)
    assert sent, f"{name}.md has no ```pd block"
    result = play(name, [(RECEIVER[name], message) for message in sent])  # an error in Pd's window is a failure
    if name.endswith("~"):
        assert abs(result["left"]).max() <= 1


@pytest.mark.parametrize("name", sorted(set(OBJECTS) - ON_A_NETWORK))
def test_the_messages_to_click_are_taken(name):
    listening = set(re.findall(r"^#X obj \d+ \d+ r (\S+);|^#X obj .* hsl \S+ \S+ \S+ \S+ \S+ \S+ \S+ (\S+) ",
                               (FOLDER / f"{name}-tutorial.pd").read_text(), re.M))
    receivers = {word for pair in listening for word in pair if word}
    assert {receiver for receiver, _ in to_click(name)} <= receivers
    play(name, to_click(name))


def test_every_object_has_a_tutorial_and_every_tutorial_an_object():
    assert OBJECTS == sorted(RECEIVER)
    assert {path.stem for path in FOLDER.glob("*.md")} == set(OBJECTS)
    # Not the object's own name: Pd would take the patch for the object.
    assert {path.stem for path in FOLDER.glob("*.pd")} == {f"{name}-tutorial" for name in OBJECTS}


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
