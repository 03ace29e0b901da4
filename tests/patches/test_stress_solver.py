"""[stress_haptic] solves its part again by the program part_stress, in a render, whose results repeat. How a
child dies, and that none outlives its object: tests/externals/part_solver_test.cpp."""
import json
import struct
import subprocess

import numpy
import pytest

from harness import Patch, stage_folder

PROGRAM = stage_folder() / "part_stress"
if not PROGRAM.exists():
    pytest.skip("the program part_stress is not built", allow_module_level=True)
MOVE_MM = 4  # a fifth of the height
POINTS = (21, 26)  # of the top edge, across the beam, a sixth of the length from the clamp


@pytest.fixture(scope="module", params=[10, pytest.param(5, marks=pytest.mark.slow)])
def beam(tmp_path_factory, request):
    """A cantilever of 200 x 20 x 20 mm, 80 hex20, or 640; a lattice of 5 x 2 x 3, of which two points may move."""
    path = tmp_path_factory.mktemp("beam") / "beam.stress.npz"
    subprocess.run([PROGRAM, *"bar --length 200 --width 20 --thickness 20 --fix x=-100 --force x=100:0,0,-100 "
                    "--lattice 5 2 3 --controls 21,26 --quiet --h".split(), str(request.param), "-o", path],
                   check=True, capture_output=True, timeout=300)
    return path


def moved(table):
    """Displacements of all parameters, m, with the points down."""
    return numpy.array([-1e-3 * MOVE_MM if row[0] in POINTS and row[1] == 2 else 0 for row in table["parameters"]])


def solve(path, p, method):
    """von Mises [N] and iterations by `serve` itself: method 1 PCG on the first factor, 2 a new factor."""
    table = numpy.load(path)
    with subprocess.Popen([PROGRAM, "serve", path, "--tolerance", "1e-8"], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as child:
        request = struct.pack("<II", method, 2) + p.astype("<f8").tobytes()
        said = child.communicate(struct.pack("<IIQ", 0x31525354, 1, len(request)) + request, timeout=300)[0]
    answer = said[16 + 40 + 16:]
    found, iterations = struct.unpack_from("<II", answer)
    assert found == method
    return numpy.frombuffer(answer, "<f4", len(table["s0"]), 32 + 8 * len(p)), iterations


def test_gradients_on_the_old_factor_find_the_stress_of_a_full_solve(beam):
    """P22. Stresses travel in single precision: one rounding in an element, 1e-8 in the mean."""
    table = numpy.load(beam)
    p = moved(table)
    (pcg, iterations), (full, _) = solve(beam, p, 1), solve(beam, p, 2)
    assert 5 <= iterations <= 20
    assert numpy.all(numpy.abs(pcg - full) <= numpy.spacing(full))
    mean = full.mean(dtype=float)
    assert pcg.mean(dtype=float) == pytest.approx(mean, rel=1e-8)
    taylor = (table["s0"] + p @ table["S"].astype(float)).mean()
    assert 0.01 < abs(taylor / mean - 1) < 0.05


def render(beam, resolve, fails=()):
    """The points move down at 300 ms; a handle 40 mm from its anchor feels k = 500 N/m times gamma."""
    table = numpy.load(beam)
    mm = " ".join(f"{1e3 * x:g}" for x in moved(table))
    patch = Patch()
    box = patch.obj("stress_haptic", str(beam), "-resolve", resolve)
    for ms, message in [(1, "range fixed 0 8e+06"), (2, "gains 0 500 0 0"), (3, "anchor 0 0 0"), (300, f"list {mm}")]:
        patch.at(ms, box, message)
    patch.at(250, box[1], "40 0 0 0 0 0")
    patch.at(900, box, "bang")
    for i, name in enumerate(("gamma", "force", "info", "protocol")):
        patch.log(name, box[i])
    return patch.render(1, expect_errors=fails)


def told(result, word):
    return [(ms, atoms[1]) for ms, atoms in result.logs["info"] if atoms[0] == word]


def test_the_object_solves_by_gradients_and_the_force_goes_over_without_a_jump(beam):
    result = render(beam, "pcg")
    assert told(result, "method")[-1][1] == "pcg"
    assert 5 <= told(result, "iters")[-1][1] <= 20
    assert told(result, "ms")[-1][1] > 0
    full, _ = solve(beam, moved(numpy.load(beam)), 2)
    # Pd's floats: 6e-8.
    assert told(result, "mean")[-1][1] == pytest.approx(full.mean(dtype=float), rel=1.2e-7)
    force = [(ms, atoms[0]) for ms, atoms in result.logs["force"] if ms >= 250]
    taylor = told(result, "mean")
    before, after = force[0][1], force[-1][1]
    assert after == pytest.approx(-20 * full.mean(dtype=float) / 8e6, rel=1e-6)
    # The fades are linear over 100 ms: no step above 1 % of the change, the series' own overshoot included.
    change = 20 * max(abs(mean - told(result, "mean")[0][1]) for _, mean in taylor) / 8e6
    assert abs(after - before) > 0.1
    steps = [abs(b - a) / max(1, tb - ta) for (ta, a), (tb, b) in zip(force, force[1:])]
    assert max(steps) < change / 50 * 1.01


def test_auto_solves_by_gradients_then_finds_new_sensitivities_at_rest_and_repeats_exactly(beam):
    first, second = render(beam, "auto"), render(beam, "auto")
    methods = [method for _, method in told(first, "method")]
    assert [m for i, m in enumerate(methods) if i == 0 or m != methods[i - 1]] == ["taylor", "pcg", "full"]
    assert {method for _, method in told(render(beam, "taylor"), "method")} == {"taylor"}
    for outlet in ("gamma", "force", "protocol"):
        assert first.logs[outlet] == second.logs[outlet]
    for word in ("raw", "mean", "method", "iters"):
        assert told(first, word) == told(second, word)


def test_a_solver_of_another_table_is_one_sentence(beam, tmp_path):
    arrays = dict(numpy.load(beam))
    meta = json.loads(bytes(arrays["meta"]))
    del meta["command"]
    other = tmp_path / "other.stress.npz"
    for changes, resolve, sentence in [  # mesh and words of one part, stresses of another
            ({"s0": arrays["s0"] * 1.01}, "auto", "stress at the table's own shape differs"),
            ({"meta": numpy.frombuffer(json.dumps(meta).encode(), numpy.uint8)}, "auto", "does not state the command that made it"),
            ({"mesh": None}, "full", "resolve full: the table has no mesh to solve"),
            ({"mesh": None}, "auto", None)]:
        numpy.savez(other, **{k: v for k, v in {**arrays, **changes}.items() if v is not None})
        result = render(other, resolve, fails=[sentence] if sentence else [])
        assert len(result.errors) == bool(sentence)
