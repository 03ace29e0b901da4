#!/usr/bin/python3
"""Fits a recipe's numbers to what recordings measure: a few Gauss-Newton steps towards their means, then
CMA-ES (Hansen; Debian: python3-cmaes) for all the rest.

    tune.py --render render_footstep RECIPE... [--label NAME] [--rounds 60] [--steps 16]
    tune.py --render render_footstep RECIPE... --recordings   also near Debian's recordings
    tune.py --render render_footstep RECIPE --sounds FOLDER     your own recordings, .wav or .ogg

A recipe of a known name is fitted to the tables of targets.py: for each feature how far its median
lies from the recordings', in units of their spread, how far its spread is from theirs, and how many
dB the mean band profile is off. With --sounds the same figures are measured from that folder first.
With --recordings come the energy distances of all 45 features to ensemble.py's stand-ins for the
collections behind the tables and, for a material that has two or more, to Debian's recordings. No
classifier is asked.
The file is written again whenever a better one is found; its comments stay.
"""
import argparse
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
from scipy.optimize import lsq_linear

import judge
import targets
from ensemble import members
from population import Population
from recordings import recordings
from steps import RATE, measure, render

warnings.filterwarnings("ignore")
# Numbers that say how strongly, how long or how high: searched on a logarithmic scale.
LINEAR = {"t60_tilt": (-0.5, 1.5), "tilt": (-1.5, 2.5), "place": (0.0, 1.0), "detune": (0.0, 0.3),
          "dissipation": (0.02, 3.0), "exponent": (0.4, 4.0), "lower_by_size": (0.0, 0.5),
          "spread": (0.05, 1.5), "vary_frequency": (0.0, 0.6), "vary_decay": (0.0, 0.45),
          "vary_level": (0.0, 0.8), "heel": (0.0, 3.0), "ball": (0.0, 2.0),
          "ratio": (1.02, 2.2), "roughness": (0.0, 3.0), "wobble": (0.0, 0.8)}
LOGARITHMIC = {"frequency": (40, 10000), "t60": (0.005, 1.5), "stiffness": (1e3, 1e11),
               "attack": (2e-4, 0.4), "decay": (0.003, 0.3), "largest": (2, 3000), "count": (3, 3000),
               "quality": (0.3, 12), "length": (2e-4, 0.03), "level": (1e-4, 1e4), "slip": (0.005, 1),
               "pressed": (0.5, 60), "load_n": (0.5, 200), "radiation": (10, 1500),
               "stribeck": (0.005, 0.5), "load": (1e-4, 3), "release": (1e-4, 1), "bright": (300, 10000)}
ROOM_LEVEL = (-40.0, 3.0)  # dB
KEPT = {"modes", "heel_kg", "ball_mass", "mass", "mu_s", "mu_d", "breakaway", "damping", "viscosity",
        "gains", "rise"}


# An energy distance of 1 is about half a standard deviation of each feature.
TO_TABLES, TO_STAND_IN, TO_RECORDINGS, AT_OTHER_SPEEDS = 2.0, 2.0, 0.05, 0.3
TO_ONE_COLLECTION = 0.4  # where nothing else is to be known
MATERIALS_APART = 2.5
# Where the stand-ins disagree they count less; here they doubt their regression more.
MEMBERS, DOUBT, MOST_NEAR = 12, 0.6, 240
# One walker in one pair of shoes varies less than eight collections do.
OF_SPREAD = 0.75
REACH, MANY = 0.06, 2


def worlds_within(worlds):
    """(45): standard deviation of sounds of one label, root mean square over labels."""
    return np.sqrt(np.mean([v[n == c].var(axis=0) for v, n in worlds for c in sorted(set(n))], axis=0))


