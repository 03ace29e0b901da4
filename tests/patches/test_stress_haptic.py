"""[stress_haptic] in a headless Pd: feedback scalars, force, shapes, swaps, damaged input."""
import json

import numpy
import pytest

from harness import Patch, stage_folder

OUTLETS = ("gamma", "force", "protocol", "info")
P20 = dict(s0=[10, 20, 30, 40], S=[[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]])


def save(path, s0, S, points=((0, 0, 0),), rows=None, trust=0.01, meta=None, **more):
    """A stress table; by default one control point that moves along x, y and z by up to 1 m."""
    rows = rows if rows is not None else [[0, axis, -1, 1] for axis in range(len(S))]
    meta = {"format": "stress-table", "version": "1.0", "name": path.stem.split(".")[0], **(meta or {})}
    numpy.savez(path, s0=numpy.array(s0, float), S=numpy.array(S, float),
                parameters=numpy.array(rows, float), control_points=numpy.array(points, float),
                trust=float(trust), meta=numpy.frombuffer(json.dumps(meta).encode(), numpy.uint8), **more)
    return path


@pytest.fixture
def table(tmp_path):
    return save(tmp_path / "four.stress.npz", **P20)


def play(file, messages=(), device=(), words=(), seconds=0.4, fails=(), **options):
    """Logs of the outlets; messages and device are (ms, text) to the two inlets."""
    patch = Patch()
    box = patch.obj("stress_haptic", str(file), *words)
    for ms, message in messages:
        patch.at(ms, box, message)
    for ms, message in device:
        patch.at(ms, box[1], message)
    for i, name in enumerate(OUTLETS):
        patch.log(name, box[i])
    return patch.render(seconds, expect_errors=fails, **options) if fails else patch.render(seconds, **options)


def last(result, outlet, word=None):
    found = [atoms for _, atoms in result.logs[outlet] if word is None or atoms[0] == word]
    return found[-1] if word is None else found[-1][1:]


@pytest.mark.parametrize("mode, range_, raw, gamma", [
    ("mean", "current", [25], [0.5]),
    ("weighted", "current", [15], [0.3181818181818182]),
    ("axis", "current", [12.5, 15, 17.5], [0.3125, 0.375, 0.4375]),
    ("mean", "initial", [25], [0.5]),
    ("mean", "fixed 5 105", [25], [0.2]),
    ("weighted", "fixed 20 30", [15], [0]),
])
def test_the_three_mappings_of_p20(table, mode, range_, raw, gamma):
    result = play(table, [(10, f"range {range_}"), (300, "bang")], words=("-mode", mode))
    assert last(result, "gamma") == pytest.approx(gamma, abs=1e-7)  # a float's precision
    assert last(result, "info", "raw") == pytest.approx(raw, rel=1e-7)
    assert last(result, "info", "method") == ["taylor"]


def test_equal_stresses_give_gamma_0(tmp_path):
    even = save(tmp_path / "even.stress.npz", [7] * 5, [[1] * 5])
    for mode in ("mean", "weighted", "axis"):
        result = play(even, [(10, "range current"), (300, "bang")], words=("-mode", mode))
        assert last(result, "gamma")[0] == 0


def test_spring_and_damper_of_p21(table):
    """k = 200 N/m at gamma 0.5 and 3 mm: -0.6 N; b = 1 N s/m at gamma 0.25 and 0.1 m/s: -0.1 N."""
    spring = play(table, [(10, "gains 0 400 0 4"), (12, "anchor 0 0 0")], [(300, "3 0 0 0 0 0")])
    assert last(spring, "force") == pytest.approx([-0.6, 0, 0], abs=1e-7)
    damper = play(table, [(10, "gains 0 400 0 4"), (11, "render damper"), (12, "range fixed 0 100")],
                  [(300, "3 0 0 0.1 0 0")])
    assert last(damper, "gamma") == pytest.approx([0.25], abs=1e-7)
    assert last(damper, "force") == pytest.approx([-0.1, 0, 0], abs=1e-7)
    both = play(table, [(10, "gains 0 400 0 4"), (11, "render both"), (12, "anchor 0 0 0")],
                [(300, "3 0 0 0 -0.1 0")])
    assert last(both, "force") == pytest.approx([-0.6, 0.2, 0], abs=1e-7)
    off = play(table, [(10, "render off")], [(300, "3 0 0 1 1 1")])
    assert last(off, "force") == [0, 0, 0]
