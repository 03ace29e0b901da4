"""The modules of patches/audiohaptics/ioa that read, recognise and find contacts."""
import struct

import numpy
import pytest

from harness import Patch
from ioa_system import BODIES_APART, SERVERS, System, hits, of, render, rows, taps, wandering


# ---- interaction server ------------------------------------------------------------------------

@pytest.mark.parametrize("server", SERVERS)
def test_a_hand_that_comes_by_a_quarter_millimetre_a_tick_hits_at_tick_57(tmp_path, server):
    script = rows(tmp_path / "hand.txt", (0, 25, 0, 20.1), (80, 25, 0, 0.1), (160, 25, 0, 20.1),
                  (240, 25, 0, 0.1))
    result = render(0.25, script, r_modal=None, **{"is": server})
    found = of(result, "lab", "hit")
    late = 1 if server == "ioa_is" else 0  # the servo's next tick after the bus's message
    assert [(h[0], h[1]) for h in found] == [(57 + late, "disk"), (217 + late, "disk")]
    for hit in found:
        assert hit[2:8] == pytest.approx([25, 0, 6, 0, 0, 1], abs=1e-4)
        assert hit[8] == pytest.approx(0.25, rel=0.01) and hit[9] == pytest.approx(0, abs=1e-4)
    assert [round(r[0]) for r in of(result, "lab", "release")] == [104 + late]


BODIES = {"sphere": ("add b sphere 0 0 0 20", (20, 20, 0), (12, 12, 0), (1.071068, 1.071068, 0)),
          "box": ("add b box 0 0 0 30 10 20", (0, 15, 0), (0, 7, 0), (0, 1.5, 0)),
          "box, pressed beyond its bottom": ("add b box 0 0 0 30 10 20", (0, 15, 0), (0, -13, 0),
                                             (0, 11.5, 0)),
          "disk": ("add b disk 0 0 0 0 0 1 50 12", (0, 0, 20), (0, 0, -3), (0, 0, 4.5)),
          "disk, its rim": ("add b disk 0 0 0 0 0 2 50 12", (60, 0, 1), (48, 0, 1), (1, 0, 0)),
          "disk, moved": ("add b disk 0 0 0 0 1 0 50 12, move b 5 10 0", (5, 30, 0), (5, 13, 0),
                          (0, 1.5, 0)),
          "plane": ("add b plane 0 2 0 5", (3, 12, 4), (3, 3, 4), (0, 1, 0))}


@pytest.mark.parametrize("name", BODIES)
def test_the_spring_is_k_times_the_depth_of_every_body(tmp_path, name):
    scene, start, end, force = BODIES[name]
    script = rows(tmp_path / "hand.txt", (0, *start), (100, *end), (300, *end))
    lines = [line.strip() for line in scene.split(",")]
    (tmp_path / "scene.txt").write_text("\n".join([*lines[:1], "mat b 500", *lines[1:]]) + "\n")
    for server in SERVERS:
        result = render(0.3, script, r_modal=None, scene=str(tmp_path / "scene.txt"), **{"is": server})
        assert len(hits(result)) == 1
        assert of(result, "lab", "contact")[-1][3:] == pytest.approx(force, abs=2e-4)
    assert of(result, "lab", "force")[-1][1:] == pytest.approx(force, abs=2e-4)


@pytest.mark.parametrize("seed", (1, pytest.param(2, marks=pytest.mark.slow)))
def test_the_servers_give_the_same_hits_within_2_ms(tmp_path, seed):
    script, seconds = wandering(tmp_path / "hand.txt", seed)
    (tmp_path / "scene.txt").write_text(BODIES_APART)
    found = [of(render(seconds, script, r_modal=None, scene=str(tmp_path / "scene.txt"),
                       **{"is": server}), "lab", "hit") for server in SERVERS]
    assert len(found[0]) >= 5 and [h[1] for h in found[0]] == [h[1] for h in found[1]]
    assert len({h[1] for h in found[0]}) >= 2
    for servo, plain in zip(*found):
        assert servo[0] == pytest.approx(plain[0], abs=2)
        assert servo[2:5] == pytest.approx(plain[2:5], abs=0.7)  # a tick's way at 0.6 m/s
        assert servo[5:8] == pytest.approx(plain[5:8], abs=0.02)
        assert servo[8] == pytest.approx(plain[8], abs=0.02)


