"""Text widths against matplotlib's copy of Helvetica's metrics, an independent source."""
import pathlib
import random

import matplotlib
from matplotlib._afm import AFM
import pytest

import text_size


def advances(font):
    """Character -> width in thousandths of the font's size."""
    path = pathlib.Path(matplotlib.get_data_path()) / "fonts" / "pdfcorefonts" / f"{font}.afm"
    with path.open("rb") as file:
        return AFM(file).get_width_char


def test_widths_are_those_of_helvetica():
    width = advances("Helvetica")
    assert [width(chr(code)) for code in range(32, 127)] == list(text_size.ADVANCE[:95])


def test_bold_text_is_about_as_wide_as_helvetica_bold():
    width = advances("Helvetica-Bold")
    for text in ("a surface rubs a body: squeaks, creaks, bows and brakes", "haptic device: force in, position out"):
        assert text_size.width(text, 12, True) == pytest.approx(sum(map(width, text)) * 12 / 1000, rel=0.04)


def test_saved_boxes_of_max_have_the_widths_that_are_computed():
    for text, saved in (("t b b b", 42), ("loadbang", 58), ("clip 0. 1.", 53), ("cos~", 34), ("gate 1 1", 52),
                        ("change -1", 62), ("clear", 37)):
        assert text_size.box_size(text)[0] == pytest.approx(saved, abs=3.5), text


def test_a_wrapped_text_keeps_its_words_and_fits():
    random.seed(1)
    for _ in range(50):
        words = ["x" * random.randint(1, 9) for _ in range(random.randint(1, 30))]
        room = random.uniform(80, 300)
        lines = text_size.wrap(" ".join(words), room)
        assert " ".join(lines).split(" ") == words
        assert all(text_size.width(line) <= room for line in lines)


def test_a_box_holds_its_text():
    for most in (60, 120, 300, None):
        width, height = text_size.box_size("some words in a box that may wrap", "comment", most)
        lines = text_size.wrap("some words in a box that may wrap", width - text_size.MARGIN + 0.5)
        assert height == text_size.box_height(len(lines), "comment")
