"""Text widths against matplotlib's copy of Helvetica's metrics, an independent source."""
import pathlib

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


def test_saved_boxes_of_max_have_the_widths_that_are_computed():
    for text, saved in (("t b b b", 42), ("loadbang", 58), ("clip 0. 1.", 53), ("cos~", 34), ("gate 1 1", 52),
                        ("change -1", 62), ("clear", 37)):
        assert text_size.box_size(text)[0] == pytest.approx(saved, abs=3.5), text
