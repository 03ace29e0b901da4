"""[phantom net HOST PORT] in unmodified Pd against haptic_server, over lines that are good and bad."""
import time

import pytest

from live_pd import Live, Patch
from peer import some_force, wait_until


@pytest.fixture
def world(program, tmp_path):
    """A server, a line to it and a Pd, that opens the device when it is told to."""
    (tmp_path / "path").write_text("0 0 0 0\n1000 20 0 0\n2000 0 0 0\n")
    server = program("--hand", "rigid", "--path", str(tmp_path / "path"))
    with Live(tmp_path, Patch(f"net 127.0.0.1 {server.relay.port}")) as pd:
        pd.wait_for_patch()
        yield server, pd


def opened(pd):
    pd.tell_phantom("open")
    pd.wait_for(r"^info: status open net")


def push(server, pd, force_n=1.0):
    """Motors on; the patch's force, said again and again, as a patch does, until it is there. A
    machine that stalls takes it away for half a second, or longer."""
    for said in range(3000):
        if said % 150 == 0:
            pd.tell_phantom("motors 1")
        pd.tell_phantom(f"list {force_n} 0 0")
        time.sleep(0.02)
        if abs(server.force() - force_n) < 0.01:
            return
    raise AssertionError(pd.read()[-3000:])


def test_positions_come_forces_go_and_quitting_ends_them(world):
    server, pd = world
    pd.tell_phantom("motors 1")
    opened(pd)
    pd.wait_until(lambda: len(set(pd.positions())) > 3)
    for _ in range(40):  # no force before motors 1, whatever was said before open
        pd.tell_phantom("list 1 0 0")
        time.sleep(0.02)
        assert server.force() == 0
    pd.tell_phantom("get motors")
    pd.wait_for(r"^info: motors 0")
    push(server, pd)
    pd.tell_phantom("list 100 0 0")
    pd.wait_for(r"^info: status clipped 1")
    pd.tell_phantom("estop")
    pd.tell_phantom("get motors")
    pd.wait_until(lambda: pd.read().count("\ninfo: motors 0") == 2)
    pd.tell_phantom("quit")
    pd.process.wait(60)
    server.wait_for_none()
    server.end()


def test_a_lost_connection_is_a_fault_and_its_return_switches_no_motor_on(world):
    server, pd = world
    opened(pd)
    push(server, pd)
    server.relay.cut()
    server.wait_for_none()
    cut = time.monotonic()
    for _ in range(40):  # the patch goes on
        pd.tell_phantom("list 1 0 0")
        time.sleep(0.05)
    back = time.monotonic()
    push(server, pd)
    assert not some_force(server.end(), cut, back)


def test_a_server_with_eight_clients_says_that_it_is_full(world):
    server, pd = world
    peers = []
    for _ in range(8):
        peers.append(server.peer())
        peers[-1].hello()
    pd.tell_phantom("open")
    said = pd.wait_for(r"^error: .*$")
    assert "refused the connection" in said and "eight clients" in said


def test_no_server_and_wrong_addresses_are_one_sentence_each(tmp_path):
    with Live(tmp_path, Patch("net 127.0.0.1 70000")) as pd:
        pd.wait_for("port 70000: expected 1..65535")
        pd.wait_for_patch()
        pd.tell_phantom("backend net 127.0.0.1 x")
        pd.wait_for("port x: expected 1..65535")
        pd.tell_phantom("backend net 127.0.0.1 9")
        pd.tell_phantom("open")
        pd.wait_for("start haptic_server there")
