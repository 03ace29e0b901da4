"""What a recipe should reach, as residuals: each about one where a step is as far off as it may be.

An Aim compares rendered steps with medians and 10 to 90 % of recordings: 11 features and the mean band
profile (targets.py), energy by time and band, energy by time, two contacts and decays (recorded_steps.py),
and, when asked, all 45 features with the sounds of stand-ins (ensemble.py). It also holds what a figure
of a spectrum cannot see: which section of the recipe makes the sound, and that no step is lost."""
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import comparison
import recorded_steps
import targets
from ensemble import members
from recordings import recordings
from steps import measure
from time_course import bursts, summary_of_contacts, time_course

# Weights of the parts of the cost; each part's mean square is about one when it is off by its tolerance.
WEIGHTS = {"features": 2.0, "profile": 1.0, "time_band": 2.5, "energy": 1.5, "contacts": 1.5,
           "bursts": 3.0, "shares": 1.0, "levels": 1.0, "prior": 0.03}
STAND_IN_WEIGHT, RECORDINGS_WEIGHT = 0.6, 0.05
# One walker in one pair of shoes varies less than seven collections do.
OF_SPREAD = 0.85
PROFILE_DB, TIME_BAND_DB = 3.0, 4.0
MEMBERS, DOUBT, MAX_NEAR, MATERIALS_APART = 12, 0.6, 160, 2.5

# What creaks: number of bursts in a step, median and 10 %; the highest under the step's peak in its band,
# dB; energy of their time over the time before, dB (recordings of November 2026: 2 to 6, -9, -1.4).
BURSTS = {"creak": (4, 2, -9.0, -1.4)}
# Shares of the sections' energies that a ground must have: kind, at least or at most, at any speed. Five
# to ten per cent more or less than tests ask for, since a few steps tell a share so nearly only.
GRAINY = ("gravel", "sand", "dryleaves", "underbrush")
HARD = ("wood", "concrete", "metal")
MIN_SHARE = {**{g: {"impact": 0.57} for g in HARD},
             "dirt": {"impact": 0.33}, "carpet": {"impact": 0.33},
             "creak": {"impact": 0.30, "friction": 0.2},
             "snow": {"impact": 0.15}, "frozensnow": {"impact": 0.15},
             **{g: {"grains": 0.57} for g in GRAINY},
             "water": {"bubbles": 0.37}, "puddle": {"bubbles": 0.37}}
MAX_RUSTLE, MAX_RUSTLE_HARD = 0.065, 0.035
SHARE_TOLERANCE_DB, MAX_SHARE_OFF = 1.5, 12
# dB under the median step that no step should reach; standard deviation of steps' levels, dB.
QUIETEST_DB, LEVEL_DEVIATION_DB, LEVEL_TOLERANCE_DB = -10, (1.0, 3.0), 1.5


@dataclass
class Played:
    """Steps that a recipe played: for each speed a list, and energies of the sections."""
    by_speed: list
    sections: list  # (name, energy)

    @property
    def steps(self):
        return [step for steps in self.by_speed for step in steps]


def shares_of(sections):
    """{kind: share of the sum of the sections' energies}."""
    whole = sum(energy for _, energy in sections) or 1.0
    found = {}
    for kind, energy in sections:
        found[kind] = found.get(kind, 0.0) + energy / whole
    return found


def odds_db(share):
    return 10 * np.log10((share + 1e-9) / (1 - share + 1e-9))


def step_levels(steps):
    """dB over the median step."""
    levels = 10 * np.log10([np.sum(step * step) + 1e-20 for step in steps])
    return levels - np.median(levels)


def spread_ratio(values, low, high, floor):
    """Logarithm of how much wider than OF_SPREAD of the recordings' 10 to 90 % the values are."""
    made = np.percentile(values, 90) - np.percentile(values, 10)
    return np.clip(np.log((made + floor) / (OF_SPREAD * (high - low) + floor)), -3, 3)


