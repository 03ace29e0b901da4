"""[stress_haptic] in a headless Pd: feedback scalars, force, shapes, swaps, damaged input."""
import json
import re

import numpy
import pytest

from harness import Patch, stage_folder

OUTLETS = ("gamma", "force", "info", "protocol")
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


def test_taylors_series_moves_the_stress_and_bounds_hold(tmp_path):
    """s = s0 + S dp at dp = (2, 0, -1) mm: cp and list say the same; 5 m is cut to the bound of 1 m."""
    file = save(tmp_path / "four.stress.npz", P20["s0"], 1e3 * numpy.array(P20["S"], float))
    words = ("-norm", "mean")
    by_cp = play(file, [(10, "range fixed 0 100"), (20, "cp 0 2 0 -1"), (300, "bang")], words=words)
    by_list = play(file, [(10, "range fixed 0 100"), (20, "list 2 0 -1"), (300, "bang")], words=words)
    expected = numpy.mean([10 + 2, 20, 30 - 1, 40 + 2 - 1]) / 100
    assert last(by_cp, "gamma") == pytest.approx([expected], rel=1e-6)
    assert last(by_cp, "gamma") == last(by_list, "gamma")
    far = play(file, [(10, "range fixed 0 1000"), (20, "cp 0 5000 0 0"), (300, "bang")])
    assert last(far, "gamma") == pytest.approx([(25 + 1e3 / 2) / 1000], rel=1e-6)
    assert last(far, "info", "outside") == [1]
    assert last(far, "info", "method") == ["taylor"]


def test_a_render_repeats_exactly(table):
    def once():
        return play(table, [(20, "grab 0"), (40, "mode axis"), (60, "list 1 2 3")],
                    [(10 + 5 * i, f"{i} {2 * i} 0") for i in range(60)]).logs
    first, second = once(), once()
    for outlet in ("gamma", "force", "protocol"):
        assert first[outlet] == second[outlet]


def test_force_is_continuous_when_another_table_is_loaded(tmp_path):
    """gamma 0.25 to 0.75, 20 N at 1: 10 N over 100 ms are 0.1 N in a millisecond."""
    save(tmp_path / "weak.stress.npz", [75] * 3, [[0] * 3])
    first = save(tmp_path / "strong.stress.npz", [25] * 3, [[0] * 3])
    result = play(first, [(1, "range fixed 0 100"), (2, "gains 0 500 0 0"), (3, "anchor 0 0 0"),
                          (300, f"load {tmp_path / 'weak.stress.npz'}")],
                  [(250, "40 0 0 0 0 0")], seconds=0.6)
    force = [(ms, atoms[0]) for ms, atoms in result.logs["force"] if ms >= 250]
    assert force[0][1] == pytest.approx(-5) and force[-1][1] == pytest.approx(-15)
    steps = [abs(b - a) / max(1, tb - ta) for (ta, a), (tb, b) in zip(force, force[1:])]
    assert 0.09 < max(steps) < 0.1001
    change = [ms for ms, f in force if -14.999 < f < -5.001]
    assert change[-1] - change[0] == pytest.approx(98, abs=2)


def test_phantom_and_stress_haptic_close_the_loop():
    """A hand of 200 N/m pulls the middle of the beam up; the spring k(gamma) to the anchor holds against
    it: at rest k y = 200 N/m (14 mm - start - y), and gamma is that of the shape where it rests."""
    patch = Patch()
    device = patch.obj("phantom sim")
    box = patch.obj("stress_haptic", str(stage_folder() / "beam.stress.npz"), "-gains", 100, 500, 0, 0)
    route, join = patch.obj("route mm"), patch.obj("t a")
    device[3] >> route
    route >> join >> box[1]
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


def test_bad_messages_and_files_are_one_sentence_and_the_last_state_goes_on(table, tmp_path):
    (tmp_path / "torn.stress.npz").write_bytes(table.read_bytes()[:200])
    other = save(tmp_path / "mpa.stress.npz", **P20, meta={"units": {"stress": "MPa"}})
    result = play(table, [(20, "cp 9 0 0 0"), (21, "cp 0 left 0 0"), (22, "list 1 2"), (23, "range fixed 2 1"),
                          (24, "gains 0 9999 0 0"), (25, "grab -1"), (26, "anchor up"), (27, "mode loud"),
                          (28, f"load {tmp_path / 'torn.stress.npz'}"), (29, f"load {other}"),
                          (30, "load missing.stress.npz"), (31, "resolve full"), (32, "state shear"),
                          (33, "nominal -5"), (300, "bang")],
                  [(40, "1 2"), (41, [1.0, float("nan"), 2.0])],
                  fails=[r"stress_haptic: cp: control point 9: expected 0\.\.0",
                         r"stress_haptic: cp: 'left'", r"stress_haptic: list: 2 numbers: expected 3",
                         r"stress_haptic: range fixed 2 1: expected current", r"stress_haptic: gains: 9999 N/m: expected at",
                         r"stress_haptic: grab: control point -1", r"stress_haptic: anchor up: expected here",
                         r"stress_haptic: mode loud: expected", r"stress_haptic: load .*torn.*: not an \.npz",
                         r"stress_haptic: load .*mpa.*: meta says that stress is in MPa: expected Pa",
                         r"stress_haptic: load missing.*no such file", r"stress_haptic: resolve full: no solver",
                         r"stress_haptic: state shear: the table has no", r"stress_haptic: nominal -5",
                         r"stress_haptic: device: 2 numbers", r"stress_haptic: device: '-?nan'"])
    assert len(result.errors) == 16
    assert last(result, "gamma") == pytest.approx([0.5])


