"""[phantom] with its simulated device in a headless Pd: forces, positions, stops and the simulated hand."""
import math

import numpy
import pytest

from device import play
from harness import Patch

LISSAJOUS = "-path lissajous 0 0 0 20 10 5 1 1.5 0.7"


def test_the_patch_s_force_follows_each_tick_and_block_sizes_change_no_bit(tmp_path):
    """A spring hand on a path, and a force of -6 (x - 0.5) from the patch: -6 N over 100 mm, a tick later."""
    def feedback(patch, box):
        box >> patch.obj("expr -6*($f1-0.5)") >> box
    seen = set()
    for block in (64, 1, 1024):
        answer = play(tmp_path, [(0, "stats")], f"-hand spring 200 2 {LISSAJOUS}", 1000, block, True, feedback)
        seen.add((tuple(answer.positions), (tmp_path / "ticks.csv").read_bytes()))
    assert len(seen) == 1 and len(answer.positions) > 990
    rows = answer.trace
    assert (numpy.diff(rows["tick"]) == 1).all()
    assert numpy.diff(rows["ms"]) == pytest.approx(numpy.ones(len(rows["ms"]) - 1), abs=1e-6)
    assert rows["fx_n"][101:] == pytest.approx(-0.06 * rows["x_mm"][100:-1], abs=2e-6)


@pytest.mark.parametrize("arguments, message, ms, word, expected", [
    ("-hand rigid -forcemax 2", "list 3 -4 0", 60, "force", (1.2, -1.6, 0)),  # the limit keeps the direction
    ("-hand rigid -forcemax 4 -units norm", "list 0 0.5 0", 60, "force", (0, 2, 0)),
    ("-hand rigid -path line 10 20 30 10 20 30 1000 -map zxy 1 -1 1", "list 0 0 0", 60, "mm", (30, -10, 20)),
    ("-hand spring 200 2", "list 1 0 0", 2000, "mm", (5, 0, 0)),  # to its equilibrium
    ("-hand spring 500 5", "target 12 -8 30", 900, "mm", (12, -8, 30))])
def test_a_message_has_its_effect_in_newtons_and_millimetres(tmp_path, arguments, message, ms, word, expected):
    answer = play(tmp_path, [(10, message), (ms, "bang")], arguments)
    assert answer.told(word)[-1] == pytest.approx(expected, abs=1e-2 if "target" in message else 1e-3)


def test_positions_are_normalised_over_the_workspace(tmp_path):
    answer = play(tmp_path, [(10, "bang")], "-hand rigid -path line 40 -75 10 40 -75 10 1000 "
                  "-workspace -80 -60 -35 80 60 35")
    assert answer.positions[-1] == pytest.approx((0.75, 0, 0.642857), abs=1e-5)
    assert answer.told("mm")[-1] == pytest.approx((40, -75, 10), abs=1e-4)


def test_learning_takes_the_workspace_from_the_motion(tmp_path):
    answer = play(tmp_path, [(5.5, "workspace learn 1"), (600.5, "workspace learn 0")],
                  "-hand rigid -path line -10 5 0 30 -15 0 400")
    assert answer.told("workspace")[0] == pytest.approx([-10, -15, 0, 30, 5, 0], abs=1e-2)


def test_forces_on_separate_inlets_are_one_force(tmp_path):
    answer = play(tmp_path, [(20.5, newton, inlet) for inlet, newton in enumerate((0.25, -0.5, 1))],
                  "-hand rigid -interp off -report force 1", 60)
    assert {tuple(f) for f in answer.told("force")} == {(0, 0, 0), (0.25, -0.5, 1)}


@pytest.mark.parametrize("bad", [math.inf, math.nan])
def test_what_is_no_number_is_refused_once_and_the_last_good_force_stays(tmp_path, bad):
    answer = play(tmp_path, [(10, 1.5, 1), (50, bad, 1), (60, "bang"), (60, "stats"), (100, 0.25, 1), (180, "bang")],
                  "-hand rigid", errors=["not a finite number"])
    assert [f[1] for f in answer.told("force")] == pytest.approx([1.5, 0.25], abs=1e-6)
    assert answer.told("stats", "refused") == [[1]] and len(answer.errors) == 1


