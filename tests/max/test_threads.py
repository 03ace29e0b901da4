"""Messages of the main thread and of the scheduler's while the audio thread performs, for every object; also
run under the thread sanitizer for some."""
import os
import random

import pytest

from max_host import RATE, declarations, load, run
from test_every_object import connected, fuzz

OBJECTS = declarations()
CHOSEN = [name for name in os.environ.get("TACTUS_MAX_OBJECTS", "").split(",") if name] or sorted(OBJECTS)


def threads(name, vectors, lines, then):
    begin = [load(name), f"rate {RATE}", "vector 64", *connected(OBJECTS[name]), "dsp on"]
    return run([*begin, f"threads {vectors}", *lines, "end", *then])


@pytest.mark.parametrize("vectors", [100, pytest.param(600, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CHOSEN)
def test_two_threads_send_while_a_third_performs(name, vectors):
    d, generator = OBJECTS[name], random.Random(name)
    lines = [f"{thread} {fuzz(d, generator, 'b')}" for _ in range(40) for thread in ("main", "scheduler")]
    lines += [f"{thread} get b {p['name']}" for p in d["parameters"] for thread in ("main", "scheduler")]
    threads(name, vectors, [*lines, "main value b"], ["run 200", "dsp off", "free b"])


@pytest.mark.parametrize("name", [name for name in CHOSEN if OBJECTS[name]["signal"] and any(
    p["name"] == "gain" and p["realtime"] for p in OBJECTS[name]["parameters"])])
def test_the_last_value_that_a_thread_sends_wins(name):
    lines = [f"main send b 0 gain {i / 8}" for i in range(1, 7)] + ["scheduler send b 0 gain 0.96875"]
    then = ["run 4", "get b gain", "send b 0 gain 0.3", "get b gain", "run 2", "get b gain"]
    values = [float(line.split()[-1]) for line in threads(name, 100, lines, then).of("value")]
    assert values[0] in (0.75, 0.96875)
    assert values[1:] == [0.3, 0.3]


@pytest.mark.skipif("TACTUS_MAX_SMALL" not in os.environ, reason="not under the thread sanitizer")
def test_the_thread_sanitizer_finds_the_planted_race_and_no_other():
    lines = [f'load "{os.environ["TACTUS_MAX_SMALL"]}"', "new a small~ @gain 0.5", "signal a 0 sine 440 0.5", "dsp on",
             "threads 2000"]
    lines += [f"main {line}" for line in ("send a 0 float 0.5", "send a 1 float 2.", "send a 0 gain 0.25", "get a gain",
                                          "send a 0 bang", "send a 0 list 1. 2.")]
    lines += [f"scheduler send a {line}" for line in ("0 float 0.75", "1 float 3.", "0 bang")]
    lines += ["end", "dsp off"]
    right = run(lines)
    assert "ThreadSanitizer" not in right.stderr and right.sent("a")
    wrong = run(lines, mistake="race", clean=False)
    assert "data race" in wrong.stderr and wrong.status != 0