# Message, and what its one sentence says after the object's name.
BAD = {"mode": "mode: expected one word", "weights heavy": "weights heavy: expected uniform or volume",
       "sens up": "sens up: expected signed or abs", "render gas": "render gas: expected spring, damper, both or off",
       "norm 9": "norm 9: expected mean or sum", "power 0": "power 0: expected 1..64",
       "power 65": "power 65: expected 1..64", "resolve now": "resolve now: expected auto, taylor, pcg or full",
       "drag 3": "drag 3: expected 0..1", "scale 0": "scale 0: expected 0.001..1000",
       "share 2": "share 2: expected 0..1", "damping -1": "damping -1 N s/m: expected 0..1000",
       "load": "load: expected 1 argument", "load 5": "load 5: expected the name of a file",
       "load /etc/passwd": "load /etc/passwd: not an .npz file", "cp 0 1 2": "cp: expected 4 arguments (id x y z), got 3",
       "cp 0.5 0 0 0": "cp: control point 0.5: expected 0..", "cp 0 1e30 0 0": "cp: '1e+30': expected numbers within",
       "list a b c": "list: 'a': expected numbers", "grab 77": "grab: control point 77: expected 0..",
       "grab 0 5": "grab: 5: expected 1 to take the control point or 0", "grab 0 1 2": "grab: expected 1..2 arguments",
       "release 3": "release: expected no arguments, got 1", "range wide": "range wide: expected current, initial, or fixed a b",
       "range fixed 1 1": "range fixed 1 1: expected", "range initial 3": "range initial 3: expected",
       "gains 1 2 3": "gains: expected 4 arguments", "gains 1 -2 0 0": "gains: -2: expected kmin kmax bmin bmax",
       "gains 0 0 99 99": "gains: 99 N s/m: expected at most 5", "anchor 1 2": "anchor 1 2: expected here, or x y z",
       "anchor a b c": "anchor: 'a': expected numbers", "solver 5": "solver 5: expected the path of part_stress",
       "solver /etc/passwd": "solver /etc/passwd: there is no such program", "draw 3": "draw 3: expected nothing or all",
       "frobnicate 5": "no message 'frobnicate'"}


def test_every_bad_message_is_one_sentence_with_its_value(table):
    result = play(table, [(10 + 2 * i, text) for i, text in enumerate(BAD)] + [(300, "bang")],
                  fails=[re.escape(f"error: stress_haptic: {sentence}") for sentence in BAD.values()])
    assert len(result.errors) == len(BAD)
    for error, sentence in zip(result.errors, BAD.values()):
        assert error.startswith(f"error: stress_haptic: {sentence}")
    assert last(result, "gamma") == pytest.approx([0.5])


def test_a_power_follows_the_largest_stresses(table):
    """((10^q + 20^q + 30^q + 40^q)/4)^(1/q) of range 10..40."""
    for q in (2, 30):
        result = play(table, [(10, f"power {q}"), (300, "bang")])
        expected = numpy.mean(numpy.array([10, 20, 30, 40.0]) ** q) ** (1 / q)
        assert last(result, "info", "raw")[0] == pytest.approx(expected, rel=1e-6)
        assert last(result, "gamma") == pytest.approx([(expected - 10) / 30], rel=1e-6)


def test_the_protocol_outlet_speaks_to_a_haptic_server(table):
    result = play(table, [(20, "points"), (30, "mode axis")], seconds=1)
    said = [atoms for _, atoms in result.logs["protocol"]]
    assert ["hap", "workspace", -1001, -1001, -1001, 1001, 1001, 1001] in said
    at = said.index(["hap", "cp", "begin", 1])
    assert said[at + 1:at + 3] == [["hap", "cp", "set", 0, 0, 0, 0], ["hap", "cp", "end"]]
    feedback = [(ms, atoms[2:]) for ms, atoms in result.logs["protocol"] if atoms[1] == "feedback"]
    assert [f[0] for _, f in feedback] == list(range(int(feedback[0][1][0]), int(feedback[-1][1][0]) + 1))
    assert len(feedback[-1][1]) == 4
    assert max(b - a for (a, _), (b, _) in zip(feedback, feedback[1:])) <= 251
