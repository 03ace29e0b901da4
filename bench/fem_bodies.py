#!/usr/bin/python3
"""What the eleven bodies of ./play bodies cost with two builds of modal_fem, and whether they are the same:
    fem_bodies.py BEFORE AFTER [--runs 1] [--only NAME]   two programs; processor seconds in turn, the least of the
                                                          runs, and the largest differences of frequencies, of losses
                                                          to the air and of the waves' coefficients (of the largest)
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "scripts" / "scenes"), str(ROOT / "tests" / "patches")]
os.environ.setdefault("TACTUS_STAGE", str(ROOT / "build" / "tactus"))
import _tour  # noqa: E402


def run(program, words, path):
    """Processor seconds."""
    before = os.times()
    subprocess.run([program, *words, "--quiet", "-o", path], check=True, stdout=subprocess.DEVNULL,
                   env=dict(os.environ, OPENBLAS_NUM_THREADS="1"))
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def difference(before, after):
    """(of frequencies, of losses, each in parts of itself; of coefficients in parts of the largest)"""
    a, b = numpy.load(before), numpy.load(after)
    found = [abs(b[name] / a[name] - 1).max() for name in ("freq", "alpha_rad")]
    return [*found, max(abs(b[name] - a[name]).max() / abs(a[name]).max() for name in ("mp_coef", "mp_band_coef"))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--only", default="", help="bodies with this in their names")
    arguments = parser.parse_args()
    print("| body | before, s | after, s | ratio | frequencies | losses | waves |\n|---|---|---|---|---|---|---|")
    total = [0.0, 0.0]
    for name, (words, *_) in _tour.BODIES.items():
        if arguments.only not in name:
            continue
        words = [str(_tour.lever() if w == "LEVER" else w) for w in (*words, *_tour.AIR)]
        with tempfile.TemporaryDirectory() as folder:
            paths = [f"{folder}/{side}.modal.npz" for side in ("before", "after")]
            runs = [[run(program, words, path) for program, path in zip((arguments.before, arguments.after), paths)]
                    for _ in range(arguments.runs)]
            seconds = [min(column) for column in zip(*runs)]
            differences = difference(*paths)
        total = [t + s for t, s in zip(total, seconds)]
        print(f"| {name} | {seconds[0]:.1f} | {seconds[1]:.1f} | {seconds[0] / seconds[1]:.2f} | "
              + " | ".join(f"{d:.0e}" for d in differences) + " |", flush=True)
    print(f"| all | {total[0]:.1f} | {total[1]:.1f} | {total[0] / total[1]:.2f} | | | |")


if __name__ == "__main__":
    main()
