"""haptic_server over bad lines: never a force above the limit (Program.end looks), none half a second
after silence, and both sides are well again by themselves. Delay, loss and stalls are a relay's; a
cable that is pulled lies between two network namespaces."""
import itertools
import os
import socket
import subprocess
import sys
import threading
import time

import pytest

from peer import HOLD_S, Peer, longest_hold_s, osc, slip, some_force


@pytest.mark.parametrize("delay_s,jitter_s,loss", [
    (0.02, 0.02, 0.05), pytest.param(0.1, 0.05, 0.2, marks=pytest.mark.slow)])
def test_delay_and_loss(program, delay_s, jitter_s, loss):
    server = program()
    relay = server.relay
    relay.delay_s, relay.jitter_s, relay.loss = delay_s, jitter_s, loss
    peer = server.in_control(relay.port)
    server.wait_for_none()
    again = time.monotonic()
    peer.push(lambda: server.force() > 0.9)  # silence alone takes no control away
    rows = server.end()
    assert longest_hold_s(rows) <= HOLD_S and some_force(rows, again)


def test_what_a_half_open_line_held_back_brings_no_force(program):
    server = program()
    peer = server.in_control(server.relay.port)
    server.relay.stalled = True
    more = itertools.count()
    peer.push(lambda: next(more) >= 100)
    server.wait_for_none()
    passed = time.monotonic()
    server.relay.stalled = False  # a hundred old forces at once
    peer.send("ping", 5)
    assert peer.wait("pong", 5)
    rows = server.end()
    assert longest_hold_s(rows) <= HOLD_S and not some_force(rows, passed)


def test_a_flood_keeps_nobody_from_an_answer_and_its_force_ends_with_it(program):
    server = program()
    flooders = [server.in_control(), *(server.peer() for _ in range(3))]
    for peer in flooders[1:]:
        peer.hello()
    ended = threading.Event()

    def flood(peer):
        try:
            while not ended.is_set():
                peer.socket.sendall(slip(osc("force", 1e30, -1e30, 1e30)) * 2000)
        except OSError:
            pass

    threads = [threading.Thread(target=flood, args=(peer,)) for peer in flooders]
    for thread in threads:
        thread.start()
    watcher = Peer(server.port, timeout=60)
    for i in range(10):
        watcher.send("ping", i)
        assert watcher.wait("pong", i, seconds=60)
    ended.set()
    for peer in flooders:
        peer.socket.shutdown(socket.SHUT_RDWR)
    for thread in threads:
        thread.join()
    server.wait_for_none()
    server.end()


CLIENT = f"""
import sys; sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})
from peer import Peer
peer = Peer(int(sys.argv[1]), host=sys.argv[2])
peer.hello(token="sixteen bytes ok"); peer.send("start", "force"); peer.push(lambda: False, 600)
"""


@pytest.mark.slow
def test_a_pulled_cable_between_two_computers(network, program, token):
    address = network.address("near")
    server = program("--listen", address, "--token", token, before=network.inside("near"))

    def client():
        return network.start("far", [sys.executable, "-c", CLIENT, server.port, address],
                             stderr=subprocess.DEVNULL)
    first = client()
    server.wait_for_force(0.9)
    network.set_link("far", up=False)
    server.wait_for_none()
    plugged = time.monotonic()
    network.set_link("far", up=True)
    time.sleep(7)  # retransmissions go on; else the client is disconnected
    first.kill()
    server.wait_for_none()
    client()
    server.wait_for_force(0.9)
    rows = server.end()
    assert longest_hold_s(rows) <= HOLD_S and some_force(rows, plugged)
