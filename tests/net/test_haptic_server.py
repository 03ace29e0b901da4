"""The haptic_server program from outside: case P16, signals, tokens, peers that are cut off."""
import os
import random
import signal
import socket
import subprocess
import time

import pytest

from peer import PROGRAM, Peer, Program, last_force, near, osc, size, slip, with_length

# A machine that stalls hears the last message late; the clock of the rule starts when it is heard.
SILENCE_S, STALL_S = 0.5, 0.15


@pytest.fixture
def program(tmp_path):
    running = []

    def start(*options, **more):
        folder = tmp_path / str(len(running))
        folder.mkdir()
        running.append(Program(folder, *options, **more))
        return running[-1]
    yield start
    for one in running:
        one.process.kill()
        one.process.wait()


def pushing(server, framing="length", force=(1.0, -2.0, 0.5)):
    peer = server.peer(framing)
    peer.hello()
    peer.send("start", "force")
    peer.hold(0.8, "force", *force)
    return peer


@pytest.mark.parametrize("framing", ["fudi", "slip", "length"])
def test_three_framings_give_the_same_force(program, framing):
    server = program()
    peer = pushing(server, framing)
    now = time.monotonic()
    peer.hold(0.2, "force", 1.0, -2.0, 0.5)
    peer.send("ping", 7)
    assert peer.wait("pong", 7)
    peer.close()
    rows = server.end()
    assert near(rows, now) == pytest.approx((1, -2, 0.5), abs=0.05)


def test_the_bytes_of_the_specification(program):
    packet = osc("force", 1.0, -2.0, 0.5)
    assert len(packet) == 32 and len(slip(packet)) == 35


def test_bad_packets_do_not_keep_it_from_answering(program):
    server = program()
    good = server.peer()
    good.hello()
    packet = osc("force", 1.0, -2.0, 0.5)
    chance = random.Random(16)
    for data in (slip(packet[:17]), with_length(packet[:17]), with_length(packet)[:20],
                 with_length(b"x" * 70000), slip(b"x" * 70000), b"x" * 70000 + b";",
                 *(bytes(chance.randrange(256) for _ in range(chance.randrange(2000)))
                   for _ in range(100))):
        bad = socket.create_connection(("127.0.0.1", server.port), timeout=20)
        try:
            bad.sendall(data)
        except OSError:
            pass
        bad.close()
        good.send("ping", 3)
        assert good.wait("pong", 3)
    rows = server.end()
    assert last_force(rows) is None


def test_70_kB_is_one_bad_packet_in_each_framing(program):
    server = program()
    for framing, data in (("length", with_length(b"x" * 70000)), ("slip", slip(b"x" * 70000)),
                          ("fudi", b"x" * 70000 + b";")):
        peer = server.peer(framing)
        peer.hello()
        peer.socket.sendall(data)
        assert "65536" in peer.wait("error", "bad")[2]
        peer.send("ping", 5)
        assert peer.wait("pong", 5)
        peer.close()


def test_a_second_controller_is_busy_until_the_first_is_gone(program):
    server = program()
    first = pushing(server)
    second = server.peer()
    second.hello()
    second.send("start", "force")
    assert second.wait("error", "busy")
    first.close()
    assert second.wait("status", "stopped")
    second.send("start", "force")
    assert second.wait("status", "started")


def test_silence_of_half_a_second_ends_the_force(program):
    server = program()
    peer = pushing(server)
    silent = time.monotonic()
    time.sleep(1)
    rows = server.end()
    assert size(near(rows, silent)) > 2
    assert last_force(rows) <= silent + SILENCE_S + STALL_S
    assert last_force(rows) >= silent + 0.3
    assert peer.wait("bye")


def test_a_stopped_client_and_a_killed_one_leave_no_force(program):
    client = f"""
import sys; sys.path.insert(0, {os.path.dirname(__file__)!r})
from peer import Peer
peer = Peer(int(sys.argv[1])); peer.hello(); peer.send("start", "force")
while True: peer.hold(1, "force", 2.0, 0.0, 0.0)
"""
    for end, allowed in ((signal.SIGSTOP, SILENCE_S), (signal.SIGKILL, 0.1)):
        server = program()
        process = subprocess.Popen(["/usr/bin/python3", "-c", client, str(server.port)])
        try:
            server.wait_for_force(1.5)
            now = time.monotonic()
            process.send_signal(end)
            time.sleep(1)
        finally:
            process.kill()
            process.wait()
        rows = server.end()
        assert size(near(rows, now - 0.1)) > 1
        assert last_force(rows) <= now + allowed + STALL_S


def test_it_listens_on_loopback_only(program):
    server = program()
    found = []
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        with open(table) as file:
            for line in file.readlines()[1:]:
                address, port = line.split()[1].split(":")
                if int(port, 16) == server.port and line.split()[3] == "0A":
                    found.append(address)
    assert "0100007F" in found
    assert set(found) <= {"0100007F", "00000000000000000000000001000000"}
    if len(found) == 2:
        assert Peer(server.port, host="::1").hello()


def test_nine_clients_are_too_many(program):
    server = program()
    peers = [server.peer() for _ in range(8)]
    for peer in peers:
        peer.hello()
    ninth = server.peer()
    assert ninth.ended(10)
    peers[0].close()
    end = time.monotonic() + 20
    while True:  # until the server has seen that one is gone
        try:
            assert server.peer().hello()
            break
        except (AssertionError, OSError):
            assert time.monotonic() < end
            time.sleep(0.05)


