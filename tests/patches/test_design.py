"""patches/design/beam.pd and arm.pd in a headless Pd: the part is drawn, dragged and felt without hardware."""
import json
import re

import numpy
import pytest

from harness import Patch, stage_folder
from harness.run import ROOT

# patch, table, control points in a layer, the one that the recorded hand takes, when it pulls furthest up (ms)
PARTS = {"beam": ("cantilever", 10, 6, 5900), "arm": ("lift_arm", 18, 15, 7600)}
CLICK_MS, TAKEN_MS = 10, 500

if not all((stage_folder() / f"{table}.stress.npz").is_file() for table, *_ in PARTS.values()):
    pytest.skip("the tables of the parts are not made in this build", allow_module_level=True)


def table_of(name):
    return numpy.load(stage_folder() / f"{PARTS[name][0]}.stress.npz")


def play(name, messages, seconds, labels=("force", "gamma", "device", "hand"), routes=()):
    """Logs of the patch's buses; messages are (ms, receiver, text). routes are words of the info bus."""
    patch = Patch(opens=ROOT / "patches" / "design" / f"{name}.pd")
    for ms, receiver, text in messages:
        patch.send(ms, receiver, text)
    for label in labels:
        patch.log(label, patch.obj(f"r design-{label}"))
    if routes:
        route = patch.obj("route", *routes)
        patch.obj("r design-info") >> route
        for i, word in enumerate(routes):
            patch.log(word, route[i])
    return patch.render(seconds).logs


def by_number(log):
    """The last message of each number, without it."""
    return {int(atoms[0]): atoms[1:] for _, atoms in log}


def side_view(table, parameters):
    """Stress and corners (mm) of the faces that look at the viewer, in any order."""
    nodes, triangles = table["surface_nodes"].copy(), table["surface_triangles"]
    first = nodes[triangles]
    normals = numpy.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])
    seen = triangles[normals[:, 2] > 1e-3 * numpy.linalg.norm(normals, axis=1)]
    for (c, axis, *_), p in zip(table["parameters"], parameters):
        nodes[:, int(axis)] += table["surface_weights"][:, int(c)] * p
    stress = table["s0"].astype(float) + parameters @ table["S"].astype(float)
    return numpy.column_stack([stress[table["surface_node_element"][seen]].mean(1),
                               1000 * nodes[seen][:, :, :2].reshape(-1, 6)])


def in_order(rows):
    return rows[numpy.lexsort(numpy.round(rows[:, 1:], 3).T)]


@pytest.mark.parametrize("name", PARTS)
def test_the_picture_is_the_tables_skin_moved_by_its_weights_in_the_colours_of_the_series(name):
    table = table_of(name)
    _, layer, handle, _ = PARTS[name]
    for up_mm in (0, 3):
        y = 1000 * table["control_points"][handle, 1] + up_mm
        x = 1000 * table["control_points"][handle, 0]
        logs = play(name, [(50, "design-part", "resolve taylor"), (100, "design-part", f"cp {handle} {x:.6f} {y:.6f} 0"),
                           (200, "design-part", "draw all")],
                    0.3, labels=(), routes=("picture", "face", "point"))
        parameters = numpy.array([1e-3 * up_mm * (int(c) == handle and int(a) == 1)
                                  for c, a, *_ in table["parameters"]])
        expected = side_view(table, parameters)
        faces, points, scale = logs["picture"][-1][1]
        assert 100 < faces < 1000 and faces == len(expected)
        assert scale == pytest.approx(side_view(table, 0 * parameters)[:, 0].max(), rel=1e-6)
        drawn = by_number(logs["face"])
        assert sorted(drawn) == list(range(len(expected)))
        found, expected = in_order(numpy.array([drawn[f] for f in range(len(expected))])), in_order(expected)
        assert numpy.abs(found[:, 1:] - expected[:, 1:]).max() < 1e-3
        assert numpy.abs(found[:, 0] - expected[:, 0]).max() < 1e-5 * scale
        at = by_number(logs["point"])
        assert points == len(at) == len(set(table["parameters"][:, 0]))
        assert at[handle][:2] == pytest.approx([x, y], abs=1e-3)
        assert at[handle + layer][1] == pytest.approx(y - up_mm, abs=1e-3)


