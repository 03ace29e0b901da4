"""How near a set of sounds comes to recordings: never by one number, since each can be cheated.

Names (class-balanced shrinkage discriminant, then distances to class means and neighbours), distance to
the nearest recording of the same material against that between recordings, spread of the set against
theirs, and whether a nearest-neighbour test tells the two sets apart (0.5: it cannot).
"""
import numpy as np

SHRINKAGE, NEIGHBOURS = 0.25, 5


def distances(a, b):
    return np.sqrt(((a[:, None] - b[None]) ** 2).sum(axis=2))


class Classifier:
    def __init__(self, vectors, labels):
        labels = np.asarray(labels)
        self.labels = labels
        self.classes = sorted(set(labels))
        self.mean, self.deviation = vectors.mean(axis=0), vectors.std(axis=0) + 1e-9
        z = self.standardised(vectors)
        centres = np.array([z[labels == c].mean(axis=0) for c in self.classes])
        within = sum((z[labels == c] - m).T @ (z[labels == c] - m) / max(1, (labels == c).sum())
                     for c, m in zip(self.classes, centres)) / len(self.classes)
        size = len(within)
        within = ((1 - SHRINKAGE) * within
                  + SHRINKAGE * np.eye(size) * np.trace(within) / size)
        values, directions = np.linalg.eigh(within)
        whiten = directions / np.sqrt(values)
        _, _, right = np.linalg.svd((centres - centres.mean(axis=0)) @ whiten, full_matrices=False)
        self.projection = whiten @ right[:min(len(self.classes) - 1, 14)].T
        self.points, self.centres = z @ self.projection, centres @ self.projection

    def standardised(self, vectors):
        return (vectors - self.mean) / self.deviation

    def project(self, vectors):
        return self.standardised(vectors) @ self.projection

    def far(self, vectors):
        """Distance of each sound (row) from each class (column)."""
        points = self.project(vectors)
        far = np.empty((len(points), len(self.classes)))
        for i, c in enumerate(self.classes):
            near = np.sort(distances(points, self.points[self.labels == c]), axis=1)
            count = min(NEIGHBOURS, max(1, near.shape[1] // 2))
            to_centre = np.linalg.norm(points - self.centres[i], axis=1)
            far[:, i] = 0.5 * near[:, :count].mean(axis=1) + 0.5 * to_centre
        return far

    def ranked(self, vectors):
        """Per sound all classes, likeliest first."""
        far = self.far(vectors)
        return [[self.classes[k] for k in row] for row in np.argsort(far, axis=1)]


def leave_one_out(vectors, labels):
    labels = np.asarray(labels)
    ranked = []
    for i in range(len(labels)):
        keep = np.arange(len(labels)) != i
        ranked += Classifier(vectors[keep], labels[keep]).ranked(vectors[i:i + 1])
    return ranked


def hits(ranked, labels, first):
    """Per label the share of sounds with their label among the first so many."""
    return {c: float(np.mean([c in r[:first] for r, k in zip(ranked, labels) if k == c]))
            for c in sorted(set(labels))}


def told_apart(real, made, rounds=20):
    """Share that a nearest neighbour puts on the right side, of equally many of both."""
    n = min(len(real), len(made))
    random = np.random.RandomState(0)
    right = []
    for _ in range(rounds):
        both = np.vstack([real[random.permutation(len(real))[:n]],
                          made[random.permutation(len(made))[:n]]])
        far = distances(both, both)
        np.fill_diagonal(far, np.inf)
        right.append(np.mean((far.argmin(axis=1) < n) == (np.arange(2 * n) < n)))
    return float(np.mean(right))


def compare(classifier, real_vectors, made_vectors, label):
    """Distance ratio, spread ratio and told-apart share of one material. Two recordings have one
    distance between them, which is no yardstick: not a number for fewer than three."""
    real = classifier.points[classifier.labels == label]
    made = classifier.project(made_vectors)
    ratio = spread = told = np.nan
    if len(real) > 2:
        among = distances(real, real)
        np.fill_diagonal(among, np.inf)
        ratio = distances(made, real).min(axis=1).mean() / among.min(axis=1).mean()
        upper = np.triu_indices
        spread = (distances(made, made)[upper(len(made), 1)].mean()
                  / among[upper(len(real), 1)].mean())
    if min(len(real), len(made)) >= 5:
        told = told_apart(classifier.standardised(real_vectors[classifier.labels == label]),
                          classifier.standardised(made_vectors))
    return ratio, spread, told


def left_out_ratio(vectors, labels, label):
    """Distance ratio of recordings that the classifier has not seen: what a perfect step would get."""
    labels = np.asarray(labels)
    ratios = []
    for i in np.flatnonzero(labels == label):
        keep = np.arange(len(labels)) != i
        if (labels[keep] == label).sum() < 2:
            return np.nan
        classifier = Classifier(vectors[keep], labels[keep])
        real = classifier.points[classifier.labels == label]
        among = distances(real, real)
        np.fill_diagonal(among, np.inf)
        nearest = distances(classifier.project(vectors[i:i + 1]), real).min()
        ratios.append(nearest / among.min(axis=1).mean())
    return float(np.mean(ratios))


def whitening(vectors, labels):
    """Matrix that makes sounds of one label vary by one in every direction, on average over labels."""
    labels = np.asarray(labels)
    within = np.mean([np.cov(vectors[labels == c].T) for c in sorted(set(labels))], axis=0)
    scale = 1 / np.sqrt(np.diag(within))
    correlation = within * np.outer(scale, scale)
    correlation = (1 - SHRINKAGE) * correlation + SHRINKAGE * np.eye(len(scale))
    values, directions = np.linalg.eigh(correlation)
    return scale[:, None] * directions / np.sqrt(values)


def energy_distance(made, real):
    """2 E|made - real| - E|made - made'| - E|real - real'|: zero only for equal distributions
    (Szekely & Rizzo 2013), so that both place and spread count. At least two sounds each."""
    def among(a):
        return distances(a, a)[np.triu_indices(len(a), 1)].mean()
    return 2 * distances(made, real).mean() - among(made) - among(real)