@pytest.mark.parametrize("driver", ["ioa_sdd_script", "ioa_sdd_osc"])
@pytest.mark.parametrize("server", SERVERS)
def test_bus_time_that_begins_again_changes_no_hit(tmp_path, server, driver):
    """A bus whose clock begins at 64536 ms, and so again at 0 after a second, beside one that begins at 0."""
    script = taps(tmp_path / "hand.txt", *[(x, 5) for x in range(0, 33, 3)], speed=0.25)
    found = []
    for origin in (0, 64536):
        patch = Patch()
        patch.obj("r ioa.clock?") >> patch.msg(str(origin)) >> patch.obj("v ioa.clock")
        system = System(patch, sdd=[driver] + [script] * (driver == "ioa_sdd_script"), r_modal=None, **{"is": server})
        if driver == "ioa_sdd_osc":
            for ms, packet in osc_positions(script, "fourth number"):
                patch.at(ms, system.box["sdd"], list(packet))
        else:
            patch.at(0, system.box["sdd"], "bang")
        result = patch.render(2.1)
        found.append([(*hit[2:],) for hit in of(result, "lab", "hit")])
        times = [hit[0] for hit in of(result, "lab", "hit")]
        logged = [(ms + origin) % 65536 for ms, _ in result.logs["lab.hit"]]
        assert times == pytest.approx(logged, abs=3)
    assert len(found[0]) == 11
    assert numpy.array(found[1]) == pytest.approx(numpy.array(found[0]), rel=0.01, abs=1e-3)


def test_a_script_and_osc_packets_of_the_same_positions_give_the_same_hits(tmp_path):
    script, seconds = wandering(tmp_path / "hand.txt", 3)
    scene = tmp_path / "scene.txt"
    scene.write_text(BODIES_APART)
    patch = Patch()
    system = System(patch, "script", sdd=["ioa_sdd_script", script], r_modal=None,
                    mm_haptic=["ioa_mm_haptic", str(scene)])
    osc = System(patch, "osc", sdd=["ioa_sdd_osc"], r_modal=None,
                 mm_haptic=["ioa_mm_haptic", str(scene)])
    # What the script says is packed as OSC and taken apart again by the other sensor driver.
    heard = patch.obj("ioa_bus", "script", "raw") >> patch.obj("route raw") >> patch.obj("list split 1")
    heard[1] >> patch.obj("oscformat raw") >> osc.box["sdd"]
    patch.at(0, system.box["sdd"], "bang")
    result = patch.render(seconds)
    assert len(hits(result, "script")) >= 5
    assert of(result, "osc", "hit") == of(result, "script", "hit")


def osc_positions(path, kind, step_ms=2):
    """(ms, packet) of a hand that taps eleven times at 0.25 m/s, once in step_ms: by time tag, by a fourth number, or
    without the sender's time."""
    rows_ = numpy.loadtxt(path)
    packets = []
    for ms in numpy.arange(0, rows_[-1, 0], step_ms):
        values = [numpy.interp(ms, rows_[:, 0], rows_[:, axis]) for axis in (1, 2, 3)] + [ms] * (kind == "fourth number")
        packet = b"/raw\0\0\0\0" + f",{'f' * len(values)}".encode().ljust(8, b"\0") + struct.pack(f">{len(values)}f", *values)
        if kind == "time tag":  # seconds since 1900, and their fraction; the 16 low bits pass 0 on the way
            at = (0xE0CEFFFF << 32) + round((ms / 1000 + 0.5) * 2 ** 32)
            packet = b"#bundle\0" + struct.pack(">QI", at, len(packet)) + packet
        packets.append((ms, packet))
    return packets


@pytest.mark.parametrize("kind, error", [("time tag", 0.03), ("fourth number", 0.03), ("none", 0.4)])
@pytest.mark.parametrize("server", SERVERS)
def test_osc_positions_that_come_in_bursts_strike_as_hard_as_they_were_sent(tmp_path, server, kind, error):
    """Pd looks at its sockets when it has time: here once in 3 to 9 ms, and four times only after 30 ms."""
    path = taps(tmp_path / "hand.txt", *[(4 * k - 20, 0) for k in range(11)])
    patch = Patch()
    system = System(patch, sdd=["ioa_sdd_osc"], r_modal=None, **{"is": server})
    draw, looks = numpy.random.default_rng(1), [5.0]
    while looks[-1] < 3000:
        looks.append(looks[-1] + (30 if len(looks) % 60 == 59 else draw.uniform(3, 9)))
    packets = osc_positions(path, kind)
    for ms, packet in packets:
        patch.at(min(look for look in looks if look >= ms), system.box["sdd"], list(packet))
    found = of(patch.render(packets[-1][0] / 1000 + 0.1), "lab", "hit")
    assert len(found) == 11
    assert [hit[8] for hit in found] == pytest.approx([0.25] * 11, rel=error)


