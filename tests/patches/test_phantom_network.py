"""The mass-spring network inside [phantom]'s servo: felt by the hand and heard by [phantom~]."""
import numpy
import pytest

from device import play
from harness import Patch
from harness.sound import RATE, peak

STRING = "network string s 19 -50 0 0 50 0 0 0.001 10 0.0005"


def heard(messages, seconds=1.0, rate=RATE, device="-hand rigid -walls 0"):
    """The two network outlets of a [phantom~] while those (ms, message) go to its [phantom]."""
    patch = Patch()
    box = patch.obj("phantom", "-name", "hand", *device.split())
    patch.log("info", box[3])
    for ms, message in messages:
        patch.at(ms, box, message)
    signals = patch.obj("phantom~", "hand")
    patch.record("left", signals[7])
    patch.record("right", signals[8])
    return patch.render(seconds, rate=rate)


def string_hertz(j, n=19, mass=1e-3, tension=10, length=0.1, steps=48000):
    omega = 2 * numpy.sqrt(tension / (mass / n * length / (n + 1))) * numpy.sin(j * numpy.pi / (2 * (n + 1)))
    return numpy.arcsin(0.5 * omega / steps) * steps / numpy.pi  # the scheme's own dispersion


@pytest.mark.parametrize("rate", [44100, pytest.param(48000, marks=pytest.mark.slow),
                                  pytest.param(96000, marks=pytest.mark.slow)])