class Aim:
    def __init__(self, features, profile, bands, levels_db, energy_db, contacts, label=None):
        self.features, self.profile, self.bands = features, np.array(profile, float), bands
        self.levels_db, self.energy_db = np.array(levels_db), np.array(energy_db, float)
        self.contacts = contacts
        self.min_share = MIN_SHARE.get(label, {})
        self.max_rustle = MAX_RUSTLE_HARD if label in HARD else MAX_RUSTLE
        self.bursts = BURSTS.get(label)
        self.has_label = label is not None
        self.near = []  # (weight, matrix, vectors by the matrix)

    @classmethod
    def of_label(cls, label):
        rows = dict(zip(targets.NAMES, targets.FEATURES[label][1]))
        return cls(rows, targets.PROFILES[label], slice(0, None, 2), recorded_steps.LEVELS_DB[label],
                   recorded_steps.ENERGY_DB[label], recorded_steps.TWO_CONTACTS[label], label)

    @classmethod
    def of_folder(cls, folder):
        import soundfile

        from features import to_rate
        paths = sorted(p for p in Path(folder).iterdir() if p.suffix in (".wav", ".ogg", ".flac"))
        if len(paths) < 3:
            sys.exit(f"{folder}: at least three recordings are needed")
        return cls.of_sounds([to_rate(*soundfile.read(p)) for p in paths])

    @classmethod
    def of_sounds(cls, sounds):
        """The same figures, measured of sounds at 22.05 kHz."""
        _, named, profiles = measure(sounds)
        course = time_course(sounds)
        rows = {n: tuple(np.percentile(v, [50, 10, 90])) for n, v in named.items()}
        return cls(rows, profiles.mean(axis=0), slice(None), np.median(course.levels_db, axis=0),
                   np.percentile(course.energy_db, [10, 50, 90], axis=0), summary_of_contacts(course))

    def also_near_recordings(self, label):
        """Adds the distances to all 45 features of the stand-ins and of the installed recordings."""
        taken = recordings()
        if not taken:
            sys.exit("no recordings are installed: Debian's minetest-data and ardentryst")
        labels = np.array([r.label for r in taken])
        vectors, _, _ = measure([r.sound() for r in taken])
        worlds = [w[:2] for w in members(vectors, labels, MEMBERS, of_error=DOUBT)]
        drawn = np.vstack([v for v, _ in worlds])
        names = np.concatenate([n for _, n in worlds])
        white = comparison.whitening(drawn, names)
        # Where materials differ from each other, an error counts more: twice as far.
        means = np.array([drawn[names == c].mean(axis=0) @ white for c in targets.MATERIALS])
        _, _, apart = np.linalg.svd(means - means.mean(axis=0), full_matrices=False)
        apart = apart[:len(means) - 1]
        white = white @ (np.eye(len(white)) + (MATERIALS_APART - 1) * apart.T @ apart)
        near = drawn[names == label] @ white
        few = np.random.RandomState(1).permutation(len(near))[:MAX_NEAR]
        near = near.mean(axis=0) + OF_SPREAD * (near[few] - near.mean(axis=0))
        self.near.append((STAND_IN_WEIGHT, white, near))
        if (labels == label).sum() > 1:
            within = np.sqrt(np.mean([v[n == c].var(axis=0) for v, n in worlds
                                      for c in sorted(set(n))], axis=0))
            self.near.append((RECORDINGS_WEIGHT, np.diag(1 / within), vectors[labels == label] / within))

    def parts(self, played):
        """{part: residuals}, and the 45 features of each step."""
        steps = played.steps
        vectors, named, profiles = measure(steps)
        course = time_course(steps)
        profile = (profiles.mean(axis=0)[self.bands] - self.profile) / PROFILE_DB
        parts = {"features": self._features(named), "profile": np.clip(profile, -5, 5),
                 "time_band": self._time_band(course), "energy": self._energy(course),
                 "contacts": self._contacts(course)}
        if self.bursts:
            parts["bursts"] = self._bursts(steps)
        parts = {name: r / np.sqrt(max(1, len(r))) for name, r in parts.items()}
        if self.has_label:
            parts["shares"] = self._shares(played.sections)
        parts["levels"] = self._levels(played.by_speed)
        return parts, vectors

    def cost(self, played, beyond_prior=()):
        """(cost, {part: its share of it}) of steps played by a point so many deviations from its prior."""
        parts, vectors = self.parts(played)
        parts["prior"] = np.asarray(beyond_prior, float)
        costs = {name: WEIGHTS[name] * float(np.sum(r * r)) for name, r in parts.items()}
        if self.near:
            costs["stand_ins"] = sum(weight * comparison.energy_distance(vectors @ matrix, real)
                                     for weight, matrix, real in self.near)
        return sum(costs.values()), costs

    def residuals(self, played, beyond_prior):
        """One vector whose square is the cost for small errors."""
        parts, vectors = self.parts(played)
        parts["prior"] = np.asarray(beyond_prior, float)
        found = [np.sqrt(WEIGHTS[name]) * r for name, r in parts.items()]
        for weight, matrix, real in self.near:
            made = vectors @ matrix
            # In d dimensions of unit variance a small shift s costs s^2 / sqrt(2 d), and a spread
            # that is e too large in one direction e^2 / sqrt(8 d).
            size = np.sqrt(2 * made.shape[1])
            found.append(np.sqrt(weight / size) * (made.mean(axis=0) - real.mean(axis=0)))
            if len(real) > 10:
                ratio = np.log((made.std(axis=0, ddof=1) + 0.1) / (real.std(axis=0) + 0.1))
                found.append(np.sqrt(weight / size / 2) * ratio)
        return np.concatenate(found)

    def _features(self, named):
        found = []
        for name, (median, low, high) in self.features.items():
            median, low, high = (np.log(v + 1e-5) for v in (median, low, high))
            logs = np.log(np.maximum(named[name], 0) + 1e-5)
            # Features of few recordings, or hardly varying ones, are not pinned beyond 5 %.
            spread = max((high - low) / 2.56, 0.05)
            middle = np.median(logs)
            outside = max(0, low - middle, middle - high) / spread
            found += [np.clip((middle - median) / spread, -5, 5), 1.5 * min(outside, 4),
                      0.7 * spread_ratio(logs, low, high, 0.05)]
        return np.array(found)

    def _time_band(self, course):
        """A cell counts fully from -25 dB of the whole and little below -45 dB, ours or theirs."""
        ours = np.median(course.levels_db, axis=0)
        audible = np.clip((np.maximum(ours, self.levels_db) + 50) / 25, 0.05, 1) ** 2
        off = np.clip(ours - self.levels_db, -15, 15) / TIME_BAND_DB
        return (np.sqrt(audible / audible.mean()) * off).ravel()

    def _energy(self, course):
        low, median, high = self.energy_db
        audible = np.sqrt(np.clip((median + 45) / 20, 0.1, 1))
        spread = np.maximum((high - low) / 2.56, 1.5)
        off = np.clip((np.median(course.energy_db, axis=0) - median) / spread, -4, 4)
        widths = [spread_ratio(v, a, b, 1.0) for v, a, b in zip(course.energy_db.T, low, high)]
        return np.concatenate([audible * off, 0.7 * audible * widths])

    def _contacts(self, course):
        share, interval, second, dip, first, decays = summary_of_contacts(course)
        real = self.contacts
        found = [(share - real[0]) / 15, np.log(interval[1] / real[1][1]) / 0.2,
                 (second[1] - real[2][1]) / max((real[2][2] - real[2][0]) / 2.56, 1.5),
                 (dip - real[3]) / 4, np.log((first[0] + 3) / (real[4][0] + 3)) / 0.35,
                 *(np.log((a + 2) / (b + 2)) / 0.35 for a, b in zip(decays, real[5]))]
        # No second contact to measure where the recordings have one is as far off as it goes.
        return np.clip(np.nan_to_num(found, nan=3.0), -3, 3)

    def _bursts(self, steps):
        number, fewest, highest, late = self.bursts
        numbers, levels, energies = bursts(steps).T
        # Means, since medians of numbers have no slope.
        found = [np.log((numbers.mean() + 1) / (number + 1)) / 0.25,
                 max(0, fewest - np.percentile(numbers, 10)), (np.median(levels) - highest) / 3,
                 (np.median(energies) - late) / 3]
        return np.clip(found, -4, 4)

    def _shares(self, sections):
        """A section's energy over that of all others, so that an inaudible one has a slope, too."""
        shares = shares_of(sections)
        found = [max(0, odds_db(least) - odds_db(shares.get(kind, 0)))
                 for kind, least in self.min_share.items()]
        found.append(max(0, odds_db(shares.get("rustle", 0)) - odds_db(self.max_rustle)))
        return np.minimum(np.array(found) / SHARE_TOLERANCE_DB, MAX_SHARE_OFF)

    def _levels(self, by_speed):
        found = []
        for steps in by_speed:
            levels = step_levels(steps)
            found.append(max(0, QUIETEST_DB - levels.min()))
            low, high = LEVEL_DEVIATION_DB
            found.append(max(0, low - levels.std(), levels.std() - high))
        return np.clip(np.array(found) / LEVEL_TOLERANCE_DB, 0, 10) / np.sqrt(len(by_speed))
