#!/usr/bin/python3
"""What the bus of AudioHaptics costs between two Pds, as hits and bodies grow.

    bench/bus_traffic.py [--seconds 5] [--bodies 1 8 64] [--rates 10 100 1000]

One Pd puts hits on its bus, round the bodies; ioa_net takes them to the other, where each body has a
contents server (ioa_cs_modal) that answers each of its hits with excite; these come back the same way.
Both on this machine, in a namespace of their own (needs root). A row: bytes of TCP payload and segments
a second, both ways; from the hit on one bus to the hit on the other, and to the excite on the first
(median, 99 %, of about 50 a second, missing ones told); the processor time of each Pd, per cent of one
core, and what it is more than its own without a hit.
"""
import argparse
import pathlib
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402
from live_session import LivePatch, Session  # noqa: E402

PORT, WATCHED_HZ = 7771, 50


def watch(patch, topic, word):
    """Each message of the topic carries its number where a hit has x. Tells `WORD n` for those that are
    multiples of what the receiver `watch-every` was given, and `WORD-count n`, of all, upon `count`."""
    fork = patch.chain(patch.chain(patch.obj(f"r bus.{topic}"), f"route {topic}", "unpack f s f"),
                       "t b f f", outlet=2)
    keep, test = patch.obj("f"), patch.obj("mod 1")
    patch.cord(patch.obj("r watch-every"), 0, test, 1)
    patch.cord(fork, 2, keep, 1)
    patch.cord(fork, 1, test)
    patch.cord(patch.chain(test, "sel 0"), 0, keep)
    count, more, asked = patch.obj("f"), patch.obj("+ 1"), patch.obj("f")
    patch.cord(fork, 0, count)
    patch.cord(count, 0, more)
    patch.cord(more, 0, count, 1)
    patch.cord(more, 0, asked, 1)
    patch.cord(patch.obj("r count"), 0, asked)
    events = patch.obj("s session-event")
    for source, text in ((keep, f"{word} \\$1"), (asked, f"{word}-count \\$1")):
        message = patch.msg(text)
        patch.cord(source, 0, message)
        patch.cord(message, 0, events)


def hitting(bodies):
    """The Pd that is struck: `every MS` begins, `every 0` ends; bodies b0, b1, ... in turn."""
    patch = LivePatch()
    metro = patch.chain(patch.obj("r every"), "t f f")
    gate = patch.chain(metro, "> 0", outlet=0)
    clock = patch.obj("metro 1000")
    patch.cord(metro, 1, clock, 1)
    patch.cord(gate, 0, clock)
    number = patch.chain(clock, "f")
    patch.cord(patch.chain(number, "+ 1"), 0, number, 1)
    fork = patch.chain(number, "t f f")
    body = patch.chain(patch.chain(fork, f"mod {bodies}"), "makefilename b%d")
    message = patch.obj("pack s f")
    patch.cord(body, 0, message)
    patch.cord(fork, 1, message, 1)
    hit = patch.msg("hit \\$1 \\$2 0 6 0 0 1 0.2 0")
    patch.cord(message, 0, hit)
    patch.cord(patch.chain(hit, "ioa_stamp"), 0, patch.obj("ioa_bus bus"))
    patch.net("bus-net", "bus hit")
    watch(patch, "hit", "struck")
    watch(patch, "excite", "answered")
    return patch


def answering(bodies):
    """The Pd with a contents server for each body."""
    patch = LivePatch(number=1)
    for i in range(bodies):
        patch.obj(f"ioa_cs_modal bus b{i} plate.modal.npz")
    patch.net("bus-net", "bus excite")
    watch(patch, "hit", "came")
    return patch


def numbers(session, name, word):
    """{number: s} of the events `WORD number`."""
    return {int(float(what.split()[1])): at_s for at_s, where, what in list(session.events)
            if where == name and what.startswith(word + " ")}


