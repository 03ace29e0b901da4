"""patches/audiohaptics/finger_on_reed.pd: a finger presses on a reed that is blown.

The constants are those of the patch; what the forces should be is worked out here, from the valve's static
equation k (y - y_0) = -w lambda p_m + k_f (y_f - y) with a stop at y = 0 and p_b = 0 at rest.
"""
import math

import numpy
import pytest

from harness import Patch, read_trace
from harness.run import ROOT
from harness.sound import cents, component, part, peak

PATCH = ROOT / "patches" / "audiohaptics" / "finger_on_reed.pd"
MASS, REED_HZ, QUALITY, REST_M, ARM_M = 3.376e-6, 2500, 5, 0.4e-3, 0.01  # preset clarinet
AREA_M2 = 13e-3 * 6.5e-3  # w lambda_m
STIFFNESS = MASS * (2 * math.pi * REED_HZ) ** 2  # k, 833 N/m
FINGER = 300  # k_f, N/m
PICTURE, FORCE, FACE_MM = 20, 10, 3  # sizes in the hand against those at the reed; its upper face


def finger_m(hand_mm):
    """y_f of a hand at that height."""
    return (hand_mm - FACE_MM) / PICTURE * 1e-3


def resting_opening(pressure_pa, y_f):
    """y of a reed at rest under a mouth pressure and a finger."""
    return max(0, (STIFFNESS * REST_M + FINGER * y_f - AREA_M2 * pressure_pa) / (STIFFNESS + FINGER))


class Play:
    """The patch for some seconds; messages: (ms, receiver, message). Signals as the patch sends them and,
    in `ticks`, what the servo wrote (ms, mm, N)."""

    def __init__(self, folder, seconds, *messages):
        patch = Patch(opens=PATCH, own="own")
        patch.record("sound", patch.dac(1))
        patch.record("force", patch.obj("r~", "own-force"))
        patch.log("opening", patch.obj("r", "finger-opening-now"))
        patch.log("reed", patch.obj("r", "finger-reed"))
        patch.send(90, "finger.phantom", f"hand rigid, trace {folder}/ticks.csv")  # the mouse's hand is made
        for ms, receiver, message in messages:
            patch.send(ms, receiver, message)
        patch.send(1000 * seconds - 5, "finger.phantom", "trace stop")
        self.result = patch.render(seconds, timeout=120)
        rows = read_trace(folder / "ticks.csv")
        self.ms, self.ticks = rows["ms"], numpy.stack([rows["z_mm"], rows["fz_n"]])

    def signal(self, label, begin_s, end_s):
        return part(self.result[label], begin_s, end_s)

    def felt(self, begin_s, end_s):
        """(mm, N) of the ticks in that time."""
        return self.ticks[:, (self.ms >= 1000 * begin_s) & (self.ms < 1000 * end_s)]

    def opening_mm(self, begin_s, end_s):
        return numpy.mean([atoms[0] for ms, atoms in self.result.logs["opening"]
                           if 1000 * begin_s <= ms < 1000 * end_s])


def fundamental(sound):
    return peak(sound, 130, 160)


def hold(mm):
    """A rigid hand at that height."""
    return f"path line 15 0 {mm} 15 0 {mm} 1000"


@pytest.mark.parametrize("pressure,hand_mm", [(0, 5), (0, -10), (0, -16), (800, 0), (2200, -16)])
def test_the_static_force_is_that_of_two_springs(tmp_path, pressure, hand_mm):
    play = Play(tmp_path, 1.5, (10, "pd", "dsp 1"), (10, "finger-breath", pressure),
                (100, "finger.phantom", hold(hand_mm)))
    y_f = finger_m(hand_mm)
    y = resting_opening(pressure, y_f)
    expected = FINGER * (y - y_f)
    z, force = play.felt(1.2, 1.45)
    assert z == pytest.approx(hand_mm, abs=1e-6)
    assert force == pytest.approx(FORCE * expected, rel=0.01)
    assert play.signal("force", 1.2, 1.45) == pytest.approx(expected, rel=0.01)
    if pressure == 0:  # at once: a servo's period and the low-pass of phantom~ after the hand
        assert play.felt(0.15, 0.2)[1] == pytest.approx(FORCE * expected, rel=0.02)
    assert play.opening_mm(1.2, 1.45) == pytest.approx(1e3 * y, rel=0.01, abs=1e-5)


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """Blown from 0.01 s on; free to 1.5 s, touched to 3 s, pressed to 4.5 s, closed to 5.5 s, then free."""
    return Play(tmp_path_factory.mktemp("reed"), 8, (10, "pd", "dsp 1"), (10, "finger-breath", 2200),
                (1500, "finger.phantom", hold(1)), (3000, "finger.phantom", hold(-4)),
                (4500, "finger.phantom", hold(-14)), (5500, "finger.phantom", hold(40)))


