"""patches/haptic: mass_spring.pd, a string that is drawn and let go and a membrane that is tapped; and struck_disk.pd,
a hit in the servo's scene, sound, and vibration back in the hand."""
import numpy
import pytest

from harness import Patch, read_trace, stage_folder
from harness.run import ROOT
from harness.sound import RATE, peak, spectrum

HAPTIC = ROOT / "patches" / "haptic"
needs_disk = pytest.mark.skipif(not (stage_folder() / "disk.modal.npz").is_file(),
                                reason="the disk's table is made where modal_fem is built")


def played(folder, name, button, seconds, *messages):
    """Sound of both sides, and the servo's trace, of a patch after one click."""
    hand = {"mass_spring": "spring-hand", "struck_disk": "struck-hand"}[name]
    patch = Patch(opens=HAPTIC / f"{name}.pd")
    for channel in (1, 2):
        patch.record(str(channel), patch.dac(channel))
    patch.send(0, hand, f"trace {folder}/ticks.csv")
    patch.send(10, button, "bang")
    for receiver, value in messages:
        patch.send(20, receiver, value)
    patch.send(1000 * seconds - 5, hand, "trace stop")
    result = patch.render(seconds)
    return result["1"], result["2"], read_trace(folder / "ticks.csv")


def test_the_string_is_felt_while_it_is_drawn_and_sounds_when_it_is_let_go(tmp_path):
    left, right, rows = played(tmp_path, "mass_spring", "help-play", 2)
    assert 0.2 < numpy.abs(left).max() < 0.9 and 0.2 < numpy.abs(right).max() < 0.9
    force = rows["fy_n"]
    # Let go 450 ms after each beat of 900: the force ends within the chain's slew, the sound begins.
    release = 10 + 900 + 450
    assert force[release - 5] < -0.5
    assert numpy.abs(force[release + 10:release + 300]).max() < 0.05
    before = numpy.abs(left[48 * (release - 20):48 * (release - 4)]).max()
    assert numpy.abs(left[48 * release:48 * (release + 40)]).max() > 10 * before
    # m = 25 mg, d = 90/41 mm, T = 12 N
    hertz = 2 * numpy.sqrt(12 / (2.5e-5 * 0.09 / 41)) * numpy.sin(numpy.pi / 82) / 2 / numpy.pi
    assert peak(left[48 * (release + 20):48 * (release + 420)], 20, 1.5 * hertz) == pytest.approx(hertz, rel=3e-3)


def test_every_tap_on_the_membrane_is_felt_and_heard(tmp_path):
    left, _, rows = played(tmp_path, "mass_spring", "spring-drum", 3)
    touched = rows["fz_n"] > 0.1
    taps = numpy.flatnonzero(touched[1:] & ~touched[:-1])
    taps = taps[taps > 400]
    assert len(taps) >= 7 and numpy.diff(taps) == pytest.approx(numpy.full(len(taps) - 1, 320), abs=20)
    assert 0.15 < numpy.abs(left[RATE // 2:]).max() < 0.9


@pytest.fixture(scope="module")
def disk(tmp_path_factory):
    """Of struck_disk.pd with the vibration felt and without it: sound, trace and the ticks in which the handle passes
    the disk's upper face, 6 mm high, downwards."""
    found = []
    for felt in (1, 0):
        sound, _, rows = played(tmp_path_factory.mktemp("disk"), "struck_disk", "help-play", 2, ("struck-felt", felt))
        inside = rows["z_mm"] < 6
        found.append((sound, rows, [n for n in numpy.flatnonzero(inside[1:] & ~inside[:-1]) + 1 if n > 50]))
    return found


@needs_disk
def test_every_impact_sounds_within_two_blocks_unclipped_at_the_disk_s_frequency(disk):
    sound, rows, impacts = disk[0]
    samples = [int(rows["ms"][n] * 48) for n in impacts]
    assert len(samples) == 4
    for sample in samples:
        before = abs(sound[sample - 480:sample - 48]).max()
        assert abs(sound[sample:sample + 48 * 3]).max() > max(5 * before, 0.1)
    for loud, _, _ in disk:  # modal_impact~ bends softly from 0.5 on; what follows clips what comes in
        assert 0.3 < abs(loud).max() < 0.85
    hz, magnitude = spectrum(sound[samples[1] + 480:samples[1] + 480 + 16384])
    assert hz[magnitude.argmax()] == pytest.approx(5891, abs=6)  # the free disk's first mode, by modal_fem


@needs_disk
def test_what_sounds_is_felt_as_250_hz_while_the_hand_touches_and_disturbs_no_impact(disk):
    (_, felt, impacts), (_, still, _) = disk
    for rows, low, high in ((felt, 0.3, 2), (still, 0, 0.01)):
        force = rows["fz_n"][impacts[1] + 10:impacts[1] + 90]
        magnitude = abs(numpy.fft.rfft((force - force.mean()) * numpy.hanning(80)))
        assert low <= 4 * magnitude[18:23].max() / 80 <= high  # 225 to 288 Hz; a sine's amplitude
    assert abs(felt["fz_n"][felt["z_mm"] > 7][60:]).max() == 0
    assert abs(felt["z_mm"] - still["z_mm"])[200:].max() < 0.2