@pytest.mark.parametrize("stall", [0, 300])
def test_positions_found_together_at_first_set_no_time_ahead_of_now(tmp_path, stall):
    """A stall just as the sender begins: the first of a burst is late, the last is not."""
    patch = Patch()
    sensor = patch.obj("ioa_sdd_osc", "lab")
    patch.log("raw", sensor)
    for ms in range(0, 600, 4):
        packet = b"/raw\0\0\0\0,ffff\0\0\0" + struct.pack(">4f", ms, 0, 0, 7000 + ms)
        patch.at(max(20 + ms, 20 + stall), sensor, list(packet))
    found = [(atoms[2], atoms[1]) for _, atoms in patch.render(0.7).logs["raw"]]
    assert [x for x, _ in found] == list(range(0, 600, 4))
    late = [t - (20 + x) for x, t in found if 20 + x > stall + 20]
    assert len(late) > 60 and max(map(abs, late)) < 2  # ms


def test_a_position_that_overtook_another_counts_and_a_clock_that_is_set_begins_anew(tmp_path):
    patch = Patch()
    sensor = patch.obj("ioa_sdd_osc", "lab")
    patch.log("raw", sensor)
    sent = (100, 102, 108, 104, 110, 90000, 90002)
    for k, ms in enumerate(sent):
        packet = b"/raw\0\0\0\0,dfih\0\0\0" + struct.pack(">dfiq", k, 0, 0, ms)
        patch.at(20 + 10 * k, sensor, list(packet))
    found = [(atoms[2], atoms[1]) for _, atoms in patch.render(0.2).logs["raw"]]
    assert [x for x, _ in found] == [0, 1, 2, 4, 5, 6]
    assert [t for _, t in found] == pytest.approx([20, 22, 28, 30, 70, 72], abs=0.01)


@pytest.mark.parametrize("server", SERVERS)
def test_positions_that_come_together_give_the_hits_that_they_give_one_by_one(tmp_path, server):
    """As a line that stalls brings them: nothing for 350 ms, twice, and then all at once."""
    script, seconds = wandering(tmp_path / "hand.txt", 1)
    scene = tmp_path / "scene.txt"
    scene.write_text(BODIES_APART)
    patch = Patch()
    near = System(patch, "near", sdd=["ioa_sdd_script", script], r_modal=None,
                  mm_haptic=["ioa_mm_haptic", str(scene)], **{"is": server})
    System(patch, "far", sdd=None, re=None, r_modal=None, mm_haptic=["ioa_mm_haptic", str(scene)],
           **{"is": server})
    both = patch.obj("ioa_bus", "near", "hand") >> patch.obj("route", "hand") >> patch.obj("t l l")
    wait = patch.obj("pipe", *[0] * 8)
    both[1] >> patch.obj("list split 1") >> patch.obj(
        "expr", "if($f1 > 600 && $f1 < 950, 950 - $f1, if($f1 > 1500 && $f1 < 1850, 1850 - $f1, 0))"
    ) >> wait[7]
    both >> wait
    again = patch.obj("pack", *["f"] * 7)
    for i in reversed(range(7)):
        wait[i] >> again[i]
    again >> patch.obj("list prepend hand") >> patch.obj("list trim") >> patch.obj("ioa_bus", "far")
    patch.at(0, near.box["sdd"], "bang")
    result = patch.render(seconds + 0.7)
    local, held = of(result, "near", "hit"), of(result, "far", "hit")
    assert len(local) >= 5 and [hit[1] for hit in held] == [hit[1] for hit in local]
    assert any(600 < hit[0] < 950 or 1500 < hit[0] < 1850 for hit in local)
    for one, other in zip(held, local):
        assert one[0] == pytest.approx(other[0], abs=2) and one[2:5] == pytest.approx(other[2:5], abs=1)