def counted(session, name, word):
    """How many there were in all, by Pd's own count."""
    before = [what for _, where, what in list(session.events) if where == name and f"{word}-count" in what]
    session.send(name, "count", "bang")
    end = time.monotonic() + 20
    while time.monotonic() < end:
        found = [what for _, where, what in list(session.events) if where == name and f"{word}-count" in what]
        if len(found) > len(before):
            return int(float(found[-1].split()[1]))
        time.sleep(0.02)
    raise RuntimeError(f"the Pd {name} does not answer: {session.said(name)[-1000:]}")


def measure(session, bodies, rates, seconds):
    """A row of the table for each rate, and one before without hits."""
    session.play("one", answering(bodies), name="answering")
    session.play("one", hitting(bodies), name="striking")
    session.join("striking", "answering", PORT, "bus-net", "bus-net")
    time.sleep(1)
    resting = None
    for rate in (0, *rates):
        every = max(1, rate // WATCHED_HZ)
        for name in ("striking", "answering"):
            session.send(name, "watch-every", every)
        before = [counted(session, *what) for what in (("striking", "struck"), ("answering", "came"),
                                                       ("striking", "answered"))]
        seen = set(numbers(session, "striking", "struck"))
        cpu = {name: session.cpu_s(name) for name in session.pds}
        traffic, begin = session.tcp_traffic("one", PORT), time.monotonic()
        if rate:
            session.send("striking", "every", 1000 / rate)
        time.sleep(seconds)
        lasted = time.monotonic() - begin
        used = {name: 100 * (session.cpu_s(name) - cpu[name]) / lasted for name in session.pds}
        size, segments = (after - was for after, was in zip(session.tcp_traffic("one", PORT), traffic))
        session.send("striking", "every", 0)
        time.sleep(1)
        if not rate:
            resting = used
            print(f"| {bodies} | 0 | {size / lasted / 1e3:.2f} | {segments / lasted:.0f} | - | - | - | "
                  f"{used['striking']:.1f} % | {used['answering']:.1f} % |", flush=True)
            continue
        struck, came, answered = (after - was for after, was in zip(
            [counted(session, *what) for what in (("striking", "struck"), ("answering", "came"),
                                                  ("striking", "answered"))], before))
        sent = {n: t for n, t in numbers(session, "striking", "struck").items() if n not in seen}
        there, back = numbers(session, "answering", "came"), numbers(session, "striking", "answered")
        texts = []
        for found in (there, back):
            times = numpy.array([1e3 * (found[n] - t) for n, t in sent.items() if n in found])
            texts.append(f"{numpy.median(times):.1f}, {numpy.quantile(times, 0.99):.1f}" if len(times) else "-")
        found = f"all {struck}" if struck == came == answered else f"{came} and {answered} of {struck}"
        cpu_texts = [f"{used[name]:.1f} % ({round(used[name] - resting[name], 1) + 0.0:+.1f})"
                     for name in ("striking", "answering")]
        print(f"| {bodies} | {rate} | {size / lasted / 1e3:.1f} | {segments / lasted:.0f} | {texts[0]} | "
              f"{texts[1]} | {found} | {' | '.join(cpu_texts)} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--bodies", type=int, nargs="+", default=[1, 8, 64])
    parser.add_argument("--rates", type=int, nargs="+", default=[10, 100, 1000], help="hits a second")
    words = parser.parse_args()
    print("| bodies | hits/s | kB/s | segments/s | hit to hit, ms: median, 99 % | and back | found | "
          "CPU of the striking Pd | of the answering Pd |\n|---|---|---|---|---|---|---|---|---|")
    try:
        for bodies in words.bodies:
            with tempfile.TemporaryDirectory(prefix="tactus-") as folder, EmulatedNetwork(["one"], nice=-10) as network, \
                    Session(network, folder) as session:
                measure(session, bodies, words.rates, words.seconds)
    except NoNamespaces as missing:
        sys.exit(f"bus_traffic: {missing}")


if __name__ == "__main__":
    main()
