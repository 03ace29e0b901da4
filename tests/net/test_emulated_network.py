"""scripts/emulated_network.py does to packets what it says: UDP packets with numbers, between two computers."""
import socket
import struct
import time

import pytest

from emulated_network import QUEUE_BYTES, EmulatedNetwork, NoNamespaces

COUNT = 400
HEADERS = 28  # bytes of IPv4 and UDP
SO_RCVBUFFORCE = 33


@pytest.fixture
def ends(network):
    """A socket on each computer; `near` sends to `far`."""
    there = network.socket("far")
    there.bind((network.address("far"), 0))
    there.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 23)  # what comes is taken after all was sent
    here = network.socket("near")
    here.connect(there.getsockname())
    with here, there:
        yield here, there


def send(here, count=COUNT, first=0, apart_s=0.0005, size=0):
    """Numbered packets of at least that size."""
    for number in range(first, first + count):
        here.send(struct.pack("!Id", number, time.monotonic()).ljust(size))
        time.sleep(apart_s)


def take(there, seconds=1.0):
    """[(number, delay in s)] of what comes until nothing has come for so long."""
    found = []
    there.settimeout(seconds)
    try:
        while True:
            number, sent_s = struct.unpack("!Id", there.recv(2048)[:12])
            found.append((number, time.monotonic() - sent_s))
    except TimeoutError:
        return found


def test_loss_is_a_share_of_the_packets_which_overtake_each_other_by_jitter(network, ends):
    here, there = ends
    network.set_line(loss=0.25, jitter_ms=5)
    send(here)
    numbers = [number for number, _ in take(there)]
    deviation = (0.25 * 0.75 / COUNT) ** 0.5
    assert abs(1 - len(numbers) / COUNT - 0.25) < 5 * deviation
    assert numbers != sorted(numbers) and len(set(numbers)) == len(numbers)


def test_a_line_that_is_held_lets_all_go_afterwards_and_one_that_is_cut_nothing(network, ends):
    here, there = ends
    network.set_line(held=True, delay_ms=30)
    send(here, 40)
    assert not take(there, 0.3)
    network.set_line(held=False)
    found = take(there)
    assert [number for number, _ in found] == list(range(40))
    assert min(delay_s for _, delay_s in found) >= 0.03
    network.set_line(delay_ms=400)
    send(here, 20)
    network.set_line(cut=True)  # what waited vanishes, too
    send(here, 20)
    network.set_line(cut=False)
    assert not take(there, 0.8)
    network.set_line(delay_ms=0)
    send(here, 20, first=100)
    assert [number for number, _ in take(there)] == list(range(100, 120))


def test_a_line_keeps_no_more_than_its_queue(network, ends):
    here, there = ends
    network.set_line(held=True)
    for first in (0, 1000):  # what has gone makes room
        send(here, 1000, first, size=1400)
        network.set_line(held=False)
        numbers = [number for number, _ in take(there)]
        assert numbers == list(range(first, first + QUEUE_BYTES // (1400 + HEADERS)))
        network.set_line(held=True)


def test_what_is_refused_leaves_a_network_as_it_is_and_a_link_may_go_down_and_up(network, ends):
    here, there = ends
    with pytest.raises(NoNamespaces):  # the names of this process are taken
        EmulatedNetwork(["near", "far"])
    with pytest.raises(TypeError, match="delay_s"):
        network.set_line(delay_s=0.1)
    network.set_link("near", up=False)
    with pytest.raises(OSError):  # its computer knows
        here.send(b"")
    network.set_link("near", up=True)
    send(here, 20)
    assert [number for number, _ in take(there)] == list(range(20))