def test_a_finger_softens_the_note_raises_its_pitch_a_little_and_ends_it_and_lifting_restores_it(pressed):
    """A stiffer reed yields less: its share of the air column's length shrinks."""
    sounds = [pressed.signal("sound", a, b) for a, b in ((1, 1.5), (2.5, 3), (4, 4.5), (5.2, 5.5), (7.5, 8))]
    free, touched, firm, closed, lifted = (sound.std() for sound in sounds)
    assert free > 0.05 and abs(pressed.signal("sound", 0, 8)).max() < 0.9
    assert free > 1.1 * touched > 1.1 * 1.1 * firm > 0.02 * free
    assert closed < 1e-3 * free
    assert lifted == pytest.approx(free, rel=0.01)
    free_hz, _, firm_hz, _, lifted_hz = (fundamental(sound) for sound in sounds)
    assert 3 < cents(firm_hz, free_hz) < 30 and abs(cents(lifted_hz, free_hz)) < 1


def test_the_reed_is_felt_vibrating(pressed):
    """The reed's fundamental stands in the force that the servo writes, as large as in the force at the reed."""
    for begin, end in ((2.4, 3), (3.9, 4.5)):
        hz = fundamental(pressed.signal("sound", begin, end))
        _, force = pressed.felt(begin, end)
        felt = component(force, hz, 1000)
        assert felt == pytest.approx(FORCE * component(pressed.signal("force", begin, end), hz), rel=0.03)
        assert felt > 0.1
        assert felt > 20 * max(component(force, f, 1000) for f in (0.7 * hz, 1.3 * hz))


def test_without_the_finger_there_is_no_force_and_the_valve_is_its_own_again(pressed):
    for begin, end in ((1, 1.5), (7, 8)):
        assert abs(pressed.signal("force", begin, end)).max() == 0
        assert abs(pressed.felt(begin, end)[1]).max() < 1e-6
    told = dict(atoms for _, atoms in pressed.result.logs["reed"] if atoms[0] != "preset")
    assert told == {"theta0": pytest.approx(-REST_M / ARM_M), "q": QUALITY}


def test_the_finger_is_a_spring_and_no_damper_for_the_reed(tmp_path):
    """What the patch tells greed~ while it is touched: m, the damper m w_r/Q and k_f as they should be."""
    play = Play(tmp_path, 0.6, (10, "pd", "dsp 1"), (100, "finger.phantom", hold(-4)))
    q = [atoms[1] for _, atoms in play.result.logs["reed"] if atoms[0] == "q"][-1]
    theta = [atoms[1] for _, atoms in play.result.logs["reed"] if atoms[0] == "theta0"][-1]
    ratio = math.sqrt((STIFFNESS + FINGER) / STIFFNESS)
    assert q == pytest.approx(QUALITY * ratio, rel=1e-4)
    assert -theta * ARM_M == pytest.approx(
        (STIFFNESS * REST_M + FINGER * finger_m(-4)) / (STIFFNESS + FINGER), rel=1e-4)


def test_one_click_plays_it(tmp_path):
    play = Play(tmp_path, 9.5, (95, "finger.phantom", "hand spring 500 10"), (100, "help-play", "bang"))
    sound = [play.signal("sound", t, t + 0.3).std() for t in (1.2, 2.9, 5.2, 8.0, 9.2)]
    assert sound[0] > 0.05 and sound[0] > sound[1] > 0.01 and sound[2] > 0.01
    assert sound[3] < 1e-3 * sound[0]
    assert sound[4] == pytest.approx(sound[0], rel=0.05)
    assert play.felt(7.9, 8.2)[1].min() > 1
