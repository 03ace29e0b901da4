"""[ioa_link] over bad lines and beside bad peers: no event is lost while connected, and both sides
recover by themselves. Lines are IP packets between two network namespaces (scripts/emulated_network.py)."""
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

ROOT = pathlib.Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests/devices/live")]
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402
from pd_process import Pd, patch  # noqa: E402
from peer import Peer, osc, slip  # noqa: E402

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


def flowing(*pds, seconds=40):
    """Waits until each has got a hundred events more."""
    wanted = [len(numbers(pd)) + 100 for pd in pds]
    end = time.monotonic() + seconds
    while any(len(numbers(pd)) < count for pd, count in zip(pds, wanted)):
        assert time.monotonic() < end, "\n".join(pd.text[-1500:] for pd in pds)
        time.sleep(0.05)


def wait_until(holds, seconds=60):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.fixture
def running():
    programs = []

    def start(*arguments, **options):
        programs.append(Pd(*arguments, **options))
        return programs[-1]
    yield start
    for program in programs:
        program.close()


@pytest.fixture
def line(tmp_path, running):
    """A Pd that listens in one namespace and one that calls in the other."""
    try:
        network = EmulatedNetwork(["listener", "caller"])
    except NoNamespaces as missing:
        pytest.skip(f"no network namespaces here: {missing}")
    token = tmp_path / "token"
    token.write_text("sixteen bytes ok\n")
    token.chmod(0o600)
    address = network.address("listener")
    with network:
        listener = running(tmp_path, *link(f"listen {PORT} {address}", token), name="listener",
                           before=network.inside("listener"))
        caller = running(tmp_path, *link(f"connect {address} {PORT}", token), name="caller",
                         before=network.inside("caller"))
        yield network, listener, caller
        for one in (listener, caller):
            one.close()


def errors(pd):
    return [text for text in re.findall(r"^(?:error|verbose\(\d\)): (ioa_link: .*)$", pd.read(), re.M)]


@pytest.mark.parametrize("delay_ms,jitter_ms,loss", [(1, 0, 0.01), (20, 10, 0.05), (100, 15, 0.2)])
def test_no_event_is_lost_on_a_line_that_delays_loses_and_reorders(line, delay_ms, jitter_ms, loss):
    network, listener, caller = line
    network.set_line(delay_ms=delay_ms, jitter_ms=jitter_ms, loss=loss)
    flowing(listener, caller)
    time.sleep(3)
    flowing(listener, caller)
    lost = max(ends(listener), ends(caller))  # at a fifth of loss TCP may be silent for five seconds
    assert lost == 0 or loss > 0.1
    for one in (listener, caller):
        assert gaps(one) <= lost


@pytest.mark.parametrize("hesitation", ["held", "cut"])
def test_a_line_that_hesitates_loses_nothing(line, hesitation):
    network, listener, caller = line
    flowing(listener, caller)
    network.set_line(**{hesitation: True})
    time.sleep(1.2)
    network.set_line(**{hesitation: False})
    flowing(listener, caller)
    assert not gaps(listener) and not gaps(caller) and not ends(listener) and not ends(caller)
    assert "status late" in listener.text and "status back" in listener.text
    assert re.search(r"^info: late \d+$", listener.text, re.M)


def test_a_line_that_is_cut_is_taken_up_again(line):
    network, listener, caller = line
    flowing(listener, caller)
    network.set_line(cut=True)  # half open: neither is told
    wait_until(lambda: ends(listener) and ends(caller), 30)
    network.set_line(cut=False)
    flowing(listener, caller)
    assert gaps(listener) <= ends(caller) + ends(listener)
    for one in (listener, caller):
        assert len(errors(one)) <= 6, errors(one)  # what ended, and that nobody answers


def test_a_link_that_is_down_between_two_computers_comes_back(line):
    network, listener, caller = line
    flowing(listener, caller)
    network.set_link("caller", up=False)
    time.sleep(1.5)
    network.set_link("caller", up=True)
    flowing(listener, caller)
    assert gaps(listener) <= max(ends(listener), ends(caller))


@pytest.fixture
def pair(tmp_path, running):
    """Two Pds on this machine that are connected, and the port of the one that listens."""
    listener = running(tmp_path, *link("listen 0"), name="listener")
    port = int(listener.wait_for(r"^info: status listening (\d+)$"))
    caller = running(tmp_path, *link(f"connect {port}"), name="caller")
    flowing(listener, caller)
    return listener, caller, port


@pytest.fixture
def busy():
    """Programs that take all processors, as many as asked for."""
    loops = []

    def start(count):
        loops.extend(subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count))
    yield start
    for loop in loops:
        loop.kill()
        loop.wait()


def test_computers_that_stall_lose_no_event(pair, busy):
    listener, caller, _ = pair
    busy(3)
    for one in (listener, caller, listener, caller):
        os.kill(one.process.pid, signal.SIGSTOP)
        time.sleep(0.8)
        os.kill(one.process.pid, signal.SIGCONT)
        time.sleep(0.4)
    flowing(listener, caller)
    assert not gaps(listener) and not gaps(caller) and not ends(caller)


def stranger(port):
    peer = Peer(port, "slip")
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


def test_peers_that_trickle_stay_silent_or_never_say_hello_are_shown_out(pair):
    listener, caller, port = pair
    slow, silent, mute = stranger(port), stranger(port), Peer(port, "slip")
    frame = slip(osc("/bus/hand", 0, 0, 0.0, 1.0))
    began, shown_out = time.monotonic(), {}
    position = 0
    while len(shown_out) < 3:
        assert time.monotonic() < began + 40
        if "slow" not in shown_out and time.monotonic() >= began + position:
            try:
                slow.socket.sendall(frame[position % len(frame):][:1])
            except OSError:
                pass
            position += 1
        for name, peer in (("slow", slow), ("silent", silent), ("mute", mute)):
            if name not in shown_out and not peer.take(0.02):
                shown_out[name] = time.monotonic() - began
    assert shown_out["slow"] >= 2 - 0.1 and shown_out["silent"] >= 5 - 0.1
    flowing(listener, caller)
    assert not gaps(listener) and not gaps(caller) and not ends(caller)
