"""How modal_fem's modes follow a lattice of control points, in the table and asked of `modal_fem serve`: against
new solves of stretched bodies."""
import io
import json
import struct
from functools import partial

import numpy as np
import program
import pytest
from program import MODAL_FEM, MODES, QUIT, READY, SOLVE, meta, table

run, refusal = partial(program.run, MODAL_FEM), partial(program.refusal, MODAL_FEM)
SIDES = {"--length": 100, "--width": 20, "--thickness": 12}
BAR = ["bar", "--h", 12, "--tolerance", 0, "--modes", 6, "--fix", "x=-50"]
# 2 x 2 x 2 linear control points: those of one face together stretch it along an axis.
LATTICE = ["--lattice", 2, 2, 2, "--degree", 1, 1, 1]


def words(**changed):
    return [word for pair in {**SIDES, **{f"--{name}": value for name, value in changed.items()}}.items() for word in pair]


class Server(program.Server):
    def __init__(self, folder, name="bar.modal.npz"):
        super().__init__(MODAL_FEM, folder, name)

    def solve(self, parameters, before):
        """Seconds, fraction, shares (before, now, share) and the table."""
        self.send(SOLVE, np.asarray([parameters, before], "<f8").tobytes())
        kind, payload = self.read()
        assert kind == MODES, payload
        seconds, fraction, count = struct.unpack_from("<ddQ", payload)
        shares = np.frombuffer(payload, [("before", "<u4"), ("now", "<u4"), ("share", "<f8")], count, 24)
        return seconds, fraction, shares, np.load(io.BytesIO(payload[24 + 16 * count:]))


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serve")
    run(*BAR, *words(), *LATTICE, "-o", "bar.modal.npz", folder=folder)
    return folder, np.load(folder / "bar.modal.npz")


def of_face(t, axis, by):
    """Parameters that move the upper face along an axis."""
    points = t["control_points"]
    return np.array([by if points[int(c), axis] > 0 and int(a) == axis else 0.0 for c, a, *_ in t["parameters"]])


def squared(t):
    return (2 * np.pi * t["freq"]) ** 2


def test_the_table_holds_the_lattice_its_derivatives_and_the_modes_of_a_body_without_one(bar):
    folder, t = bar
    plain, _ = table(*BAR, *words(), folder=folder)
    assert not {"domega2_dp", "parameters", "mesh"} & set(plain.files)
    assert len(t["freq"]) == 6 and t["phi"].shape == plain["phi"].shape
    assert t["freq"] == pytest.approx(plain["freq"], rel=1e-9)
    assert t["control_points"] == pytest.approx(
        np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) * [*SIDES.values()] / 2000)
    assert t["domega2_dp"].shape == (24, 6)
    assert (t["parameters"][:, :2] == [(c, a) for c in range(8) for a in range(3)]).all()
    assert (t["parameters"][:, 2] < 0).all() and (t["parameters"][:, 3] > 0).all()
    assert t["trust"] == pytest.approx(0.1 * SIDES["--thickness"] / 1000)


def test_a_shift_of_all_points_changes_nothing_and_a_pair_of_a_round_bar_splits_by_its_own_derivatives(tmp_path):
    # Drawn out along y by both faces, a free round bar's first pair of bending parts: stiffer about one
    # axis as d(omega^2)/omega^2 = 2 dy/y, for the other only heavier and stiffer alike: 0.
    t, _ = table("bar", "--length", 300, "--diameter", 12, "--tolerance", 0, "--modes", 4, "--h", 10, *LATTICE, "--directions",
                 "y", folder=tmp_path)
    assert abs(t["domega2_dp"][:, :2].sum()) < 1e-6 * abs(t["domega2_dp"]).max()  # parts of a pair are sorted
    assert t["mult"][0] == 2 and t["mult"][1] == 2
    outwards = np.sign(t["control_points"][t["parameters"][:, 0].astype(int), 1])
    first, second = t["domega2_dp"][:, :2].T / squared(t)[:2, None] * 0.006
    assert (first <= second + 1e-9).all()  # ascending for each parameter; their sum adds up
    assert (outwards * (first + second)).sum() == pytest.approx(2, abs=0.03)


