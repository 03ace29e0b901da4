"""Positions as datagrams, from outside: haptic_server --udp, [phantom net ... udp 1], a lossy line."""
import os
import pathlib
import re
import socket
import subprocess
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests/devices/live"))
sys.path.insert(0, str(ROOT / "scripts"))
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402
from live_pd import Live, Patch  # noqa: E402
from peer import Peer, Program, osc, parse, size  # noqa: E402
from relay import Relay  # noqa: E402


@pytest.fixture
def server(tmp_path):
    program = Program(tmp_path, "--udp", "--hand", "rigid")
    yield program
    program.process.kill()
    program.process.wait()


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

    def positions_over_tcp(self, seconds):
        """How many `pos` come over TCP, without an answer by UDP."""
        self.peer.waiting.clear()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.peer.take(end - time.monotonic())
        return sum(message[0] == "pos" for message in self.peer.waiting)


def test_positions_come_as_datagrams_with_the_key(server):
    client = Receiver(server.port)
    assert 0 < client.key < 2 ** 31
    messages = client.take_until(lambda found: len(found) > 10)
    assert {message[0] for message in messages} == {"pos"}
    assert {message[-1] for message in messages} == {client.key}
    numbers = [message[1] for message in messages]
    assert numbers == sorted(set(numbers))
    client.take_until(lambda found: len(found) > 10 and not client.peer.take(0)
                      or client.positions_over_tcp(0.05) == 0)


def test_tcp_takes_over_when_nothing_arrives_and_gives_back(server):
    client = Receiver(server.port)
    client.take_until(lambda _: client.positions_over_tcp(0.1) == 0)  # short of 250 ms
    end = time.monotonic() + 30
    while client.positions_over_tcp(0.5) < 20:  # no more probes
        client.peer.send("ping", 1)
        assert time.monotonic() < end
    client.take_until(lambda _: client.positions_over_tcp(0.1) == 0)


def test_datagrams_move_no_motor_and_strangers_get_none(server):
    client = Receiver(server.port)
    client.take_until(lambda found: len(found) > 0)
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


def test_a_server_without_datagrams_says_so(tmp_path):
    program = Program(tmp_path)
    peer = program.peer()
    peer.hello()
    peer.send("udp", 1)
    assert peer.wait("status", "udp") == ["status", "udp", 0, 0]
    program.end()


def test_a_patch_has_positions_while_tcp_is_held_up(tmp_path):
    """The relay carries TCP alone: what comes while it is stalled came as datagrams."""
    (tmp_path / "path").write_text("".join(f"{i} {i % 2000 / 100} 0 0\n" for i in range(0, 600000, 100)))
    program = Program(tmp_path, "--udp", "--hand", "rigid", "--path", str(tmp_path / "path"))
    relay = Relay(program.port)
    try:
        with Live(tmp_path, Patch(f"net 127.0.0.1 {relay.port} udp 1")) as pd:
            pd.wait_for_patch()
            pd.tell_phantom("open")
            pd.wait_for(r"^info: status open net")
            pd.wait_until(lambda: len(set(pd.positions())) > 3)
            relay.stalled = True
            time.sleep(0.7)  # longer than what makes a failure of a device without positions
            before = len(pd.positions())
            time.sleep(0.5)
            during = pd.positions()[before:]
            relay.stalled = False
            assert len(set(during)) > 3, pd.read()[-2000:]
            assert "does not answer" not in pd.read()
    finally:
        relay.close()
        program.process.kill()
        program.process.wait()


CLIENT = f"""
import sys; sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})
from test_datagrams import Receiver
client = Receiver(int(sys.argv[1]), host=sys.argv[2], token="sixteen bytes ok")
client.take_until(lambda found: len(found) > 0)
numbers = [message[1] for message in client.take(8)]
print(len(numbers), max(numbers) - min(numbers) + 1, sum(b < a for a, b in zip(numbers, numbers[1:])))
"""


def test_a_line_that_loses_packets_loses_single_positions(tmp_path):
    token = tmp_path / "token"
    token.write_text("sixteen bytes ok\n")
    token.chmod(0o600)
    try:
        network = EmulatedNetwork(["device", "client"], delay_ms=10, jitter_ms=3, loss=0.05)
    except NoNamespaces as missing:
        pytest.skip(f"no network namespaces here: {missing}")
    with network:
        program = Program(tmp_path, "--udp", "--listen", network.address("device"), "--token", str(token),
                          before=network.inside("device"))
        ran = subprocess.run([*network.inside("client"), sys.executable, "-c", CLIENT, str(program.port),
                              network.address("device")], capture_output=True, text=True, timeout=120)
        assert ran.returncode == 0, ran.stderr
        program.end()
    came, sent, overtaken = map(int, ran.stdout.split())
    assert sent > 400
    share = 1 - came / sent
    assert abs(share - 0.05) < 6 * (0.05 * 0.95 / sent) ** 0.5 + 0.005, ran.stdout
    assert overtaken > 0  # jitter of 3 ms against 5 ms from one to the next
    assert re.fullmatch(r"\d+ \d+ \d+\n", ran.stdout)