class Text:
    """A recipe's lines, with those numbers that are searched."""

    def __init__(self, path):
        self.lines = path.read_text().splitlines()
        self.numbers = []  # line, key, low, high, logarithmic
        section = ""
        for i, line in enumerate(self.lines):
            words = line.split("#")[0].split()
            if not words:
                continue
            if words[0].startswith("["):
                section = words[0].strip("[]")
                continue
            key = words[0]
            if key in KEPT or (section == "" and key == "level") or (
                    section == "solid" and key in ("heel", "exponent")):
                continue
            if section == "friction" and key == "load":
                low, high, log = *LOGARITHMIC["load_n"], True
            elif section == "friction" and key == "stiffness":
                low, high, log = 1e3, 1e7, True
            elif section == "room" and key == "level":
                low, high, log = *ROOM_LEVEL, False
            elif section == "room" and key == "t60":
                low, high, log = 0.05, 1.5, True
            elif key in LINEAR:
                low, high, log = *LINEAR[key], False
            elif key in LOGARITHMIC:
                low, high, log = *LOGARITHMIC[key], True
            else:
                continue
            self.numbers.append((i, key, low, high, log))

    def point(self):
        values = []
        for i, _, low, high, log in self.numbers:
            v = min(max(float(self.lines[i].split()[1]), low), high)
            values.append(np.log(v / low) / np.log(high / low) if log else (v - low) / (high - low))
        return np.array(values)

    def at(self, point):
        lines = list(self.lines)
        for (i, key, low, high, log), p in zip(self.numbers, np.clip(point, 0, 1)):
            value = low * (high / low) ** p if log else low + p * (high - low)
            comment = lines[i].partition("#")[2]
            lines[i] = f"{key} {value:.4g}" + (f"  #{comment}" if comment else "")
        return "\n".join(lines) + "\n"


class Aim:
    """Medians, 10 and 90 % of features and a profile that a recipe should have."""

    def __init__(self, features, profile, bands):
        self.features, self.profile, self.bands = features, np.array(profile, float), bands
        self.near = []  # (weight, matrix, vectors by the matrix)

    def also_near_recordings(self, label, source=None):
        """Adds the distances to all 45 features of the stand-ins and of the installed recordings, or of
        those of one source."""
        taken = [r for r in recordings() if source in (None, r.source)]
        labels = np.array([r.label for r in taken])
        vectors, _, _ = measure([r.sound() for r in taken])
        if source:
            worlds = [Population(vectors, labels).sounds()]
        else:
            worlds = [w[:2] for w in members(vectors, labels, MEMBERS, of_error=DOUBT)]
        drawn = np.vstack([v for v, _ in worlds])
        names = np.concatenate([n for _, n in worlds])
        white = judge.whitening(drawn, names)
        # Where materials differ from each other, an error counts more: twice as far.
        means = np.array([drawn[names == c].mean(axis=0) @ white for c in targets.MATERIALS])
        _, _, apart = np.linalg.svd(means - means.mean(axis=0), full_matrices=False)
        apart = apart[:len(means) - 1]
        white = white @ (np.eye(len(white)) + (MATERIALS_APART - 1) * apart.T @ apart)
        near = drawn[names == label] @ white
        few = np.random.RandomState(1).permutation(len(near))[:MOST_NEAR]
        near = near.mean(axis=0) + OF_SPREAD * (near[few] - near.mean(axis=0))
        self.near.append((TO_STAND_IN, white, near))
        if (labels == label).sum() > 1:
            scale = np.diag(1 / worlds_within(worlds))
            weight = TO_ONE_COLLECTION if source else TO_RECORDINGS
            self.near.append((weight, scale, vectors[labels == label] @ scale))

    @classmethod
    def of_label(cls, label):
        rows = dict(zip(targets.NAMES, targets.FEATURES[label][1]))
        return cls(rows, targets.PROFILES[label], slice(0, None, 2))

    @classmethod
    def of_sounds(cls, folder):
        import soundfile

        from features import to_rate
        paths = sorted(p for p in Path(folder).iterdir() if p.suffix in (".wav", ".ogg", ".flac"))
        if len(paths) < 3:
            sys.exit(f"{folder}: at least three recordings are needed")
        _, named, profiles = measure([to_rate(*soundfile.read(p)) for p in paths])
        rows = {n: tuple(np.percentile(v, [50, 10, 90])) for n, v in named.items()}
        return cls(rows, profiles.mean(axis=0), slice(None))

    def cost(self, steps, others=()):
        """Of steps; others: lists of steps at other speeds, of which the tables count, too."""
        vectors, named, profiles = measure(steps)
        near = sum(weight * judge.energy_distance(vectors @ matrix, real)
                   for weight, matrix, real in self.near)
        elsewhere = sum(self.to_tables(*measure(other)[1:]) for other in others)
        return self.to_tables(named, profiles) + AT_OTHER_SPEEDS * elsewhere + near

    def to_tables(self, named, profiles):
        total = 0.0
        for name, (median, low, high) in self.features.items():
            logs = np.log(np.maximum(named[name], 0) + 1e-5)
            # Features of few recordings, or hardly varying ones, are not pinned beyond 5 %.
            spread = max(np.log((high + 1e-5) / (low + 1e-5)) / 2.56, 0.05)
            m = np.median(logs)
            off = (m - np.log(median + 1e-5)) / spread
            outside = max(0, np.log(low + 1e-5) - m, m - np.log(high + 1e-5)) / spread
            ratio = np.log((np.percentile(logs, 90) - np.percentile(logs, 10) + 0.02) /
                           (OF_SPREAD * 2.56 * spread + 0.02))
            total += (min(off * off, 25) + 3 * (outside > 0) + 2 * min(outside, 5)
                      + 0.5 * min(ratio * ratio, 9))
        profile = profiles.mean(axis=0)[self.bands]
        rms = np.sqrt(np.mean((profile - self.profile) ** 2))
        return TO_TABLES * total / len(self.features) + (rms / 3) ** 2

    def off_tables(self, named, profiles):
        found = []
        for name, (median, low, high) in self.features.items():
            spread = max(np.log((high + 1e-5) / (low + 1e-5)) / 2.56, 0.05)
            logs = np.log(np.maximum(named[name], 0) + 1e-5)
            found.append((logs.mean() - np.log(median + 1e-5)) / spread)
        off = (profiles.mean(axis=0)[self.bands] - self.profile) / 3 / np.sqrt(len(self.profile))
        return np.concatenate([np.clip(found, -5, 5) * np.sqrt(TO_TABLES / len(found)), off])

    def residuals(self, steps, others=()):
        """What cost() is for small errors, as one vector whose square is its smooth part."""
        vectors, named, profiles = measure(steps)
        parts = [self.off_tables(named, profiles)]
        parts += [np.sqrt(AT_OTHER_SPEEDS) * self.off_tables(*measure(other)[1:]) for other in others]
        for weight, matrix, real in self.near:
            made = vectors @ matrix
            # In d dimensions of unit variance a small shift s costs s^2 / sqrt(2 d), and a spread
            # that is e too large in one direction e^2 / sqrt(8 d).
            size = np.sqrt(2 * made.shape[1])
            parts.append(np.sqrt(weight / size) * (made.mean(axis=0) - real.mean(axis=0)))
            if len(real) > 10:
                ratio = np.log((made.std(axis=0, ddof=1) + 0.1) / (real.std(axis=0) + 0.1))
                parts.append(np.sqrt(weight / size / 2) * ratio)
        return np.concatenate(parts)


