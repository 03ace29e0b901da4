"""[stress_haptic] in a headless Pd: feedback scalars, force, shapes, swaps, damaged input."""
import json

import numpy
import pytest

from harness import Patch, stage_folder

P20 = dict(s0=[10, 20, 30, 40], S=[[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]])


def save(path, s0, S, meta=None):
    """A stress table whose one control point moves along x, y and z by up to 1 m."""
    meta = {"format": "stress-table", "version": "1.0", "name": path.stem.split(".")[0], **(meta or {})}
    numpy.savez(path, s0=numpy.array(s0, float), S=numpy.array(S, float), trust=0.01, control_points=numpy.zeros((1, 3)),
                parameters=numpy.array([[0, axis, -1, 1] for axis in range(len(S))], float),
                meta=numpy.frombuffer(json.dumps(meta).encode(), numpy.uint8))
    return path


@pytest.fixture
def table(tmp_path):
    return save(tmp_path / "four.stress.npz", **P20)


def play(file, messages=(), device=(), words=(), seconds=0.4, fails=()):
    """Logs of the outlets; messages and device are (ms, text) to the two inlets."""
    patch = Patch()
    box = patch.obj("stress_haptic", str(file), *words)
    for inlet, told in enumerate((messages, device)):
        for ms, message in told:
            patch.at(ms, box[inlet], message)
    for i, name in enumerate(("gamma", "force", "info", "protocol")):
        patch.log(name, box[i])
    return patch.render(seconds, expect_errors=fails)


def last(result, outlet, word=None):
    found = [atoms for _, atoms in result.logs[outlet] if word is None or atoms[0] == word]
    return found[-1] if word is None else found[-1][1:]


@pytest.mark.parametrize("mode, message, raw, gamma", [
    ("mean", "range current", [25], [0.5]),
    ("weighted", "range current", [15], [0.3181818181818182]),
    ("axis", "range current", [12.5, 15, 17.5], [0.3125, 0.375, 0.4375]),
    ("mean", "range initial", [25], [0.5]),
    ("mean", "range fixed 5 105", [25], [0.2]),
    ("weighted", "range fixed 20 30", [15], [0]),
    # ((10^q + 20^q + 30^q + 40^q)/4)^(1/q) of range 10..40
    ("mean", "power 2", [750 ** 0.5], [(750 ** 0.5 - 10) / 30])])
def test_the_three_mappings_of_p20(table, mode, message, raw, gamma):
    result = play(table, [(10, message), (300, "bang")], words=("-mode", mode))
    assert last(result, "gamma") == pytest.approx(gamma, abs=1e-7)  # a float's precision
    assert last(result, "info", "raw") == pytest.approx(raw, rel=1e-6)
    assert last(result, "info", "method") == ["taylor"]


@pytest.mark.parametrize("messages, device, gamma, force", [
    (["render spring", "anchor 0 0 0"], "3 0 0 0 0 0", 0.5, (-0.6, 0, 0)),
    (["render damper", "range fixed 0 100"], "3 0 0 0.1 0 0", 0.25, (-0.1, 0, 0)),
    (["render both", "anchor 0 0 0"], "3 0 0 0 -0.1 0", 0.5, (-0.6, 0.2, 0)),
    (["render off"], "3 0 0 1 1 1", 0.5, (0, 0, 0))])
def test_spring_and_damper_of_p21(table, messages, device, gamma, force):
    """k = 200 N/m at gamma 0.5 and 3 mm: -0.6 N; b = 1 N s/m at gamma 0.25 and 0.1 m/s: -0.1 N."""
    told = [(10 + i, message) for i, message in enumerate(["gains 0 400 0 4", *messages])]
    result = play(table, told, [(300, device)])
    assert last(result, "gamma") == pytest.approx([gamma], abs=1e-7)
    assert last(result, "force") == pytest.approx(force, abs=1e-7)


def test_phantom_and_stress_haptic_close_the_loop():
    """A hand of 200 N/m pulls the middle of the beam up; the spring k(gamma) to the anchor holds against
    it: at rest k y = 200 N/m (14 mm - start - y), and gamma is that of the shape where it rests."""
    patch = Patch()
    device = patch.obj("phantom sim")
    box = patch.obj("stress_haptic", str(stage_folder() / "beam.stress.npz"), "-gains", 100, 500, 0, 0)
    route = patch.obj("route mm")
    device[3] >> route >> patch.obj("t a") >> box[1]
    box[1] >> device
    patch.at(1, device, "report mm 1, hand spring 200 2, target 0 10 0")
    patch.at(1500, box, "anchor here, grab 1")
    patch.at(1700, device, "target 0 14 0")
    for name, outlet in (("gamma", box), ("force", box[1]), ("mm", route)):
        patch.log(name, outlet)
    result = patch.render(4)
    start = [atoms[1] for ms, atoms in result.logs["mm"] if ms <= 1500][-1]
    y = result.logs["mm"][-1][1][1] - start
    gamma, force = last(result, "gamma")[0], last(result, "force")
    assert 1 < y < 8
    assert force[1] == pytest.approx(-(100 + 400 * gamma) * 1e-3 * y, rel=1e-3)
    assert force[1] == pytest.approx(-200 * 1e-3 * (14 - start - y), abs=0.01)
    lifted = play(stage_folder() / "beam.stress.npz", [(100, f"cp 1 0 {10 + y} 0")])  # the point began at 10 mm
    assert gamma == pytest.approx(last(lifted, "gamma")[0], abs=1e-4)
    steps = numpy.abs(numpy.diff([atoms[1] for ms, atoms in result.logs["force"] if ms > 1500]))
    assert steps.max() < 0.02
