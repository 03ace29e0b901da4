"""A stand-in for recordings that are not at hand: 45 features of the 396 sounds that targets.py counts.

The tables say where 22 of the 45 features lie (twelve of the band profile's cepstrum, ten with a
name), and how far ten of them spread. How features correlate is estimated from the recordings that
are at hand: ridge regression for the means of the other 23, their residuals' correlations (shrunk)
for the spread. So the stand-in is Gaussian per material and as good as that: realism.py prints what
it makes of real recordings beside what it makes of rendered steps."""
import numpy as np
from scipy.fft import dct

import targets
from features import mel_centres

CEPSTRUM = list(range(12))
# Indices of the named features in the vector of features.py, and how they are scaled there.
INDICES = {"duration_s": (17, np.log), "attack_s": (18, np.log), "crest": (21, np.log),
          "decay20_s": (23, lambda v: np.log(v + 0.003)),
          "event_density_hz": (24, lambda v: np.log(v + 3)), "centroid_hz": (26, np.log),
          "rolloff85_hz": (28, lambda v: np.log(v + 50)),
          "flatness": (29, lambda v: np.log(v + 1e-3)), "peakiness": (32, lambda v: v),
          "harmonicity": (33, lambda v: 2 * v)}
KNOWN = CEPSTRUM + [index for index, _ in INDICES.values()]
RIDGE, SHRINKAGE = 10.0, 0.5


class Population:
    """Mean (materials, 45) and standard deviation (materials, 45) of each material's features."""

    ridge = RIDGE

    def __init__(self, vectors, labels):
        """From recordings at hand: (sounds, 45) and their labels."""
        labels = np.asarray(labels)
        self.names = targets.MATERIALS
        groups = [labels == c for c in sorted(set(labels))]
        residuals = np.vstack([vectors[g] - vectors[g].mean(axis=0) for g in groups])
        free = len(labels) - len(groups)
        self.within = np.sqrt((residuals ** 2).sum(axis=0) / free)
        self.mean, self.deviation = self.from_tables()
        self.regress(vectors)
        scaled = residuals / self.within
        correlation = scaled.T @ scaled / free
        self.correlation = (1 - SHRINKAGE) * correlation + SHRINKAGE * np.eye(len(correlation))
        scale = 1 / np.sqrt(np.diag(self.correlation))
        self.correlation *= np.outer(scale, scale)

    def from_tables(self):
        hz = mel_centres()[1:-1]
        mean = np.full((len(self.names), len(self.within)), np.nan)
        deviation = np.tile(self.within, (len(self.names), 1))
        for row, label in enumerate(self.names):
            profile = np.interp(np.arange(26), np.arange(0, 26, 2), targets.PROFILES[label])
            profile[25] += (profile[24] - profile[22]) * (hz[25] - hz[24]) / (hz[24] - hz[22])
            mean[row, CEPSTRUM] = dct(profile, norm="ortho")[1:13]
            figures = dict(zip(targets.NAMES, targets.FEATURES[label][1]))
            for name, (index, scaled) in INDICES.items():
                median, low, high = (scaled(v) for v in figures[name])
                mean[row, index] = median
                deviation[row, index] = max((high - low) / 2.56, 0.1 * self.within[index])
        return mean, deviation

    def regress(self, vectors):
        others = [i for i in range(vectors.shape[1]) if i not in KNOWN]
        centre, scale = vectors.mean(axis=0), vectors.std(axis=0) + 1e-9
        z = (vectors - centre) / scale
        known = z[:, KNOWN]
        weights = np.linalg.solve(known.T @ known + self.ridge * np.eye(len(KNOWN)),
                                  known.T @ z[:, others])
        told = (self.mean[:, KNOWN] - centre[KNOWN]) / scale[KNOWN]
        # Not further out than the recordings that taught it.
        told = np.clip(told, known.min(axis=0) - 0.5, known.max(axis=0) + 0.5)
        self.mean[:, others] = centre[others] + scale[others] * (told @ weights)

    def sounds(self, seed=1):
        """(396, 45) features drawn, and labels."""
        random = np.random.RandomState(seed)
        root = np.linalg.cholesky(self.correlation)
        vectors, labels = [], []
        for row, label in enumerate(self.names):
            count = targets.FEATURES[label][0]
            drawn = random.randn(count, root.shape[0]) @ root.T
            vectors.append(self.mean[row] + drawn * self.deviation[row])
            labels += [label] * count
        return np.vstack(vectors), np.array(labels)
