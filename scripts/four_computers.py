#!/usr/bin/python3
"""The AudioHaptics scene on four computers: device, interaction, sound, screen, on one machine.

    scripts/four_computers.py [--delay 5] [--loss 0] [--seconds 8] [--out out/four_computers]

Each computer is a network namespace with its own Pd, which opens its patch of patches/audiohaptics/four_computers;
ioa_net connects them by their addresses, with a token, over connections with the given delay, in ms each way, and loss.
A simulated hand taps the disk. Prints the messages that each computer received, and the latency from a hit to the sound
and to the screen; writes each one's messages (NAME.txt), Pd's output (NAME.log) and the sound (sound.wav). Needs root,
for namespaces. The setup of four real computers: docs/four_computers.md.
"""
import argparse
import collections
import pathlib
import sys
import time

import numpy
import scipy.io.wavfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402
from live_session import STAGE, LivePatch, Session  # noqa: E402

PATCHES = ROOT / "patches" / "audiohaptics" / "four_computers"
COMPUTERS = ("device", "interaction", "sound", "screen")
PORTS = {"device": 7771, "sound": 7772, "screen": 7773}  # ports of the interaction's computer
TOPICS = {"device": ("hand", "force"), "interaction": ("hand", "hit", "release", "force"),
          "sound": ("hit", "excite", "hand"), "screen": ("hit", "mark", "hand", "contact", "release")}
EVENTS = {"interaction": ("hit",), "sound": ("excite",), "screen": ("mark",), "device": ()}


def companion(computer):
    """A patch that records the bus and the connections of that computer's patch."""
    patch = LivePatch()
    patch.see("four", *TOPICS[computer])
    for topic in EVENTS[computer]:
        patch.tell(patch.obj(f"r four.{topic}"), 0, topic)
    patch.tell(patch.obj("r four-file-done"), 0, "written")
    nets = [f"four-net-{other}" for other in PORTS] if computer == "interaction" else ["four-net"]
    for net in nets:
        patch.tell(patch.chain(patch.obj(f"r {net}-connected"), "sel 1"), 0, f"{net}-connected")
    return patch


def opened(computer, folder):
    """The patch, with another modal table if that of the disk has not been computed."""
    patch = PATCHES / f"four_{computer}.pd"
    if computer != "sound" or (STAGE / "disk.modal.npz").is_file():
        return patch
    print("four_computers: no disk.modal.npz in the library folder (./play computes it): using a plate")
    other = folder / patch.name
    other.write_text(patch.read_text().replace("disk.modal.npz", "plate.modal.npz"))
    return other


def rows_of(path):
    """The recorded messages of a bus, as lists of words."""
    return [line.rstrip(";").split() for line in path.read_text().splitlines()]


def latency_ms(session, computer, event):
    """Time from each hit at the interaction to the next event at that computer; nan if the next hit came first."""
    hits, effects = session.of("interaction", "hit"), session.of(computer, event)
    found = []
    for hit, following in zip(hits, [*hits[1:], float("inf")]):
        found.append(min((1e3 * (t - hit) for t in effects if hit <= t < following), default=float("nan")))
    return found


def run(words):
    folder = words.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    with EmulatedNetwork(COMPUTERS, delay_ms=words.delay, loss=words.loss) as network, \
            Session(network, folder) as session:
        for computer in COMPUTERS:
            session.play(computer, companion(computer), opens=[opened(computer, folder)])
        for computer, port in PORTS.items():
            session.join(computer, "interaction", port, "four-net", f"four-net-{computer}")
        time.sleep(1)
        session.send("sound", "four-on", "bang")
        session.send("sound", "four-file", f"start {folder / 'sound'} {words.seconds:g}")
        session.send("device", "four-play", "bang")
        time.sleep(words.seconds)
        session.wait("sound", "written")
        for computer in COMPUTERS:
            session.send(computer, "session-write", f"symbol {folder / computer}.txt")
        time.sleep(1)
        latencies = {"sound": latency_ms(session, "sound", "excite"),
                     "screen": latency_ms(session, "screen", "mark")}
        errors = {computer: session.said(computer).count("ioa-error") for computer in COMPUTERS}
    return report(folder, words, latencies, errors)


def report(folder, words, latencies, errors):
    print(f"four computers, delay {words.delay:g} ms in each direction, {words.loss:.0%} of the packets lost\n"
          "| computer | messages seen | wrong messages |\n|---|---|---|")
    hits = {}
    for computer in COMPUTERS:
        rows = rows_of(folder / f"{computer}.txt")
        counts = collections.Counter(row[0] for row in rows)
        hits[computer] = [row[2:6] for row in rows if row[0] == "hit"]
        seen = ", ".join(f"{counts[topic]} {topic}" for topic in TOPICS[computer])
        print(f"| {computer} | {seen} | {errors[computer]} |")
    for computer, values in latencies.items():
        there = [value for value in values if value == value]
        if there:
            print(f"hit to {computer}: median {numpy.median(there):.1f} ms, largest {max(there):.1f} ms, "
                  f"{len(there)} of {len(values)}")
        else:
            print(f"hit to {computer}: none of {len(values)}")
    force = max((sum(float(f) ** 2 for f in row[2:5]) ** 0.5
                 for row in rows_of(folder / "device.txt") if row[0] == "force"), default=0.0)
    rate, sound = scipy.io.wavfile.read(folder / "sound.wav")
    peak = numpy.abs(sound).max()
    scipy.io.wavfile.write(folder / "sound.wav", rate, (sound * (0.5 / peak if peak > 0 else 1)).astype("float32"))
    print(f"largest force at the device {force:.2f} N; {folder / 'sound.wav'}: {len(sound) / rate:.1f} s, "
          f"scaled from a peak of {peak:.3f} to 0.5")
    same = hits["interaction"] == hits["sound"] == hits["screen"]
    print("the hits of interaction, sound and screen are " + ("the same" if same else "NOT the same"))
    return 0 if same and hits["interaction"] else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--delay", type=float, default=5, help="delay in each direction, ms")
    parser.add_argument("--loss", type=float, default=0, help="share of lost packets, 0 to 1")
    parser.add_argument("--seconds", type=float, default=8)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "four_computers")
    try:
        return run(parser.parse_args())
    except NoNamespaces as missing:
        print(f"four_computers: {missing}", file=sys.stderr)
        return 77


if __name__ == "__main__":
    sys.exit(main())
