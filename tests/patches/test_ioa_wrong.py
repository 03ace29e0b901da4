"""The ioa modules under wrong messages and doubled or deleted modules: one line each, and they go on."""
import re
import struct

import pytest

from harness import Patch
from ioa_system import NEEDS_DISK, System, hits, of, taps

pytestmark = pytest.mark.skipif(NEEDS_DISK, reason="the disk's table is made where modal_fem is built")

APART_MS = 600  # ioa_error tells the first wrong message of each half second and counts the others
WRONG = {  # role: [(message, what the one line says)]; what a topic's fields are is tested in test_ioa_bus.py
    "bus": [("raw foo", "lab module raw foo expected t x y z"),
            ("model add a sphere 0 0 0 0", "lab module model .*expected add id"),
            ("model add a box 0 0 0 1 -1 1", "expected add id"), ("model add a disk 0 0 0 0 0 1 5 0", "expected add id"),
            ("model set disk mat 1 2 3 4", "expected add id"), ("model set disk colour red", "expected add id"),
            ("model set ghost mat 1 2 3", "ghost: no such body"), ("model del ghost", "ghost: no such body"),
            ("table disk nosuch.npz", "nosuch.npz: file not found"),
            ("excite 0 disk 0 0 6 1e20", "expected 1e-06..50")],
    "sdd": [("rate foo", "ioa_sdd_script rate foo expected a number from 1 to 4000"), ("rate 1e38", "rate 1e"),
            ("rate", "rate expected"), ("rate 0", "rate 0 expected"),
            ("start nosuch.txt", "start nosuch.txt expected a file"), ("start 3", "start 3 expected a file")],
    "re": [("tau foo", "ioa_re tau foo expected a number from 0.01"), ("tau 1e38", "tau 1e"),
           ("tau -1", "tau -1"), ("grip_button foo", "grip_button foo expected"), ("foo", "expected a topic")],
    "cs": [("table disk", "lab ioa_cs_modal table disk expected id file"), ("table 3 4", "expected id file")],
    "mm_haptic": [("add x blob 1", "ioa_mm_haptic model add x blob 1 expected add id"),
                  ("mat disk foo", "ioa_mm_haptic model set disk mat foo expected add id"),
                  ("foo", "ioa_mm_haptic foo expected add or mat"), ("load", "load expected a file"),
                  ("load nosuch.txt", "load nosuch.txt expected a file"), ("load 3", "load 3 expected a file")],
    "mm_sound": [("speaker foo", "speaker foo expected 0 to 3 numbers"), ("speaker 0 0 0 0", "0 to 3"),
                 ("speaker 1e38 0 0", "0 to 3"), ("speaker hand foo", "speaker-hand foo expected")],
    "mm_screen": [("size foo", "ioa_mm_screen size foo expected"), ("size 1e38", "size 1e"),
                  ("colour disk foo", "colour foo expected")],
    "r_spring": [("spring foo", "ioa_r_spring spring foo expected 1 to 2"), ("spring 1e38 1", "spring 1e"),
                 ("spring 100 foo", "100 foo expected"), ("spring", "spring expected")],
    "r_modal": [("latency 1e38", "ioa_r_modal latency 1e.* expected a number from 0 to 1000"),
                ("latency foo", "latency foo"), ("latency -3", "latency -3"), ("ears 1e38", "ears 1e"),
                ("ears foo", "ears foo"), ("fix foo", "fix foo expected 3"), ("fix 1e38 0 0", "fix 1e"),
                ("fix 1", "fix 1 expected"), ("gain foo", "gain foo"), ("load nosuch.npz", "file not found")],
}


def loudest(result, begin_ms):
    return abs(result["lab.left"][int(begin_ms * 48):]).max()


@pytest.mark.parametrize("role", WRONG)
def test_a_wrong_message_is_one_line_and_nothing_stops(role, tmp_path):
    patch = Patch()
    system = System(patch, sdd=["ioa_sdd_script", taps(tmp_path / "taps.txt", (10, 0))])
    box = system.bus if role == "bus" else system.box[role]
    for k, (message, _) in enumerate(WRONG[role]):
        patch.at(APART_MS * (k + 1), box, message)
    end = APART_MS * (len(WRONG[role]) + 1)
    patch.at(end, system.box["sdd"], "bang")
    result = patch.render(end / 1000 + 0.4, expect_errors=["error"])
    assert len(result.errors) == len(WRONG[role]), result.errors
    for line, (message, pattern) in zip(result.errors, WRONG[role]):
        assert re.search(pattern, line), (message, line)
    assert [body for t, body in hits(result) if t > end] == ["disk"]
    assert loudest(result, end) > 1e-3


