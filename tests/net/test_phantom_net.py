"""[phantom net HOST PORT] in unmodified Pd against haptic_server, over lines that are good and bad."""
import os
import pathlib
import signal
import sys
import time

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "devices/live"))
from live_pd import Live, Patch  # noqa: E402
from peer import Program, largest, last_force  # noqa: E402
from relay import Relay  # noqa: E402

SILENCE_S, STALL_S = 0.5, 0.15


class World:
    """Server, relay and Pd; Pd opens the device when it is told to."""

    def __init__(self, folder):
        self.folder = folder
        (folder / "path").write_text("0 0 0 0\n1000 20 0 0\n2000 0 0 0\n")
        self.server = Program(folder, "--hand", "rigid", "--path", str(folder / "path"))
        self.relay = Relay(self.server.port)
        patch = Patch(f"net 127.0.0.1 {self.relay.port}")
        self.pd = Live(folder, patch)

    def open(self):
        self.pd.wait_for_patch()
        self.pd.tell_phantom("open")
        self.pd.wait_for(r"^info: status open net")

    def push(self, force_n=1.0):
        """Motors on; the patch's force, said again and again, as a patch does, until it is there. A
        machine that stalls takes it away for half a second, or longer."""
        end = time.monotonic() + 60
        while self.server.force() < 0.85 * force_n:
            assert time.monotonic() < end, self.pd.read()[-3000:]
            self.pd.tell_phantom("motors 1")
            pause = time.monotonic() + 3
            while time.monotonic() < pause and self.server.force() < 0.85 * force_n:
                self.pd.tell_phantom(f"list {force_n} 0 0")
                time.sleep(0.02)

    def close(self):
        self.pd.__exit__()
        self.relay.close()
        self.server.process.kill()
        self.server.process.wait()


@pytest.fixture
def world(tmp_path):
    made = World(tmp_path)
    yield made
    made.close()


def test_positions_come_and_forces_go(world):
    world.open()
    world.pd.wait_until(lambda: len(set(world.pd.positions())) > 0)
    world.push()
    now = time.monotonic()
    world.pd.tell_phantom("quit")
    world.pd.process.wait(30)
    quit_s = time.monotonic()
    time.sleep(0.3)
    rows = world.server.end()
    assert largest(rows, now - 1, now) == pytest.approx(1, abs=0.15)
    assert last_force(rows) <= quit_s + STALL_S


def test_the_fault_of_a_lost_connection_and_the_way_back(world):
    world.open()
    world.push()
    world.relay.cut()
    cut = time.monotonic()
    for _ in range(40):  # the patch goes on
        world.pd.tell_phantom("list 1 0 0")
        time.sleep(0.05)
    back = time.monotonic()
    world.push()
    rows = world.server.end()
    assert largest(rows, cut - 1, cut) > 0.8
    between = [row for row in rows if cut + STALL_S < row[0] < back]
    assert last_force(between) is None  # the motors stay off until they are switched on
    assert last_force(rows, after=back) is not None


@pytest.mark.parametrize("end", [signal.SIGSTOP, signal.SIGKILL])
def test_a_pd_that_hangs_or_dies_leaves_no_force(world, end):
    world.open()
    world.push()
    now = time.monotonic()
    os.kill(world.pd.process.pid, end)
    time.sleep(1)
    rows = world.server.end()
    assert largest(rows, now - 1, now) > 0.8
    assert last_force(rows) <= now + SILENCE_S + STALL_S


def test_a_line_that_stalls_both_ways(world):
    world.open()
    world.push()
    world.relay.stalled = True
    stalled = time.monotonic()
    for _ in range(20):
        world.pd.tell_phantom("list 1 0 0")
        time.sleep(0.05)
    passed = time.monotonic()
    assert "no position has come from the haptic server" in world.pd.read()
    world.relay.stalled = False  # what was held back comes at once
    time.sleep(0.5)
    rows = world.server.end()
    assert last_force([row for row in rows if row[0] < passed]) <= stalled + SILENCE_S + STALL_S


def test_the_server_stops_the_motors_and_pd_says_so(world):
    world.open()
    world.push()
    world.server.signal(signal.SIGUSR1)
    stopped = time.monotonic()
    world.pd.wait_for("estop")
    for _ in range(10):
        world.pd.tell_phantom("list 1 0 0")
        time.sleep(0.05)
    rows = world.server.end()
    assert last_force(rows) <= stopped + STALL_S


def test_the_second_in_control_is_told_that_there_is_a_first(world):
    other = world.server.peer()
    other.hello()
    other.send("start", "force")
    world.open()
    end = time.monotonic() + 30
    while "has failed" not in world.pd.read():
        assert time.monotonic() < end, world.pd.read()[-3000:]
        world.pd.tell_phantom("motors 1")
        other.hold(0.7, "force", 0.0, 0.0, 0.0)
        world.pd.tell_phantom("list 1 0 0")
        other.hold(0.3, "force", 0.0, 0.0, 0.0)
    assert "another client is in control" in world.pd.wait_for(r"^error: .*has failed.*$")


def test_a_server_with_eight_clients_says_that_it_is_full(world):
    peers = [world.server.peer() for _ in range(8)]
    for peer in peers:
        peer.hello()
    world.pd.wait_for_patch()
    world.pd.tell_phantom("open")
    said = world.pd.wait_for(r"^error: .*$")
    assert "does not take the connection" in said and "eight clients" in said


def test_no_server_is_one_sentence(tmp_path):
    with Live(tmp_path, Patch("net 127.0.0.1 9")) as pd:
        pd.wait_for_patch()
        pd.tell_phantom("open")
        pd.wait_for("start haptic_server there")


def test_wrong_addresses_are_refused(tmp_path):
    with Live(tmp_path, Patch("net 127.0.0.1 70000")) as pd:
        pd.wait_for("no whole number from 1 to 65535")
        pd.wait_for_patch()
        pd.tell_phantom("backend net 127.0.0.1 x")
        pd.wait_for("the port x is no whole number")