def test_a_strict_watchdog_wants_forces_to_keep_coming(tmp_path):
    answer = play(tmp_path, [(19.5, "list 1 0 0"), (110.5, "bang"), (145.5, "bang"), (175.5, "bang"),
                             (200.5, "list 1 0 0"), (300.5, "bang")],
                  "-hand rigid -strict 1 -watchdog 100 50 -interp off")
    assert [f[0] for f in answer.told("force")] == pytest.approx([1, 0.5, 0, 1], abs=0.03)


# ---- the passivity controller and the limit ---------------------------------------------------

def test_a_constant_force_arrives_at_once_and_no_wall_pulls_or_acts_outside(tmp_path):
    rows = play(tmp_path, [(100.5, "list 1 0 0")], "-hand spring 200 2", 600, traced=True).trace
    assert rows["fx_n"][102:] == pytest.approx(1, abs=0.01)
    for stiffness in (50, 500):
        for faults in ("", "-resolution 0.034 -latency 1"):
            answer = play(tmp_path, [(1, "scene add wall plane 0 1 0 0"), (2, f"scene mat wall {stiffness} 0 0"),
                                     (3, "path line 0 -8 0 0 8 0 1000")], f"-hand spring 200 2 {faults}", 3000, traced=True)
            force, outside = answer.trace["fy_n"], answer.trace["y_mm"] > 0
            assert force.max() > 0.1 and force.min() >= 0 and (force[outside] == 0).all()
            assert (answer.trace["braked_n"] > 0).any() and (answer.trace["braked_n"][outside] == 0).all()


def test_what_the_limit_and_the_controller_take_is_told(tmp_path):
    answer = play(tmp_path, [(10, "list 100 0 0"), (100, "list 1 0 0")], "-hand rigid", 1000, traced=True, errors=[])
    assert answer.told("status", "clipped") == [[1], [0]]
    assert (answer.trace["asked_n"] == 100).any() and answer.trace["fx_n"].max() == pytest.approx(8)
    wall = [(1, "scene add wall plane 0 1 0 0"), (2, "scene mat wall 5000 0 0"), (3, "list 0 -1 0"), (900, "list 0 1 0")]
    assert play(tmp_path, wall, "-hand free", 2000).told("status", "braked") == [[1], [0]]


# ---- the emergency stop ----------------------------------------------------------------------

def test_an_emergency_stop_holds_whatever_happens_to_the_connection_until_motors_on(tmp_path):
    asked = ["close", "open", "clock wall", "clock logical", "rate 2000", "backend sim", "name other", "motors 0"]
    messages = [(10, "list 2 0 0"), (99, "bang"), (100, "estop")]
    for i, message in enumerate(asked):
        messages += [(110 + 200 * i, message), (200 + 200 * i, f"list 2.{i} 0 0"), (290 + 200 * i, "bang")]
    end = 150 + 200 * len(asked)
    messages += [(end, "motors 1"), (end + 10, "list 3 0 0"), (end + 250.5, "bang"), (end + 650, "bang")]
    before, *held, rising, back = [f[0] for f in play(tmp_path, messages, "-hand rigid").told("force")]
    assert before == pytest.approx(2) and len(held) >= len(asked) - 2 and not any(held)
    assert rising == pytest.approx(1.5, abs=0.02) and back == pytest.approx(3)


@pytest.mark.parametrize("name, first, then, force, told", [
    ("-name left", ["estop"], ["dump"], 0, ["estop", 1]),
    ("-name left", ["estop"], ["motors 1", "dump"], 2, ["estop", 0]),  # the user ends it
    ("-name left", ["estop", "motors 1"], ["dump"], 2, ["estop", 0]),  # ended before: not inherited
    ("-name left -motors 1", ["estop"], [], 0, None),  # a creation argument does not end it
    ("", ["estop"], ["dump"], 2, ["estop", 0])])  # simulated and without a name: no other's
def test_an_emergency_stop_holds_for_the_next_phantom_of_that_name(name, first, then, force, told):
    patch = Patch()
    patch.sub("made").obj("inlet")
    answer = patch.obj("r answer")
    patch.log("again", answer)
    lines = ["obj 10 10 r say", f"obj 10 50 phantom sim -hand rigid {name}", "obj 10 90 s answer", "connect 1 0 2 0",
             "connect 2 3 3 0"]
    for start in (10, 310):
        for i, line in enumerate(lines):
            patch.send(start + i, "pd-made", line)
    said = [(100, "list 2 0 0"), (150, "bang"), *((200 + i, m) for i, m in enumerate(first)),
            *((350 + i, m) for i, m in enumerate(then)), (1000, "list 2 0 0"), (1600, "bang")]
    for ms, message in said:
        patch.send(ms, "say", message)
    patch.send(300, "pd-made", "clear")
    patch.send(301, "pd-made", "obj 10 10 inlet")
    result = patch.render(1.7)
    info = [atoms for _, atoms in result.logs["again"]]
    assert [atoms[1] for atoms in info if atoms[0] == "force"] == pytest.approx([2, force])
    assert not told or told in info
    assert ("the estop of an earlier phantom of the same name or device is still active" in result.output) == (name != "" and len(first) == 1)