def test_an_emergency_stop_at_the_server(program):
    server = program()
    peer = pushing(server)
    stopped = time.monotonic()
    server.signal(signal.SIGUSR1)
    assert peer.wait("status", "stopped", "estop")
    peer.send("start", "force")
    assert peer.wait("error", "estop")
    peer.hold(0.3, "force", 2.0, 0.0, 0.0)
    server.signal(signal.SIGUSR2)
    peer.hold(0.3, "force", 2.0, 0.0, 0.0)
    released = time.monotonic()
    peer.send("start", "force")
    peer.hold(0.5, "force", 2.0, 0.0, 0.0)
    rows = server.end()
    assert last_force([row for row in rows if row[0] < released], after=stopped + STALL_S) is None
    assert last_force(rows, after=released + 0.3) is not None


def test_the_end_of_the_program_tells_everybody(program):
    server = program()
    peer = pushing(server)
    server.end()
    assert peer.wait("bye", "closing")
    assert peer.ended()


def test_once_ends_with_the_last_client(program):
    server = program("--once")
    peer = server.peer()
    peer.hello()
    peer.close()
    assert server.process.wait(30) == 0


def refused(*options):
    run = subprocess.run([PROGRAM, *options], capture_output=True, text=True, timeout=60)
    assert run.returncode != 0 and run.stderr.count("\n") == 1, run.stderr
    assert run.stderr.startswith("haptic_server: ")
    return run.stderr


def test_another_address_needs_a_token(program, tmp_path):
    assert "token" in refused("--port", "0", "--listen", "0.0.0.0")
    short = tmp_path / "short"
    short.write_text("fifteen bytes..\n")
    assert "16" in refused("--port", "0", "--listen", "0.0.0.0", "--token", str(short))
    assert "read" in refused("--port", "0", "--token", str(tmp_path / "none"))
    token = tmp_path / "token"
    token.write_text("sixteen bytes ok\n")
    token.chmod(0o600)
    assert "numbers" in refused("--port", "0", "--listen", "elsewhere", "--token", str(token))
    away = refused("--port", "0", "--listen", "192.0.2.1", "--token", str(token))  # RFC 5737: nobody's
    assert "an address of this computer" in away and "another port" not in away
    server = program("--listen", "127.0.0.1", "--token", str(token))
    with pytest.raises(AssertionError):
        server.peer().hello()
    assert server.peer().hello(token="sixteen bytes ok")
    for _ in range(2):
        with pytest.raises(AssertionError):
            server.peer().hello(token="sixteen bytes kO")
    peer = server.peer()
    assert peer.hello(token="sixteen bytes ok")  # one in between begins the count anew


def test_three_wrong_tokens_lock_out(program, tmp_path):
    token = tmp_path / "token"
    token.write_text("sixteen bytes ok\n")
    server = program("--token", str(token))
    for _ in range(3):
        peer = server.peer()
        peer.send("hello", 1, "guess", "control", "guess")
        assert peer.wait("error", "token")
    peer = server.peer()
    peer.send("hello", 1, "guess", "control", "sixteen bytes ok")
    assert peer.wait("error", "locked")


def test_wrong_options_are_one_sentence():
    assert refused("--dance") == refused("--dance", "3") == "haptic_server: there is no option --dance; --help shows all\n"
    assert refused("--port", "70000").startswith("haptic_server: --port 70000: expected 0..65535; 0 takes")
    assert refused("--hand", "soft").endswith(": expected free, rigid, spring or person: holds the handle of sim (spring)\n")
    assert refused("--device", "").rstrip().endswith("WHICH is an index, a serial number or a path (sim)")
    assert refused("--port") == "haptic_server: --port lacks its value\n"
    assert "driver" in refused("--device", "wheelbarrow")
    assert "trace" in refused("--port", "0", "--trace", "/nowhere/trace.csv")


def test_a_port_that_is_taken(program):
    server = program()
    assert str(server.port) in refused("--port", str(server.port))


def test_stress_feedback_is_a_spring_at_the_device(program, tmp_path):
    path = tmp_path / "path"
    path.write_text("0 13 0 0\n")
    server = program("--hand", "rigid", "--path", str(path))
    peer = server.peer()
    peer.hello()
    peer.send("gains", 0.0, 400.0, 0.0, 4.0)
    peer.send("anchor", 10.0, 0.0, 0.0)
    peer.send("start", "spring")
    for i in range(10):
        peer.send("feedback", i, 0.5)
        time.sleep(0.1)
    now = time.monotonic()
    peer.send("ping", 1)
    peer.wait("pong")
    time.sleep(0.1)
    rows = server.end()
    assert near(rows, now)[0] == pytest.approx(-0.6, rel=1e-3)  # P21


def test_dragging_a_control_point(program, tmp_path):
    path = tmp_path / "path"
    path.write_text("0 0 0 0 0\n1500 0 0 0 0\n1500 0 0 0 1\n2500 10 0 0 1\n3000 10 0 0 1\n3000 10 0 0 0\n")
    server = program("--hand", "rigid", "--path", str(path))
    peer = server.peer()
    peer.hello()
    for message in (("cp/begin", 1), ("cp/set", 0, 2.0, 0.0, 0.0), ("cp/end",), ("start", "spring")):
        peer.send(*message)
    seen = []
    for i in range(40):
        peer.send("ping", i)
        time.sleep(0.1)
        peer.take(0.001)
        seen += peer.waiting
        peer.waiting = []
    assert ["grab", 0, 1] in seen and ["grab", 0, 0] in seen
    moves = [message for message in seen if message[0] == "cp/move"]
    assert len(moves) > 30
    assert moves[-1] == ["cp/move", 0, pytest.approx(12), 0, 0]
