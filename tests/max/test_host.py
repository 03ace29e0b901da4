"""The stub host (max/stub) itself, by small~, whose outlet is inlet 0 times gain: the host names each mistake that
small~ can make, and none of the right one."""
import math
import os
import pathlib
import re
import struct

import pytest

from max_host import GUARD, RATE, run

SMALL = pathlib.Path(os.environ["TACTUS_MAX_SMALL"])
SOURCE = pathlib.Path(__file__).with_name("small~.cpp").read_text()
MISTAKES = sorted(set(re.findall(r'(?:provokes|when)\("((?:[^"\\]|\\.)+)"', SOURCE)) - {"race"})  # of test_threads.py
WATCHED = "malloc on the audio path"  # by tests/guard
# All that the mistakes need to show.
PLAY = ("new a small~ @gain 0.5; describe a; send a 0 float 0.5; send a 1 float 2.; send a 0 list 1. x; send a 0 gain 0.25; "
        "get a gain; send a 0 bang; advance 10; signal a 0 sine 440 0.5; dsp on; run 4; mute a 1; run 2; "
        "send a 0 bang; free a").split("; ")


def play(script, **options):
    return run([f'load "{SMALL}"', *script], **options)


def test_the_right_one_has_no_mistake():
    play(PLAY)


@pytest.mark.parametrize("violation", MISTAKES)
def test_each_mistake_is_named(violation):
    if violation == WATCHED and not GUARD:
        pytest.skip("the audio guard is not there")
    result = play(PLAY, mistake=violation, clean=False)
    assert result.status != 0
    assert violation in (result.stderr if violation == WATCHED else "\n".join(result.of("violation")))


@pytest.mark.parametrize("inplace", ["off", "same", "crossed"])
@pytest.mark.parametrize("vector", [1, 64, 512])
def test_signals_are_the_same_whatever_the_vector(vector, inplace, tmp_path):
    play(["new a small~ @gain 0.5", f"vector {vector}", f"inplace {inplace}", "signal a 0 sine 440 0.25",
          f"record a {tmp_path}/out", "dsp on", f"run {512 // vector}"])
    theory = [0.125 * math.sin(2 * math.pi * 440 * n / RATE) for n in range(512)]
    assert struct.unpack("512d", (tmp_path / "out").read_bytes()) == pytest.approx(theory, abs=1e-13)
    play(["new a small~", f"signal a 0 file {tmp_path}/out", f"record a {tmp_path}/again", "dsp on", "run 9"])
    assert (tmp_path / "again").read_bytes()[:4096] == (tmp_path / "out").read_bytes()


@pytest.mark.parametrize("vector", [16, 512])
def test_clocks_run_at_their_logical_time_whatever_the_vector(vector):
    result = play([f"vector {vector}", "new a small~", "send a 0 bang", "dsp on", f"run {4096 // vector}", "send a 0 bang",
                   "advance 6"])
    assert [ms for ms, _, _ in result.sent("a")] == pytest.approx([5, 4096 * 1000 / RATE + 5], abs=1e-9)


@pytest.mark.parametrize("line", ["send nobody 0 bang", "nonsense", "new", "load no-such.mxl"])
def test_a_wrong_script_has_a_status(line):
    assert play(["new a small~", line], clean=False).status == 2
