"""Positions as datagrams, from outside: haptic_server --udp, [phantom net ... udp 1]."""
import socket
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
