#!/usr/bin/python3
"""Fits recipes to one collection of recordings and compares them with another.

    cross.py --render render_footstep [--minutes 3] [--labels dirt highgrass snow concrete]

For the materials that both minetest-data and ardentryst have. Each fit starts from one neutral recipe
that has seen nothing and sees the recordings of one collection only: no table (they hold all collections),
no stand-in. Two energy distances to the recordings of the second collection: of the 45 features, and of
the 140 levels of band and time, both in units of the recordings' spread within a material; for the
neutral recipe, the fitted one, and the first collection's own recordings."""
import argparse
import tempfile
from pathlib import Path

import numpy as np

import comparison
from aims import Aim
from recordings import recordings
from band_classifiers import cells
from steps import measure, render
from tune import Fit

NEUTRAL = """level 0.1
radiation 60
vary_frequency 0.1
vary_decay 0.15
[solid]
modes 12
frequency 150
ratio 1.3
t60 0.07
t60_tilt 0.5
tilt 0.5
place 0.3
stiffness 1e8
dissipation 0.5
ball 1
ball_mass 0.05
patches 4
unevenness 0.004
vary_frequency 0.05
vary_level 0.15
[grains]
count 100
attack 0.005
decay 0.04
exponent 1.5
largest 100
frequency 1500
spread 0.8
quality 1
length 0.003
level 0.3
ball 0.8
load 0.01
release 0.003
vary_level 0.2
[rustle]
attack 0.005
decay 0.04
frequency 1500
spread 0.8
quality 0.4
level 0.05
ball 0.8
load 0.01
[room]
level -12
t60 0.35
bright 3000
"""


def within(vectors, labels):
    """Standard deviation of sounds of one label, root mean square over labels."""
    return np.sqrt(np.mean([vectors[labels == c].var(axis=0, ddof=1) for c in sorted(set(labels))],
                           axis=0)) + 1e-9


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--render", required=True)
    parser.add_argument("--minutes", type=float, default=3, help="a fit")
    parser.add_argument("--labels", nargs="+", default=["dirt", "highgrass", "snow", "concrete"])
    parser.add_argument("--steps", type=int, default=24)
    parser.add_argument("--few", type=int, default=9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=int, default=22050)
    parser.add_argument("--speeds", type=float, nargs="+", default=[1.0, 1.4, 1.8])
    parser.add_argument("--sigma", type=float, default=0.04)
    arguments = parser.parse_args()
    taken = recordings()
    sounds = [r.sound() for r in taken]
    labels, sources = (np.array([getattr(r, k) for r in taken]) for k in ("label", "source"))
    heard = {"features": lambda s: measure(s)[0], "bands in time": cells}
    real = {name: of(sounds) for name, of in heard.items()}
    spread = {name: within(vectors, labels) for name, vectors in real.items()}

    def distances(made, label, source):
        """One for each way to hear; made: {name: vectors}."""
        return [comparison.energy_distance(made[name] / spread[name],
                                      real[name][(labels == label) & (sources == source)] / spread[name])
                for name in heard]

    rows = []
    for label in arguments.labels:
        for fitted, other in (("minetest", "ardentryst"), ("ardentryst", "minetest")):
            first = (labels == label) & (sources == fitted)
            with tempfile.TemporaryDirectory() as folder:
                start, copy = Path(folder, "neutral.txt"), Path(folder, f"{label}.txt")
                for path in (start, copy):
                    path.write_text(NEUTRAL)
                aim = Aim.of_sounds([sounds[i] for i in np.flatnonzero(first)])
                Fit(copy, aim, arguments).run()
                before, after = (
                    [step for speed in arguments.speeds
                     for step in render(arguments.render, path, 10, 11, speed)]
                    for path in (start, copy))
            figures = [distances({name: of(steps) for name, of in heard.items()}, label, other)
                       for steps in (before, after)]
            figures.append(distances({name: v[first] for name, v in real.items()}, label, other))
            rows.append((label, fitted, other, *np.transpose(figures).ravel()))
    print("| material | fitted to | compared with | "
          + " | ".join(f"{name}: {whose}" for name in heard
                       for whose in ("neutral", "fitted", "the first's recordings")) + " |")
    print("|---" * 9 + "|")
    for label, fitted, other, *figures in rows:
        print(f"| {label} | {fitted} | {other} | " + " | ".join(f"{v:.1f}" for v in figures) + " |")


if __name__ == "__main__":
    main()
