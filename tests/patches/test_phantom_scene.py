"""The scene inside [phantom]'s servo, from a headless Pd."""

import math

import pytest

from test_phantom import DevicePatch, force_after


def scripted(tmp_path, rows, *scene, end_ms=None):
    """A rigid hand on rows of ms x y z in mm, in a scene; force and contact reported each ms."""
    path = tmp_path / "hand.txt"
    path.write_text("\n".join(" ".join(map(str, row)) for row in rows) + "\n")
    patch = DevicePatch("-hand rigid -path hand.txt -report mm 1 -report force 1",
                        end_ms or rows[-1][0] + 20)
    for line in scene:
        patch.at(0, f"scene {line}")
    return patch


@pytest.mark.parametrize("body, start, end, force", [
    ("sphere 0 0 0 20", (30, 0, 0), (18, 0, 0), (1, 0, 0)),
    ("sphere 0 0 0 20", (20, 20, 0), (12, 12, 0), (1.071068, 1.071068, 0)),
    ("box 0 0 0 30 10 20", (0, 15, 0), (0, 7, 0), (0, 1.5, 0)),
    ("box 1 2 3 30 20 10 0.70710678 0 0 0.70710678", (1, 40, 3), (1, 29, 3), (0, 1.5, 0)),
    ("disk 0 0 0 0 0 1 50 12", (0, 0, 20), (0, 0, -3), (0, 0, 4.5)),
    ("plane 0 2 0 5", (3, 12, 4), (3, 3, 4), (0, 1, 0)),
])
def test_a_body_pushes_back_with_k_times_the_depth(tmp_path, body, start, end, force):
    patch = scripted(tmp_path, [(0, *start), (100, *end)], f"add body {body}", "k 500", end_ms=150)
    patch.at(140, "bang")
    assert force_after(patch.run(tmp_path)) == pytest.approx(force, abs=2e-5)


def test_a_body_that_is_there_from_the_start_lets_the_hand_out(tmp_path):
    patch = scripted(tmp_path, [(0, 18, 0, 0), (1, 18, 0, 0)], "add 1 sphere 0 0 0 20", end_ms=120)
    patch.at(100, "bang")
    assert force_after(patch.run(tmp_path)) == pytest.approx([1, 0, 0], abs=2e-5)


def test_a_hand_that_starts_inside_is_led_out_with_a_newton_at_most(tmp_path):
    # 17 mm deep in a hard sphere: its spring alone would give 34 N.
    patch = scripted(tmp_path, [(0, 13, 0, 0), (500, 13, 0, 0)], "add 1 sphere 0 0 0 30",
                     "mat 1 2000 5 0.5", end_ms=500)
    forces = [math.hypot(*row) for row in patch.run(tmp_path).tagged("force")]
    assert max(forces) == pytest.approx(1, abs=1e-4)
    assert forces[-1] == pytest.approx(1, abs=1e-4)


def test_bodies_reached_at_one_tick_are_hit_in_the_order_of_their_numbers_then_as_added(tmp_path):
    patch = scripted(tmp_path, [(0, 20, 20, 20), (100, -5, -5, -5)],
                     "add zebra plane 0 0 1 0", "add 7 plane 1 0 0 0", "add 3 plane 0 1 0 0")
    hits = [row for row in patch.run(tmp_path).info if row[0] == "hit"]
    assert [row[2] for row in hits] == ["3", "7", "zebra"]
    assert len({row[1] for row in hits}) == 1  # one tick


@pytest.mark.parametrize("amplitude_mm, hz, hits", [(0.05, 40, 1), (0.15, 40, 1), (1, 40, 40),
                                                    (5, 20, 20), (1, 100, 1)])
def test_chatter_is_a_hit_for_each_real_departure(tmp_path, amplitude_mm, hz, hits):
    rows = [(n, 0, 0, round(amplitude_mm * math.cos(2 * math.pi * hz * (n + 0.5) * 1e-3), 6))
            for n in range(1001)]
    patch = scripted(tmp_path, rows, "add floor plane 0 0 1 0")
    found = [row for row in patch.run(tmp_path).info if row[0] == "hit" and float(row[1]) < 1000]
    assert len(found) == hits