def test_a_plucked_string_sounds_at_the_discrete_chain_s_frequencies(rate):
    result = heard([(0, STRING), (0, "network drag 1"), (0, "network touch 0 0 0"), (10, "network listen s-2 z"),
                    (20, "network pluck s-3 0 0 1 2")], seconds=2, rate=rate)
    sound = result["left"][rate // 10:]
    for j in range(1, 10):  # the tenth has a node there
        wanted = string_hertz(j)
        assert peak(sound, wanted - 20, wanted + 20, rate) == pytest.approx(wanted, rel=2e-4, abs=0.05)


def test_velocity_displacement_and_force_are_one_motion():
    common = [(0, "network anchor a 0 0 0"), (0, "network mass m 0.01 0 0 0"), (0, "network drag 0"),
              (0, "network link a m 400 0 0"), (0, "network touch 0 0 0"), (50, "network pluck m 0 0 1 1")]
    result = heard(common + [(0, "network listen m z 1 displacement"), (0, "network listen a z 2 force")], 0.4)
    assert not result["left"][:2300].any()  # before the pluck
    z, force = result["left"][4800:], result["right"][4800:]
    # 1 mN s on 10 g at 200 rad/s: 0.1 m/s and 0.5 mm; the anchor feels k z.
    assert z.max() == pytest.approx(5e-4, rel=5e-3)
    assert force == pytest.approx(400 * z, abs=1e-4)
    velocity = heard(common + [(0, "network listen m z")], 0.4)["left"][4800:]
    slope = numpy.diff(z) * RATE  # half a step from each
    assert velocity[1:] == pytest.approx(slope, abs=0.1 * 200 / RATE)


def test_a_pressed_string_feels_as_its_springs_in_series(tmp_path):
    """Grabbed in the middle and drawn 3 mm aside: 4 T/L with the grabbing spring."""
    answer = play(tmp_path, [(0, "network string s 21 -50 0 0 50 0 0 0.001 10 0.01"), (1, "network drag 100"),
                             (2, "network touch 0 0"), (3, "network grab s-11 400 0.5"), (1400, "bang")],
                  "-hand rigid -path line 0 0 3 0 0 3 1000")
    assert answer.force == pytest.approx([0, 0, -0.003 / (1 / 400 + 1 / 400)], abs=1e-4)


@pytest.mark.parametrize("name, pluck, counts", [("drop.txt", "drop 0 0.5 0 20", [5, 4]),
                                                 ("bars.txt", "low 0 0.5 0 1", [9, 6])])
def test_the_networks_that_come_with_the_package_load_and_sound(name, pluck, counts):
    result = heard([(0, f"network load networks/{name}"), (0, "dump"), (50, f"network pluck {pluck}")])
    assert numpy.abs(result["left"]).max() > 1e-3
    assert [atoms[1:3] for _, atoms in result.logs["info"] if atoms[0] == "network"][-1] == counts
    if name == "bars.txt":
        assert peak(result["left"][4800:], 50, 150) == pytest.approx(110, abs=0.2)


def test_stiff_springs_raise_the_rate_and_say_so(tmp_path):
    answer = play(tmp_path, [(0, "network anchor a 0 0 0, network mass m 0.0001 10 0 0, network touch 0 0 0"),
                             (10, "network link a m 1e6"), (30, "dump")])
    assert "network: stepped at" in answer.result.output
    assert "mass m (0.0001 kg) with its springs and the hand needs" in answer.result.output
    assert answer.told("network")[-1][2] >= 1e5 / 2 / 0.7  # w = 1e5 rad/s, w h <= 1.4


def test_a_network_that_another_servo_rate_cannot_step_rests_and_says_so(tmp_path):
    answer = play(tmp_path, [(0, "network anchor a 0 0 0, network mass m 1e-6 10 0 0, network touch 0 0 0"),
                             (5, "network link a m 1e6"), (50, "rate 200")], "-rate 4000",
                  errors=["network: stopped: at 200 ticks a second, mass m"])
    assert len(answer.errors) == 1


def test_deleting_one_string_leaves_the_others_their_links_pickups_and_motion():
    """Two strings of other pitches; the first is taken away while the second sounds."""
    build = [(0, "network touch 0"), (0, "network string a 9 -50 0 0 50 0 0 0.001 3"),
             (0, "network string b 9 -50 20 0 50 20 0 0.001 12"), (0, "network listen b-2 z"),
             (50, "network pluck b-3 0 0 1 2")]
    whole = heard(build, 0.5)["left"]
    cut = heard(build + [(200, "network del a")], 0.5)["left"]
    assert numpy.abs(whole[-4800:]).max() > 0.1
    assert cut == pytest.approx(whole, abs=1e-5)


def test_everything_can_be_deleted_while_it_sounds_and_built_again():
    left = heard([(0, STRING), (0, "network listen s-4 z"), (50, "network pluck s-4 0 0 1 2"), (150, "network del s"),
                  (300, STRING), (310, "network listen s-4 z"), (320, "network pluck s-4 0 0 1 2"),
                  (450, "network reset"), (500, "network del all")], 0.7)["left"]
    level = [numpy.abs(left[48 * a:48 * b]).max() for a, b in ((60, 150), (160, 300), (330, 450), (455, 690))]
    assert level[0] > 0.1 and level[1] == 0 and level[2] > 0.1 and level[3] == 0


@pytest.mark.parametrize("message, said", [
    ("network touch 10 900, network grab nearest 900, scene add p plane 0 0 1 0, scene mat p 1900", []),
    ("network touch 10 1100", [[1100, 1000]]), ("network grab nearest 1100", [[1100, 1000]]),
    ("scene add p plane 0 0 1 0, scene mat p 2100", [[2100, 2000]])])
def test_a_spring_to_the_network_is_said_to_hum_at_half_of_what_a_body_may_have(tmp_path, message, said):
    """(B + damp)/T and 2 (B + damp)/T with B = 1 N s/m: docs/network.md."""
    answer = play(tmp_path, [(1, "network mass a 1 0 500 0"), (2, message), (50, "bang")], "-viscous 1 -damp 0")
    assert answer.told("status", "stiff") == said


def test_a_string_replaces_the_masses_that_had_its_names_and_no_name_is_no_group(tmp_path):
    def empty_symbol(patch, box):
        symbol = patch.obj("symbol")
        patch.at(3, symbol, "bang")
        symbol >> patch.msg("network del $1") >> box
    answer = play(tmp_path, [(0, "network mass s-2 1 0 500 0, network mass other 1 0 510 0, network link s-2 other 10"),
                             (1, "network string s 3 -50 0 0 50 0 0"),  # s-0 .. s-4
                             (5, "dump")], draw=empty_symbol, errors=["network del: : no such mass"])
    assert [row[:2] for row in answer.told("network")] == [[6, 4]]
