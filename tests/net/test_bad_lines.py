"""haptic_server over bad lines: never a force above the limit, none half a second after silence, and
both sides are well again by themselves. Delay, loss, stalls, cuts and trickles are a relay's, since
few kernels have netem; a link that is pulled is a pair of network namespaces."""
import os
import socket
import subprocess
import sys
import threading
import time

import pytest

from peer import Peer, Program, last_force, near, osc, size, with_length
from relay import Relay

SILENCE_S, STALL_S = 0.5, 0.15


@pytest.fixture
def line(tmp_path):
    server = Program(tmp_path)
    relay = Relay(server.port)
    yield server, relay
    relay.close()
    server.process.kill()
    server.process.wait()


def start(port, seconds=0.8):
    peer = Peer(port)
    peer.hello()
    peer.send("start", "force")
    peer.hold(seconds, "force", 2.0, 0.0, 0.0)
    return peer


def again(port):
    """A new connection that has control and a force, within 10 s."""
    end = time.monotonic() + 10
    while True:
        try:
            peer = start(port)
            peer.send("ping", 77)
            peer.wait("pong", 77, seconds=5)
            return peer
        except (OSError, AssertionError):
            assert time.monotonic() < end
            time.sleep(0.25)


@pytest.mark.parametrize("delay_s,jitter_s,loss", [
    (0.001, 0, 0.01), (0.02, 0.02, 0.05), (0.1, 0, 0.1), (0.1, 0.05, 0.2)])
def test_delay_and_loss(line, delay_s, jitter_s, loss):
    server, relay = line
    relay.delay_s, relay.jitter_s, relay.loss = delay_s, jitter_s, loss
    peer = start(relay.port, 3)
    silent = time.monotonic()
    time.sleep(1.5 + delay_s)
    passed = relay.passed_s  # not from the delays: on a busy machine a relay is late, too
    peer.hold(1, "force", 2.0, 0.0, 0.0)  # and back again
    rows = server.end()
    assert size(near(rows, silent - 0.1)) > 1
    quiet = [row for row in rows if row[0] < silent + 1.5]
    assert last_force(quiet) <= passed + SILENCE_S + STALL_S
    assert last_force(rows, after=silent + 1.5) is not None


def test_a_cut_line(line):
    server, relay = line
    start(relay.port)
    relay.cut()
    cut = time.monotonic()
    time.sleep(0.5)
    again(relay.port)
    rows = server.end()
    assert last_force([row for row in rows if row[0] < cut + 0.5]) <= cut + STALL_S
    assert last_force(rows, after=cut + 0.5) is not None


def test_a_half_open_peer_and_what_was_held_back(line):
    server, relay = line
    peer = start(relay.port)
    relay.stalled = True
    stalled = time.monotonic()
    peer.hold(2, "force", 2.0, 0.0, 0.0)
    passed = time.monotonic()
    relay.stalled = False  # a hundred old forces at once
    time.sleep(1)
    rows = server.end()
    assert last_force(rows) <= stalled + SILENCE_S + STALL_S
    assert passed < rows[-1][0]


def test_a_half_open_peer_is_shown_out_and_another_takes_over(line):
    server, relay = line
    start(relay.port)
    relay.stalled = True
    other = Peer(server.port)
    other.hello()
    end = time.monotonic() + 10
    while time.monotonic() < end:
        other.send("start", "force")
        time.sleep(0.25)
        other.take(0.01)
        if any(message[:2] == ["status", "started"] for message in other.waiting):
            break
    else:
        raise AssertionError("control was never free")
    other.hold(1, "force", 1.0, 0.0, 0.0)
    assert size(server.end()[-1][1]) == 0


