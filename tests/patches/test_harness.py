"""The harness takes no error for a success."""
import math

import numpy
import pytest

from harness import Patch, PdFailure


def test_a_sound_that_is_not_finite_fails():
    samples = numpy.ones(100)
    samples[7:10] = math.nan, math.inf, -math.inf
    patch = Patch()
    patch.record("out", patch.signal(samples))
    with pytest.raises(PdFailure, match="not finite at 3 samples, first 7"):
        patch.render(0.01)
    assert list(numpy.flatnonzero(numpy.isnan(patch.render(0.01, allow_not_finite=True)["out"]))) \
        == [7, 8, 9]


@pytest.mark.parametrize("box", ["no-such-object", "tabread~ no-such-array"])
def test_what_pd_cannot_make_or_find_fails(box):
    patch = Patch()
    patch.record("out", patch.obj("noise~"))
    patch.at(0, patch.obj("+ 1"), 1)
    patch.obj(box)
    with pytest.raises(PdFailure):
        patch.render(0.1)


def test_an_error_fails_unless_the_test_expects_it():
    patch = Patch()
    patch.at(10, patch.obj("osc~ 440"), "unheard-of 1")
    patch.record("out", patch.obj("noise~"))
    with pytest.raises(PdFailure, match="unheard-of"):
        patch.render(0.1)
    assert len(patch.render(0.1, expect_errors=["no method for 'unheard-of'"]).errors) == 1
    with pytest.raises(PdFailure, match="did not say"):
        patch.render(0.1, expect_errors=["unheard-of", "something else"])


def test_a_patch_that_hangs_or_quits_early_fails():
    patch = Patch()
    loop, again = patch.obj("until"), patch.obj("t b")
    patch.start >> loop >> again
    with pytest.raises(PdFailure, match="did not finish"):
        patch.render(0.1, timeout=1)
    patch = Patch()
    patch.record("out", patch.obj("noise~"))
    patch.send(10, "pd", "quit")
    with pytest.raises(PdFailure, match="left no"):
        patch.render(0.1)
