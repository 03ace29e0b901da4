"""The band classifiers, and cross-validation by collection."""
import numpy
import pytest
from band_classifiers import discriminant, shrunk_covariance
from validation import all_classifiers, left_out, shares

RANDOM = numpy.random.RandomState(7)


def test_a_shrunk_covariance_is_near_the_truth_for_few_sounds_and_many_numbers():
    size, count = 60, 20
    truth = numpy.diag(numpy.linspace(0.5, 1.5, size))
    drawn = RANDOM.randn(count, size) @ numpy.sqrt(truth)
    residuals = drawn - drawn.mean(axis=0)
    plain = residuals.T @ residuals / count
    shrunk = shrunk_covariance(residuals)
    assert numpy.linalg.matrix_rank(plain) < size
    assert numpy.linalg.eigvalsh(shrunk).min() > 0.1
    assert numpy.linalg.norm(shrunk - truth) < 0.5 * numpy.linalg.norm(plain - truth)
    assert numpy.trace(shrunk) == pytest.approx(numpy.trace(plain))
    many = RANDOM.randn(20000, 5) @ numpy.diag([1, 1, 1, 1, 2.0])
    assert numpy.diag(shrunk_covariance(many)) == pytest.approx([1, 1, 1, 1, 4], rel=0.05)


def test_the_discriminant_is_bayes_rule_for_two_normal_distributions():
    # Means 0 and 2 along one axis of variance 1, a second axis of variance 9 that tells nothing.
    labels = numpy.array(["a"] * 4000 + ["b"] * 4000)
    sounds = numpy.column_stack([RANDOM.randn(8000) + 2 * (labels == "b"), 3 * RANDOM.randn(8000)])
    ranked = discriminant(sounds, labels, numpy.array([[0.9, 8.0], [1.1, -8.0], [3.0, 0.0]]))
    assert [r[0] for r in ranked] == ["a", "b", "b"]
    right = numpy.mean([r[0] == c for r, c in zip(discriminant(sounds, labels, sounds), labels)])
    assert right == pytest.approx(0.8413, abs=0.015)  # the normal distribution up to 1


def collections_of_two_labels(apart):
    """Two labels that another number tells apart in each of two collections."""
    labels = numpy.repeat(["a", "b", "a", "b"], 10)
    collections = numpy.repeat(["x", "y"], 20)
    vectors = 0.1 * RANDOM.randn(40, 45)
    vectors[:, 0] += 10.0 * (collections == "y")
    vectors[:, 1] += apart * (collections == "x") * (labels == "b")
    vectors[:, 2] += apart * (collections == "y") * (labels == "b")
    return vectors, labels, collections


@pytest.mark.parametrize("name", list(all_classifiers()))
def test_a_collection_left_out_shows_what_one_sound_left_out_hides(name):
    rank = all_classifiers()[name]
    vectors, labels, collections = collections_of_two_labels(5.0)
    one = shares(left_out(rank, vectors, labels, numpy.arange(40) % 5), labels)
    whole = shares(left_out(rank, vectors, labels, collections), labels)
    assert one[0] > 0.75
    assert whole[0] < 0.6


def test_a_label_of_one_collection_only_is_not_classified():
    vectors, labels, collections = collections_of_two_labels(5.0)
    labels = numpy.where((collections == "x") & (labels == "b"), "c", labels)
    ranked = left_out(discriminant, vectors, labels, collections)
    assert all((r is None) == (c != "a") for r, c in zip(ranked, labels))
    assert shares(ranked, labels)[2] == 20
