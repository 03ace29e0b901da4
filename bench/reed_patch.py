#!/usr/bin/env python3
"""How much of a core the whole five-reed patch takes at 48 kHz.

    TACTUS_STAGE=build/tactus bench/reed_patch.py [SECONDS]

Runs patches/reed/reed_haptic.pd (five greed~, five playability~, phantom, map) and a patch with
one [osc~] in headless Pd for that much logical time, five times in turn, and prints processor time
over logical time: median and range. The map that the patch computes once, in a thread of its own,
counts; a longer run thins it out.
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
PATCH = """#N canvas 20 20 420 420 12;
#X obj 20 40 {box};
#X obj 20 80 loadbang;
#X msg 20 120 \\; pd dsp 1;
#X obj 120 120 del {milliseconds};
#X msg 120 160 \\; pd quit;
#X obj 250 120 del 500;
#X msg 250 160 \\; reed-hand target 0 5 -4;
#X obj 350 40 r reed-hand;
#X connect 1 0 2 0;
#X connect 1 0 3 0;
#X connect 3 0 4 0;
#X connect 1 0 5 0;
#X connect 5 0 6 0;
"""


def processor_seconds(box, seconds):
    with tempfile.TemporaryDirectory() as folder:
        patch = pathlib.Path(folder) / "timed.pd"
        patch.write_text(PATCH.format(box=box, milliseconds=1000 * seconds))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(["pd", "-nogui", "-batch", "-nosound", "-noprefs", "-r", "48000",
                        "-path", STAGE, "-open", patch], check=True, timeout=600)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    shares = {"reed_haptic": [], "osc~ 440": []}
    for _ in range(ROUNDS):
        for box, list_of in shares.items():
            list_of.append(100 * processor_seconds(box, seconds) / seconds)
    for box, values in shares.items():
        print(f"{box:12s} {statistics.median(values):6.2f} % of a core "
              f"({min(values):.2f} to {max(values):.2f}), {seconds:g} s, {ROUNDS} rounds")


if __name__ == "__main__":
    main()