def test_a_flood(line):
    server, relay = line
    packet = with_length(osc("force", 1e30, -1e30, 1e30)) * 2000
    flooders = [start(server.port, 0.1)] + [Peer(server.port) for _ in range(3)]
    for peer in flooders[1:]:
        peer.hello()
    ended = threading.Event()

    def flood(peer):
        try:
            while not ended.is_set():
                peer.socket.sendall(packet)
        except OSError:
            pass

    threads = [threading.Thread(target=flood, args=(peer,)) for peer in flooders]
    for thread in threads:
        thread.start()
    time.sleep(1)
    watcher = Peer(server.port)
    for i in range(10):
        watcher.send("ping", i)
        assert watcher.wait("pong", i)
    ended.set()
    for peer in flooders:
        peer.socket.shutdown(socket.SHUT_RDWR)
    for thread in threads:
        thread.join()
    over = time.monotonic()
    time.sleep(1.5)
    rows = server.end()  # no tick above the limit
    assert last_force(rows) <= over + SILENCE_S + STALL_S


def test_a_byte_a_second(line):
    server, relay = line
    peer = start(relay.port)
    relay.dribble = 1
    slow = time.monotonic()
    ended = threading.Event()

    def trickle():
        try:
            peer.hold(6, "force", 2.0, 0.0, 0.0, every=0.5)
        except OSError:
            ended.set()

    thread = threading.Thread(target=trickle)
    thread.start()
    thread.join()
    relay.dribble = None
    back = time.monotonic()
    again(server.port)
    rows = server.end()
    assert ended.is_set() or peer.ended(1)
    assert last_force([row for row in rows if row[0] < back]) <= slow + SILENCE_S + STALL_S + 0.1


NAMES = [f"tactus{os.getpid()}{end}" for end in "ab"]
CLIENT = f"""
import sys, time; sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})
from peer import Peer
peer = Peer(int(sys.argv[1]), host="10.77.0.1")
peer.hello(token="sixteen bytes ok"); peer.send("start", "force")
print("started", flush=True)
while True: peer.hold(1, "force", 2.0, 0.0, 0.0)
"""


def ip(*words):
    return subprocess.run(["ip", *words], capture_output=True, text=True, check=True)


@pytest.fixture
def namespaces():
    """Two computers with a cable between them."""
    try:
        for name in NAMES:
            ip("netns", "add", name)
        ip("link", "add", "near", "netns", NAMES[0], "type", "veth", "peer", "name", "far", "netns",
           NAMES[1])
        for name, device, address in zip(NAMES, ("near", "far"), ("10.77.0.1", "10.77.0.2")):
            ip("-n", name, "addr", "add", f"{address}/24", "dev", device)
            ip("-n", name, "link", "set", device, "up")
            ip("-n", name, "link", "set", "lo", "up")
    except (subprocess.CalledProcessError, OSError) as refused:
        for name in NAMES:
            subprocess.run(["ip", "netns", "del", name], capture_output=True)
        pytest.skip(f"no network namespaces here: {getattr(refused, 'stderr', refused)}")
    yield
    for name in NAMES:
        subprocess.run(["ip", "netns", "del", name], capture_output=True)


def test_a_pulled_cable_between_two_computers(namespaces, tmp_path):
    token = tmp_path / "token"
    token.write_text("sixteen bytes ok\n")
    token.chmod(0o600)
    inside = ["ip", "netns", "exec"]
    server = Program(tmp_path, "--listen", "10.77.0.1", "--token", str(token),
                     before=[*inside, NAMES[0]])

    def client():
        return subprocess.Popen([*inside, NAMES[1], sys.executable, "-c", CLIENT, str(server.port)],
                                stdout=subprocess.PIPE, text=True)
    first = client()
    second = None
    try:
        assert first.stdout.readline() == "started\n"
        time.sleep(1)
        before = time.monotonic()
        ip("-n", NAMES[1], "link", "set", "far", "down")
        pulled = time.monotonic()
        time.sleep(1.5)
        plugged = time.monotonic()
        ip("-n", NAMES[1], "link", "set", "far", "up")
        time.sleep(7)  # retransmissions go on; else the client is disconnected
        first.kill()
        second = client()
        assert second.stdout.readline() == "started\n"
        time.sleep(1)
    finally:
        for one in (first, second):
            if one:
                one.kill()
                one.wait()
    time.sleep(0.3)
    rows = server.end()
    assert size(near(rows, before - 0.1)) > 1
    assert last_force([row for row in rows if row[0] < plugged]) <= pulled + SILENCE_S + STALL_S
    assert last_force(rows, after=plugged) is not None
