"""[ioa_link] and ioa_net between Pds in real time: the same hits behind a line, at the same times, and
no event lost. Lines are a relay's; those of the kernel are in test_bus_lines.py."""
import os
import pathlib
import re
import subprocess
import sys
import time

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "patches"))
from ioa_system import BODIES_APART, wandering  # noqa: E402
from pd_process import Pd  # noqa: E402
from relay import Relay  # noqa: E402


def patch(boxes, cords):
    """Lines of a patch: boxes by name, as `obj ...` or `msg ...`; cords as `from out to in`."""
    number = {name: i for i, name in enumerate(boxes)}
    return [f"#X {words.split()[0]} 10 10 {words.split(' ', 1)[1]};" for words in boxes.values()] + [
        f"#X connect {number[a]} {i} {number[b]} {j};"
        for a, i, b, j in (cord.split() for cord in cords)]


@pytest.fixture
def pds(tmp_path):
    running = []

    def start(name, boxes, cords, **options):
        running.append(Pd(tmp_path, *patch(boxes, cords), name=name, **options))
        return running[-1]
    yield start
    for one in running:
        one.close()


@pytest.fixture
def busy():
    """Programs that take all processors, as many as asked for."""
    loops = []

    def start(count):
        loops.extend(subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count))
    yield start
    for loop in loops:
        loop.kill()
        loop.wait()


def server(pds, scene):
    """A Pd with the interaction server alone. What it tells of late messages comes as a mark with the
    time of it, translated like all times."""
    boxes = {"net": "obj ioa_net far hit release mark", "is": "obj ioa_is far",
             "mm": f"obj ioa_mm_haptic far {scene}", "begin": "obj loadbang", "listen": "msg listen 0",
             "print": "obj print far", "sort": "obj route late", "t": "obj t b", "clock": "obj ioa_clock",
             "mark": r"msg mark \$1 late 0 0 0 0", "bus": "obj ioa_bus far"}
    running = pds("far", boxes, ["begin 0 listen 0", "listen 0 net 0", "net 0 print 0", "net 0 sort 0",
                                 "sort 0 t 0", "t 0 clock 0", "clock 0 mark 0", "mark 0 bus 0"])
    return running, int(running.wait_for(r"^far: status listening (\d+)$"))


def hand(pds, scene, script, port):
    """A Pd with the hand, that shows the hits of a server of its own and of the one behind the line."""
    boxes = {"net": "obj ioa_net lab hand", "sdd": f"obj ioa_sdd_script lab {script}",
             "re": "obj ioa_re lab 1", "tap": "obj ioa_bus lab hand", "beside": "obj ioa_bus ref",
             "is": "obj ioa_is ref", "mm": f"obj ioa_mm_haptic ref {scene}",
             "hits": "obj ioa_bus lab hit mark", "far": "obj print far", "own": "obj ioa_bus ref hit",
             "ref": "obj print ref", "begin": "obj loadbang", "connect": f"msg connect {port}",
             "print": "obj print link", "sort": "obj route connected late", "one": "obj sel 1",
             "wait": "obj delay 1500", "end": "obj r lab.script-end", "t": "obj t b",
             "clock": "obj ioa_clock", "late": "obj print late"}
    return pds("hand", boxes, ["begin 0 connect 0", "connect 0 net 0", "net 0 print 0", "net 0 sort 0",
                               "sort 0 one 0", "one 0 wait 0", "wait 0 sdd 0", "tap 0 beside 0",
                               "hits 0 far 0", "own 0 ref 0", "sort 1 t 0", "t 0 clock 0",
                               "clock 0 late 0"])


def hits(running, side):
    return [(float(t), body) for t, body in
            re.findall(rf"^{side}: hit (\S+) (\S+) ", running.read(), re.M)]


def play(pds, tmp_path, seed, delay_s=0.0, jitter_s=0.0):
    """Both servers' hits once the script has been played, and when messages were late."""
    script, seconds = wandering(tmp_path / "hand.txt", seed)
    (tmp_path / "scene.txt").write_text(BODIES_APART)
    far, port = server(pds, tmp_path / "scene.txt")
    relay = Relay(port, seed)
    relay.delay_s, relay.jitter_s = delay_s, jitter_s
    try:
        near = hand(pds, tmp_path / "scene.txt", script, relay.port)
        near.wait_for(r"^link: (connected 1)$")
        end = time.monotonic() + 1.5 + seconds + 2
        while time.monotonic() < end or len(hits(near, "far")) < len(hits(near, "ref")):
            assert time.monotonic() < end + 30, near.text[-3000:] + far.read()[-1000:]
            time.sleep(0.1)
    finally:
        relay.close()
    text = near.read()
    late = [float(t) for t in re.findall(r"^far: mark (\S+) late", text, re.M)]
    late += [float(t) for t in re.findall(r"^late: (\S+)$", text, re.M)]
    return hits(near, "ref"), hits(near, "far"), late


LATE_MS = 1500  # what is late is told within half a second, and the delay before it was too short


def compare(local, networked, late):
    """The largest difference of times, ms, apart from stretches in which `late` was told."""
    assert len(local) >= 5 and [body for _, body in networked] == [body for _, body in local]
    apart = [(t, abs(t - other)) for (t, _), (other, _) in zip(local, networked)
             if not any(t - 100 < told < t + LATE_MS for told in late)]
    return max((difference for _, difference in apart), default=0.0), len(apart)


@pytest.mark.parametrize("seed", [1, 2])
def test_p23_over_30_ms_and_20_ms_of_jitter_each_way_the_hits_are_the_same(pds, tmp_path, seed):
    local, networked, late = play(pds, tmp_path, seed, 0.03, 0.02)
    worst_ms, compared = compare(local, networked, late)
    print(f"{len(local)} hits, {compared} compared, largest difference {worst_ms:.3f} ms")
    assert worst_ms <= 2
