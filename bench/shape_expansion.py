#!/usr/bin/python3
"""How far the frequencies of a reshaped body are from a new solve, for four first-order rules.

    bench/shape_expansion.py build [-o docs/results/shape_expansion.csv]

Meshes of a cantilever and of a free plate are moved node by node, stretched along an axis or thickened
towards the middle of their length, and solved again by modal_fem.
The derivatives are central differences of solves at +-0.1 %, so nothing here shares code with
eigenvalue_sensitivity(). Modes are compared in ascending order; a row gives the largest error of the
first modes in percent of the frequency:

  linear      w^2 = w0^2 + w0^2 g d            root        w = w0 + w0 g d/2
  logarithm   w^2 = w0^2 exp(g d)              reciprocal  w^2 = w0^2/(1 - g d)
"""
import argparse
import csv
import pathlib
import subprocess
import sys
import tempfile

import numpy

MODES, SOLVED = 6, 12  # compared; solved, as modes cross
BODIES = {  # name: options, whether its end at the lowest x is held
    "cantilever": (["bar", "--length", "300", "--width", "20", "--thickness", "6",
                    "--h", "10", "--tolerance", "0"], True),
    "plate": (["plate", "--length", "320", "--width", "200", "--thickness", "5",
               "--h", "16", "--tolerance", "0"], False),
}
STEPS = [-.2, -.1, -.05, -.01, .01, .05, .1, .2]


def scaled(axis):
    def move(x, d):
        y = x.copy()
        low = x[:, axis].min()
        y[:, axis] = low + (x[:, axis] - low) * (1 + d)
        return y
    return move


def bulged(x, d):
    """The upper face rises by d heights in the middle of its length, as a parabola."""
    t = (x - x.min(0)) / numpy.ptp(x, 0)
    weight = 4 * t[:, 0] * (1 - t[:, 0]) * t[:, 2] ** 2
    y = x.copy()
    y[:, 2] += d * numpy.ptp(x[:, 2]) * weight
    return y


MOVES = {"length": scaled(0), "width": scaled(1), "height": scaled(2), "bulge": bulged}


def read_inp(path):
    lines = path.read_text().splitlines()
    first = next(i for i, s in enumerate(lines) if s.upper().startswith("*NODE")) + 1
    last = next(i for i in range(first, len(lines)) if lines[i].startswith("*"))
    rows = [s.split(",") for s in lines[first:last]]
    return lines, first, last, [r[0] for r in rows], numpy.array([[float(c) for c in r[1:4]]
                                                                  for r in rows])


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("build")
    options.add_argument("-o", "--output")
    options = options.parse_args()
    program = pathlib.Path(options.build) / "programs/modal_fem/modal_fem"
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        base = folder / "base.inp"
        for body, (shape, clamped) in BODIES.items():
            subprocess.run([program, *shape, "--export-inp", base, "--quiet"], check=True,
                           stdout=subprocess.DEVNULL)
            lines, first, last, names, nodes = read_inp(base)

            def solve(points):
                moved = folder / "moved.inp"
                text = [f"{n}, " + ", ".join(f"{c:.12g}" for c in p) for n, p in zip(names, points)]
                moved.write_text("\n".join([*lines[:first], *text, *lines[last:]]) + "\n")
                out = folder / "modes.csv"
                fixed = ["--fix", f"x={points[:, 0].min():.12g}"] if clamped else []
                subprocess.run([program, moved, "--unit", "m", "--modes", str(SOLVED), *fixed,
                                "--tolerance", "0", "--csv", out, "--quiet"], check=True,
                               stdout=subprocess.DEVNULL)
                with open(out) as file:
                    return numpy.array([float(r["frequency_hz"]) for r in csv.DictReader(file)])

            still = solve(nodes)
            for name, move in MOVES.items():
                h = 1e-3
                g = (solve(move(nodes, h)) ** 2 - solve(move(nodes, -h)) ** 2) / (2 * h * still ** 2)
                for d in STEPS:
                    exact = solve(move(nodes, d))
                    x = g * d
                    with numpy.errstate(invalid="ignore", divide="ignore"):
                        rules = {"linear": numpy.sqrt(1 + x), "logarithm": numpy.exp(x / 2),
                                 "root": 1 + x / 2, "reciprocal": 1 / numpy.sqrt(1 - x)}
                    error = {k: 100 * max(abs(numpy.sort(still * v)[:MODES] / exact[:MODES] - 1))
                             for k, v in rules.items()}
                    rows.append({"body": body, "move": name, "step": d,
                                 "largest_change_percent": f"{100 * max(abs(exact / still - 1)[:MODES]):.3g}",
                                 **{k: f"{v:.3g}" for k, v in error.items()}})
                    print(rows[-1], flush=True)
    if options.output:
        with open(options.output, "w", newline="") as file:
            table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