@pytest.mark.parametrize("amplitude, hz, expected", [(0.15, 40, 1), (1.0, 40, 10), (1.0, 100, 1)])
def test_a_chattering_hand_hits_again_after_a_real_departure_only(tmp_path, amplitude, hz, expected):
    """By docs/results/scene.md 0.2 mm and 10 ms away: 12.5 ms in the air at 40 Hz, 5 ms at 100 Hz."""
    points = [(0, 25, 0, 9), (40, 25, 0, 6.01)]
    points += [(50 + k, 25, 0, 6 + amplitude * numpy.sin(2 * numpy.pi * hz * k / 1000 + 0.1))
               for k in range(240)]
    script = rows(tmp_path / "hand.txt", *points)
    for server in SERVERS:
        result = render(0.28, script, r_modal=None, **{"is": server})
        assert len([t for t, _ in hits(result) if t < 280]) == pytest.approx(expected, abs=expected // 8)


@pytest.mark.parametrize("server", SERVERS)
def test_the_damper_acts_on_the_approach_alone(tmp_path, server):
    (tmp_path / "scene.txt").write_text("add disk disk 0 0 0 0 0 1 50 12\n")
    script = rows(tmp_path / "hand.txt", (0, 25, 0, 20), (80, 25, 0, 0), (160, 25, 0, 20))
    result = render(0.16, script, r_modal=None, scene=str(tmp_path / "scene.txt"), re=["ioa_re", 0.1],
                    r_spring=["ioa_r_spring", 600, 3], **{"is": server})
    contacts = of(result, "lab", "contact")
    felt = contacts if server == "ioa_is" else of(result, "lab", "force")
    for contact, force in zip(contacts, felt):
        coming = 78 > contact[0]
        if coming or contact[0] > 84:
            expected = 0.6 * contact[2] + (3 * 0.25 if coming else 0)
            assert force[-1] == pytest.approx(expected, abs=0.01)


# ---- sensors and recognition ---------------------------------------------------------------------

def test_a_script_is_played_a_thousand_times_a_second_on_straight_lines(tmp_path):
    path = tmp_path / "hand.txt"
    path.write_text("# a comment\n10 0 0 0\n20 10 -5 1 1\n20 40 0 0 4\n30 40 10 0\n")
    patch = Patch()
    sensor = patch.obj("ioa_sdd_script", "lab", str(path))
    patch.log("raw", sensor)
    patch.at(5, sensor, "bang")
    logged = [entry for entry in patch.render(0.06).logs["raw"] if entry[0] < 60]
    raw = numpy.array([atoms[1:] for _, atoms in logged if atoms[0] == "raw"])
    t = raw[:, 0] - 5
    assert list(t) == list(range(55))
    assert raw[:, 1] == pytest.approx(numpy.where(t < 20, numpy.clip(t - 10, 0, 10), 40), abs=1e-5)
    assert raw[:, 2] == pytest.approx(numpy.where(t < 20, -0.5 * numpy.clip(t - 10, 0, 10),
                                                  numpy.clip(t - 20, 0, 10)), abs=1e-5)
    assert [a for _, a in logged if a[0] == "rawbutton"] == [
        ["rawbutton", 25, 2, 1], ["rawbutton", 35, 2, 0]]  # the second row of a jump counts: mask 4


def test_rows_of_a_script_that_are_no_positions_are_named_and_left_out(tmp_path):
    path = tmp_path / "hand.txt"
    path.write_text("0 1 2 3\n1 2\n5 x 2 3\n10 11 2 3\n")
    patch = Patch()
    sensor = patch.obj("ioa_sdd_script", "lab", str(path))
    patch.log("raw", sensor)
    patch.at(0, sensor, "bang")
    result = patch.render(0.02, expect_errors=["ioa-error: lab ioa_sdd_script row 1 2 expected ms x y z"])
    assert [a[2] for _, a in result.logs["raw"]][:12] == pytest.approx([*range(1, 12), 11])


def test_the_velocity_follows_the_difference_quotient_with_the_time_constant(tmp_path):
    script = rows(tmp_path / "hand.txt", (0, 0, 0, 0), (20, 0, 0, 0), (100, 80, -40, 20))
    result = render(0.1, script, re=["ioa_re", 4], r_modal=None, **{"is": None})
    patch = Patch()
    system = System(patch, sdd=["ioa_sdd_script", script], re=["ioa_re", 4], r_modal=None)
    patch.log("hand", patch.obj("ioa_bus", "lab", "hand"))
    patch.at(0, system.box["sdd"], "bang")
    hand = numpy.array([a[1:] for ms, a in patch.render(0.1).logs["hand"] if ms < 100])
    t = hand[:, 0]
    share = 1 - numpy.exp(-numpy.maximum(t - 20, 0) / 4)
    assert hand[:, 4:] == pytest.approx(numpy.outer(share, (1, -0.5, 0.25)), abs=1e-4)
    assert not of(result, "lab", "hit")


def test_buttons_and_the_grip_are_recognised(tmp_path):
    script = rows(tmp_path / "hand.txt", (0, 0, 0, 30, 0), (10, 0, 0, 30, 1), (20, 0, 0, 30, 2),
                  (30, 0, 0, 30, 0))
    result = render(0.05, script, r_modal=None)
    assert sorted(of(result, "lab", "button")) == [[10, 0, 1], [20, 0, 0], [20, 1, 1], [30, 1, 0]]
    assert of(result, "lab", "grip") == [[10, 1], [20, 0]]
    result = render(0.05, script, r_modal=None, messages=[(1, "re", "grip_button 1")])
    assert of(result, "lab", "grip") == [[20, 1], [30, 0]]
