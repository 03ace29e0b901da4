"""Positions as datagrams, from outside: haptic_server --udp, [phantom net ... udp 1], a lossy line."""
import os
import socket
import subprocess
import sys
import time

import pytest

from live_pd import Live, Patch
from peer import Peer, osc, parse, size


class Receiver:
    """A client that has asked for datagrams."""

    def __init__(self, port, host="127.0.0.1", token=""):
        self.peer = Peer(port, host=host)
        self.peer.hello(token=token)
        self.peer.send("subscribe", "pos", 200.0)
        self.peer.send("udp", 1)
        _, _, self.key, self.port = self.peer.wait("status", "udp")
        self.door = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.server, self.newest = (host, self.port), -1

    def probe(self):
        self.door.sendto(osc("udp", self.key, self.newest), self.server)

    def take(self, seconds):
        """What comes by UDP in that time, probing; pings keep the connection."""
        messages, end, due = [], time.monotonic() + seconds, 0.0
        while (now := time.monotonic()) < end:
            if now >= due:
                self.probe()
                self.peer.send("ping", 1)
                due = now + 0.05
            self.door.settimeout(0.02)
            try:
                messages.append(parse(self.door.recv(2048)))
                self.newest = max(self.newest, messages[-1][1])
            except TimeoutError:
                pass
        return messages

    def take_until(self, true, seconds=60):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            messages = self.take(0.2)
            if true(messages):
                return messages
        raise AssertionError("in vain")


def test_positions_come_in_order_with_the_key_and_datagrams_move_no_motor(program):
    server = program("--udp", "--hand", "rigid")
    client = Receiver(server.port)
    assert 0 < client.key < 2 ** 31
    messages = client.take_until(lambda found: len(found) > 10)
    assert {(message[0], message[-1]) for message in messages} == {("pos", client.key)}
    numbers = [message[1] for message in messages]
    assert numbers == sorted(set(numbers))
    client.peer.send("start", "force")
    client.peer.wait("status", "started")
    stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    stranger.settimeout(0.5)
    for packet in (osc("udp", client.key ^ 1, -1), osc("udp", 0, -1), b"", bytes(3000), osc("pos", 1)):
        stranger.sendto(packet, client.server)
    for packet in (osc("force", 1, 2.0, 0.0, 0.0), osc("force", 2.0, 0.0, 0.0), osc("start", "force"),
                   osc("gains", 0.0, 500.0, 0.0, 5.0), osc("hello", 1, "me", "control", "")):
        client.door.sendto(packet, client.server)
    with pytest.raises(TimeoutError):
        stranger.recv(2048)
    client.take(0.3)
    client.peer.send("ping", 77)
    client.peer.wait("pong", 77)  # and TCP goes on
    assert all(size(force) == 0 for _, force in server.end())


def test_a_patch_has_positions_while_tcp_is_held_up(program, tmp_path):
    """The relay carries TCP alone: what comes while it is stalled came as datagrams."""
    path = tmp_path / "path"
    path.write_text("".join(f"{i} {i % 2000 / 100} 0 0\n" for i in range(0, 600000, 100)))
    relay = program("--udp", "--hand", "rigid", "--path", str(path)).relay
    with Live(tmp_path, Patch(f"net 127.0.0.1 {relay.port} udp 1")) as pd:
        pd.wait_for_patch()
        pd.tell_phantom("open")
        pd.wait_for(r"^info: status open net")
        pd.wait_until(lambda: len(set(pd.positions())) > 3)
        relay.stalled = True
        time.sleep(0.7)  # longer than what makes a failure of a device without positions
        before = len(pd.positions())
        pd.wait_until(lambda: len(set(pd.positions()[before:])) > 3)
        assert "does not answer" not in pd.read()


CLIENT = f"""
import sys; sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})
import conftest
from test_datagrams import Receiver
client = Receiver(int(sys.argv[1]), host=sys.argv[2], token="sixteen bytes ok")
client.take_until(lambda found: len(found) > 0)
numbers = [message[1] for message in client.take(8)]
print(len(numbers), max(numbers) - min(numbers) + 1, sum(b < a for a, b in zip(numbers, numbers[1:])))
"""


@pytest.mark.slow
def test_a_line_that_loses_packets_loses_single_positions(network, program, token):
    network.set_line(delay_ms=10, jitter_ms=3, loss=0.05)
    address = network.address("near")
    server = program("--udp", "--listen", address, "--token", token, before=network.inside("near"))
    ran = subprocess.run([*network.inside("far"), sys.executable, "-c", CLIENT, str(server.port), address],
                         capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stderr
    server.end()
    came, sent, overtaken = map(int, ran.stdout.split())
    assert sent > 400
    assert abs(1 - came / sent - 0.05) < 6 * (0.05 * 0.95 / sent) ** 0.5 + 0.005, ran.stdout
    assert overtaken > 0  # jitter of 3 ms against 5 ms from one to the next
