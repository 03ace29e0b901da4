"""The scene inside [phantom]'s servo, from a headless Pd."""
import math

import numpy
import pytest

from device import moved, play
from harness import Patch, read_trace

SQUARE = "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3 4\n"
EDGE = 0.5 * (4 - 2 * math.sqrt(2)) / math.sqrt(2)  # N: 500 N/m times how far a ball of 4 mm is over an edge


@pytest.mark.parametrize("tool, body, start, end, force, point", [
    (0, "sphere 0 0 0 20", (20, 20, 0), (12, 12, 0), (1.071068, 1.071068, 0), (14.142, 14.142, 0)),
    (0, "box 0 0 0 30 10 20", (0, 15, 0), (0, 7, 0), (0, 1.5, 0), (0, 10, 0)),
    (0, "box 1 2 3 30 20 10 0.70710678 0 0 0.70710678", (1, 40, 3), (1, 29, 3), (0, 1.5, 0), (1, 32, 3)),
    (0, "disk 0 0 0 0 0 1 50 12", (0, 0, 20), (0, 0, -3), (0, 0, 4.5), (0, 0, 6)),
    (0, "plane 0 2 0 5", (3, 12, 4), (3, 3, 4), (0, 1, 0), (3, 5, 4)),
    (4, "sphere 0 0 0 16", (30, 0, 0), (18, 0, 0), (1, 0, 0), (16, 0, 0)),
    (4, "plane 0 1 0 5", (0, 30, 0), (0, 8, 0), (0, 0.5, 0), (0, 5, 0)),
    (4, "disk 0 0 0 0 0 1 50 12", (0, 0, 20), (0, 0, -3), (0, 0, 6.5), (0, 0, 6)),
    (4, "box 0 0 0 10 10 10", (18, 18, 0), (12, 12, 0), (EDGE, EDGE, 0), (10, 10, 0)),
    (4, "mesh square.obj", (3, 4, -10), (3, 4, -2), (0, 0, -1), (3, 4, 0))])
def test_a_body_is_hit_at_its_surface_and_pushes_back_with_k_times_the_depth(tmp_path, tool, body, start, end, force,
                                                                            point):
    """The tool is a point or a sphere of that radius, mm."""
    (tmp_path / "square.obj").write_text(SQUARE)
    answer = moved(tmp_path, [(0, *start), (100, *end), (200, *end)], f"scene tool {tool}", f"scene add body {body}",
                   "scene k 500")
    assert answer.force == pytest.approx(force, abs=3e-5)
    (hit,) = answer.told("hit")
    assert hit[1] == "body" and hit[2:5] == pytest.approx(point, abs=1e-3)


def test_a_strike_on_the_disk_is_one_hit_with_the_tick_s_time(tmp_path):
    # 0.25 mm a tick down, a rest, away and back.
    rows = [(0, 25, 0, 20.1), (80, 25, 0, 0.1), (200, 25, 0, 0.1), (280, 25, 0, 20.1), (360, 25, 0, 0.1)]
    answer = moved(tmp_path, rows, "scene add disk disk 0 0 0 0 0 1 50 12")
    (ms, name, *numbers), _ = answer.told("hit")
    assert ms == pytest.approx(57, abs=1e-3) and name == "disk"
    assert numbers == pytest.approx([25, 0, 6, 0, 0, 1, 0.25, 0], rel=0.01, abs=1e-3)
    assert [name for _, name in answer.told("release")] == ["disk"]
    contacts = [row[0] for row in answer.told("contact")]
    assert min(b - a for a, b in zip(contacts, contacts[1:])) > 3.9


def test_a_scene_can_be_changed_while_it_is_touched(tmp_path):
    (tmp_path / "hand.txt").write_text("0 0 0 10\n50 0 0 -2\n")
    changes = ["add 7 plane 0 0 1 0", "mat 7 1000 0 0.5", "move 7 0 0 1", "move 7 0 0 -5",
               "add 7 sphere 0 0 -40 39",  # another body of that name: 1 mm deep
               "move 7 0 0 -38 50", "del all"]
    messages = [(100 * i, f"scene {change}") for i, change in enumerate(changes)]
    asked = [(ms, "bang") for ms in (90, 190, 290, 390, 490, 524.5, 590, 690)]
    answer = play(tmp_path, sorted(messages + asked), "-hand rigid -path hand.txt")
    assert [row[2] for row in answer.told("force")] == pytest.approx([1, 2, 3, 0, 0.5, 1.0, 1.5, 0], abs=0.02)


def test_a_scene_file_is_taken_whole_or_not_at_all(tmp_path):
    (tmp_path / "good.txt").write_text("# a table with a ball\ntool 2.5\nk 800\nadd table plane 0 1 0 -10;\n"
                                       "scene add ball sphere 0 0 0 15\nmat ball 300 1 0.2\n")
    (tmp_path / "bad.txt").write_text("add other plane 0 1 0 -10\nadd ball cube 1 2 3\n")
    answer = play(tmp_path, [(10, "scene load good.txt"), (20, "scene load bad.txt"), (30, "dump")], errors=[
        "phantom: scene load: bad.txt line 2: scene add: cube: expected plane, sphere, box, disk or mesh$"])
    assert answer.told("scene", "mat") == [["table", 800, 0, 0], ["ball", 300, 1, pytest.approx(0.2)]]
    assert answer.told("scene", "tool") == [[2.5]]


def test_a_scene_holds_64_bodies_and_8_meshes(tmp_path):
    (tmp_path / "leaf.obj").write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n")
    messages = [(10 + i / 10, f"scene add s{i} sphere {i} 80 0 1") for i in range(65)]
    messages += [(30 + i / 10, f"scene add m{i} mesh leaf.obj") for i in range(9)]
    answer = play(tmp_path, messages, errors=["scene add: 65 bodies: expected at most 64",
                                              "scene add: 9 meshes: expected at most 8"])
    assert len(answer.errors) == 2


def test_a_stiffness_above_the_stable_bound_is_said_once(tmp_path):
    answer = play(tmp_path, [(10, "scene add wall plane 0 0 1 0"), (20, "scene mat wall 1500 0 0"),
                             (30, "scene mat wall 1200 0 0")])
    assert answer.told("status", "stiff") == [[1500, 1000]]


def test_the_time_of_a_hit_keeps_its_resolution_as_it_begins_again_after_65536_ms(tmp_path):
    """A single float of ms since the start, with which two of Pd's are apart by 4 ms after a day."""
    patch = Patch()
    box = patch.obj("phantom", *"-hand rigid -rate 1300 -path line 0 0 5.03 0 0 -4.97 1021.5".split())
    patch.at(0, box, f"scene add wall plane 0 0 1 0, trace {tmp_path}/ticks.csv")
    patch.log("info", box[3])
    patch.at(66500, box, "trace stop")
    result = patch.render(66.6)
    hits = [atoms[1] for _, atoms in result.logs["info"] if atoms[0] == "hit"]
    rows = read_trace(tmp_path / "ticks.csv")
    begins = numpy.flatnonzero((rows["z_mm"][1:] < 0) & (rows["z_mm"][:-1] >= 0)) + 1
    assert len(begins) >= 65
    assert hits[:len(begins)] == pytest.approx(numpy.fmod(rows["ms"][begins], 65536), abs=1 / 512)
    assert 0 <= hits[len(begins) - 1] < 1000
