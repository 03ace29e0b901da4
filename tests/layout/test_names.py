"""Two copies of any help patch or instrument live side by side, and so does each with every other: no name by which
boxes reach each other without a cord is sent by one and heard by another.

A name that carries $0 or an argument is an instance's own. What is left is compared over all patches of the library:
a name may be heard (the controls of [pd outside]) or sent (what others may listen to), not both, and nothing may be
defined by it: an array, a text, a template, a device's name.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from pd_canvas import ROOT, Stage, pd_file
from pd_names import crosstalk

sys.path.insert(0, str(ROOT / "tests" / "patches"))
from harness import Patch  # noqa: E402

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
STAGE = Stage(os.environ.get("TACTUS_STAGE", BUILD / "tactus"), BUILD / "declarations.json")
# Deliberately one for all, with the reason; a patch of this list is not opened twice.
SHARED = {
    "ioa_clock": "the one clock from which all modules of a Pd read their time",
    "design_link": "moves the parts of beam and arm by the name at which they hear every patch, design-part",
}

STILL = 0.03  # of the workspace: what the force on a free hand of reed_haptic moves it in half a second


def drawn(folder, name, text):
    path = folder / f"{name}.pd"
    path.write_text("#N canvas 0 0 400 300 12;\n" + text)
    return pd_file.read(path)


def canvases():
    return {path.stem: pd_file.read(path) for path in STAGE.patches()}


def test_no_patch_reaches_another_or_a_copy_of_itself_by_a_name():
    found = {name: users for name, users in crosstalk(canvases()).items() if not users.keys() & SHARED.keys()}
    assert found == {}


def test_the_list_of_shared_names_is_no_longer_than_it_must_be():
    users = set().union(*crosstalk(canvases()).values())
    assert SHARED.keys() <= users


@pytest.mark.parametrize("text,fault", [
    ("#X obj 10 10 s level;\n#X obj 10 40 r level;\n", True),
    ("#X obj 10 10 s \\$0-level;\n#X obj 10 40 r \\$0-level;\n", False),
    ("#X obj 10 40 r level;\n", False),
    ("#X msg 10 10 \\; level 1;\n#X obj 10 40 r level;\n", True),
    ("#X msg 10 10 level 1;\n#X obj 10 40 r level;\n", False),
    ("#X obj 10 10 hsl 100 15 0 1 0 0 level level empty 0 0 0 12 #ffffff #000000 #000000 0 1;\n", True),
    ("#X obj 10 10 hsl 100 15 0 1 0 0 \\$1-level \\$1-level empty 0 0 0 12 #ffffff #000000 #000000 0 1;\n", False),
    ("#X floatatom 10 10 5 0 0 0 - level -;\n#X obj 10 40 s level;\n", True),
    ("#X obj 10 10 array define level 10;\n", True), ("#X obj 10 10 array define \\$0-level 10;\n", False),
    ("#X obj 10 10 phantom sim -name hand;\n", True), ("#X obj 10 10 phantom sim -name \\$0-hand;\n", False),
    ("#X obj 10 10 v level;\n", True), ("#X obj 10 10 struct cell float x;\n", True),
    ("#N canvas 0 0 100 100 inner 0;\n#X obj 10 10 s level;\n#X restore 10 10 pd inner;\n#X obj 10 40 r level;\n", True),
])
def test_a_planted_name_is_found(tmp_path, text, fault):
    assert bool(crosstalk({"drawn": drawn(tmp_path, "drawn", text)})) == fault


def said_of_two(folder, patches):
    """What Pd complains of while it opens these and a copy of each - in a folder of its own, since Pd opens no file
    twice - and plays for a second."""
    second = folder / "copies"
    second.mkdir()
    patches = [*patches, *(pathlib.Path(shutil.copy(path, second)) for path in patches)]
    end = folder / "end.pd"
    end.write_text("#N canvas 0 0 400 300 12;\n#X obj 10 10 loadbang;\n#X obj 10 40 delay 1000;\n"
                   "#X msg 10 70 \\; pd quit;\n#X connect 0 0 1 0;\n#X connect 1 0 2 0;\n")
    words = [word for path in (*patches, end) for word in ("-open", path)]
    done = subprocess.run(["pd", "-nogui", "-batch", "-noprefs", "-stderr", "-path", STAGE.folder, *words],
                          capture_output=True, text=True, timeout=300, check=True)
    return [line for line in done.stderr.splitlines() if re.search("multiply defined|couldn't create|^error", line)]


@pytest.mark.slow
def test_two_copies_of_every_patch_open_at_once(tmp_path):
    """In one Pd, so each with each. Only design_part, which is opened here without its table, says what it misses."""
    patches = STAGE.patches()
    assert len(patches) > 100
    said = said_of_two(tmp_path, patches)
    assert [line for line in said if not line.startswith("error: stress_haptic: ")] == []


def copies(folder, *patches):
    """Copies of staged patches in which $0 has a name instead of a number."""
    made = []
    for own, name in patches:
        made.append(folder / f"{own}.pd")
        made[-1].write_text((STAGE.folder / f"{name}.pd").read_text().replace("\\$0", own))
    return made


def moved(log):
    return max(atoms[0] for _, atoms in log) - min(atoms[0] for _, atoms in log) if log else 0


@pytest.mark.parametrize("first, second", [
    ("phantom-help", "phantom-help"), pytest.param("greed_gradient~-help", "phantom-help", marks=pytest.mark.slow),
    ("reed_haptic", "reed_haptic"), pytest.param("struck_disk", "mass_spring", marks=pytest.mark.slow)])
def test_a_hand_that_moves_in_one_leaves_the_other_alone(tmp_path, first, second):
    """In Pd: the first is played, the second only opened."""
    patch = Patch(opens=copies(tmp_path, ("one", first), ("two", second)))
    for own in ("one", "two"):
        patch.log(own, patch.obj("r", f"{own}-y"))
    receiver = "one-help" if first == "phantom-help" else "one-hand"
    patch.log("hand", patch.obj("r", receiver))
    patch.send(50, receiver, "hand spring 300 3, target 0 20 10")
    result = patch.render(0.6)
    assert result.logs["hand"]
    assert moved(result.logs["two"]) < STILL
    if first in ("phantom-help", "reed_haptic"):
        assert moved(result.logs["one"]) > 3 * STILL
