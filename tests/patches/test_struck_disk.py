"""patches/haptic/struck_disk.pd: hit in the servo's scene, sound, and vibration back in the hand."""

import csv
import pathlib

import numpy
import pytest

from harness import Patch, stage_folder

PATCH = pathlib.Path(__file__).resolve().parents[2] / "patches" / "haptic" / "struck_disk.pd"

pytestmark = pytest.mark.skipif(not (stage_folder() / "disk.modal.npz").is_file(),
                                reason="the disk's table is made where modal_fem is built")


def struck(folder, felt):
    patch = Patch(opens=PATCH)
    patch.record("left", patch.dac(1))
    patch.send(0, "struck-hand", f"trace {folder}/ticks.csv")
    patch.send(10, "help-play", "bang")
    patch.send(20, "struck-felt", felt)
    patch.send(1995, "struck-hand", "trace stop")
    result = patch.render(2)
    rows = list(csv.DictReader((folder / "ticks.csv").open()))
    return result["left"], {k: numpy.array([float(r[k]) for r in rows]) for k in ("ms", "z_mm", "fz_n")}


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    return [struck(tmp_path_factory.mktemp("disk"), felt) for felt in (1, 0)]


def impacts(z):
    """Ticks in which the handle passes the disk's upper face, 6 mm high, downwards."""
    inside = z < 6
    return [n for n in numpy.flatnonzero(inside[1:] & ~inside[:-1]) + 1 if n > 50]


def test_every_impact_sounds_within_two_blocks(both):
    sound, ticks = both[0]
    found = impacts(ticks["z_mm"])
    assert len(found) == 4
    for n in found:
        sample = int(ticks["ms"][n] * 48)
        before = abs(sound[sample - 480:sample - 48]).max()
        after = abs(sound[sample:sample + 48 * 3]).max()
        assert after > 5 * before and after > 0.1


def test_no_strike_is_clipped(both):
    for sound, _ in both:  # modal_impact~ bends softly from 0.5 on; what follows clips what comes in
        assert 0.3 < abs(sound).max() < 0.85


def test_the_disk_sounds_at_its_own_frequencies(both):
    sound, ticks = both[0]
    begin = int(ticks["ms"][impacts(ticks["z_mm"])[1]] * 48)
    part = sound[begin + 480:begin + 480 + 16384] * numpy.hanning(16384)
    spectrum = abs(numpy.fft.rfft(part))
    loudest = numpy.argmax(spectrum) * 48000 / 16384
    assert loudest == pytest.approx(5891, abs=6)  # the free disk's first mode, by modal_fem


def test_what_sounds_is_felt_as_250_hz_while_the_hand_touches(both):
    (_, felt), (_, still) = both
    begin = impacts(felt["z_mm"])[1]
    contact = slice(begin + 10, begin + 90)
    for ticks, low, high in ((felt, 0.3, 2), (still, 0, 0.01)):
        force = ticks["fz_n"][contact]
        spectrum = abs(numpy.fft.rfft((force - force.mean()) * numpy.hanning(80)))
        level = 4 * spectrum[18:23].max() / 80  # 225 to 288 Hz; a sine's amplitude
        assert low <= level <= high
    away = felt["z_mm"] > 7
    assert abs(felt["fz_n"][away][60:]).max() == 0


def test_the_vibration_does_not_disturb_the_impact(both):
    (_, felt), (_, still) = both
    assert abs(felt["z_mm"] - still["z_mm"])[200:].max() < 0.2
