"""The stub host (max/stub) itself, by small~: its outlet is inlet 0 times inlet 1 (or the last float there) times gain.
Signals, time, inlets, attributes and files are as the stub's README says; and the host names each mistake that small~
can make, and none of the right one."""
import math
import os
import pathlib
import re
import struct

import pytest

from max_host import EMULATOR, RATE, run

SMALL = pathlib.Path(os.environ["TACTUS_MAX_SMALL"])
SOURCE = pathlib.Path(__file__).with_name("small~.cpp").read_text()
MISTAKES = sorted(set(re.findall(r'(?:provokes|when)\("((?:[^"\\]|\\.)+)"', SOURCE)) - {"race"})  # of test_threads.py
BREACH, CRASH = 3, 4
LOCKS = "pthread_mutex_lock in perform"  # watched by a native host without sanitizers alone
# All that the mistakes need to show.
PLAY = (
    "class small~; buffer samples 2 16 constant 0.5; new a small~ clarinet @gain 0.5; "
    "expect a inlets signal signal message; expect a outlets signal message message; describe a; loadbang a; "
    "send a 0 float 0.5; send a 1 int 2; send a 2 hello 1 2. world; send a 0 list 1 2. x; "
    "send a 0 gain 0.25; send a 0 getgain; send a 0 find known.txt; value a; value a 0.75 2.; "
    "drop a locked known.txt; drop a unlocked known.txt; send a 0 bang; advance 10; signal a 0 sine 440 0.5; "
    "vector 32; dsp on; run 4; mute a 1; run 2; mute a 0; signal a 1 constant 3; thread scheduler; "
    "send a 1 float 4; thread main; send a 0 bang; dsp off; free a; new b small~").split("; ")


@pytest.fixture(name="play")
def in_an_empty_folder(tmp_path):
    """A function: what a script does, with small~ loaded and a file known.txt beside it."""
    (tmp_path / "known.txt").write_text("")

    def play(script, **options):
        return run([f'load "{SMALL}"', f'searchpath "{tmp_path}"', *script], folder=tmp_path, **options)
    return play


@pytest.fixture(name="render")
def samples(play, tmp_path):
    """A function: samples of box a's outlet."""
    def render(script, vectors):
        play([*script, "record a out.f64", "dsp on", f"run {vectors}"])
        data = (tmp_path / "out.f64").read_bytes()
        return list(struct.unpack(f"{len(data) // 8}d", data))
    return render


def test_the_right_one_has_no_mistake(play):
    result = play(PLAY)
    assert not result.stderr.strip()


@pytest.mark.parametrize("violation", MISTAKES)
def test_each_mistake_is_named(violation, play):
    if violation == LOCKS and (EMULATOR or os.environ.get("TACTUS_SANITIZED") == "ON"):
        pytest.skip("locks are not watched here")
    result = play(PLAY, mistake=violation.replace('\\"', '"'), clean=False)
    if "AddressSanitizer: use-after-poison" not in result.stderr:  # that ends the run at a write into a guard zone
        assert any(violation in line for line in result.of("violation")), (result.of("violation"), result.stderr)
        assert result.status in (BREACH, CRASH) or "LeakSanitizer" in result.stderr


def noise(seed, count):
    """The README's noise."""
    mask, found = 2**64 - 1, []
    for n in range(count):
        x = (seed + n + 0x9E3779B97F4A7C15) & mask
        x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & mask
        x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & mask
        x ^= x >> 31
        found.append(2 * (x >> 11) * 2.0**-53 - 1)
    return found


BOX = "new a small~ @gain 0.5"