# ---- the simulated hand ------------------------------------------------------------------------

def test_a_path_file_moves_the_hand_and_its_buttons(tmp_path):
    (tmp_path / "stroke.txt").write_text("# ms x y z buttons\n0 0 0 0 0\n100 10 20 -30 2\n")
    answer = play(tmp_path, [(50.5, "bang"), (150.5, "bang"), (160.2, "seek 50"), (161.5, "bang")],
                  "-hand rigid -path stroke.txt")
    assert answer.told("mm")[:2] == [pytest.approx([5, 10, -15], abs=1e-4), pytest.approx([10, 20, -30], abs=1e-4)]
    assert answer.told("mm")[2][0] == pytest.approx(5.1, abs=1e-4)
    assert answer.told("vel")[0] == pytest.approx([0.1, 0.2, -0.3], abs=1e-5)
    assert answer.told("button")[0] == [1, 1]
    (tmp_path / "bad.txt").write_text("0 0 0 0\n5 1 2\n")
    play(tmp_path, [(10, "path bad.txt")], errors=["phantom: path bad.txt: line 2: expected ms x y z .buttonmask.$"])


def test_arrays_are_a_path(tmp_path):
    def tables(patch, _):
        for name, top in (("ax", 9), ("ay", 0), ("az", -4.5)):
            patch.obj(f"table {name} 10")
            patch.send(1, name, [0, *(top * i / 9 for i in range(10))])
    answer = play(tmp_path, [(10.5, "path array ax ay az 2"), (19.5, "bang"), (60.5, "bang")], "-hand rigid", draw=tables)
    assert answer.told("mm") == [pytest.approx([4.5, 0, -2.25], abs=1e-4), pytest.approx([9, 0, -4.5], abs=1e-4)]


def test_seeds_choose_the_person(tmp_path):
    one, again, other = (play(tmp_path, [(290, "bang")], f"-hand person -seed {seed}").positions for seed in (1, 1, 2))
    assert one == again != other


def test_an_encoder_step_shows_and_velocity_is_estimated(tmp_path):
    answer = play(tmp_path, [(0, "report mm 1, report vel 1")],
                  "-hand rigid -resolution 0.05 -path line -20 0 0 20 0 0 1000", 251)
    steps = numpy.array(answer.told("mm"))[:, 0] / 0.05
    assert abs(steps - steps.round()).max() < 1e-2
    # Half way after 250 ms at pi * 40 mm / 1 s.
    assert answer.told("vel")[-1][0] == pytest.approx(0.1257, rel=0.05)


@pytest.mark.parametrize("arguments, count", [(f"{LISSAJOUS} -outrate 100", 10), (f"{LISSAJOUS} -outrate 0", 0),
                                              ("", 1), ("-repeat 1", 100), (f"{LISSAJOUS} -rate 4000", 100)])
def test_positions_come_as_often_as_was_asked_for(tmp_path, arguments, count):
    found = [ms for ms, _ in play(tmp_path, [(0, "stats")], arguments, 300).result.logs["x"] if ms < 99.5]
    assert len(found) == count


def test_a_rate_changed_on_the_way_goes_on_at_once(tmp_path):
    answer = play(tmp_path, [(1000.2, "rate 200"), (1999, "stats")], LISSAJOUS)
    assert answer.told("stats", "ticks")[0][0] == pytest.approx(1200, abs=2)


def test_closing_stops_and_opening_starts_afresh(tmp_path):
    answer = play(tmp_path, [(99.5, "close"), (199.5, "open")], LISSAJOUS, 300)
    times = [ms for ms, _ in answer.result.logs["x"]]
    assert not [ms for ms in times if 100 < ms < 199] and len([ms for ms in times if 200 < ms < 300]) >= 98
    assert answer.told("status") == [["closed", "sim"], ["open", "sim"]]
