"""[modal_impact~] whose body is reshaped asks the program modal_fem for the modes of the moved mesh."""
import subprocess

import numpy
import pytest

from harness import Patch, stage_folder
from harness.sound import RATE

PROGRAM = stage_folder() / "modal_fem"
if not PROGRAM.exists():
    pytest.skip("the program modal_fem is not built", allow_module_level=True)
BODY = ("bar --length 200 --width 20 --thickness 20 --material steel --h 10 --tolerance 0 --fix x=-100 --modes 12 "
        "--loss 0.002").split()
# Of the top, not at the clamp.
LATTICE = "--lattice 5 2 2 --directions y --range 6 --controls 6,7,8,9,16,17,18,19".split()
MOVE_MM = -4  # a fifth of the height


def run(*words):
    subprocess.run([PROGRAM, *words, "--quiet"], check=True, capture_output=True, timeout=300)


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("beam")
    run(*BODY, *LATTICE, "-o", folder / "beam.modal.npz", "--export-inp", folder / "beam.inp")
    return folder / "beam.modal.npz"


def spline(t, degree, points):
    """The clamped uniform B-splines of that degree (Cox, de Boor)."""
    knots = numpy.concatenate([numpy.zeros(degree), numpy.linspace(0, 1, points - degree + 1), numpy.ones(degree)])
    basis = [((t >= a) & (t < b) | (b == 1) & (t == 1) & (a < b)).astype(float) for a, b in zip(knots, knots[1:])]
    for d in range(1, degree + 1):
        def share(i):
            return (t - knots[i]) / (knots[i + d] - knots[i]) if knots[i + d] > knots[i] else 0 * t
        basis = [basis[i] * share(i) + basis[i + 1] * (1 - share(i + 1)) * (knots[i + d + 1] > knots[i + 1])
                 for i in range(len(basis) - 1)]
    return numpy.array(basis)


def moved_frequencies(beam, p):
    """By modal_fem on the mesh whose nodes were moved here, by a B-spline of our own."""
    lines = beam.with_name("beam.inp").read_text().splitlines()
    first = next(i for i, s in enumerate(lines) if s.upper().startswith("*NODE")) + 1
    last = next(i for i in range(first, len(lines)) if lines[i].startswith("*"))
    rows = [s.split(",") for s in lines[first:last]]
    x = numpy.array([[float(c) for c in row[1:4]] for row in rows])
    u, v, w = ((x - x.min(0)) / numpy.ptp(x, axis=0)).T
    along, across, deep = spline(u, 3, 5), spline(v, 1, 2), spline(w, 1, 2)
    y = x.copy()
    for (c, axis, _, _), by in zip(numpy.load(beam)["parameters"].astype(int), p):
        y[:, axis] += by * along[c % 5] * across[c // 5 % 2] * deep[c // 10]
    text = [f"{row[0]}, " + ", ".join(f"{c:.15g}" for c in at) for row, at in zip(rows, y)]
    moved = beam.with_name("moved.inp")
    moved.write_text("\n".join([*lines[:first], *text, *lines[last:]]) + "\n")
    out = beam.with_name("moved.modal.npz")
    run(moved, "--unit", "m", "--material", "steel", "--modes", str(len(numpy.load(beam)["freq"])), "--tolerance", "0", "--fix", f"x={x[:, 0].min():.15g}",
        "-o", out)
    return numpy.load(out)["freq"]


def shape(table, mm=MOVE_MM):
    return numpy.full(len(table["parameters"]), 1e-3 * mm)


def message(p):
    return "shape " + " ".join(f"{1000 * x:.9g}" for x in p)


def struck(beam, *arguments):
    patch = Patch()
    box = patch.obj("modal_impact~", beam.name, "-sync", 1, *arguments)
    patch.record("left", box[0])
    patch.log("info", box[3])
    return patch, box


def told(result, word, from_ms=0):
    return [atoms[1:] for t, atoms in result.logs["info"] if atoms[0] == word and t >= from_ms]


def test_after_a_solve_the_frequencies_are_those_of_the_moved_mesh(beam):
    """1e-6, single precision of Pd's lists; the expansion is off by percents there."""
    table = numpy.load(beam)
    p = shape(table)
    exact = moved_frequencies(beam, p)
    patch, box = struck(beam)
    for ms, told_it in ((100, message(p)), (105, "info"), (400, "info"), (410, "resolve off"), (420, message(0 * p))):
        patch.at(ms, box, told_it)
    result = patch.render(1, path=[beam.parent])
    before, after = (numpy.array(told(result, "frequencies", t)[0]) for t in (104, 399))
    assert len(told(result, "resolved")) == 1  # none any more once it is off
    assert abs(after / exact - 1).max() < 1e-6
    assert abs(numpy.sort(before)[:2] / exact[:2] - 1).max() > .01  # by Taylor's series


def test_the_sound_of_a_render_repeats_and_does_not_click(beam):
    table = numpy.load(beam)
    sounds = []
    for _ in range(2):
        patch, box = struck(beam)
        patch.at(20, box, "hit 100 10 0 0.3")
        patch.at(300, box, message(shape(table)))
        sounds.append(patch.render(1, path=[beam.parent])["left"])
    assert (sounds[0] == sounds[1]).all()
    sound, swap = sounds[0], int(.310 * RATE)  # beyond the trust: asked for at once, answered 10 ms later
    steps = abs(numpy.diff(sound))
    steady = steps[swap - RATE // 10:swap - RATE // 50].max()
    assert steps[swap - RATE // 50:swap + RATE // 10].max() < 2 * steady
    assert abs(sound[swap + RATE // 20:swap + RATE // 4]).max() < 1.2 * abs(sound[swap - RATE // 4:swap - RATE // 20]).max()
    assert abs(sound[-RATE // 10:]).max() > 0.05 * abs(sound[swap - RATE // 10:swap]).max()  # it rings on


def test_a_missing_solver_is_one_sentence_and_the_expansion_goes_on(beam, tmp_path):
    table = numpy.load(beam)
    other = tmp_path / "not_modal_fem"
    other.write_text("#!/bin/sh\necho 'out of order' >&2\nexit 3\n")
    other.chmod(0o755)
    patch, box = struck(beam)
    patch.at(50, box, f"solver {other}")
    for t in (100, 400, 700):
        patch.at(t, box, message(shape(table, MOVE_MM * t / 1000)))
    patch.at(900, box, "info")
    result = patch.render(1, path=[beam.parent], expect_errors=["resolve: the solver ended: out of order; frequencies"])
    assert len(result.errors) == 1
    p = shape(table, MOVE_MM * .7)
    by_series = table["freq"] * numpy.exp(.5 * (p @ table["domega2_dp"]) / (2 * numpy.pi * table["freq"]) ** 2)
    assert numpy.allclose(told(result, "frequencies", 899)[0], numpy.sort(by_series), rtol=1e-5)
