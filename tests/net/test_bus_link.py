"""[ioa_link] and ioa_net between Pds in real time: the same hits behind a line, at the same times, and
no event lost. Lines are a relay's; those of the kernel are in test_bus_lines.py. TACTUS_SEEDS=10: so many
scripts and lines for each kind of jitter, instead of one; `-s` prints a row of each."""
import os
import re
import time

import pytest

from ioa_system import BODIES_APART, wandering
from pd_process import patch
from relay import Relay


def server(pd, scene):
    """A Pd with the interaction server alone. What it tells of late messages comes as a mark with the
    time of it, translated like all times."""
    boxes = {"net": "obj ioa_net far hit release mark", "is": "obj ioa_is far",
             "mm": f"obj ioa_mm_haptic far {scene}", "begin": "obj loadbang", "listen": "msg listen 0",
             "print": "obj print far", "sort": "obj route late", "t": "obj t b", "clock": "obj ioa_clock",
             "mark": r"msg mark \$1 late 0 0 0 0", "bus": "obj ioa_bus far"}
    running = pd(*patch(boxes, ["begin 0 listen 0", "listen 0 net 0", "net 0 print 0", "net 0 sort 0",
                                 "sort 0 t 0", "t 0 clock 0", "clock 0 mark 0", "mark 0 bus 0"]),
                 name="far")
    return running, int(running.wait_for(r"^far: status listening (\d+)$"))


def hand(pd, scene, script, port):
    """A Pd with the hand, that shows the hits of a server of its own and of the one behind the line."""
    boxes = {"net": "obj ioa_net lab hand", "sdd": f"obj ioa_sdd_script lab {script}",
             "re": "obj ioa_re lab 1", "tap": "obj ioa_bus lab hand", "beside": "obj ioa_bus ref",
             "is": "obj ioa_is ref", "mm": f"obj ioa_mm_haptic ref {scene}",
             "hits": "obj ioa_bus lab hit mark", "far": "obj print far", "own": "obj ioa_bus ref hit",
             "ref": "obj print ref", "begin": "obj loadbang", "connect": f"msg connect {port}",
             "print": "obj print link", "sort": "obj route connected late", "one": "obj sel 1",
             "wait": "obj delay 1500", "end": "obj r lab.script-end", "t": "obj t b",
             "clock": "obj ioa_clock", "late": "obj print late"}
    return pd(*patch(boxes, ["begin 0 connect 0", "connect 0 net 0", "net 0 print 0", "net 0 sort 0",
                               "sort 0 one 0", "one 0 wait 0", "wait 0 sdd 0", "tap 0 beside 0",
                               "hits 0 far 0", "own 0 ref 0", "sort 1 t 0", "t 0 clock 0",
                               "clock 0 late 0"]), name="hand")


def hits(running, side):
    return [(float(t), body) for t, body in
            re.findall(rf"^{side}: hit (\S+) (\S+) ", running.read(), re.M)]


def play(pd, tmp_path, seed, meanwhile=lambda far, relay: None, **line):
    """Both servers' hits once the script has been played, and when messages were late. meanwhile: what
    happens while it is played; line: settings of the relay."""
    script, seconds = wandering(tmp_path / "hand.txt", seed)
    (tmp_path / "scene.txt").write_text(BODIES_APART)
    far, port = server(pd, tmp_path / "scene.txt")
    relay = Relay(port, seed)
    vars(relay).update(line)
    try:
        near = hand(pd, tmp_path / "scene.txt", script, relay.port)
        near.wait_for(r"^link: (connected 1)$")
        end = time.monotonic() + 1.5 + seconds + 2
        time.sleep(1.5)
        meanwhile(far, relay)
        while time.monotonic() < end or (len(hits(near, "far")) < len(hits(near, "ref")) and
                                         time.monotonic() < end + PATIENCE_S):
            time.sleep(0.1)
    finally:
        relay.close()
    text = near.read()
    late = [float(t) for t in re.findall(r"^far: mark (\S+) late", text, re.M)]
    late += [float(t) for t in re.findall(r"^late: (\S+)$", text, re.M)]
    found = hits(near, "ref"), hits(near, "far"), late
    near.close()
    far.close()
    return found


PATIENCE_S = 15  # for hits that are on their way
LATE_MS = 700  # what is late is told within half a second


def compare(local, networked, late):
    """The largest difference of times, ms, apart from stretches in which `late` was told."""
    assert len(local) >= 5 and [body for _, body in networked] == [body for _, body in local]
    apart = [(t, abs(t - other)) for (t, _), (other, _) in zip(local, networked)
             if not any(t - 100 < told < t + LATE_MS for told in late)]
    return max((difference for _, difference in apart), default=0.0), len(apart)


UNIFORM, EXPONENTIAL = {"jitter_s": 0.02}, {"jitter_s": 0.01, "exponential": True}
SEEDS = os.environ.get("TACTUS_SEEDS")
LINES = ([(jitter, seed) for jitter in (UNIFORM, EXPONENTIAL) for seed in range(1, 1 + int(SEEDS))] if SEEDS else
         [(UNIFORM, 1), pytest.param(EXPONENTIAL, 2, marks=pytest.mark.slow)])
TRIALS = 3


@pytest.mark.parametrize("jitter,seed", LINES)
def test_p23_over_30_ms_and_20_ms_of_jitter_each_way_the_hits_are_the_same(pd, tmp_path, jitter, seed):
    """A stall of the machine can cost a hit (once in 46 runs on a busy one), and is no part of the line: a trial
    with messages that were told late and another number of hits is repeated."""
    for trial in range(1, 1 + TRIALS):
        folder = tmp_path / str(trial)
        folder.mkdir()
        local, networked, late = play(pd, folder, seed, delay_s=0.03, **jitter)
        if len(local) == len(networked) or not late:
            break
        print(f"{jitter} seed {seed}, trial {trial}: {len(networked)} of {len(local)} hits, {len(late)} times late")
    worst_ms, compared = compare(local, networked, late)
    # Translated times stay right when messages are late, but for a stall of the machine.
    all_ms = sorted(abs(t - other) for (t, _), (other, _) in zip(local, networked))
    assert all_ms[-2] <= 2
    print(f"{jitter} seed {seed}: {len(local)} hits, largest difference {all_ms[-1]:.3f} ms; told {len(late)} times of "
          f"late messages, {compared} hits apart from these, {worst_ms:.3f} ms")
    assert worst_ms <= 2
