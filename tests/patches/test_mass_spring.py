"""patches/haptic/mass_spring.pd: a string that is drawn and let go, and a membrane that is tapped."""

import csv
import pathlib

import numpy
import pytest

from harness import Patch

PATCH = pathlib.Path(__file__).resolve().parents[2] / "patches" / "haptic" / "mass_spring.pd"
RATE = 48000


def played(folder, button, seconds=3):
    patch = Patch(opens=PATCH)
    for channel in (1, 2):
        patch.record(str(channel), patch.dac(channel))
    patch.send(0, "spring-hand", f"trace {folder}/ticks.csv")
    patch.send(10, button, "bang")
    patch.send(1000 * seconds - 5, "spring-hand", "trace stop")
    result = patch.render(seconds, RATE)
    rows = list(csv.DictReader((folder / "ticks.csv").open()))
    return result["1"], result["2"], {k: numpy.array([float(r[k]) for r in rows]) for k in rows[0]}


def test_the_string_is_felt_while_it_is_drawn_and_sounds_when_it_is_let_go(tmp_path):
    left, right, rows = played(tmp_path, "help-play")
    assert 0.2 < numpy.abs(left).max() < 0.9 and 0.2 < numpy.abs(right).max() < 0.9
    force = rows["fy_n"]
    # Let go 450 ms after each beat of 900: the force ends within the chain's slew, the sound begins.
    release = 10 + 900 + 450
    assert force[release - 5] < -0.5
    assert numpy.abs(force[release + 10:release + 300]).max() < 0.05
    before = numpy.abs(left[48 * (release - 20):48 * (release - 4)]).max()
    assert numpy.abs(left[48 * release:48 * (release + 40)]).max() > 10 * before
    # m = 25 mg, d = 90/41 mm, T = 12 N
    omega = 2 * numpy.sqrt(12 / (2.5e-5 * 0.09 / 41)) * numpy.sin(numpy.pi / 82)
    part = left[48 * (release + 20):48 * (release + 420)]
    level = numpy.abs(numpy.fft.rfft(part * numpy.hanning(len(part)), 1 << 18))
    hertz = numpy.fft.rfftfreq(1 << 18, 1 / RATE)
    low = hertz < 1.5 * omega / 2 / numpy.pi
    assert hertz[low][level[low].argmax()] == pytest.approx(omega / 2 / numpy.pi, rel=3e-3)


def test_every_tap_on_the_membrane_is_felt_and_heard(tmp_path):
    left, _, rows = played(tmp_path, "spring-drum")
    touched = rows["fz_n"] > 0.1
    taps = numpy.flatnonzero(touched[1:] & ~touched[:-1])
    taps = taps[taps > 400]
    assert len(taps) >= 7 and numpy.diff(taps) == pytest.approx(numpy.full(len(taps) - 1, 320), abs=20)
    assert 0.15 < numpy.abs(left[RATE // 2:]).max() < 0.9