def play(text, arguments, steps, seed):
    """Steps at the usual speed, and lists of half as many at the others."""
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        file.write(text)
        file.flush()
        return (render(arguments.render, file.name, steps, seed, rate=arguments.rate),
                [render(arguments.render, file.name, steps // 2, seed, speed, arguments.rate)
                 for speed in getattr(arguments, "speeds", ())])


def cost_of(text, aim, arguments, steps, seed):
    return aim.cost(*play(text, arguments, steps, seed))


def approach(path, aim, arguments):
    """Gauss-Newton steps. Many points around the present one, each of a few steps on the ground, tell by
    linear regression how every figure depends on every number (each step played tells of all numbers);
    a damped least-squares solution within the bounds goes where that says; of several dampings the one
    that costs least is kept."""
    recipe = Text(path)
    point = recipe.point()
    size = len(point)
    best = cost_of(recipe.at(point), aim, arguments, MANY * arguments.steps, 1)
    print(f"{path.stem}: {size} numbers, cost {best:.2f}", flush=True)
    random = np.random.RandomState(arguments.seed)
    reach = REACH
    for turn in range(1, arguments.approach + 1):
        points = np.clip(point + reach * random.randn(3 * size, size), 0, 1)
        found = np.array([aim.residuals(*play(recipe.at(at), arguments, arguments.few, 1000 * turn + i))
                          for i, at in enumerate(points)])
        moved = points - point
        centre, here = moved.mean(axis=0), found.mean(axis=0)
        ridge = 0.02 * len(points) * reach ** 2
        slopes = np.linalg.solve((moved - centre).T @ (moved - centre) + ridge * np.eye(size),
                                 (moved - centre).T @ (found - here)).T
        tried = []
        for damping in (2.0, 6.0, 18.0):
            move = lsq_linear(np.vstack([slopes, damping * np.eye(size)]),
                              np.concatenate([slopes @ centre - here, np.zeros(size)]),
                              (np.maximum(-point, -0.3) - 1e-9, np.minimum(1 - point, 0.3) + 1e-9)).x
            there = np.clip(point + move, 0, 1)
            cost = cost_of(recipe.at(there), aim, arguments, MANY * arguments.steps, 1)
            tried.append((cost, damping, there))
        cost, damping, there = min(tried, key=lambda t: t[0])
        print(f"{path.stem}: step {turn}, {cost:.2f} (damping {damping}), best {min(cost, best):.2f}",
              flush=True)
        if cost < best:
            best, point = cost, there
            path.write_text(recipe.at(point))
        else:
            reach *= 0.7


def tune(path, aim, arguments):
    from cmaes import CMA
    recipe = Text(path)
    start = recipe.point()
    best = cost_of(recipe.at(start), aim, arguments, 3 * arguments.steps, 1)
    print(f"{path.stem}: {len(start)} numbers, cost {best:.2f}", flush=True)
    search = CMA(mean=start, sigma=arguments.sigma, bounds=np.array([[0.0, 1.0]] * len(start)),
                 seed=arguments.seed)
    for turn in range(1, arguments.rounds + 1):
        tried = []
        for _ in range(search.population_size):
            point = search.ask()
            # The same seed within a round, so that they are compared fairly; another one each round.
            tried.append((point, cost_of(recipe.at(point), aim, arguments, arguments.steps, 1 + turn)))
        search.tell(tried)
        if turn % 5 == 0 or turn == arguments.rounds:
            # One round's winner owes much to its seed; the better half's middle is judged by more
            # steps.
            tried.sort(key=lambda t: t[1])
            text = recipe.at(np.mean([point for point, _ in tried[:len(tried) // 2]], axis=0))
            cost = cost_of(text, aim, arguments, 3 * arguments.steps, 1)
            if cost < best:
                best = cost
                path.write_text(text)
            print(f"{path.stem}: round {turn}, {cost:.2f}, best {best:.2f}", flush=True)
        if search.should_stop():
            break


def bring_to_level(path, program, peak=0.4, rare=0.75):
    """Scales the recipe's own level so that the median step peaks at `peak`, or lower if one step in ten
    would pass `rare`: footstep~ bends what passes 0.7."""
    peaks = [abs(step).max() for step in render(program, path, 60, 7)]
    factor = min(peak / np.median(peaks), rare / np.percentile(peaks, 90))
    lines = path.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("level "))
    lines[at] = f"level {float(lines[at].split()[1]) * factor:.4g}"
    path.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recipes", nargs="+", type=Path)
    parser.add_argument("--render", required=True)
    parser.add_argument("--label")
    parser.add_argument("--sounds")
    parser.add_argument("--recordings", action="store_true")
    parser.add_argument("--approach", type=int, default=4, help="Gauss-Newton steps first")
    parser.add_argument("--rounds", type=int, default=60, help="of CMA-ES")
    parser.add_argument("--steps", type=int, default=16)
    parser.add_argument("--few", type=int, default=8, help="steps of a point of the regression")
    parser.add_argument("--rate", type=int, default=RATE, help="22050 takes half the time")
    parser.add_argument("--speeds", type=float, nargs="*", default=[],
                        help="m/s, at which the tables count, too, besides 1.4")
    parser.add_argument("--sigma", type=float, default=0.05)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    for path in arguments.recipes:
        label = arguments.label or path.stem
        if not arguments.sounds and label not in targets.FEATURES:
            sys.exit(f"{label}: known are {', '.join(targets.MATERIALS)}; or give --sounds FOLDER")
        aim = Aim.of_sounds(arguments.sounds) if arguments.sounds else Aim.of_label(label)
        if arguments.recordings:
            aim.also_near_recordings(label)
        if arguments.approach:
            approach(path, aim, arguments)
        if arguments.rounds:
            tune(path, aim, arguments)
        bring_to_level(path, arguments.render)


if __name__ == "__main__":
    main()