def test_signals_are_what_they_say_whatever_the_vector(play, render):
    assert render([BOX, "signal a 0 noise 7 1", "signal a 1 constant 3"], 4) == [v * 3 * 0.5 for v in noise(7, 256)]
    theory = [0.25 * math.sin(2 * math.pi * 440 * n / RATE) for n in range(256)]
    assert render([BOX, "signal a 0 sine 440 0.25", "send a 1 float 2"], 4) == pytest.approx(theory, abs=1e-13)
    assert render([BOX, "signal a 0 sine 440 1", "send a 0 float 2"], 1) == [0.0] * 64  # inlet 0's float is not inlet 1's
    both = [BOX, "signal a 0 noise 1 1", "signal a 1 noise 2 1"]
    whole = render([*both, "vector 2048"], 1)
    for vector in (1, 2, 64, 512):
        for inplace in ("off", "same", "crossed"):
            assert render([*both, f"vector {vector}", f"inplace {inplace}"], 2048 // vector) == whole, (vector, inplace)
    assert render(["new b small~ @gain 3.", "signal b 0 noise 1 1", "send b 1 float 1", "new a small~",
                   "signal a 0 box b 0", "send a 1 float 1"], 2) == [3 * v for v in noise(1, 128)]
    levels = play([BOX, "signal a 0 nan", "send a 1 float 1", "dsp on", "run 1", "levels a"]).of("level")
    assert levels == ["a 0 0.0 0.0 64"]  # counts what is not finite


def test_files_are_signals_and_are_found(play, render, tmp_path):
    samples = noise(3, 64)
    (tmp_path / "in.f64").write_bytes(struct.pack("64d", *samples))
    box = ["new a small~", "send a 1 float 1"]
    assert render([*box, "signal a 0 file in.f64"], 2) == samples + [0.0] * 64
    whole = [-32768, 32767, 1, 0, -1, 12345]
    frames = struct.pack("<12h", *[v for w in whole for v in (0, w)])
    (tmp_path / "in.wav").write_bytes(b"RIFF" + struct.pack("<I", 36 + len(frames)) + b"WAVEfmt " + struct.pack(
        "<IHHIIHH", 16, 1, 2, RATE, RATE * 4, 4, 16) + b"data" + struct.pack("<I", len(frames)) + frames)
    assert render([*box, "signal a 0 wav in.wav 1"], 1)[:6] == [w / 32768 for w in whole]
    result = play(["patcher sub/some.maxpat", "buffer samples 2 100 constant 0.25", "new a small~",
                   "send a 0 find known.txt", "send a 0 find unknown.txt", "send a 0 sum", "send a 0 patcher",
                   "patcher sub/some.maxpat subpatcher", "new b small~", "send b 0 patcher"])
    found, total, *paths = [words for _, _, words in result.sent("a")]
    assert found[0] == "found" and found[1].endswith("/known.txt") and total == ["float", "50.0"]
    assert result.of("error") == ["small~ a: unknown.txt: no such file"]
    own, outer = [words for _, _, words in result.sent("b")]  # a subpatcher has no file of its own
    assert all(words[0].endswith("/sub/some.maxpat") for words in (*paths, outer)) and own[0] in ("", '""')


@pytest.mark.parametrize("vector", [16, 512])
def test_clocks_run_at_their_logical_time_whatever_the_vector(vector, play):
    result = play([f"vector {vector}", "new a small~", "send a 0 bang", "dsp on", f"run {4096 // vector}", "send a 0 bang",
                   "advance 6"])
    assert [ms for ms, _, _ in result.sent("a")] == pytest.approx([5, 4096 * 1000 / RATE + 5], abs=1e-9)


def test_boxes_come_and_go_in_either_thread(play):
    play(["overdrive off", "new a small~", "thread scheduler", "send a 0 bang", "thread main", "advance 6"])
    play(["new a small~", "repeat 300", "new b small~ @gain 2", "send b 0 bang", "free b", "end"])


def test_each_method_gets_its_messages_and_others_are_refused(play):
    lines = play(["new a small~ 1 2.5 word @gain 0.5 @nothing 3", "new a2 nothing~", "describe a", "send a 0 int 3",
                  "send a 0 list 4.", "send a 0 list 4. 5 x", "send a 0 float", "send a 0 float word", "send a 7 bang",
                  "send a 0 dsp64", "send a 0 gain word", "send a 0 getgain", "send a 0 float #nan"]).lines
    assert set(lines) >= {
        'error: small~: "nothing" is not a valid attribute argument', "error: max: nothing~: no such object",
        "inlet: a 1 signal (signal/float) factor", "inlet: a 2 message (message) words",
        "outlet: a 0 signal (signal) product", "out: 0.0 a 1 float 3.0", "out: 0.0 a 1 list 4.0",
        "out: 0.0 a 1 list 4.0 5 x", 'error: small~ a: bad arguments for message "float"',
        "error: small~ a: has no inlet 7", 'error: small~ a: doesn\'t understand "dsp64"',
        "error: small~ a: gain: expected a number", "out: 0.0 a 2 gain 0.5", "out: 0.0 a 1 float nan"}
    circle = play(["new a small~", "new b small~", "cord a 1 b 0", "cord b 1 a 0", "send a 0 float 1"])
    assert any("stack overflow" in line for line in circle.lines)
    saved = play(["new a small~ @gain 4", "save state.txt", "set a gain 5", "get a gain", "restore state.txt", "get a gain"])
    assert saved.lines == ["value: a gain 5.0", "value: a gain 4.0"]


@pytest.mark.parametrize("line, status", [("send nobody 0 bang", 2), ("nonsense", 2), ("expect a outlets signal", BREACH)])
def test_a_wrong_script_has_a_status(line, status, play):
    assert play(["new a small~", line], clean=False).status == status
