"""[ioa_link] over bad lines and beside bad peers: no event is lost while connected, and both sides
recover by themselves. Lines are IP packets between two network namespaces (scripts/emulated_network.py)."""
import re
import socket
import threading

import pytest

from pd_process import patch
from peer import Peer, osc, slip, wait_until

PORT = 7795


def link(begin, token=None):
    """A patch with a link that sends numbered events, 100 a second, and a stream of 500 positions a
    second, and prints what comes."""
    boxes = {"begin": "obj loadbang", "do": f"msg {f'token {token} {chr(92)}, ' if token else ''}{begin}",
             "link": "obj ioa_link", "sort": "obj route hit", "got": "obj print got",
             "info": "obj print info", "events": "obj metro 10", "count": "obj f", "next": "obj + 1",
             "hit": r"msg send hit 0 \$1", "stream": "obj metro 2",
             "hand": "msg send hand 0 1 2 3 0 0 0", "late": "obj r from-test"}
    return patch(boxes, ["begin 0 events 0", "begin 0 stream 0", "begin 0 do 0", "do 0 link 0",
                         "link 0 sort 0", "sort 0 got 0", "link 1 info 0", "events 0 count 0",
                         "count 0 next 0", "next 0 count 1", "count 0 hit 0", "hit 0 link 0",
                         "stream 0 hand 0", "hand 0 link 0", "late 0 link 0"])


def numbers(pd):
    """The events that have come."""
    return [int(float(n)) for n in re.findall(r"^got: (?:list )?\S+ (\S+)$", pd.read(), re.M)]


def gaps(pd):
    found = numbers(pd)
    return sum(b != a + 1 for a, b in zip(found, found[1:]))


def ends(pd):
    """How often a connection ended there."""
    return len(re.findall(r"^info: connected 0$", pd.read(), re.M))


def flowing(*pds):
    """Waits until each has got a hundred events more."""
    wanted = [len(numbers(pd)) + 100 for pd in pds]
    wait_until(lambda: all(len(numbers(pd)) >= count for pd, count in zip(pds, wanted)), 120)


@pytest.fixture
def line(network, pd, token):
    """A Pd that listens on one computer and one that calls on the other."""
    address = network.address("near")
    listener = pd(*link(f"listen {PORT} {address}", token), name="listener", before=network.inside("near"))
    caller = pd(*link(f"connect {address} {PORT}", token), name="caller", before=network.inside("far"))
    flowing(listener, caller)
    return network, listener, caller


@pytest.mark.parametrize("delay_ms,jitter_ms,loss", [
    pytest.param(1, 0, 0.01, marks=pytest.mark.slow), (20, 10, 0.05),
    pytest.param(100, 15, 0.2, marks=pytest.mark.slow)])
def test_no_event_is_lost_on_a_line_that_delays_loses_and_reorders(line, delay_ms, jitter_ms, loss):
    network, listener, caller = line
    network.set_line(delay_ms=delay_ms, jitter_ms=jitter_ms, loss=loss)
    for _ in range(3):
        flowing(listener, caller)
    lost = max(ends(listener), ends(caller))  # at a fifth of loss TCP may be silent for five seconds
    assert lost == 0 or loss > 0.1
    for one in (listener, caller):
        assert gaps(one) <= lost


@pytest.fixture
def pair(pd):
    """Two Pds on this machine that are connected, and the port of the one that listens."""
    listener = pd(*link("listen 0"), name="listener")
    port = int(listener.wait_for(r"^info: status listening (\d+)$"))
    caller = pd(*link(f"connect {port}"), name="caller")
    flowing(listener, caller)
    return listener, caller, port



def stranger(port):
    peer = Peer(port)
    peer.send("hello", 1, "stranger", "bus")
    peer.wait("welcome")
    return peer


def test_peers_that_flood_take_nothing_from_the_others(pair):
    listener, caller, port = pair
    packets = {"stream": slip(osc("/bus/hand", 0, 0, 0.0, 1.0)), "bad": slip(osc("/bus/hand", "x"))}
    ended = threading.Event()
    peers = [stranger(port) for _ in range(3)]

    def flood(peer, data):
        try:
            while not ended.is_set():
                peer.socket.sendall(data)
        except OSError:
            pass
    threads = [threading.Thread(target=flood, args=(peer, data * 500)) for peer, data in
               zip(peers, (packets["stream"], packets["bad"], b"\xc0\xdb" * 1000))]
    for thread in threads:
        thread.start()
    flowing(listener, caller)
    ended.set()
    for peer in peers:
        try:
            peer.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
    for thread in threads:
        thread.join()
    flowing(listener, caller)
    assert not gaps(listener) and not gaps(caller) and not ends(caller)
