"""The haptic_server program from outside: case P16, signals, tokens, peers that are cut off."""
import datetime
import os
import signal
import subprocess

import pytest

from peer import HOLD_S, PROGRAM, Peer, longest_hold_s, some_force, wait_until


def test_a_force_arrives_in_its_direction_and_the_end_tells_everybody(program):
    server = program()
    peer = server.peer()
    peer.hello()
    peer.send("start", "force")
    wait_until(lambda: peer.send("force", 1.0, -2.0, 0.5) or server.force() > 2.29)  # of 2.2913 N
    peer.send("ping", 7)
    assert peer.wait("pong", 7)
    rows = server.end()
    assert max(force for _, force in rows) == pytest.approx((1, -2, 0.5), abs=0.01)
    assert peer.wait("bye", "closing")
    assert peer.ended()


def test_a_clipped_force_is_told_to_the_client_and_each_line_of_the_log_has_its_time(program):
    begun = datetime.datetime.now().replace(microsecond=0)
    server = program()
    peer = server.in_control()
    peer.send("force", 100.0, 0.0, 0.0)
    asked, limit = peer.wait("status", "clipped", 1)[3:]
    assert asked > limit == 3
    server.end()
    lines = server.log.splitlines()
    assert all(begun <= datetime.datetime.fromisoformat(line[:19]) <= datetime.datetime.now() for line in lines)
    assert sum("the force is clipped: " in line for line in lines) == 1


@pytest.mark.parametrize("end", [signal.SIGSTOP, signal.SIGKILL])
def test_a_stopped_client_and_a_killed_one_leave_no_force(program, end):
    server = program()
    client = f"""
import sys; sys.path.insert(0, {os.path.dirname(__file__)!r})
from peer import Peer
peer = Peer({server.port}); peer.hello(); peer.send("start", "force"); peer.push(lambda: False)
"""
    process = subprocess.Popen(["/usr/bin/python3", "-c", client])
    try:
        server.wait_for_force(0.9)
        process.send_signal(end)
        server.wait_for_none()
    finally:
        process.kill()
        process.wait()
    assert longest_hold_s(server.end()) <= HOLD_S


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
        assert server.peer(host="::1").hello()


def test_an_emergency_stop_at_the_server_holds_until_it_is_released_there_and_started(program):
    server = program()
    peer = server.in_control()
    server.signal(signal.SIGUSR1)
    assert peer.wait("status", "stopped", "estop")
    peer.send("start", "force")
    assert peer.wait("error", "estop")
    server.wait_for_none()
    server.signal(signal.SIGUSR2)

    def released():
        peer.send("start", "force")
        peer.take(0.02)
        return ["status", "started", "force", "peer"] in peer.waiting
    wait_until(released)
    peer.push(lambda: server.force() > 0.9)
    server.end()


def test_once_ends_with_the_last_client(program):
    server = program("--once")
    peer = server.peer()
    peer.hello()
    peer.close()
    assert server.process.wait(60) == 0


def refused(*options):
    run = subprocess.run([PROGRAM, *options], capture_output=True, text=True, timeout=60)
    assert run.returncode != 0 and run.stderr.count("\n") == 1, run.stderr
    assert run.stderr.startswith("haptic_server: ")
    return run.stderr


def test_another_address_needs_a_token(program, tmp_path, token):
    assert "token" in refused("--port", "0", "--listen", "0.0.0.0")
    short = tmp_path / "short"
    short.write_text("fifteen bytes..\n")
    assert "16" in refused("--port", "0", "--listen", "0.0.0.0", "--token", str(short))
    assert "read" in refused("--port", "0", "--token", str(tmp_path / "none"))
    assert "numeric" in refused("--port", "0", "--listen", "elsewhere", "--token", token)
    away = refused("--port", "0", "--listen", "192.0.2.1", "--token", token)  # RFC 5737: nobody's
    assert "an address of this computer" in away and "another port" not in away
    server = program("--listen", "127.0.0.1", "--token", token)
    for wrong in ("", "sixteen bytes kO"):
        with pytest.raises(AssertionError):
            server.peer().hello(token=wrong)
    assert server.peer().hello(token="sixteen bytes ok")


def test_wrong_options_are_one_sentence(program):
    assert refused("--dance") == refused("--dance", "3") == "haptic_server: unknown option --dance; see --help\n"
    assert refused("--port", "70000").startswith("haptic_server: --port 70000: expected 0..65535; 0: any free")
    assert refused("--hand", "soft").endswith(": expected free, rigid, spring or person: how the hand holds sim (spring)\n")
    assert refused("--device", "").rstrip().endswith("WHICH is an index, a serial number or a path (sim)")
    assert refused("--port") == "haptic_server: --port needs a value\n"
    assert "driver" in refused("--device", "wheelbarrow")
    assert "trace" in refused("--port", "0", "--trace", "/nowhere/trace.csv")
    taken = str(program().port)
    assert taken in refused("--port", taken)


def test_dragging_a_control_point_along_the_path_of_a_file(program, tmp_path):
    path = tmp_path / "path"  # ms, mm, buttons
    path.write_text("0 0 0 0 0\n1500 0 0 0 0\n1500 0 0 0 1\n2500 10 0 0 1\n3000 10 0 0 1\n3000 10 0 0 0\n")
    peer = program("--hand", "rigid", "--path", str(path)).peer()
    peer.hello()
    for message in (("cp/begin", 1), ("cp/set", 0, 2.0, 0.0, 0.0), ("cp/end",), ("start", "spring")):
        peer.send(*message)
    wait_until(lambda: peer.send("ping", 1) or peer.take(0.1) and ["grab", 0, 0] in peer.waiting)
    assert ["grab", 0, 1] in peer.waiting
    moves = [message for message in peer.waiting if message[0] == "cp/move"]
    assert len(moves) > 3
    assert moves[-1] == ["cp/move", 0, pytest.approx(12), 0, 0]
