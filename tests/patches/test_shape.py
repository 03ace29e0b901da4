"""[modal_impact~] in Pd: the shape of a body moves while it rings."""
import numpy
import pytest
from harness import Patch
from test_modal_impact import RATE, far_from_tones, struck, table

FREQUENCIES = numpy.array([400.0, 1000.0, 1600.0])
HEIGHT, LENGTH = 0.006, 0.2  # m; omega^2 ~ h^2/L^4, a bar in bending


def shaped(folder, *arguments, **changes):
    """The square table as if its modes were a bar's: one control point at its end, up and along."""
    squared = (2 * numpy.pi * changes.get("freq", FREQUENCIES)) ** 2
    arrays = {"control_points": numpy.array([[0.1, 0.003, 0.0]]),
              "parameters": numpy.array([[0, 1, -0.003, 0.003], [0, 0, -0.05, 0.05]]),
              "trust": numpy.array(0.002),
              "domega2_dp": numpy.stack([2 / HEIGHT * squared, -4 / LENGTH * squared])}
    patch, box = struck(folder, *arguments)
    table(folder / "square.modal.npz", **{**arrays, **changes})
    return patch, box


def peaks(sound, near):
    spectrum = abs(numpy.fft.rfft(sound * numpy.hanning(len(sound)), 1 << 19))
    found = []
    for f in near:
        band = slice(int(f * 0.97 * (1 << 19) / RATE), int(f * 1.03 * (1 << 19) / RATE))
        found.append((spectrum[band].argmax() + band.start) * RATE / (1 << 19))
    return numpy.array(found)


@pytest.mark.parametrize("message, height, length", [
    ("shape 0.6 0", 0.1, 0), ("shape 0 10", 0, 0.05), ("cp 0 110 2.4 0", -0.1, 0.05),
    ("shape 100 0", 0.5, 0)])  # to its bound
def test_ringing_modes_follow_the_shape_as_a_bars_to_first_order(tmp_path, message, height, length):
    patch, box = shaped(tmp_path)
    patch.at(100, box, "hit 30 40 0 1")
    patch.at(300, box, message)
    sound = patch.render(1.5, path=[tmp_path])["left"]
    exact = FREQUENCIES * (1 + height) / (1 + length) ** 2
    # ln(1 + x) against x: the error of the first order
    off = abs(height - numpy.log1p(height)) + 2 * abs(length - numpy.log1p(length))
    expected = FREQUENCIES * numpy.exp(height - 2 * length)
    assert abs(expected / exact - 1).max() < 1.02 * numpy.expm1(off)
    assert abs(peaks(sound[RATE // 2:], expected) - expected).max() < 0.1
    assert abs(peaks(sound[RATE // 10:RATE * 3 // 10], FREQUENCIES) - FREQUENCIES).max() < 2


def same(one, two):
    """But for Pd's rounding of positions to single precision."""
    return abs(one - two).max() < 1e-4 * abs(one).max()


def test_cp_and_shape_are_the_same_and_info_tells_them(tmp_path):
    heard = []
    for message in ("shape 0.6 4", "cp 0 104 3.6 0", "cp 0 104 3.6 99"):
        patch, box = shaped(tmp_path)
        patch.at(100, box, "hit 30 40 0 1")
        patch.at(200, box, message)
        patch.at(300, box, "info")
        result = patch.render(0.5, path=[tmp_path])
        heard.append(result["left"])
        told = {atoms[0]: atoms[1:] for _, atoms in result.logs["info"]}
        assert told["shape"] == pytest.approx([0.6, 4], rel=1e-5)
        assert told["cp"] == pytest.approx([0, 104, 3.6, 0], rel=1e-5)
        assert told["frequencies"] == pytest.approx(FREQUENCIES * numpy.exp(0.1 - 0.04), rel=1e-5)
    assert same(heard[0], heard[1]) and (heard[1] == heard[2]).all()


def test_a_shape_of_0_changes_no_bit_and_size_scales_the_positions(tmp_path):
    def play(*messages):
        patch, box = shaped(tmp_path)
        for ms, message in messages:
            patch.at(ms, box, message)
        return patch.render(0.4, path=[tmp_path])["left"]
    still = play((100, "hit 30 40 0 1"))
    assert (play((50, "shape 0 0"), (100, "hit 30 40 0 1")) == still).all()
    assert (play((50, "shape 1 5"), (60, "cp 0 100 3 0"), (100, "hit 30 40 0 1")) == still).all()
    large = play((50, "size 2"), (60, "shape 1.2 8"), (100, "hit 60 80 0 1"))
    assert same(play((50, "size 2"), (60, "cp 0 208 7.2 0"), (100, "hit 60 80 0 1")), large)
    first = play((50, "shape 0.6 4"), (60, "size 2"), (100, "hit 60 80 0 1"))
    assert same(first, large)


@pytest.mark.parametrize("message, sentence", [
    ("shape 1", "shape: 1 numbers: expected 2, one for each shape parameter of the table"),
    ("shape 1 nan", "shape 1 nan: expected numbers"),
    ("cp 1 0 0 0", "cp: control point 1: expected 0..0"),
    ("cp 0.5 0 0 0", "cp: control point 0.5: expected 0..0"),
])
def test_misuse_is_one_sentence_and_changes_nothing(tmp_path, message, sentence):
    def play(*messages):
        patch, box = shaped(tmp_path)
        patch.at(50, box, "shape 0.3 2")
        for wrong in messages:
            patch.at(60, box, wrong)
        patch.at(100, box, "hit 30 40 0 1")
        return patch.render(0.3, path=[tmp_path],
                            expect_errors=["modal_impact~: " + sentence] if messages else [])
    wrong = play(message)
    assert len(wrong.errors) == 1
    assert (wrong["left"] == play()["left"]).all()


def test_a_table_without_parameters_says_so(tmp_path):
    patch, box = struck(tmp_path)
    patch.at(50, box, "shape 1")
    patch.render(0.1, path=[tmp_path], expect_errors=[
        "shape: this table has no shape parameters: expected one with domega2_dp"])


def test_a_table_of_wrong_derivatives_is_refused_by_name(tmp_path):
    patch, box = shaped(tmp_path, domega2_dp=numpy.zeros((2, 2)))
    patch.render(0.1, path=[tmp_path], expect_errors=[r"'domega2_dp' has shape \(2, 2\): expected \(2, 3\)"])


def test_a_new_table_begins_in_its_own_shape(tmp_path):
    patch, box = shaped(tmp_path)
    patch.at(50, box, "shape 0.6 0")
    patch.at(100, box, "load square.modal.npz")
    patch.at(150, box, "loss 0.002")
    patch.at(200, box, "hit 30 40 0 1")
    sound = patch.render(1.2, path=[tmp_path])["left"][RATE // 4:]
    assert abs(peaks(sound, FREQUENCIES) - FREQUENCIES).max() < 0.1


def test_dragging_does_not_click(tmp_path):
    # One tone, drawn up by a tenth within half a second by messages every 10 ms.
    patch, box = shaped(tmp_path, freq=numpy.array([400.0, 400.5, 401.0]),
                        eta=numpy.full(3, 1e-4))
    patch.at(10, box, "hit 30 40 0 1")
    for i in range(50):
        patch.at(200 + 10 * i, box, f"shape {0.6 * (i + 1) / 50} 0")
    sound = patch.render(1.0, path=[tmp_path])["left"][RATE // 5:]
    assert far_from_tones(sound, [400, 420, 440], 120) < -60
