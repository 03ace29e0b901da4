"""The figures by which steps are compared with recordings, on points whose answers are known."""
import math

import comparison
import numpy
import pytest
import targets
from population import INDICES, Population
from scipy.stats import norm

RANDOM = numpy.random.RandomState(5)


def test_energy_distance_of_two_normal_distributions():
    shift = 1.0
    a = norm.ppf((numpy.arange(1500) + 0.5) / 1500)[:, None]
    b = a + shift
    # E|N(shift, 2)| - E|N(0, 2)|, each twice.
    apart = (2 / math.sqrt(math.pi) * math.exp(-shift ** 2 / 4)
             + shift * math.erf(shift / 2)) - 2 / math.sqrt(math.pi)
    assert comparison.energy_distance(a, b) == pytest.approx(2 * apart, rel=0.01)
    assert comparison.energy_distance(a, a + 0) == pytest.approx(0, abs=0.003)


def test_steps_from_the_same_source_as_the_recordings_are_as_near_and_as_varied():
    labels = ["a"] * 120 + ["b"] * 120
    vectors = RANDOM.randn(240, 6) + numpy.repeat([[0.0], [4.0]], 120, axis=0)
    classifier = comparison.Classifier(vectors, labels)
    ratio, spread, told = comparison.compare(classifier, vectors, RANDOM.randn(120, 6), "a")
    assert ratio == pytest.approx(1, abs=0.2)
    assert spread == pytest.approx(1, abs=0.15)
    assert told == pytest.approx(0.5, abs=0.1)
    assert comparison.left_out_ratio(vectors, labels, "a") == pytest.approx(1, abs=0.2)
    far = comparison.compare(classifier, vectors, RANDOM.randn(120, 6) + 9, "a")
    assert far[0] > 3 and far[2] > 0.99


def test_two_recordings_are_no_yardstick():
    vectors = RANDOM.randn(12, 3)
    classifier = comparison.Classifier(vectors, ["a"] * 10 + ["b"] * 2)
    ratio, spread, _ = comparison.compare(classifier, vectors, vectors, "b")
    assert math.isnan(ratio) and math.isnan(spread)


def test_whitened_sounds_vary_alike_in_all_directions():
    mixing = numpy.eye(4) + 0.4 * RANDOM.rand(4, 4)
    vectors = RANDOM.randn(4000, 4) @ mixing
    white = vectors @ comparison.whitening(vectors, ["a"] * 4000)
    # Correlations are shrunk by a quarter first, so that much is left of them.
    assert numpy.std(white, axis=0) == pytest.approx(numpy.ones(4), rel=0.35)


def test_the_stand_in_has_the_tables_medians():
    vectors = RANDOM.randn(60, 45)
    population = Population(vectors, ["wood"] * 30 + ["snow"] * 30)
    drawn, labels = population.sounds()
    assert len(drawn) == sum(count for count, _ in targets.FEATURES.values())
    for label in ("concrete", "snow"):
        figures = dict(zip(targets.NAMES, targets.FEATURES[label][1]))
        for name, (index, scaled) in INDICES.items():
            median, low, high = (scaled(v) for v in figures[name])
            found = numpy.median(drawn[labels == label][:, index])
            assert found == pytest.approx(median, abs=max(0.6 * (high - low), 0.2)), name
