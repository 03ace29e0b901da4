"""The bus of patches/audiohaptics/ioa: what passes, what is refused and said, and who hears whom."""
import pytest

from harness import Patch
from ioa_system import System, of, taps

RIGHT = ["raw 0 1 2 3", "rawbutton 0 1 1", "hand 0 1 2 3 0.1 0 -0.1", "button 5 0 1", "grip 5 1",
         "hit 57 disk 25 0 6 0 0 1 0.25 0", "hit 57 7 25 0 6 0 0 1 0.25 0",
         "contact 60 disk 0.5 0 0 0.25", "release 70 disk", "release 70 7",
         "excite 57 disk 25 0 6 0.25", "force 60 0 0 0.25", "listener 0 0 300 500",
         "mark 57 disk 25 0 6 10", "table disk disk.modal.npz", "model del disk",
         "model add p plane 0 1 0 -20", "model add s sphere 0 0 0 20",
         "model add b box 0 0 0 30 10 20", "model add b box 0 0 0 30 10 20 1 0 0 0",
         "model add disk disk 0 0 0 0 0 1 50 12", "model add 7 mesh cup.obj 2",
         "model set disk mat 900 0.5 0.2", "model set disk move 0 0 5", "publish", "quit"]
WRONG = {"raw 0 1 2": "expected t x y z", "raw 0 1 2 3 4": "expected t x y z",
         "raw 0 1 foo 3": "expected t x y z", "raw 0 1 1e39 3": "expected t x y z", "hand": "expected t",
         "hand 0 1 2 3 0.1 0": "expected t x y z vx vy vz",
         "hit disk 57 25 0 6 0 0 1 0.25 0": "expected t id x y z nx ny nz vn vt",
         "hit 57 disk 25 0 six 0 0 1 0.25 0": "expected t id", "release disk": "expected t id",
         "contact 60 disk 0.5 0 0": "expected t id depth", "table disk": "expected id file",
         "table disk 7": "expected id file", "model": "expected add",
         "model add disk": "expected add", "model add disk disk 0 0 0 0 0 1 50": "expected add",
         "model add b box 0 0 0 30 10 20 1": "expected add", "model add c cone 0 0 0": "expected add",
         "model add s sphere 0 0 0 1e39": "expected add", "model set disk": "expected add",
         "model set disk 3": "expected add", "model del": "expected add", "model paint disk": "expected",
         "publish 1": "expected nothing", "quit now": "expected nothing", "fie 1 2": "expected a topic",
         "7 8 9": "expected a topic", "bang": "expected a topic"}


def test_right_messages_pass_and_wrong_ones_are_named_with_what_was_expected():
    patch = Patch()
    bus = patch.obj("ioa_bus", "lab")
    topics = sorted({m.split()[0] for m in RIGHT})
    patch.log("passed", patch.obj("ioa_bus", "lab", *topics))
    patch.log("errors", patch.obj("r", "lab.error"))
    patch.at(0, bus, "module tester")
    for i, message in enumerate(RIGHT + list(WRONG)):
        patch.at(1 + i, bus, message)
    patch.at(100, bus, RIGHT[0])
    result = patch.render(0.2, expect_errors=["ioa-error: lab tester raw 0 1 2 expected t x y z"])

    def plain(message):
        return [word if not word.lstrip("-").replace(".", "").isdigit() else pytest.approx(float(word))
                for word in message.split()]
    assert [atoms for _, atoms in result.logs["passed"]] == [plain(m) for m in [*RIGHT, RIGHT[0]]]
    errors = [atoms for _, atoms in result.logs["errors"]]
    assert len(errors) == len(WRONG)
    for atoms, (message, expected) in zip(errors, WRONG.items()):
        text = " ".join(f"{a:g}" if isinstance(a, float) else a for a in atoms)
        assert text.startswith("error tester") and expected in text, message


def test_a_field_too_few_or_too_many_is_wrong_for_every_topic():
    fixed = [m for m in RIGHT if m.split()[0] not in ("model", "publish", "quit")]
    patch = Patch()
    bus = patch.obj("ioa_bus", "lab")
    patch.log("passed", patch.obj("ioa_bus", "lab", *{m.split()[0] for m in fixed}))
    patch.log("errors", patch.obj("r", "lab.error"))
    for i, message in enumerate(fixed):
        patch.at(1 + i, bus, message.rsplit(" ", 1)[0])
        patch.at(1 + i, bus, message + " 7")
    result = patch.render(0.1, expect_errors=["ioa-error: lab module raw 0 1 2 expected"])
    assert not result.logs["passed"] and len(result.logs["errors"]) == 2 * len(fixed)


def test_a_thousand_wrong_messages_are_two_lines_and_the_rest_goes_on():
    patch = Patch()
    bus = patch.obj("ioa_bus", "lab")
    patch.log("passed", patch.obj("ioa_bus", "lab", "raw"))
    start = patch.start >> patch.obj("metro", 0.5)
    start >> patch.msg("raw 0 1 foo 3") >> bus
    start >> patch.msg("raw 0 1 2 3") >> bus
    result = patch.render(0.6, expect_errors=["ioa-error: lab .*raw 0 1 foo 3 expected t x y z",
                                              "ioa-error: lab [0-9]+ more wrong messages"])
    assert len(result.errors) == 2 + 1  # at 0 ms, what came until 500 ms, and one at 500.5 ms
    assert len(result.logs["passed"]) > 1000


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scripts")
    return {"one": taps(folder / "one.txt", (25, 0), (-10, 20)),
            "two": taps(folder / "two.txt", (0, 40), (0, -30), speed=0.4, start=13)}


def played(scripts, *names, **modules):
    patch = Patch()
    for name in names:
        system = System(patch, name, sdd=["ioa_sdd_script", scripts[name]], r_modal=None, **modules)
        patch.at(0, system.box["sdd"], "bang")
    result = patch.render(0.45)
    return {name: of(result, name, "hit") for name in names}


@pytest.mark.parametrize("server", ["ioa_is", "ioa_is_pd"])
def test_two_systems_in_one_pd_do_not_hear_each_other(scripts, server):
    alone = {**played(scripts, "one", **{"is": server}), **played(scripts, "two", **{"is": server})}
    assert [len(alone[name]) for name in ("one", "two")] == [2, 2]
    assert played(scripts, "one", "two", **{"is": server}) == alone
