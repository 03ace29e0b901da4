"""[tactus_osc]: OSC packets become messages of an object, its answers become packets; a damaged packet is one
error and does nothing. Packets go in and out as lists of bytes, and once over UDP."""
import pathlib
import random
import socket
import struct

import numpy
import pytest
from peer import osc as message, parse

from harness import Patch
from harness.live import LivePd, free_port, patch_text
from harness.run import ROOT

LIVE = ROOT / "patches" / "live"


def bundle(*messages, time=1):
    return b"#bundle\0" + struct.pack(">Q", time) + b"".join(struct.pack(">i", len(m)) + m for m in messages)


def unpacked(packet):
    """[address, values...] of a message in a list of bytes."""
    return parse(bytes(map(int, packet)))


def exchange(packets, spacing=10, errors=(), name="greed"):
    """Packets to [greed~] through [tactus_osc]: messages, answers, status by packet."""
    patch = Patch()
    reed, osc = patch.obj("greed~ -preset clarinet"), patch.obj("tactus_osc", name, 0)
    osc >> reed
    reed[4] >> osc[1]
    for i, packet in enumerate(packets):
        patch.at(10 + spacing * i, osc, list(packet))
    for outlet, label in enumerate(("messages", "packets", "status")):
        patch.log(label, osc[outlet])
    result = patch.render((10 + spacing * len(packets) + 20) / 1000, path=[LIVE], expect_errors=errors)
    return [[(round((ms - 10) / spacing), atoms) for ms, atoms in result.logs[label]]
            for label in ("messages", "packets", "status")] + [result]


def test_addresses_become_messages_and_answers_come_back():
    messages, packets, status, _ = exchange([
        message("/greed/theta0", -0.0371), message("/greed/get", "theta0"), message("/greed/preset", "oboe"),
        message("/greed/get", "bore", "seed"), bundle(message("/greed/seed", 17), message("/greed/get", "seed")),
        message("/greed/reset")])
    assert [m for i, m in messages if i == 0] == [["theta0", pytest.approx(-0.0371)]]
    assert [unpacked(p) for i, p in packets] == [
        ["/greed/theta0", pytest.approx(-0.0371)], ["/greed/bore", "cone"], ["/greed/seed", 1], ["/greed/seed", 17]]
    assert messages[-1][1] == ["reset"] and not status


def typed(address, tags, data=b""):
    return message(address)[:-4] + tags.encode() + bytes(4 - len(tags) % 4) + data


TAKEN = [
    (typed("/greed/x", ",df", struct.pack(">df", 1 / 3, 0.5)), ["x", float(numpy.float32(1 / 3)), 0.5]),
    (typed("/greed/x", ",ddd", struct.pack(">ddd", -1e-5, 1e-300, 3e38)),
     ["x", float(numpy.float32(-1e-5)), 0, float(numpy.float32(3e38))]),
    (typed("/greed/x", ",sdhhT", b"word\0\0\0\0" + struct.pack(">dqq", -2.5, 5, -7)), ["x", "word", -2.5, 5, -7, 1]),
    (typed("/greed/tune", ",T"), ["tune", 1]), (typed("/greed/tune", ",F"), ["tune", 0]),
    (typed("/greed/preset", ",S", b"oboe\0\0\0\0"), ["preset", "oboe"]),
    (bundle(typed("/greed/seed", ",h", struct.pack(">q", 3))), ["seed", 3]),
    # A phone's button: pressed, let go.
    (message("/greed/tongue", 1.0), ["tongue"]), (message("/greed/tongue", 0.0), None), (typed("/greed/reset", ",T"), ["reset"]),
]


def test_types_that_mean_one_thing_are_taken_as_it():
    messages, _, status, _ = exchange([packet for packet, _ in TAKEN], errors=["no message 'x'"])
    assert messages == [(i, atoms) for i, (_, atoms) in enumerate(TAKEN) if atoms] and not status


def test_signal_inlets_are_played_by_names():
    """What the help patch does: /greed/mouth_pressure is routed to a ramp of the first inlet."""
    patch = Patch()
    osc, route = patch.obj("tactus_osc greed 0"), patch.obj("route mouth_pressure")
    reed = patch.obj("greed~ -preset clarinet")
    ramp = patch.obj("pack f 20")
    osc >> route
    route >> ramp
    ramp >> patch.obj("line~") >> reed
    route[1] >> reed
    patch.at(50, osc, list(message("/greed/mouth_pressure", 2000.0)))
    patch.record("sound", reed)
    sound = patch.render(1, path=[LIVE])["sound"]
    assert abs(sound[:2000]).max() < 1e-3 < 0.05 < abs(sound[-9600:]).max()


@pytest.mark.parametrize("times", [(1, 1, 1), (1 << 60, 1 << 60, (1 << 60) + 1), (5, 6 << 32, 7 << 40)])
def test_bundles_in_bundles_are_carried_out_in_order(times):
    def seed(value):
        return message("/greed/seed", value)
    packet = bundle(seed(1), bundle(seed(2), bundle(seed(3), seed(4), time=times[2]), bundle(time=times[2]), time=times[1]), seed(5),
                    time=times[0])
    messages, *_ = exchange([packet])
    assert [words[-1] for _, words in messages if "seed" in words] == [1, 2, 3, 4, 5]


