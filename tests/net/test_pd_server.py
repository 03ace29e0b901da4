"""Unmodified Pd: [haptic_server] in a patch, and Pd's own objects as clients of the program."""
import os
import pathlib
import re
import signal
import sys
import time

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "devices" / "live"))
from pd_process import Pd  # noqa: E402
from peer import Peer, Program, last_force, near  # noqa: E402

SILENCE_S, STALL_S = 0.5, 0.25


@pytest.fixture
def pd(tmp_path):
    running = []

    def start(*lines):
        running.append(Pd(tmp_path, *lines))
        return running[-1]
    yield start
    for one in running:
        one.close()


SERVER = ["#X obj 10 10 loadbang;", "#X msg 10 40 port 0 \\, workspace -80 -60 -35 80 60 35 \\, "
          "10 -20 30 \\, open;", "#X obj 10 80 haptic_server -forcemax 3;", "#X obj 10 120 print force;",
          "#X obj 200 120 print info;", "#X connect 0 0 1 0;", "#X connect 1 0 2 0;",
          "#X connect 2 0 3 0;", "#X connect 2 1 4 0;"]


def forces(running):
    return [tuple(map(float, line.split())) for line in
            re.findall(r"^force: (?:list )?(\S+ \S+ \S+)$", running.read(), re.M)]


@pytest.mark.parametrize("framing", ["fudi", "slip", "length"])
def test_a_client_gets_positions_and_gives_forces(pd, framing):
    running = pd(*SERVER)
    port = int(running.wait_for(r"^info: status open (\d+)$"))
    peer = Peer(port, framing)
    welcome = peer.hello()
    assert welcome[2] == "patch" and welcome[5] == 3
    assert peer.wait("status", "workspace")[2:] == [-80, -60, -35, 80, 60, 35]
    peer.send("subscribe", "pos", 20.0)
    assert peer.wait("pos")[3:] == [10, -20, 30]
    peer.send("start", "force")
    peer.hold(1.2, "force", 1.0, -2.0, 0.5)
    assert forces(running)[-1] == pytest.approx((1, -2, 0.5), abs=1e-3)
    peer.hold(0.2, "force", 1e20, 0.0, 0.0)
    assert max(sum(c * c for c in force) for force in forces(running)) <= 9 * (1 + 1e-5)
    silent = time.monotonic()
    while forces(running)[-1] != (0, 0, 0):
        assert time.monotonic() < silent + SILENCE_S + STALL_S + 0.1
        time.sleep(0.01)
    peer.close()
    running.wait_for(r"^info: client .* left$")


def test_a_token_file_beside_the_patch(pd, tmp_path):
    (tmp_path / "token.txt").write_text("sixteen bytes ok\n")
    lines = list(SERVER)
    lines[1] = lines[1].replace("msg 10 40 ", "msg 10 40 token token.txt \\, ")
    running = pd(*lines)
    port = int(running.wait_for(r"^info: status open (\d+)$"))
    with pytest.raises(AssertionError):
        Peer(port).hello()
    assert Peer(port).hello(token="sixteen bytes ok")


def test_dump_tells_address_and_emergency_stop(pd):
    lines = list(SERVER)
    lines[1] = lines[1].replace(" \\, open;", " \\, open \\, dump \\, estop \\, dump \\, motors 1 \\, motors 1 "
                                "\\, get estop \\, listen 192.0.2.1 \\, get listen \\, close;")
    running = pd(*lines)
    running.wait_for(r"^info: status closed$")
    assert re.findall(r"^info: ((?:status estop|estop|listen) .*)$", running.read(), re.M) == [
        "listen loopback", "estop 0", "status estop 1", "listen loopback", "estop 1", "status estop 0",
        "estop 0", "listen 192.0.2.1"]


def test_another_address_without_a_token_is_refused(pd):
    lines = list(SERVER)
    lines[1] = lines[1].replace("msg 10 40 ", "msg 10 40 listen 0.0.0.0 \\, ")
    running = pd(*lines)
    running.wait_for(r"haptic_server.*needs a token file")


@pytest.fixture
def program(tmp_path):
    running = Program(tmp_path)
    yield running
    running.process.kill()
    running.process.wait()


def test_vanilla_netsend_in_text(pd, program):
    running = pd("#X obj 10 10 loadbang;", "#X obj 10 40 delay 200;", f"#X msg 10 70 connect 127.0.0.1 "
                 f"{program.port} \\, send hap hello 1 vanilla control \\, send hap start force;",
                 "#X obj 10 200 netsend;", "#X obj 200 40 metro 20;", "#X msg 200 70 send hap force 1 -2 0.5;",
                 "#X obj 200 200 print heard;", "#X obj 200 10 delay 500;",
                 "#X connect 0 0 1 0;", "#X connect 1 0 2 0;", "#X connect 2 0 3 0;",
                 "#X connect 0 0 7 0;", "#X connect 7 0 4 0;", "#X connect 4 0 5 0;", "#X connect 5 0 3 0;",
                 "#X connect 3 1 6 0;")
    running.wait_for(r"^heard: hap welcome 1 simulated - 3 3 1000$")
    running.wait_for(r"^heard: hap status started force vanilla$")
    program.wait_for_force(2.28)  # of 2.29 N: Pd may take its time to start
    now = time.monotonic()
    time.sleep(0.2)
    os.kill(running.process.pid, signal.SIGSTOP)
    stopped = time.monotonic()
    time.sleep(1)
    rows = program.end()
    assert near(rows, now) == pytest.approx((1, -2, 0.5), abs=0.05)
    assert last_force(rows) <= stopped + SILENCE_S + STALL_S


def test_vanilla_oscformat_through_slip(pd, program):
    running = pd("#X obj 10 10 loadbang;", "#X obj 10 40 delay 200;", f"#X msg 10 70 connect 127.0.0.1 "
                 f"{program.port};", "#X obj 10 200 netsend -b;",
                 "#X obj 200 10 t b b b;",
                 "#X msg 400 70 1 vanilla control;", "#X obj 400 100 oscformat -f fss hap hello;",
                 "#X msg 300 70 list force;", "#X obj 300 100 oscformat -f s hap start;",
                 "#X obj 200 70 metro 20;", "#X msg 200 100 1 -2 0.5;", "#X obj 200 130 oscformat hap force;",
                 "#X obj 200 160 slip;", "#X obj 200 180 list prepend send;", "#X obj 200 190 list trim;",
                 "#X obj 100 10 delay 400;",
                 "#X connect 0 0 1 0;", "#X connect 1 0 2 0;", "#X connect 2 0 3 0;",
                 "#X connect 0 0 15 0;", "#X connect 15 0 4 0;",
                 "#X connect 4 0 9 0;", "#X connect 4 1 7 0;", "#X connect 4 2 5 0;",
                 "#X connect 5 0 6 0;", "#X connect 6 0 12 0;", "#X connect 7 0 8 0;", "#X connect 8 0 12 0;",
                 "#X connect 9 0 10 0;", "#X connect 10 0 11 0;", "#X connect 11 0 12 0;",
                 "#X connect 12 0 13 0;", "#X connect 13 0 14 0;", "#X connect 14 0 3 0;")
    program.wait_for_force(2.28)
    now = time.monotonic()
    time.sleep(0.2)
    running.close()
    closed = time.monotonic()
    time.sleep(0.4)
    rows = program.end()
    assert near(rows, now) == pytest.approx((1, -2, 0.5), abs=0.05)
    assert last_force(rows) <= closed + STALL_S
