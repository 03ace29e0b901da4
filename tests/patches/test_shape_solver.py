"""[modal_impact~] whose body is reshaped asks the program modal_fem for the modes of the moved mesh: in a render,
whose results repeat, and live, where the child may die or be missing."""
import os
import signal
import struct
import subprocess

import numpy
import pytest

from harness import Patch, stage_folder

PROGRAM = stage_folder() / "modal_fem"
if not PROGRAM.exists():
    pytest.skip("the program modal_fem is not built", allow_module_level=True)
RATE = 48000
BODY = "bar --length 200 --width 20 --thickness 20 --material steel --h 10 --tolerance 0 --fix x=-100 --modes 12 --loss 0.002".split()
LATTICE = "--lattice 5 2 2 --directions y --range 6 --controls 6,7,8,9,16,17,18,19".split()  # of the top, not at the clamp
MOVE_MM = -4  # a fifth of the height


def run(*words):
    subprocess.run([PROGRAM, *words, "--quiet"], check=True, capture_output=True, timeout=300)


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("beam")
    run(*BODY, *LATTICE, "-o", folder / "beam.modal.npz", "--export-inp", folder / "beam.inp")
    return folder / "beam.modal.npz"


def nodes_of(path):
    lines = path.read_text().splitlines()
    first = next(i for i, s in enumerate(lines) if s.upper().startswith("*NODE")) + 1
    last = next(i for i in range(first, len(lines)) if lines[i].startswith("*"))
    rows = [s.split(",") for s in lines[first:last]]
    return lines, first, last, [r[0] for r in rows], numpy.array([[float(c) for c in r[1:4]] for r in rows])


def bernstein(t, degree):
    """Of the clamped uniform B-spline that has one knot interval for each point beyond its degree (Cox, de Boor)."""
    points = len(degree[1])
    p = degree[0]
    knots = numpy.concatenate([numpy.zeros(p), numpy.linspace(0, 1, points - p + 1), numpy.ones(p)])
    basis = [((t >= a) & (t < b)) | ((b == 1) & (t == 1) & (a < b)) for a, b in zip(knots[:-1], knots[1:])]
    basis = [b.astype(float) for b in basis]
    for d in range(1, p + 1):
        basis = [(basis[i] * (t - knots[i]) / (knots[i + d] - knots[i]) if knots[i + d] > knots[i] else 0 * t)
                 + (basis[i + 1] * (knots[i + d + 1] - t) / (knots[i + d + 1] - knots[i + 1])
                    if knots[i + d + 1] > knots[i + 1] else 0 * t) for i in range(len(basis) - 1)]
    return numpy.array(basis)


def moved_frequencies(beam, p):
    """By modal_fem on the mesh whose nodes were moved here, by a B-spline of our own."""
    table = numpy.load(beam)
    lines, first, last, names, x = nodes_of(beam.with_name("beam.inp"))
    low, high = x.min(0), x.max(0)
    u, v, w = ((x - low) / (high - low)).T
    along, across, deep = bernstein(u, (3, range(5))), bernstein(v, (1, range(2))), bernstein(w, (1, range(2)))
    y = x.copy()
    for (c, axis, _, _), by in zip(table["parameters"], p):
        c = int(c)
        y[:, int(axis)] += by * along[c % 5] * across[c // 5 % 2] * deep[c // 10]
    text = [f"{n}, " + ", ".join(f"{c:.15g}" for c in at) for n, at in zip(names, y)]
    moved = beam.with_name("moved.inp")
    moved.write_text("\n".join([*lines[:first], *text, *lines[last:]]) + "\n")
    out = beam.with_name("moved.modal.npz")
    run(moved, "--unit", "m", "--material", "steel", "--modes", "12", "--tolerance", "0", "--fix", f"x={x[:, 0].min():.15g}",
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
    patch.at(100, box, message(p))
    patch.at(105, box, "info")
    patch.at(400, box, "info")
    result = patch.render(.5, path=[beam.parent])
    before, after = (numpy.array(told(result, "frequencies", t)[0]) for t in (104, 399))
    assert len(told(result, "resolved")) == 1
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


def test_resolve_off_asks_for_nothing(beam):
    patch, box = struck(beam, "-resolve", "off")
    patch.at(100, box, message(shape(numpy.load(beam))))
    assert not told(patch.render(1, path=[beam.parent]), "resolved")