@pytest.mark.parametrize("body, start, end, force, point", [
    ("sphere 0 0 0 16", (30, 0, 0), (18, 0, 0), (1, 0, 0), (16, 0, 0)),
    ("plane 0 1 0 5", (0, 30, 0), (0, 8, 0), (0, 0.5, 0), (0, 5, 0)),
    ("disk 0 0 0 0 0 1 50 12", (0, 0, 20), (0, 0, -3), (0, 0, 6.5), (0, 0, 6)),
    ("box 0 0 0 10 10 10", (18, 18, 0), (12, 12, 0),
     tuple([0.5 * (4 - 2 * math.sqrt(2)) / math.sqrt(2)] * 2 + [0]), (10, 10, 0)),
    ("mesh square.obj", (3, 4, -10), (3, 4, -2), (0, 0, -1), (3, 4, 0)),
])
def test_a_tool_of_4_mm_is_a_sphere_that_hits_at_its_surface(tmp_path, body, start, end, force,
                                                             point):
    (tmp_path / "square.obj").write_text(
        "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3 4\n")
    patch = scripted(tmp_path, [(0, *start), (100, *end)], "tool 4", f"add body {body}",
                     end_ms=250)
    patch.at(240, "bang")
    result = patch.run(tmp_path)
    assert force_after(result) == pytest.approx(force, abs=3e-5)
    hits = [row for row in result.info if row[0] == "hit"]
    assert len(hits) == 1
    assert [float(w) for w in hits[0][3:6]] == pytest.approx(point, abs=1e-3)


def test_the_tool_s_radius_is_part_of_a_scene_file_and_of_the_dump(tmp_path):
    (tmp_path / "scene.txt").write_text("tool 2.5\nadd ball sphere 0 0 0 15\n")
    patch = DevicePatch("", 50)
    patch.at(10, "scene load scene.txt")
    patch.at(30, "dump")
    result = patch.run(tmp_path)
    assert result.errors == []
    assert [row for row in result.info if row[:2] == ["scene", "tool"]] == [["scene", "tool", "2.5"]]


def test_a_strike_on_the_disk_is_one_hit_with_the_tick_s_time(tmp_path):
    # 0.25 mm a tick down, a rest, away and back.
    patch = scripted(tmp_path, [(0, 25, 0, 20.1), (80, 25, 0, 0.1), (200, 25, 0, 0.1),
                                (280, 25, 0, 20.1), (360, 25, 0, 0.1)],
                     "add disk disk 0 0 0 0 0 1 50 12")
    result = patch.run(tmp_path)
    hits = [row for row in result.info if row[0] == "hit"]
    assert len(hits) == 2 and hits[0][2] == "disk"
    numbers = [float(w) for w in hits[0][1:2] + hits[0][3:]]
    assert numbers[0] == pytest.approx(57, abs=1e-3)
    assert numbers[1:4] == pytest.approx([25, 0, 6], abs=1e-3)
    assert numbers[4:7] == pytest.approx([0, 0, 1], abs=1e-5)
    assert numbers[7] == pytest.approx(0.25, rel=0.01)
    assert numbers[8] == pytest.approx(0, abs=1e-6)
    releases = [row for row in result.info if row[0] == "release"]
    assert len(releases) == 1 and releases[0][2] == "disk"
    contacts = [float(row[1]) for row in result.info if row[0] == "contact"]
    assert min(b - a for a, b in zip(contacts, contacts[1:])) > 3.9


def test_a_scene_can_be_changed_while_it_is_touched(tmp_path):
    (tmp_path / "hand.txt").write_text("0 0 0 10\n50 0 0 -2\n")
    patch = DevicePatch("-hand rigid -path hand.txt", 700)
    patch.at(0, "scene add 7 plane 0 0 1 0")
    patch.at(100, "scene mat 7 1000 0 0.5")
    patch.at(200, "scene move 7 0 0 1")
    patch.at(300, "scene move 7 0 0 -5")
    patch.at(400, "scene add 7 sphere 0 0 -40 39")  # another body of that name: 1 mm deep
    patch.at(500, "scene move 7 0 0 -38 50")
    patch.at(600, "scene del all")
    for ms in (90, 190, 290, 390, 490, 524.5, 590, 690):
        patch.at(ms, "bang")
    forces = [row[2] for row in patch.run(tmp_path).tagged("force")]
    assert forces == pytest.approx([1, 2, 3, 0, 0.5, 1.0, 1.5, 0], abs=0.02)


