"""The harness records exactly what Pd computes, and takes no error for a success."""
import math
import pathlib
import re

import numpy
import pytest

from harness import Patch, PdFailure


@pytest.mark.parametrize("rate, block", [(44100, 1), (48000, 64), (96000, 4096)])
def test_a_signal_comes_back_bit_for_bit_at_any_rate_and_block_size(rate, block):
    rng = numpy.random.default_rng(1)
    samples = rng.standard_normal(5000).astype(numpy.float32)
    patch = Patch(block=block)
    patch.record("out", patch.signal(samples))
    sound = patch.render(0.2, rate)["out"]
    assert len(sound) == round(0.2 * rate)
    assert numpy.array_equal(sound[:5000], samples, equal_nan=True)
    assert not sound[5000:].any()


def test_a_sound_that_is_not_finite_fails():
    samples = numpy.ones(100)
    samples[7:10] = math.nan, math.inf, -math.inf
    patch = Patch()
    patch.record("out", patch.signal(samples))
    with pytest.raises(PdFailure, match="not finite at 3 samples, first 7"):
        patch.render(0.01)
    assert list(numpy.flatnonzero(numpy.isnan(patch.render(0.01, allow_not_finite=True)["out"]))) \
        == [7, 8, 9]


def test_control_messages_arrive_in_time_with_words_and_exact_numbers():
    patch = Patch()
    through = patch.obj("t a")
    patch.log("log", through)
    patch.at(0, through, "bang")
    patch.at(100, through, "mode open 3.25")
    patch.at(250.5, through, 1 / 3)
    patch.at(300, through, [1, math.inf, math.nan])
    log = patch.render(0.5).logs["log"]
    assert [ms for ms, _ in log] == [0, 100, 250.5, 300]
    assert log[0][1] in ([], ["bang"])
    assert log[1][1] == ["mode", "open", 3.25]
    assert log[2][1] == [float(numpy.float32(1 / 3))]
    assert log[3][1][0] == 1 and math.isinf(log[3][1][1]) and math.isnan(log[3][1][2])


def test_messages_act_at_the_block_of_their_time_and_sub_patches_have_their_own_block_size():
    patch = Patch()
    step, inner = patch.obj("sig~"), patch.sub("coarse", block=512)
    inner.obj("inlet~") >> inner.obj("outlet~")
    patch.at(100, step, 1)
    step >> inner.node
    patch.record("step", step)
    patch.record("late", inner.node)
    result = patch.render(0.2)
    begins, late = (int(numpy.argmax(result[name])) for name in ("step", "late"))
    assert 4800 - 64 <= begins <= 4800 and late == begins + 512 - 64


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


def test_the_example_of_the_readme_runs():
    text = pathlib.Path(__file__).with_name("README.md").read_text()
    example, = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    defined = {}
    exec(compile(example, "README.md", "exec"), defined)
    tests = [function for name, function in defined.items() if name.startswith("test_")]
    assert tests
    for test in tests:
        test()
