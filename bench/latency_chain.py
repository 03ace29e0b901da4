#!/usr/bin/python3
"""How long a contact takes to the force and to the sound: in one Pd, over a network, over the bus.

    bench/latency_chain.py [--build build] [--seconds 60] [--out out/latency_chain]

Chains, each on one computer and over lines of 1, 10 and 50 ms each way between two network namespaces:

    contact -> force, phantom net   the device's handle crosses the disk's face at a haptic_server; the
                                    scene in the Pd of the other computer meets it, its spring's force
                                    comes back to the device's servo
    contact -> sound, phantom net   the same contact, to the strike's first block of sound in that Pd
    hit -> sound, bus               a hit on the bus of one Pd, to the strike's first block in another
    hand -> force, bus              a hand on the bus of one Pd crosses the face; interaction server and
                                    spring are another Pd's; to the force on the first bus

and one Pd alone, in its logical time. Prints a table (median, 99 %, largest; how many of how many taps
were found), writes every tap to latencies.csv and a picture. Times are one clock's (CLOCK_MONOTONIC).
Sound cards add their buffer; the largest of 60 taps is what 99 % can tell. A tap a second: no effect comes
after the next tap, since the bus lets nothing out later than 0.4 s after it was sent. Needs root for
namespaces.
"""
import argparse
import bisect
import csv
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
for folder in ("scripts", "scripts/scenes", "tests/patches"):
    sys.path.insert(0, str(ROOT / folder))
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402
from live_session import STAGE, LivePatch, Session  # noqa: E402

PAPER_FORCE_MS, PAPER_SOUND_MS = 1.0, 1000 / 16  # periods of the paper's loops: 1 kHz, 16 Hz
LINES_MS = (None, 1, 10, 50)  # None: one computer
PERIOD_MS, FACE_MM, HIGH_MM, DEEP_MM, SPEED_MM_PER_MS, HOLD_MS = 1000, 6.0, 9.0, 4.0, 0.25, 80
TABLE = "disk.modal.npz" if (STAGE / "disk.modal.npz").is_file() else "plate.modal.npz"
FEEL_PORT, TOUCH_PORT = 7771, 7772
NICE = -10  # other programs of this machine are not what is measured


def taps(path, seconds, start_ms=0.0):
    """Rows of a hand that presses the face of the disk 2 mm deep once a second, at x = 25 mm."""
    rows, down_ms = [], (HIGH_MM - DEEP_MM) / SPEED_MM_PER_MS
    for begin in numpy.arange(start_ms, start_ms + 1e3 * seconds, PERIOD_MS):
        rows += [(begin, HIGH_MM), (begin + down_ms, DEEP_MM), (begin + down_ms + HOLD_MS, DEEP_MM),
                 (begin + 2 * down_ms + HOLD_MS, HIGH_MM)]
    path.write_text("".join(f"{ms:g} 25 0 {z:g}\n" for ms, z in rows))
    return path


def matched(causes_s, effects_s):
    """For each cause the ms to the first effect before the next cause; nan when there is none."""
    effects = sorted(effects_s)
    found = []
    for cause, following in zip(causes_s, [*causes_s[1:], causes_s[-1] + PERIOD_MS / 1e3]):
        at = bisect.bisect_left(effects, cause)
        found.append(1e3 * (effects[at] - cause) if at < len(effects) and effects[at] < following
                     else float("nan"))
    return found


def computers(line_ms):
    """An emulated network, and which of its computers has the hand and which the sound."""
    if line_ms is None:
        return EmulatedNetwork(["both"], nice=NICE), "both", "both"
    return EmulatedNetwork(["hand", "sound"], delay_ms=line_ms, nice=NICE), "hand", "sound"


def sounding(patch, name):
    """The contents and the sound of the disk on that bus; `sound` at the first block of each strike."""
    patch.obj(f"ioa_cs_modal {name} disk {TABLE}")
    body = patch.obj(f"ioa_r_modal {name} disk")
    patch.tell(patch.chain(body, "threshold~ 0.001 30 0.0005 30", outlet=2), 0, "sound")
    patch.cord(patch.obj("loadbang"), 0, on := patch.msg("\\; pd dsp 1"))
    return on


