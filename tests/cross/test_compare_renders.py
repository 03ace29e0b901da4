"""compare_renders.py finds what differs, and no limit lets through what is not a number or missing."""
import numpy
import pytest

from compare_renders import SAMPLES, Limits, compare_messages, compare_sound, expected


@pytest.fixture
def sound(tmp_path):
    a = numpy.sin(numpy.arange(2 * SAMPLES) / 7)
    a.tofile(tmp_path / "a.f64")

    def compare(change, until=SAMPLES):
        b = change(a.copy())
        b.tofile(tmp_path / "b.f64")
        return compare_sound(tmp_path / "a.f64", tmp_path / "b.f64", until)[0]
    return compare


def put(at, value):
    def change(signal):
        signal[at] = value
        return signal
    return change


def test_sound(sound):
    assert sound(lambda a: a) is None
    assert sound(lambda a: numpy.nextafter(a, 2)) == pytest.approx(-319, abs=1)
    assert sound(put(0, -0.0)) == -numpy.inf and not -numpy.inf < Limits().sound  # other bits, no difference
    assert sound(put(SAMPLES + 500, 100.0)) > 0
    assert sound(put(SAMPLES + 500, 100.0), until=501) > 0  # of the second outlet
    assert sound(put(SAMPLES + 500, 100.0), until=500) == -numpy.inf
    for wrong in (put(9, numpy.nan), put(9, numpy.inf), lambda a: a[:-1]):
        assert sound(wrong, until=500) == numpy.inf


@pytest.mark.parametrize("theirs, level", [
    ("1 0 gain 2 word\n", None), ("1 0 gain 2.00002 word\n", -100), ("1 0 gain 2 other\n", numpy.inf),
    ("1 0 gain 2 3 word\n", numpy.inf), ("1 0 gain nan word\n", numpy.inf), ("", numpy.inf)])
def test_messages(theirs, level, tmp_path):
    (tmp_path / "a").write_text("1 0 gain 2 word\n")
    (tmp_path / "b").write_text(theirs)
    found = compare_messages(tmp_path / "a", tmp_path / "b")[0]
    assert found == (pytest.approx(level, abs=0.1) if level else None)


def test_limits():
    single, double = expected("windows-amd64", 32), expected("windows-amd64", 64)
    assert (single["trombone"].sound, double["trombone"].sound) == (-120, -190)
    assert (double["syrinx"].until, double["gradient"].messages) == (9600, -10)
    assert "leaves" not in single and "impact" not in double
