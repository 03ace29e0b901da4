#!/usr/bin/python3
"""Fits a recipe's numbers to what recordings measure: Gauss-Newton steps whose slopes come from a
regression over many points, then CMA-ES (Hansen; Debian: python3-cmaes) until the time is over.

    tune.py --render render_footstep RECIPE... [--label NAME] [--minutes 6]
    tune.py --render render_footstep RECIPE... --recordings   also near ensemble.py's stand-ins
    tune.py --render render_footstep RECIPE --sounds FOLDER     your own recordings, .wav or .ogg

Which numbers are searched, their bounds and priors: searched.py. What they should reach: aims.py. A
recipe of a known name is fitted to the tables; with --sounds the same figures are measured from that
folder first. No classifier is asked. The file is written again whenever a better one is found, so that
the fit may be stopped at any time; comments stay. The recipe's level, in Pa, stays as it was: its first
`level` is set so that the median step has the energy that it had before the fit."""
import argparse
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from scipy.optimize import lsq_linear

import targets
from aims import Aim, Played
from searched import RecipeText
from steps import render

warnings.filterwarnings("ignore")
REACH, POINTS_PER_NUMBER = 0.06, 2
DAMPINGS = (2.0, 6.0, 18.0)
# A candidate for the file is evaluated on so many times the steps of a search point, from another seed.
CONFIRM, CONFIRM_SEED = 2, 1
APPROACH_SHARE = 0.9  # of the time
# Rendered at 22.05 kHz, cells of time and band lie within 1.6 dB rms of rendering at 44.1 kHz, but for
# grounds with a centroid above this.
BRIGHT_HZ = 4000


