"""Features of signals whose answers are known by hand."""
import math

import numpy
import pytest
from features import RATE, features

TIME = numpy.arange(RATE) / RATE


def named(sound):
    return features(sound)[1]


def test_a_steady_tone_is_one_frequency_and_repeats_itself():
    tone = numpy.sin(2 * numpy.pi * 1000 * TIME) * (abs(TIME - 0.25) < 0.15)
    figures = named(tone)
    # The ends click, which moves the mean frequency by some per cent of its energy.
    assert figures["centroid_hz"] == pytest.approx(1000, rel=0.03)
    assert figures["crest"] == pytest.approx(math.sqrt(2), rel=0.06)
    assert figures["duration_s"] == pytest.approx(0.9 * 0.3, abs=0.006)
    # One period later all but 1 ms overlaps, of at least the 20 ms before the loudest moment.
    assert 0.94 < figures["harmonicity"] <= 1
    assert figures["low_band_share"] < 0.01
    assert figures["flatness"] < 0.01


def test_a_damped_tone_has_the_times_of_its_exponential():
    fall = 0.03
    figures = named(numpy.sin(2 * numpy.pi * 700 * TIME) * numpy.exp(-TIME / fall))
    # Energy falls as exp(-2 t / fall); the envelope is smoothed over 3 ms.
    assert figures["duration_s"] == pytest.approx(fall / 2 * math.log(19), rel=0.03)
    assert figures["decay20_s"] == pytest.approx(fall * math.log(10), abs=0.005)
    assert figures["attack_s"] < 0.004


def test_white_noise_is_flat():
    noise = numpy.random.RandomState(1).randn(RATE) * (TIME < 0.5)
    figures = named(noise)
    # Geometric over arithmetic mean of exponentially distributed powers: exp(-Euler's constant).
    assert figures["flatness"] == pytest.approx(math.exp(-numpy.euler_gamma), rel=0.05)
    assert figures["centroid_hz"] == pytest.approx(RATE / 4, rel=0.03)
    assert figures["low_band_share"] == pytest.approx(400 / (RATE / 2), rel=0.25)
    assert figures["harmonicity"] < 0.2


def test_clicks_are_counted():
    noise = numpy.random.RandomState(2).randn(RATE)
    clicks = noise * (numpy.mod(TIME, 0.02) < 0.001) * (TIME < 0.5)
    assert named(clicks)["event_density_hz"] == pytest.approx(50, rel=0.15)


def test_neither_level_nor_silence_before_it_changes_a_sound():
    burst = numpy.random.RandomState(3).randn(RATE) * numpy.exp(-TIME / 0.05)
    burst = numpy.r_[numpy.zeros(1000), burst]
    vector = features(burst)[0]
    assert len(vector) == 45
    assert features(0.01 * burst)[0] == pytest.approx(vector, abs=1e-6)
    assert features(numpy.r_[numpy.zeros(3000), burst])[0] == pytest.approx(vector, abs=0.01)
