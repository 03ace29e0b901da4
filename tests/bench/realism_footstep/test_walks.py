"""How a walk is cut into steps, on sounds whose steps are known."""
import numpy
import pytest
import targets
from ensemble import members, named_right
from population import INDICES
from walks import contacts, onsets

RATE = 22050


def bursts(times, seconds):
    random = numpy.random.RandomState(1)
    sound = numpy.zeros(int(seconds * RATE))
    for at in times:
        t = numpy.arange(int(0.15 * RATE)) / RATE
        from_ = int(at * RATE)
        sound[from_:from_ + len(t)] += random.randn(len(t)) * numpy.exp(-t / 0.03)
    return sound


def test_a_contact_is_where_the_force_leaves_nothing():
    force = numpy.zeros(1000)
    force[100:300] = force[500:700] = 400
    assert list(contacts(force)) == [100, 500]


def test_steps_are_found_by_their_sound_alone():
    times = numpy.array([0.2, 1.3, 2.35, 3.5])
    found = onsets(bursts(times, 4.5), RATE, 0.7) / RATE
    assert found == pytest.approx(times, abs=0.005)


def recordings_like():
    random = numpy.random.RandomState(5)
    return random.randn(60, 45) + 3, numpy.array(["wood"] * 30 + ["snow"] * 30)


def test_members_differ_from_each_other_and_keep_the_tables_means():
    worlds = members(*recordings_like(), 2)
    for vectors, labels, sources in worlds:
        assert len(vectors) == len(labels) == len(sources) == sum(
            count for count, _ in targets.FEATURES.values())
        index, scaled = INDICES["centroid_hz"]
        for label in ("wood", "snow"):
            median = scaled(dict(zip(targets.NAMES, targets.FEATURES[label][1]))["centroid_hz"][0])
            assert vectors[labels == label][:, index].mean() == pytest.approx(median, abs=0.01)
    assert abs(worlds[0][0] - worlds[1][0]).max() > 0.5


def test_a_label_of_one_collection_alone_is_not_known_without_it():
    random = numpy.random.RandomState(2)
    labels = numpy.array(["a", "b", "a", "b", "c"]).repeat(20)
    sources = numpy.array([0, 0, 1, 1, 2]).repeat(20)
    vectors = random.randn(100, 4)
    vectors[labels == "b", 0] += 20
    vectors[labels == "c", 1] += 20
    assert named_right(vectors, labels, numpy.arange(100)) == [1, 1]
    assert named_right(vectors, labels, sources) == [0.8, 0.8]
