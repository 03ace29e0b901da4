"""Cross-validation: recordings are split by collection; no classifier is tested on its own collection.

Three classifiers (comparison.py's features; band_classifiers.py's two) name recordings and steps. A recording is named
with itself left out, and with its whole collection left out; steps are named by all recordings, and by
each collection alone. Sounds of one collection have microphone, room and shoe in common: naming a sound
with its own collection at hand says little of the next collection's. So the confidence of a figure is
the range over classifiers trained on one collection each."""
from dataclasses import dataclass

import numpy as np

import comparison
import band_classifiers


def by_features(train, labels, sounds):
    return comparison.Classifier(train, labels).ranked(sounds)


@dataclass
class Recorded:
    """The recordings: features (n, 45), cells (n, 140), labels (n) and collections (n)."""
    features: np.ndarray
    cells: np.ndarray
    labels: np.ndarray
    collections: np.ndarray

    def heard_by(self, name):
        return self.features if name == "features" else self.cells


def all_classifiers():
    return {"features": by_features, **band_classifiers.classifiers()}


def left_out(rank, vectors, labels, groups):
    """Rankings of the sounds when each group in turn is left out; None for those whose label nobody else
    has."""
    ranked = [None] * len(labels)
    for group in sorted(set(groups)):
        out = groups == group
        known = np.isin(labels, labels[~out]) & out
        if known.any():
            for i, r in zip(np.flatnonzero(known), rank(vectors[~out], labels[~out], vectors[known])):
                ranked[i] = r
    return ranked


def shares(ranked, labels):
    """(first, among three, number of sounds): means over labels of the shares named right."""
    kept = [(r, c) for r, c in zip(ranked, labels) if r is not None]
    if not kept:
        return np.nan, np.nan, 0
    ranked, labels = zip(*kept)
    return (*(np.mean(list(comparison.hits(ranked, labels, k).values())) for k in (1, 3)), len(kept))


def percent(pair):
    return " / ".join("" if np.isnan(v) else f"{100 * v:.0f}" for v in pair[:2])


def named(rank, train, labels, made):
    """Rankings and labels of steps made as {label: vectors}, of labels that the classifier knows."""
    known = [c for c in made if c in set(labels)]
    ranked = [r for c in known for r in rank(train, labels, made[c])]
    return ranked, [c for c in known for _ in range(len(made[c]))]


def lines(recorded, made_features, made_cells):
    """Lines of two tables: classifiers, and surface materials. made_*: {label: (steps, figures)}."""
    labels, collections = recorded.labels, recorded.collections
    several = sorted(c for c in set(labels) if len(set(collections[labels == c])) > 1)
    names = sorted(set(collections))
    heads = ["recordings, one left out", "recordings, their collection left out", "ours, by all",
             f"ours of {', '.join(several)}: by all",
             *(f"by {name} alone" for name in names)]
    out = ["| classifier, first / among three, % | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    grounds = {}
    for name, rank in all_classifiers().items():
        vectors = recorded.heard_by(name)
        made = made_features if name == "features" else made_cells
        common = {c: made[c] for c in several if c in made}
        cells = [percent(shares(left_out(rank, vectors, labels, np.arange(len(labels))), labels)),
                 percent(shares(left_out(rank, vectors, labels, collections), labels)),
                 percent(shares(*named(rank, vectors, labels, made))),
                 percent(shares(*named(rank, vectors, labels, common)))]
        for collection in names:
            one = collections == collection
            cells.append(percent(shares(*named(rank, vectors[one], labels[one], common))))
        out.append(f"| {name} | " + " | ".join(cells) + " |")
        ranked, truth = named(rank, vectors, labels, made)
        for label in dict.fromkeys(truth):
            own = [r for r, c in zip(ranked, truth) if c == label]
            answers = [r[0] for r in own]
            taken = sorted(sorted(set(answers)), key=lambda a: -answers.count(a))[:2]
            grounds.setdefault(label, []).append(
                f"{percent(shares(own, [label] * len(own)))} ({' '.join(taken)})")
    out += ["", "| material, first / among three, % (taken for) | " + " | ".join(all_classifiers()) + " |",
            "|---" * (len(all_classifiers()) + 1) + "|"]
    out += [f"| {label} | " + " | ".join(row) + " |" for label, row in grounds.items()]
    if len(all_classifiers()) < 3:
        out += ["", "No forest: install Debian's python3-sklearn."]
    return out