class Fit:
    """One recipe file and its aim."""

    def __init__(self, path, aim, arguments):
        self.path, self.aim, self.arguments = path, aim, arguments
        self.recipe = RecipeText(path.read_text())
        self.energy = self.median_energy(self.play(self.recipe.at(self.recipe.start), 12, CONFIRM_SEED))
        self.began = time.monotonic()
        self.best, self.point = np.inf, self.recipe.start

    def minutes(self):
        return (time.monotonic() - self.began) / 60

    def play(self, text, steps, seed):
        """Steps shared out among the speeds, and the energies of the sections at the fastest."""
        speeds = self.arguments.speeds
        bright = self.aim.features["centroid_hz"][0] > BRIGHT_HZ
        rate = self.arguments.rate or (44100 if bright else 22050)
        by_speed = []
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            file.write(text)
            file.flush()
            for speed in speeds:
                # At the fastest, where contacts and friction have least of the sound, rustle most.
                shares = speed == max(speeds)
                made = render(self.arguments.render, file.name, max(3, steps // len(speeds)), seed,
                              speed, rate, shares)
                if shares:
                    made, sections = made
                by_speed.append(made)
        return Played(by_speed, sections)

    @staticmethod
    def median_energy(played):
        return float(np.median([np.sum(step * step) for step in played.steps]))

    def cost(self, point, steps, seed):
        return self.aim.cost(self.play(self.recipe.at(point), steps, seed),
                             self.recipe.beyond_prior(point))

    def residuals(self, point, steps, seed):
        return self.aim.residuals(self.play(self.recipe.at(point), steps, seed),
                                  self.recipe.beyond_prior(point))

    def confirm(self, point, name):
        """Evaluates a candidate on many steps; keeps and writes it when it is better."""
        cost, costs = self.cost(point, CONFIRM * self.arguments.steps, CONFIRM_SEED)
        better = cost < self.best
        if better:
            self.best, self.point = cost, point
            if self.point is not self.recipe.start:
                self.path.write_text(self.at_level(point))
        print(f"{self.path.stem} {self.minutes():.1f} min, {name}: {cost:.2f}, best {self.best:.2f} ("
              + " ".join(f"{n} {c:.2f}" for n, c in costs.items()) + ")", flush=True)
        return better

    def at_level(self, point):
        """The text with its first `level` such that the median step keeps its energy."""
        text = self.recipe.at(point)
        factor = np.sqrt(self.energy / self.median_energy(self.play(text, 12, CONFIRM_SEED)))
        lines = text.splitlines()
        row = next((i for i, line in enumerate(lines) if line.startswith("level ")), None)
        if row is None or row > next(i for i, line in enumerate(lines) if line.startswith("[")):
            return text
        lines[row] = f"level {float(lines[row].split()[1]) * factor:.3g}"
        return "\n".join(lines) + "\n"

    def approach(self, minutes):
        """Gauss-Newton steps. Many points around the present one, each of a few steps on the ground and
        all of the same random draws, tell by linear regression how every residual depends on every
        number; many steps at the present point tell how large they are. A damped least-squares solution
        within the bounds goes where that says; the best of several dampings is kept."""
        size = len(self.point)
        random = np.random.RandomState(self.arguments.seed)
        reach, turn = REACH, 0
        while self.minutes() < minutes and reach > REACH / 5:
            turn += 1
            points = np.clip(self.point + reach * random.randn(POINTS_PER_NUMBER * size, size), 0, 1)
            found = np.array([self.residuals(at, self.arguments.few, 1000 * turn) for at in points])
            moved = points - points.mean(axis=0)
            ridge = 0.02 * len(points) * reach ** 2
            slopes = np.linalg.solve(moved.T @ moved + ridge * np.eye(size),
                                     moved.T @ (found - found.mean(axis=0))).T
            here = self.residuals(self.point, CONFIRM * self.arguments.steps, 1000 * turn)
            tried = []
            for damping in DAMPINGS:
                move = lsq_linear(np.vstack([slopes, damping * np.eye(size)]),
                                  np.concatenate([-here, np.zeros(size)]),
                                  (np.maximum(-self.point, -0.3) - 1e-9,
                                   np.minimum(1 - self.point, 0.3) + 1e-9)).x
                there = np.clip(self.point + move, 0, 1)
                tried.append((self.cost(there, self.arguments.steps, CONFIRM_SEED + turn)[0], damping,
                              there))
            _, damping, there = min(tried, key=lambda t: t[0])
            if not self.confirm(there, f"Gauss-Newton step {turn}, damping {damping:g}"):
                reach *= 0.6

    def search(self, minutes):
        """CMA-ES around the best point."""
        from cmaes import CMA
        evolution = CMA(mean=self.point, sigma=self.arguments.sigma,
                        bounds=np.array([[0.0, 1.0]] * len(self.point)), seed=self.arguments.seed)
        generation = 0
        while self.minutes() < minutes and not evolution.should_stop():
            generation += 1
            tried = []
            for _ in range(evolution.population_size):
                point = evolution.ask()
                # One seed for a generation, so that its points are compared fairly; then another.
                tried.append((point, self.cost(point, self.arguments.steps, 100 + generation)[0]))
            evolution.tell(tried)
            if generation % 5 == 0:
                # A generation's winner owes much to its seed: the middle of its better half.
                tried.sort(key=lambda t: t[1])
                self.confirm(np.mean([point for point, _ in tried[:len(tried) // 2]], axis=0),
                             f"generation {generation}")

    def run(self):
        print(f"{self.path.stem}: {len(self.point)} numbers", flush=True)
        self.confirm(self.recipe.start, "start")
        self.approach(APPROACH_SHARE * self.arguments.minutes)
        self.search(self.arguments.minutes)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recipes", nargs="+", type=Path)
    parser.add_argument("--render", required=True)
    parser.add_argument("--label")
    parser.add_argument("--sounds")
    parser.add_argument("--recordings", action="store_true")
    parser.add_argument("--minutes", type=float, default=6, help="a recipe")
    parser.add_argument("--steps", type=int, default=24)
    parser.add_argument("--few", type=int, default=9, help="steps of a point of the regression")
    parser.add_argument("--rate", type=int, help="22050, and 44100, which takes twice the time, for "
                        "grounds whose sound reaches beyond")
    parser.add_argument("--speeds", type=float, nargs="+", default=[1.0, 1.4, 1.8], help="m/s")
    parser.add_argument("--sigma", type=float, default=0.04)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    for path in arguments.recipes:
        label = arguments.label or path.stem
        if not arguments.sounds and label not in targets.FEATURES:
            sys.exit(f"{label}: known are {', '.join(targets.MATERIALS)}; or give --sounds FOLDER")
        aim = Aim.of_folder(arguments.sounds) if arguments.sounds else Aim.of_label(label)
        if arguments.recordings:
            aim.also_near_recordings(label)
        Fit(path, aim, arguments).run()


if __name__ == "__main__":
    main()