@pytest.mark.parametrize("order, sentence", [
    (["--lattice", 1, 2, 2], "--lattice 1: expected three integers in 2..32"),
    (["--lattice", 2.5, 2, 2], "--lattice 2.5: expected three integers in 2..32"),
    (["--box", "0,0,0,1,1"], "--box 0,0,0,1,1: expected X1,Y1,Z1,X2,Y2,Z2"),
    (["--box", "0,0,0,-1,1,1"], "expected each coordinate of the second corner above the first's"),
    (["--controls", 99], "--controls: control point 99: expected 0..26"),
    (["--directions", "w"], "--directions w: expected directions such as x, yz or xyz"),
    (["--box", "-10,-50,-50,10,50,50", "--lattice", 2, 2, 2], "no control point may move"),
])
def test_a_wrong_lattice_is_one_sentence(tmp_path, order, sentence):
    assert sentence in refusal(*BAR, *words(), *order, "-o", "bar.modal.npz", folder=tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_moved_shape_has_the_modes_of_a_body_of_its_dimensions(bar):
    """A bar whose height grows by 20 % is a bar of that height, with as many elements: 1e-6, the middle 1.2 mm up."""
    folder, t = bar
    exact, _ = table(*BAR, *words(thickness=14.4), folder=folder)
    zero, p = np.zeros(len(t["parameters"])), of_face(t, 2, 2.4e-3)
    assert len(exact["xyz"]) == len(t["xyz"])
    with Server(folder) as server:
        kind, ready = server.read()
        assert kind == READY and struct.unpack("<QQQ", ready) == (6, len(t["xyz"]), len(p))
        seconds, fraction, shares, now = server.solve(p, zero)
        assert seconds > 0 and fraction == 1
        assert now["freq"] == pytest.approx(exact["freq"], rel=1e-6)
        assert now["mass"] == pytest.approx(1.2 * t["mass"], rel=1e-9)
        assert now["xyz"] == pytest.approx(exact["xyz"] + [0, 0, 1.2e-3], abs=1e-8)
        assert (now["displacement"] == p).all() and "mesh" not in now.files
        assert (now["parameters"] == t["parameters"]).all()
        # Derivatives, of the table and there, against steps of 0.1 % of each side: the difference errs by its
        # second derivative.
        for at, base, size in ((p, now, 14.4e-3), (zero, t, 12e-3)):
            for axis in range(3):
                step = 1e-3 * (size if axis == 2 else [*SIDES.values()][axis] / 1000)
                near = server.solve(at + of_face(t, axis, step), at)[3]
                slope = (squared(near) - squared(base)) / step
                assert slope == pytest.approx(of_face(t, axis, 1) @ base["domega2_dp"], rel=6e-3,
                                              abs=2e-3 * abs(slope).max())
        # Shares are +-1 here, and answers depend on the request alone.
        assert len(shares) == 6 and abs(abs(shares["share"]) - 1).max() < 1e-9
        again = server.solve(p, zero)
        assert (again[3]["freq"] == now["freq"]).all() and (again[2] == shares).all()
        # A shape that turns elements inside out is solved before it: a twentieth of the height is left.
        both_faces = [-5.99e-3 * np.sign(t["control_points"][int(c), 2]) if a == 2 else 0 for c, a, *_ in t["parameters"]]
        assert server.solve(both_faces, zero)[1] == pytest.approx(0.95 * 6 / 5.99, abs=1.5e-3)
        server.process.stdin.close()
        assert server.process.wait(60) == 0


def test_what_cannot_be_answered_is_refused_and_the_next_request_is_answered(bar):
    folder, t = bar
    count = len(t["parameters"])
    with Server(folder) as server:
        server.read()
        for payload, said in ((b"", "0 bytes"), (bytes(8 * count), "expected"), (np.full(2 * count, np.nan).tobytes(), "finite"),
                              (np.tile(of_face(t, 2, -30e-3), 2).tobytes(), "along z -30 mm: expected -6..6 mm")):
            assert said in server.refuses(SOLVE, payload)
        assert "kind 77" in server.refuses(77)
        assert server.solve(np.zeros(count), np.zeros(count))[3]["freq"] == pytest.approx(t["freq"], rel=1e-9)
        server.send(QUIT)
        assert server.process.wait(60) == 0


def test_a_table_that_was_changed_or_holds_no_mesh_is_refused(bar):
    folder, t = bar
    table(*BAR, *words(), folder=folder)
    assert "body.modal.npz" in refusal("serve", "body.modal.npz", folder=folder)
    assert "expected one file" in refusal("serve", folder=folder)
    request = np.zeros(2 * len(t["parameters"])).tobytes()
    for changed, said in (({"freq": t["freq"] * 1.001}, "mode 1 has"), ({"phi": t["phi"][::-1]}, "differs from that at")):
        np.savez(folder / "changed.modal.npz", **{**t, **changed})
        with Server(folder, "changed.modal.npz") as server:
            assert server.read()[0] == READY
            sentence = server.refuses(SOLVE, request)
            assert said in sentence and "unchanged" in sentence
    silent = {name: value for name, value in meta(t).items() if name != "command"}
    np.savez(folder / "silent.modal.npz", **{**t, "meta": np.frombuffer(json.dumps(silent).encode(), np.uint8)})
    assert "the command that made it" in refusal("serve", "silent.modal.npz", folder=folder)
