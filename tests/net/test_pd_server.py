"""Unmodified Pd: [haptic_server] in a patch, and Pd's own objects as clients of the program."""
import os
import re
import signal

import pytest

from peer import Peer, wait_until


SERVER = ["#X obj 10 10 loadbang;", "#X msg 10 40 port 0 \\, workspace -80 -60 -35 80 60 35 \\, "
          "10 -20 30 \\, open;", "#X obj 10 80 haptic_server -forcemax 3;", "#X obj 10 120 print force;",
          "#X obj 200 120 print info;", "#X connect 0 0 1 0;", "#X connect 1 0 2 0;",
          "#X connect 2 0 3 0;", "#X connect 2 1 4 0;"]


def forces(running):
    return [tuple(map(float, line.split())) for line in
            re.findall(r"^force: (?:list )?(\S+ \S+ \S+)$", running.read(), re.M)]


def test_a_client_gets_positions_and_gives_forces_which_end_with_it(pd):
    running = pd(*SERVER)
    peer = Peer(int(running.wait_for(r"^info: status open (\d+)$")))
    welcome = peer.hello()
    assert welcome[2] == "patch" and welcome[5] == 3
    assert peer.wait("status", "workspace")[2:] == [-80, -60, -35, 80, 60, 35]
    peer.send("subscribe", "pos", 20.0)
    assert peer.wait("pos")[3:] == [10, -20, 30]
    peer.send("start", "force")
    for asked, felt in (((1.0, -2.0, 0.5), (1, -2, 0.5)), ((1e20, 0.0, 0.0), (3, 0, 0))):
        wait_until(lambda: peer.send("force", *asked) or
                   forces(running) and forces(running)[-1] == pytest.approx(felt, abs=1e-3))
    assert max(sum(c * c for c in force) for force in forces(running)) <= 9 * (1 + 1e-5)
    running.wait_for(r"^info: status clipped 1 \S+ 3$")
    wait_until(lambda: forces(running)[-1] == (0, 0, 0))  # silent
    peer.close()
    running.wait_for(r"^info: client .* left$")


def test_another_address_wants_a_token_which_is_a_file_beside_the_patch(pd, token):
    lines = list(SERVER)
    lines[1] = lines[1].replace("msg 10 40 ", "msg 10 40 listen 0.0.0.0 \\, open \\, listen loopback "
                                "\\, token token \\, ")
    running = pd(*lines)
    running.wait_for(r"haptic_server.*needs a token file")
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


def test_vanilla_netsend_in_text(pd, program):
    server = program()
    running = pd("#X obj 10 10 loadbang;", "#X obj 10 40 delay 200;", f"#X msg 10 70 connect 127.0.0.1 "
                 f"{server.port} \\, send hap hello 1 vanilla control \\, send hap start force;",
                 "#X obj 10 200 netsend;", "#X obj 200 40 metro 20;", "#X msg 200 70 send hap force 1 -2 0.5;",
                 "#X obj 200 200 print heard;", "#X obj 200 10 delay 500;",
                 "#X connect 0 0 1 0;", "#X connect 1 0 2 0;", "#X connect 2 0 3 0;",
                 "#X connect 0 0 7 0;", "#X connect 7 0 4 0;", "#X connect 4 0 5 0;", "#X connect 5 0 3 0;",
                 "#X connect 3 1 6 0;")
    running.wait_for(r"^heard: hap welcome 1 simulated - 3 3 1000$")
    running.wait_for(r"^heard: hap status started force vanilla$")
    server.wait_for_force(2.28)  # of 2.29 N
    os.kill(running.process.pid, signal.SIGSTOP)
    server.wait_for_none()
    assert max(force for _, force in server.end()) == pytest.approx((1, -2, 0.5), abs=0.05)


def test_vanilla_oscformat_through_slip(pd, program):
    server = program()
    running = pd("#X obj 10 10 loadbang;", "#X obj 10 40 delay 200;", f"#X msg 10 70 connect 127.0.0.1 "
                 f"{server.port};", "#X obj 10 200 netsend -b;",
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
    server.wait_for_force(2.28)
    running.close()
    server.wait_for_none()
    assert max(force for _, force in server.end()) == pytest.approx((1, -2, 0.5), abs=0.05)