def phantom_net(build, line_ms, seconds, folder):
    """{chain: ms of each tap} with the device behind haptic_server."""
    network, hand, sound = computers(line_ms)
    with network, Session(network, folder) as session:
        token, trace = folder / "token", folder / "trace.csv"
        token.write_text("sixteen bytes ok\n")
        token.chmod(0o600)
        address = network.address(hand) if line_ms is not None else "127.0.0.1"
        server = network.start(
            hand, [build / "programs/haptic_server/haptic_server", "--listen", address, "--port", 0,
                   "--token", token, "--hand", "rigid", "--path",
                   taps(folder / "path", seconds + 30), "--trace", trace],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        port = re.search(r"on \S+:(\d+)", server.stdout.readline())[1]
        patch = LivePatch()
        for module in ("sdd_phantom lab", "re lab", "is lab", "mm_haptic lab disk_scene.txt",
                       "r_spring lab", "ddd_phantom lab"):
            patch.obj(f"ioa_{module}")
        sounding(patch, "lab")
        status = patch.chain(patch.obj("r lab.phantom-info"), "route status", "route open")
        patch.tell(status, 0, "opened")
        session.play(sound, patch)
        for words in (f"backend net {address} {port}", f"driver token {token}", "report status 1", "open"):
            session.send(sound, "lab.phantom", words)
        session.wait(sound, "opened")
        session.send(sound, "lab.phantom", "motors 1")
        time.sleep(1)
        begin = time.monotonic()
        time.sleep(seconds)
        end = time.monotonic()
        time.sleep(0.5)
        server.terminate()
        server.wait()
        heard = session.of(sound, "sound")
    with open(trace, newline="") as file:
        ticks = numpy.array([[float(row[key]) for key in ("ms", "z_mm", "fx_n", "fy_n", "fz_n")]
                             for row in csv.DictReader(file)])
    at_s, inside, felt = ticks[:, 0] / 1e3, ticks[:, 1] < FACE_MM, (ticks[:, 2:] != 0).any(axis=1)
    contacts = [t for t in at_s[1:][inside[1:] & ~inside[:-1]] if begin < t < end]
    forces = at_s[1:][felt[1:] & ~felt[:-1]]
    return {"contact -> force, phantom net": matched(contacts, forces),
            "contact -> sound, phantom net": matched(contacts, heard)}


def over_the_bus(line_ms, seconds, folder):
    """{chain: ms of each tap} with modules on two Pds, joined by ioa_net."""
    network, near_computer, far_computer = computers(line_ms)
    hand, sound = "hand", "sound"
    with network, Session(network, folder) as session:
        near, far = LivePatch(), LivePatch(number=1)
        path = taps(folder / "path", seconds + 3, start_ms=500)
        for name in ("touch", "feel"):
            near.cord(near.obj(f"r {name}-play"), 0, near.obj(f"ioa_sdd_script {name} {path}"))
            near.obj(f"ioa_re {name} 1")
        for module in ("is touch", "mm_haptic touch disk_scene.txt"):
            near.obj(f"ioa_{module}")
        for module in ("is_pd feel", "mm_haptic feel disk_scene.txt", "r_spring feel", "mm_sound touch"):
            far.obj(f"ioa_{module}")
        sounding(far, "touch")
        for patch, name, topics in ((near, "touch", " hit model"), (near, "feel", " hand"),
                                    (far, "touch", ""), (far, "feel", " force")):
            patch.net(f"{name}-net", f"{name}{topics}")
        near.tell(near.obj("r touch.hit"), 0, "hit")
        for receiver, test, word in (("feel.hand", f"expr $f4 < {FACE_MM:g}", "crossing"),
                                     ("feel.force", "expr abs($f2) + abs($f3) + abs($f4) > 1e-6", "force")):
            change = near.chain(near.obj(f"r {receiver}"), "route hand force", outlet=0)
            fork = near.obj(test.replace("$", "\\$").replace(",", "\\,"))
            near.cord(change, 0, fork)
            near.cord(change, 1, fork)
            near.tell(near.chain(fork, "change", "sel 1"), 0, word)
        session.play(far_computer, far, name=sound)
        session.play(near_computer, near, name=hand)
        for name, port in (("touch", TOUCH_PORT), ("feel", FEEL_PORT)):
            session.join(hand, sound, port, f"{name}-net", f"{name}-net")
        time.sleep(1)
        for name in ("touch", "feel"):
            session.send(hand, f"{name}-play", "bang")
        time.sleep(1)
        begin = time.monotonic()
        time.sleep(seconds)
        end = time.monotonic()
        time.sleep(0.5)

        def between(word):
            return [t for t in session.of(hand, word) if begin < t < end]
        return {"hit -> sound, bus": matched(between("hit"), session.of(sound, "sound")),
                "hand -> force, bus": matched(between("crossing"), session.of(hand, "force"))}


def one_pd(folder):
    """The same chain in one Pd, in the logical time in which its simulated device lives."""
    from _audiohaptics import latencies
    found = latencies(taps(folder / "path", 3), seconds=3.2, table=TABLE)
    return {"contact -> force, one Pd": [felt - t for t, felt, _ in found],
            "contact -> sound, one Pd": [heard - t for t, _, heard in found]}


def line_name(line_ms):
    return "one computer" if line_ms is None else f"{line_ms} ms each way"


def row_of(chain, line, values):
    times = numpy.array([value for value in values if value == value])
    found = f"{len(times)} of {len(values)}"
    if len(times) == 0:
        return f"| {chain} | {line} | {found} | - | - | - | - |"
    paper_ms = PAPER_FORCE_MS if "force" in chain else PAPER_SOUND_MS
    median = numpy.median(times)
    return (f"| {chain} | {line} | {found} | {median:.2f} | {numpy.quantile(times, 0.99):.2f} | "
            f"{times.max():.2f} | {median / paper_ms:.3g} of {paper_ms:g} ms |")


def picture(results, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(9, 0.42 * len(results) + 1.6))
    shown = [((chain, line), [v for v in values if v == v]) for (chain, line), values in results.items()]
    random = numpy.random.default_rng(1)
    for row, ((chain, line), times) in enumerate(shown):
        colour = "#b5482f" if "force" in chain else "#2f6f8f"
        axes.scatter(numpy.maximum(times, 0.01), row + random.uniform(-0.22, 0.22, len(times)), s=7,
                     alpha=0.5, color=colour, linewidths=0)
        if times:
            axes.plot(2 * [max(numpy.median(times), 0.01)], [row - 0.35, row + 0.35], color="black", lw=1.5)
    for at, text in ((PAPER_FORCE_MS, "paper's haptic loop\n1 kHz"), (PAPER_SOUND_MS, "paper's audio loop\n16 Hz")):
        axes.axvline(at, color="#888888", lw=1, ls="--")
        axes.text(at, -0.75, text, ha="center", va="bottom", fontsize=8, color="#555555")
    axes.set(xscale="log", xlim=(0.008, 1000), ylim=(len(shown) - 0.4, -0.6), xlabel="ms (0 is drawn at 0.01)",
             yticks=range(len(shown)), yticklabels=[f"{chain}\n{line}" for (chain, line), _ in shown])
    axes.tick_params(axis="y", labelsize=7)
    axes.set_xticks([0.01, 0.1, 1, 10, 100], ["0", "0.1", "1", "10", "100"])
    axes.grid(axis="x", alpha=0.25)
    figure.suptitle("From contact to force (red) and to sound (blue); a dot a tap, a bar the median", fontsize=10)
    figure.tight_layout()
    figure.savefig(path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--seconds", type=float, default=60, help="of taps, one a second, in each run")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "latency_chain")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    results = {}

    def run(line, measure, *arguments):
        with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
            for chain, values in measure(*arguments, pathlib.Path(folder)).items():
                results[chain, line] = values
                print(row_of(chain, line, values), flush=True)

    print(f"ms; the strike is of {TABLE}\n"
          "| chain | line | found | median | 99 % | largest | median in the paper's periods |\n"
          "|---|---|---|---|---|---|---|")
    try:
        run("logical time", one_pd)
        for line_ms in LINES_MS:
            run(line_name(line_ms), phantom_net, words.build, line_ms, words.seconds)
        for line_ms in LINES_MS:
            run(line_name(line_ms), over_the_bus, line_ms, words.seconds)
    except NoNamespaces as missing:
        sys.exit(f"latency_chain: {missing}")
    with open(words.out / "latencies.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["chain", "line", "tap", "ms"])
        for (chain, line), values in results.items():
            rows.writerows((chain, line, tap, f"{ms:.3f}") for tap, ms in enumerate(values))
    picture(results, words.out / "latencies.png")
    missing = sum(value != value for values in results.values() for value in values)
    print(f"\n{missing} of {sum(map(len, results.values()))} taps without an effect before the next tap; "
          f"{words.out}/latencies.csv, latencies.png")


if __name__ == "__main__":
    main()