GOOD = bundle(message("/greed/seed", 3), message("/greed/mass", 1e-5))
DAMAGED = {
    "too short": b"/a\0\0", "not whole words": message("/greed/seed", 3)[:-1],
    "a byte too many": message("/greed/seed", 3) + b"\0",
    "no slash": b"greed\0\0\0,i\0\0\0\0\0\3",
    "a bundle cut": GOOD[:-4], "a size beyond the packet": GOOD[:16] + struct.pack(">i", 1 << 20) + GOOD[20:],
    "a negative size": GOOD[:16] + struct.pack(">i", -8) + GOOD[20:], "a size of 0": GOOD[:16] + bytes(4) + GOOD[20:],
    "an inner bundle of an earlier time": bundle(bundle(message("/greed/seed", 3), time=(1 << 60) + 2), time=(1 << 60) + 3),
    "a message beyond its inner bundle": bundle(GOOD[:16] + struct.pack(">i", 44) + message("/greed/seed", 3), message("/greed/seed", 4)),
    "an inner bundle too short": bundle(b"#bundle\0"), "an inner bundle of another name": bundle(b"#bundlE\0" + GOOD[8:]),
    "the second message damaged": bundle(message("/greed/seed", 3), b"xyz\0,\0\0\0abcd"),
    "another name": message("/bell/seed", 3), "a number alone": message("/greed", 2000.0),
    "a program": message("/greed/solver", "/bin/true"), "a file written": message("/greed/write", "x"),
    "a type that is not taken": typed("/greed/seed", ",b", bytes(4)), "an endless double": typed("/greed/seed", ",d", b"\x7f\xf0" + bytes(6)),
    "an int64 beyond 32 bits": typed("/greed/seed", ",h", struct.pack(">q", 1 << 32)),
    "a good message, then another type": bundle(message("/greed/seed", 3), typed("/greed/mass", ",N")),
    "half a double": typed("/greed/seed", ",d", bytes(4)), "more than its types": message("/greed/seed", 3) + bytes(4),
    "no types": b"/greed/seed\0abcd", "the numbers missing": message("/greed/seed", 3)[:-4],
}


@pytest.mark.parametrize("what", DAMAGED)
def test_a_damaged_packet_is_one_error_and_does_nothing(what):
    messages, packets, status, result = exchange([DAMAGED[what]], errors=["."])
    said = [line for line in result.errors if line.startswith(("error", "tactus_osc", "greed~", "oscparse"))]
    assert not messages and not packets and len(status) <= 1
    assert len(said) == 1, result.errors


@pytest.mark.parametrize("count", [300, pytest.param(3000, marks=pytest.mark.slow)])
def test_random_packets_do_nothing_and_the_next_good_one_works(count):
    generator = random.Random(1)
    packets = []
    for _ in range(count):
        packet = bytearray(generator.choice((GOOD, message("/greed/get", "seed"), message("/bell/x", 1.0))))
        for _ in range(generator.randrange(1, 5)):
            packet[generator.randrange(len(packet))] = generator.randrange(256)
        packets.append(bytes(packet[:generator.randrange(1, len(packet) + 1)] if generator.random() < 0.5 else packet))
    packets.append(message("/greed/get", "os"))
    _, answers, _, result = exchange(packets, spacing=1, errors=["."])
    assert unpacked(answers[-1][1]) == ["/greed/os", 0]
    # A flood does not fill the console: at most two lines a second of our own.
    assert len([line for line in result.errors if line.startswith("tactus_osc")]) <= 2 * (count / 1000 + 0.1) + 1


def test_packets_go_through_udp_of_this_machine_to_all_who_want_answers(tmp_path):
    """In real time: Pd reads no sockets in batch mode. `localhost` may be either address."""
    port, patch, packets = free_port(socket.SOCK_DGRAM), tmp_path / "reed.pd", {}
    with (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second,
          socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as sixth):
        for answers in (first, second):
            answers.bind(("127.0.0.1", 0))
            answers.settimeout(0.3)
        patch.write_text(patch_text([
            f"obj 20 20 tactus_osc greed {port} 127.0.0.1 {first.getsockname()[1]}", "obj 20 80 greed~ -preset clarinet",
            "obj 20 120 loadbang", "msg 20 160 " + " ".join(["reply"] + [f"127.0.0.1 {s.getsockname()[1]}" for s in (first, second)])],
            ["0 0 1 0", "1 4 0 1", "2 0 3 0", "3 0 0 0"]))
        with LivePd(patch, path=[LIVE]) as pd:
            def answered(sender, host):
                sender.sendto(message("/greed/get", "os"), (host, port))
                try:
                    packets[host] = [answers.recv(1000) for answers in (first, second)]
                except OSError:
                    return False  # Pd has not opened its port yet
                return True
            pd.wait_until(lambda: answered(first, "127.0.0.1"), "an answer")
            pd.wait_until(lambda: answered(sixth, "::1"), "an answer to ::1")
            listening = [pathlib.Path(f"/proc/net/{name}").read_text() for name in ("udp", "udp6")]
    assert [[parse(one) for one in two] for two in packets.values()] == [[["/greed/os", 0]] * 2] * 2
    # Of this machine only, where nobody says otherwise.
    assert f"0100007F:{port:04X}" in listening[0] and f"00000000:{port:04X}" not in listening[0]
    assert f"{'0' * 24}01000000:{port:04X}" in listening[1] and f"{'0' * 32}:{port:04X}" not in listening[1]
