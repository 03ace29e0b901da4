#!/usr/bin/python3
"""Fits recipes to one collection of recordings and judges them by another.

    cross.py --render render_footstep [--approach 2]

For the materials that both minetest-data and ardentryst have. All distances are energy distances of the
45 features, in units of the recordings' spread within a material: of the shipped recipe, of the recipe
fitted to the first collection (and the tables), and of the first collection's own recordings, each to
the recordings of the second, which the fit has not seen."""
import argparse
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import judge
from population import Population
from recordings import recordings
from steps import RATE, measure, render
from tune import Aim, approach

ROOT = Path(__file__).resolve().parents[2]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--render", required=True)
    parser.add_argument("--approach", type=int, default=2)
    parser.add_argument("--steps", type=int, default=16)
    parser.add_argument("--rate", type=int, default=22050)
    arguments = parser.parse_args()
    taken = recordings()
    vectors, _, _ = measure([r.sound() for r in taken])
    labels, sources = (np.array([getattr(r, k) for r in taken]) for k in ("label", "source"))
    within = Population(vectors, labels).within

    def distance(made, label, source):
        real = vectors[(labels == label) & (sources == source)]
        return judge.energy_distance(made / within, real / within)

    rows = []
    for label in ("dirt", "highgrass", "snow", "concrete"):
        shipped = ROOT / "data" / "surfaces" / f"{label}.txt"
        for fitted, other in (("minetest", "ardentryst"), ("ardentryst", "minetest")):
            with tempfile.TemporaryDirectory() as folder:
                copy = Path(folder, f"{label}.txt")
                copy.write_text(shipped.read_text())
                aim = Aim.of_label(label)
                aim.also_near_recordings(label, fitted)
                approach(copy, aim, SimpleNamespace(**vars(arguments)))
                before, after = (measure(render(arguments.render, path, 30, 11, rate=RATE))[0]
                                 for path in (shipped, copy))
            own = vectors[(labels == label) & (sources == fitted)]
            rows.append((label, fitted, other, distance(before, label, other),
                         distance(after, label, other), distance(own, label, other)))
    print("| material | fitted to | judged by | shipped | fitted | the first's recordings |")
    print("|---|---|---|---|---|---|")
    for label, fitted, other, *figures in rows:
        print(f"| {label} | {fitted} | {other} | " + " | ".join(f"{v:.1f}" for v in figures) + " |")


if __name__ == "__main__":
    main()