def test_packets_that_are_no_osc_are_told_once_and_counted(tmp_path):
    patch = Patch()
    system = System(patch, sdd=["ioa_sdd_osc"])
    packets = ("foo", "1 2 3", "1e20 5", "47 114 97 119", "47 98 99 100 0 0 0", "300 300 1 1 1 1 1 1", "47 98 0 0 44 78 0 0",
               " ".join(map(str, b"/raw\0\0\0\0,fffi\0\0\0" + struct.pack(">fffi", 1, 2, 3, 1 << 24))))
    for k, packet in enumerate(packets):
        patch.at(10 + k, system.box["sdd"], packet)
    result = patch.render(1, expect_errors=["ioa_sdd_osc foo expected listen", "5 more wrong messages",
                                             "ioa_sdd_osc type N is not taken", "raw: expected ms below 16777216"])
    assert len(result.errors) == 4


@pytest.mark.parametrize("module, more, kind", [("ioa_re", (1,), "recognition-engine"),
                                                ("ioa_is", (), "interaction-server"),
                                                ("ioa_is_pd", (), "interaction-server")])
def test_a_second_one_of_its_kind_says_so_waits_and_takes_over_when_the_first_is_deleted(module, more, kind, tmp_path):
    path = taps(tmp_path / "taps.txt", *[(x, 0) for x in range(0, 40, 2)])
    patch = Patch()
    patch.sub("first").obj(module, "lab", *more)
    system = System(patch, sdd=["ioa_sdd_script", path], **{"is": "ioa_is_pd" if module == "ioa_is_pd" else "ioa_is"})
    patch.at(600, system.box["sdd"], "bang")
    patch.send(1000, "pd-first", "clear")
    result = patch.render(4, expect_errors=[f"expected to be the only {kind}"])
    begun = [t for t, _ in hits(result)]
    assert len(result.errors) == 1 and len(set(begun)) == len(begun) == len(of(result, "lab", "excite"))
    assert len([t for t in begun if t < 1000]) == 2
    assert len([t for t in begun if 2000 < t < 3900]) >= 9  # one in 187 ms
    assert loudest(result, 2000) > 1e-3


def struck(result, begin=0.0):
    return [atoms[:2] for t, atoms in result.logs["lab.excite"] if t > begin]


@pytest.mark.parametrize("second", ["ioa_cs_modal", "ioa_cs_physics"])
def test_a_second_contents_server_of_a_body_says_so_and_waits(second, tmp_path):
    path = taps(tmp_path / "taps.txt", (0, 0), (10, 0), (20, 0), (30, 0))
    patch = Patch()
    system = System(patch, sdd=["ioa_sdd_script", path], cs=["ioa_cs_modal", "disk", "disk.modal.npz"])
    # Of its own table nothing is said, nor of its striker; a body that nobody else has is its own.
    other = patch.obj(second, "lab", "disk", "plate.modal.npz", 7, "plate.modal.npz")
    patch.log("table", patch.obj("ioa_bus", "lab", "table") >> patch.obj("route", "table"))
    patch.log("model", patch.obj("ioa_bus", "lab", "model") >> patch.obj("route", "model"))
    patch.at(500, other, "choke 0.8")
    patch.at(550, system.bus, "publish")
    patch.at(600, system.box["sdd"], "bang")
    patch.at(580, system.bus, "hit 580 7 0 0 0 0 0 1 0.5 0")
    result = patch.render(1.6, expect_errors=["disk expected to be the only contents server"])
    assert len(result.errors) == 1
    assert len(hits(result)) == 5
    assert [row for row in struck(result) if row[1] == "disk"] == [list(hit) for hit in hits(result) if hit[1] == "disk"]
    assert [row[1] for row in struck(result) if row[1] != "disk"][0] == 7
    told = [atoms for _, atoms in result.logs["table"]]
    assert ["disk", "plate.modal.npz"] not in told and ["disk", "disk.modal.npz"] in told
    assert [7, "plate.modal.npz"] in told
    settings = [atoms for _, atoms in result.logs["model"] if "choke" in atoms]
    assert settings and all(atoms[1] == 7 for atoms in settings)


def test_the_second_contents_server_takes_over_when_the_first_is_deleted(tmp_path):
    path = taps(tmp_path / "taps.txt", *[(x, 0) for x in range(0, 40, 2)])
    patch = Patch()
    first = patch.sub("first")
    first.obj("ioa_cs_modal", "lab", "disk", "disk.modal.npz")
    system = System(patch, sdd=["ioa_sdd_script", path], cs=["ioa_cs_modal", "disk", "plate.modal.npz"])
    patch.log("table", patch.obj("ioa_bus", "lab", "table") >> patch.obj("route", "table"))
    patch.at(600, system.box["sdd"], "bang")
    patch.send(1010, "pd-first", "clear")
    result = patch.render(4, expect_errors=["expected to be the only contents server"])
    assert len(result.errors) == 1
    assert struck(result) == [list(hit) for hit in hits(result)]
    taken = [t for t, atoms in result.logs["table"] if atoms == ["disk", "plate.modal.npz"]]
    assert len(taken) == 1 and 1010 < taken[0] <= 1510
