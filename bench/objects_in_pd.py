#!/usr/bin/env python3
"""How much of a core an object takes in Pd at 48 kHz, and how many [osc~] that is.

    TACTUS_STAGE=build/tactus bench/objects_in_pd.py [SECONDS]

Renders in headless Pd, five times in turn, a patch with 40 of each object, one with 1000 [osc~] and an empty one. Printed
is processor time, less that of the empty patch, over logical time, per object: median and range; and its ratio to one
[osc~], which depends least on the machine.
"""
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
STAGE = pathlib.Path(os.environ.get("TACTUS_STAGE", ROOT / "build" / "tactus")).resolve()
ROUNDS = 5
# Copies and the numbers of the signal inlets, by box.
OSC = "osc~ 440"
CASES = {
    OSC: (1000, {}),
    "greed~ -preset clarinet": (40, {0: 2500}),
    "greed~ -preset clarinet -tune 1": (40, {0: 2500, 2: 262}),
    "footstep~ gravel -walk 0": (40, {}),
    "footstep~ gravel -walk 1": (40, {}),
    "footstep~ wood -walk 1": (40, {}),
    "footstep~ gravel -feet 2 -walk 1": (40, {}),
}


def patch(box, copies, inlets, milliseconds):
    lines = ["#N canvas 20 20 420 420 12;", "#X obj 20 20 loadbang;", "#X msg 20 60 \\; pd dsp 1;",
             f"#X obj 120 60 del {milliseconds};", "#X msg 120 100 \\; pd quit;"]
    cords = [(0, 0, 1, 0), (0, 0, 2, 0), (2, 0, 3, 0)]
    signal = {}
    for inlet, number in inlets.items():
        signal[inlet] = len(lines) - 1
        lines.append(f"#X obj 320 {60 + 30 * inlet} sig~ {number};")
    for _ in range(copies):
        index = len(lines) - 1
        lines.append(f"#X obj 20 200 {box};")
        cords += [(signal[inlet], 0, index, inlet) for inlet in inlets]
    return "\n".join(lines + [f"#X connect {a} {i} {b} {j};" for a, i, b, j in cords]) + "\n"


def processor_seconds(text):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "timed.pd"
        file.write_text(text)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(["pd", "-nogui", "-batch", "-nosound", "-noprefs", "-r", "48000", "-path", STAGE, "-open", file],
                       check=True, timeout=600)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    found = {box: [] for box in CASES}
    for _ in range(ROUNDS):
        empty = processor_seconds(patch("", 0, {}, 1000 * seconds))
        for box, (copies, inlets) in CASES.items():
            spent = processor_seconds(patch(box, copies, inlets, 1000 * seconds))
            found[box].append(100 * (spent - empty) / seconds / copies)
    unit = statistics.median(found[OSC])
    for box, shares in found.items():
        share = statistics.median(shares)
        print(f"{box:34s} {share:7.4f} % of a core ({min(shares):.4f} to {max(shares):.4f}) {share / unit:7.1f} osc~")


if __name__ == "__main__":
    main()