def test_a_scene_file_is_taken_whole_or_not_at_all(tmp_path):
    (tmp_path / "good.txt").write_text(
        "# a table with a ball\nk 800\nadd table plane 0 1 0 -10;\n"
        "scene add ball sphere 0 0 0 15\nmat ball 300 1 0.2\n")
    (tmp_path / "bad.txt").write_text("add other plane 0 1 0 -10\nadd ball cube 1 2 3\n")
    patch = DevicePatch("", 50)
    patch.at(10, "scene load good.txt")
    patch.at(20, "scene load bad.txt")
    patch.at(30, "dump")
    result = patch.run(tmp_path)
    assert result.errors == ["phantom: scene load: bad.txt line 2: scene add: "
                             "cube: expected plane, sphere, box, disk or mesh"]
    names = [row[2] for row in result.info if row[:2] == ["scene", "mat"]]
    assert names == ["table", "ball"]
    assert [row[3:] for row in result.info if row[:2] == ["scene", "mat"]] == [
        ["800", "0", "0"], ["300", "1", "0.2"]]


def test_a_mesh_file_is_touched_from_both_sides(tmp_path):
    (tmp_path / "square.obj").write_text(
        "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3 4\n")
    patch = scripted(tmp_path, [(0, 3, 4, 10), (50, 3, 4, -2), (150, 3, 4, -2), (151, 30, 4, -2),
                                (160, 30, 4, -2), (200, 30, 4, -10), (220, 3, 4, -10),
                                (270, 3, 4, 4)], "add sheet mesh square.obj", end_ms=400)
    patch.at(140, "bang")
    patch.at(390, "bang")
    forces = [row for row in patch.run(tmp_path).tagged("force")]
    assert max(f[2] for f in forces) == pytest.approx(1, abs=1e-4)
    assert forces[-1] == pytest.approx([0, 0, -2], abs=1e-4)


@pytest.mark.parametrize("message, sentence", [
    ("scene paint 1", "scene paint: expected add, mat, move, del, tool, k or load"),
    ("scene add 1", "scene add: expected a name and a shape"),
    ("scene add 1 cube 1 1 1", "scene add: cube: expected plane, sphere, box, disk or mesh"),
    ("scene add 1 sphere 0 0 0", "scene add: sphere: radius is missing: expected 0.01..10000 mm"),
    ("scene add 1 sphere 0 0 0 -3", "scene add: sphere: radius -3 mm: expected 0.01..10000 mm"),
    ("scene add 1 plane 0 0 0 1", "scene add: plane: the normal nx ny nz has no direction"),
    ("scene add 1 mesh nix.obj", "scene add: mesh: nix.obj: no such file"),
    ("scene mat 3 500", "scene mat: 3: no such body"),
    ("scene move 3 0 0 0", "scene move: 3: no such body"),
    ("scene del 3", "scene del: 3: no such body"),
    ("scene tool -1", "scene tool: radius -1 mm: expected 0..50 mm"),
    ("scene tool wide", "scene tool: radius wide: expected 0..50 mm"),
    ("scene tool 0.001", "scene tool: radius 0.001 mm: expected 0, which is a point, or 0.01..50 mm"),
    ("scene k -1", "scene k: k -1 N/m: expected 0..100000 N/m"),
    ("scene load nix.txt", "scene load: nix.txt: no such file"),
])
def test_a_refused_scene_message_costs_one_sentence(tmp_path, message, sentence):
    patch = DevicePatch("-hand rigid", 30)
    patch.at(10, message)
    assert patch.run(tmp_path).errors == [f"phantom: {sentence}"]


def test_a_scene_holds_64_bodies_and_8_meshes(tmp_path):
    (tmp_path / "leaf.obj").write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n")
    patch = DevicePatch("", 60)
    for i in range(65):
        patch.at(10 + i / 10, f"scene add s{i} sphere {i} 80 0 1")
    for i in range(9):
        patch.at(30 + i / 10, f"scene add m{i} mesh leaf.obj")
    assert patch.run(tmp_path).errors == [
        "phantom: scene add: the scene has 64 bodies already, the most there can be",
        "phantom: scene add: the scene has 8 meshes already, the most there can be"]


def test_a_stiffness_above_the_stable_bound_is_said_once(tmp_path):
    patch = DevicePatch("", 60)
    patch.at(10, "scene add wall plane 0 0 1 0")
    patch.at(20, "scene mat wall 1500 0 0")
    patch.at(30, "scene mat wall 1200 0 0")
    result = patch.run(tmp_path)
    stiff = [row for row in result.info if row[:2] == ["status", "stiff"]]
    assert [[float(w) for w in row[2:]] for row in stiff] == [[1500, 1000]]