@pytest.mark.parametrize("name", PARTS)
def test_one_click_reshapes_the_part_and_the_hand_feels_its_spring(name):
    """At rest the spring k(gamma) to the anchor and the hand's 400 N/m balance at the point that is dragged."""
    _, layer, handle, rest_ms = PARTS[name]
    ask = [(rest_ms, "design-part", "bang, draw")]
    logs = play(name, [(CLICK_MS, "help-play", "bang"), *ask], (rest_ms + 50) / 1000, routes=("point", "peak", "outside"))
    at = by_number(logs["point"])
    first = 1000 * table_of(name)["control_points"][handle]
    up = at[handle][1] - first[1]
    assert 2 < up < 15
    assert at[handle + layer][:2] == pytest.approx(at[handle][:2], abs=1e-4)  # all layers move
    gamma, force = logs["gamma"][-1][1][0], logs["force"][-1][1]
    assert force[1] == pytest.approx(-(100 + 400 * gamma) * 1e-3 * up, rel=0.01, abs=1e-3)
    peaks = [atoms[0] for _, atoms in logs["peak"]]
    assert max(peaks) > 1.001 * min(peaks)
    steps = [numpy.abs(numpy.subtract(b, a)).max() for (_, a), (_, b) in zip(logs["force"], logs["force"][1:])]
    assert max(steps) < 0.05


def test_the_beam_gets_weaker_and_stronger_with_its_height_and_keeps_its_shape_until_reset():
    """The recorded hand goes down to -3 mm and up to 5 mm: the mean stress rises, then falls below the first."""
    handle = PARTS["beam"][2]
    y = 1000 * table_of("beam")["control_points"][handle, 1]
    logs = play("beam", [(CLICK_MS, "help-play", "bang"), (7000, "design-release", "bang"), (7600, "design-part", "draw"),
                         (7700, "design-reset", "bang"), (8000, "design-part", "draw")], 8.2, routes=("mean", "point"))
    mean = [atoms[0] for ms, atoms in logs["mean"] if ms < 7000]
    assert max(mean) > 1.03 * mean[0] and mean[-1] < 0.98 * mean[0]
    heights = [(ms, atoms[2]) for ms, atoms in logs["point"] if int(atoms[0]) == handle]
    kept = [h for ms, h in heights if 7100 < ms < 7700]
    assert kept and min(kept) > y + 0.5 and max(kept) - min(kept) < 0.05  # the shape stays when the hand lets go
    assert heights[-1][1] == pytest.approx(y, abs=1e-4)
    assert ["target", 0, 0, 0] in [atoms for _, atoms in logs["hand"]]


def test_only_faces_that_change_are_drawn_again():
    logs = play("beam", [(200, "design-part", "draw all"), (300, "design-part", "draw"),
                         (400, "design-part", "cp 9 100 14 0"), (500, "design-part", "draw")], 0.6, labels=(),
                routes=("picture", "face"))

    def faces(ms):
        return [atoms for t, atoms in logs["face"] if abs(t - ms) < 8]
    count = logs["picture"][0][1][0]
    assert len(faces(200)) == count and not faces(300)
    assert 0 < len(faces(500)) < 0.8 * count


def test_what_cannot_be_drawn_is_one_sentence(tmp_path):
    file = tmp_path / "bare.stress.npz"
    meta = json.dumps({"format": "stress-table", "version": "1.0"}).encode()
    numpy.savez(file, meta=numpy.frombuffer(meta, numpy.uint8), s0=numpy.ones(3), S=numpy.ones((1, 3)),
                parameters=numpy.array([[0, 0, -1.0, 1.0]]), control_points=numpy.zeros((1, 3)), trust=0.01)
    patch = Patch()
    bare, empty = patch.obj("stress_haptic", str(file)), patch.obj("stress_haptic")
    patch.at(10, bare, "draw")
    patch.at(20, bare, "draw twice")
    patch.at(30, empty, "draw")
    result = patch.render(0.1, expect_errors=[r"stress_haptic: draw: the table has no surface",
                                              r"stress_haptic: draw twice: expected nothing or all",
                                              r"stress_haptic: draw: no table is loaded"])
    assert len(result.errors) == 3


def test_what_the_patches_name_is_there():
    """Pd says nothing of a missing path file until it is played: all files that the patches name exist."""
    for name in PARTS:
        text = (ROOT / "patches" / "design" / f"{name}.pd").read_text()
        for file in re.findall(r"\S+\.(?:npz|txt)", text):
            assert (stage_folder() / file).is_file(), file
