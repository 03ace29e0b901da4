"""`modal_fem serve`: the modes of a table's body at other shapes, asked by a child's stdin."""
import io
import json
import struct

import numpy as np
import pytest
import serve_client
from serve_client import MODES, QUIT, READY, REFUSED, SOLVE
from test_modal_fem import PROGRAM, refusal, run

SIDES = ["bar", "--length", "100", "--width", "20", "--thickness", "12"]
BAR = [*SIDES, "--h", "12", "--tolerance", "0", "--modes", "6", "--fix", "x=-50"]
LATTICE = ["--lattice", "2", "2", "2", "--degree", "1", "1", "1"]


class Server(serve_client.Server):
    def __init__(self, folder, table="bar.modal.npz"):
        super().__init__(PROGRAM, folder, table)

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
    run(*BAR, *LATTICE, "-o", "bar.modal.npz", folder=folder)
    return folder, np.load(folder / "bar.modal.npz")


def of_face(t, axis, by):
    """Parameters that move the upper face along an axis."""
    points = t["control_points"]
    return np.array([by if points[int(c), axis] > 0 and int(a) == axis else 0.0 for c, a, *_ in t["parameters"]])


def test_a_moved_shape_has_the_modes_of_a_body_of_its_dimensions(bar):
    """A bar whose height grows by 20 % is a bar of that height, with as many elements: 1e-6, the middle 1.2 mm up."""
    folder, t = bar
    grown = [("14.4" if w == "12" and BAR[i - 1] == "--thickness" else w) for i, w in enumerate(BAR)]
    run(*grown, "-o", "grown.modal.npz", folder=folder)
    exact = np.load(folder / "grown.modal.npz")
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
        # Its derivatives are those there: against a step of 0.1 % of the height.
        _, _, _, near = server.solve(p + of_face(t, 2, 1.44e-5), p)
        slope = 4 * np.pi ** 2 * (near["freq"] ** 2 - now["freq"] ** 2) / 1.44e-5
        assert slope == pytest.approx((of_face(t, 2, 1) @ now["domega2_dp"]), rel=5e-3, abs=1e-3 * abs(slope).max())
        # Shares are +-1 here, and answers depend on the request alone.
        assert len(shares) == 6 and abs(abs(shares["share"]) - 1).max() < 1e-9
        again = server.solve(p, zero)
        assert (again[3]["freq"] == now["freq"]).all() and (again[2] == shares).all()
        server.process.stdin.close()
        assert server.process.wait(60) == 0


def test_a_shape_that_turns_elements_inside_out_is_solved_before_it(bar):
    folder, t = bar
    zero, p = np.zeros(len(t["parameters"])), of_face(t, 2, -30e-3)
    with Server(folder) as server:
        server.read()
        server.send(SOLVE, np.array([p, zero]).tobytes())
        kind, payload = server.read()
        assert kind == MODES, payload
        fraction = struct.unpack_from("<d", payload, 8)[0]
        assert fraction == pytest.approx(0.95 * 12 / 30, abs=1.5e-3)  # a twentieth of the height is left


def test_what_cannot_be_answered_is_refused_and_the_next_request_is_answered(bar):
    folder, t = bar
    count = len(t["parameters"])
    with Server(folder) as server:
        server.read()
        for payload, words in ((b"", "0 bytes"), (bytes(8 * count), "expected"),
                               (np.full(2 * count, np.nan).tobytes(), "finite")):
            server.send(SOLVE, payload)
            kind, sentence = server.read()
            assert kind == REFUSED and words in sentence.decode()
        server.send(77)
        assert "kind 77" in server.read()[1].decode()
        assert server.solve(np.zeros(count), np.zeros(count))[3]["freq"] == pytest.approx(t["freq"], rel=1e-9)
        server.send(QUIT)
        assert server.process.wait(60) == 0


def test_a_table_that_was_changed_or_holds_no_mesh_is_refused(bar):
    folder, t = bar
    run(*BAR, "-o", "plain.modal.npz", folder=folder)
    assert "mesh" not in np.load(folder / "plain.modal.npz").files
    assert "plain.modal.npz" in refusal("serve", "plain.modal.npz", folder=folder)
    assert "expected one file" in refusal("serve", folder=folder)
    arrays = dict(t)
    np.savez(folder / "tuned.modal.npz", **{**arrays, "freq": t["freq"] * 1.001})
    np.savez(folder / "turned.modal.npz", **{**arrays, "phi": t["phi"][::-1]})
    zero = np.zeros(len(t["parameters"]))
    for table, words in (("tuned.modal.npz", "mode 1 has"), ("turned.modal.npz", "another shape")):
        with Server(folder, table) as server:
            assert server.read()[0] == READY
            server.send(SOLVE, np.array([zero, zero]).tobytes())
            kind, sentence = server.read()
            assert kind == REFUSED and words in sentence.decode() and "unchanged" in sentence.decode()
    meta = json.loads(bytes(t["meta"]))
    del meta["command"]
    np.savez(folder / "silent.modal.npz",
             **{**arrays, "meta": np.frombuffer(json.dumps(meta).encode(), np.uint8)})
    assert "how it was made" in refusal("serve", "silent.modal.npz", folder=folder)
