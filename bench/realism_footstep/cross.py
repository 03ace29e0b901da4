#!/usr/bin/python3
"""Fits recipes to one collection of recordings and judges them by another.

    cross.py --render render_footstep [--minutes 3] [--labels dirt highgrass snow concrete]

For the materials that both minetest-data and ardentryst have. Each fit starts from one neutral recipe
that has seen nothing. All distances are energy distances of the 45 features, in units of the recordings'
spread within a material: of the neutral recipe, of the recipe fitted to the first collection (and the
tables), and of the first collection's own recordings, each to the recordings of the second, which the
fit has not seen."""
import argparse
import tempfile
from pathlib import Path

import numpy as np

import judge
from aims import Aim
from population import Population
from recordings import recordings
from steps import RATE, measure, render
from tune import Fit

NEUTRAL = """level 0.1
[solid]
frequency 150
level 1
[grains]
count 100
load 0.01
release 0.001
[rustle]
frequency 1500
level 0.1
load 0.01
release 0.001
[room]
level -15
"""
# Numbers that the search may change have to be written down.
SPELT = {"solid": "modes 8\nratio 1.5\ndetune 0.05\nt60 0.1\nt60_tilt 0.5\ntilt 0.5\nplace 0.3\n"
                  "stiffness 1e7\ndissipation 0.3\nball 0.6\n",
         "grains": "attack 0.01\ndecay 0.05\nexponent 1.5\nlargest 100\nfrequency 1500\nspread 0.8\n"
                   "quality 1\nlength 0.004\nlevel 0.3\nheel 1\nball 0.6\n",
         "rustle": "attack 0.01\ndecay 0.05\nspread 0.9\nquality 0.5\nheel 1\nball 0.6\n",
         "room": "t60 0.3\nbright 3000\n"}


def neutral():
    text = NEUTRAL
    for section, lines in SPELT.items():
        text = text.replace(f"[{section}]\n", f"[{section}]\n{lines}")
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--render", required=True)
    parser.add_argument("--minutes", type=float, default=3, help="a fit")
    parser.add_argument("--labels", nargs="+", default=["dirt", "highgrass", "snow", "concrete"])
    parser.add_argument("--steps", type=int, default=24)
    parser.add_argument("--few", type=int, default=9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=int, default=22050)
    parser.add_argument("--speeds", type=float, nargs="+", default=[1.4])
    parser.add_argument("--sigma", type=float, default=0.04)
    arguments = parser.parse_args()
    taken = recordings()
    vectors, _, _ = measure([r.sound() for r in taken])
    labels, sources = (np.array([getattr(r, k) for r in taken]) for k in ("label", "source"))
    within = Population(vectors, labels).within

    def distance(made, label, source):
        real = vectors[(labels == label) & (sources == source)]
        return judge.energy_distance(made / within, real / within)

    rows = []
    for label in arguments.labels:
        for fitted, other in (("minetest", "ardentryst"), ("ardentryst", "minetest")):
            with tempfile.TemporaryDirectory() as folder:
                start, copy = Path(folder, "neutral.txt"), Path(folder, f"{label}.txt")
                for path in (start, copy):
                    path.write_text(neutral())
                aim = Aim.of_label(label)
                aim.also_near_recordings(label, fitted)
                Fit(copy, aim, arguments).run()
                before, after = (measure(render(arguments.render, path, 30, 11, rate=RATE))[0]
                                 for path in (start, copy))
            own = vectors[(labels == label) & (sources == fitted)]
            rows.append((label, fitted, other, distance(before, label, other),
                         distance(after, label, other), distance(own, label, other)))
    print("| material | fitted to | judged by | neutral | fitted | the first's recordings |")
    print("|---|---|---|---|---|---|")
    for label, fitted, other, *figures in rows:
        print(f"| {label} | {fitted} | {other} | " + " | ".join(f"{v:.1f}" for v in figures) + " |")


if __name__ == "__main__":
    main()
