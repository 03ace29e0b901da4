"""How modal_fem's frequencies follow a lattice of control points: against new solves of stretched bodies."""
import numpy as np
import pytest
from test_modal_fem import refusal, run

LENGTH, WIDTH, THICKNESS = 200, 24, 10  # with elements of 13 mm as many in a body 0.1 % larger or smaller
BAR = ["bar", "--h", "13", "--tolerance", "0", "--modes", "8", "--fix", f"x={-LENGTH / 2}"]
# 2 x 2 x 2 linear control points: those of one face together stretch it along an axis.
LATTICE = ["--lattice", "2", "2", "2", "--degree", "1", "1", "1"]


def table(folder, name, *words):
    run(*words, "-o", name, folder=folder)
    return np.load(folder / name)


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bar")
    sides = ["--length", LENGTH, "--width", WIDTH, "--thickness", THICKNESS]
    return folder, table(folder, "bar.modal.npz", *BAR, *sides, *LATTICE)


def squared(t):
    return (2 * np.pi * t["freq"]) ** 2


def of_face(t, axis):
    """d(omega^2) per m that the upper face of an axis moves outwards."""
    points = t["control_points"]
    upper = points[:, axis] > 0
    rows = t["parameters"]
    chosen = [upper[int(c)] and int(a) == axis for c, a, _, _ in rows]
    assert sum(chosen) == 4
    return t["domega2_dp"][chosen].sum(0)


def test_a_table_without_a_lattice_has_no_derivatives_and_the_same_modes(bar):
    folder, t = bar
    plain = table(folder, "plain.modal.npz", *BAR, "--length", LENGTH, "--width", WIDTH, "--thickness",
                  THICKNESS)
    assert "domega2_dp" not in plain.files and "parameters" not in plain.files
    assert len(t["freq"]) == 8 and t["phi"].shape == plain["phi"].shape
    assert t["freq"] == pytest.approx(plain["freq"], rel=1e-9)


def test_control_points_and_parameters_are_those_of_the_lattice(bar):
    t = bar[1]
    assert t["control_points"] == pytest.approx(
        np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
        * np.array([LENGTH, WIDTH, THICKNESS]) / 2000)
    assert t["domega2_dp"].shape == (24, 8)
    assert (t["parameters"][:, :2] == [(c, a) for c in range(8) for a in range(3)]).all()
    assert (t["parameters"][:, 2] < 0).all() and (t["parameters"][:, 3] > 0).all()
    assert t["trust"] == pytest.approx(0.1 * THICKNESS / 1000)


@pytest.mark.parametrize("axis, side", [(0, "--length"), (1, "--width"), (2, "--thickness")])
def test_stretching_the_bar_gives_the_derivatives_of_new_solves(bar, axis, side):
    folder, t = bar
    sides = {"--length": LENGTH, "--width": WIDTH, "--thickness": THICKNESS}
    step = 1e-3
    both = []
    for sign in (1, -1):
        moved = {**sides, side: sides[side] * (1 + sign * step)}
        words = [w for pair in moved.items() for w in pair]
        order = [f"x={-moved['--length'] / 2}" if str(w).startswith("x=") else w for w in BAR]
        both.append(squared(table(folder, "moved.modal.npz", *order, *words)))
    expected = (both[0] - both[1]) / (2e-3 * sides[side] * step)
    # A central difference of 0.1 % errs by the third derivative, 1e-5 of omega^2; graded meshes keep
    # their proportions as all sides of an element are stretched alike.
    scale = squared(t) / (sides[side] / 1000)
    assert abs(of_face(t, axis) - expected).max() < 1e-3 * scale.max()
    assert (abs(of_face(t, axis) - expected) / scale).max() < 2e-3


def test_a_shift_of_all_points_changes_nothing(tmp_path):
    t = table(tmp_path, "free.modal.npz", "bar", "--h", "13", "--tolerance", "0", "--modes", "8",
              "--length", LENGTH, "--width", WIDTH, "--thickness", THICKNESS, *LATTICE)
    for axis in range(3):
        rows = t["domega2_dp"][t["parameters"][:, 1] == axis]
        assert abs(rows.sum(0)).max() < 1e-6 * abs(rows).max()


def test_a_pair_of_a_round_bar_splits_by_its_own_derivatives(tmp_path):
    # Drawn out along y by both faces, a free round bar's first pair of bending parts: stiffer about one
    # axis as d(omega^2)/omega^2 = 2 dy/y, for the other only heavier and stiffer alike: 0.
    t = table(tmp_path, "round.modal.npz", "bar", "--length", 300, "--diameter", 12, "--tolerance", "0",
              "--modes", "4", "--h", "6", *LATTICE, "--directions", "y")
    assert t["mult"][0] == 2 and t["mult"][1] == 2
    points, rows = t["control_points"], t["parameters"]
    outwards = np.sign(points[rows[:, 0].astype(int), 1])
    first, second = t["domega2_dp"][:, :2].T / squared(t)[:2, None] * 0.006
    assert (first <= second + 1e-9).all()  # ascending for each parameter; their sum adds up
    assert (outwards * (first + second)).sum() == pytest.approx(2, abs=0.03)


@pytest.mark.parametrize("words, sentence", [
    (["--lattice", "1", "2", "2"], "--lattice 1: expected three whole numbers from 2 to 32"),
    (["--lattice", "2.5", "2", "2"], "--lattice 2.5: expected three whole numbers from 2 to 32"),
    (["--box", "0,0,0,1,1"], "--box 0,0,0,1,1: expected X1,Y1,Z1,X2,Y2,Z2"),
    (["--box", "0,0,0,-1,1,1"], "expected each coordinate of the second corner above the first's"),
    (["--controls", "99"], "--controls: control point 99 is not there, expected 0 to 26"),
    (["--directions", "w"], "--directions w: expected directions out of x, y and z"),
    (["--box", "-10,-50,-50,10,50,50", "--lattice", "2", "2", "2"], "no control point may move"),
])
def test_a_wrong_lattice_is_one_sentence(tmp_path, words, sentence):
    assert sentence in refusal(*BAR, "--length", LENGTH, "--width", WIDTH, "--thickness", THICKNESS, *words,
                               "-o", "bar.modal.npz", folder=tmp_path)
    assert not (tmp_path / "bar.modal.npz").exists()
