"""A second opinion on steps: what band sounds when, and two classifiers that share nothing with comparison.py.

A sound is the level of each of 20 bands in each of 7 windows of time after its onset (time_course.py),
over the whole, so that level does not count. Classifiers: linear discriminants whose common covariance is
shrunk as Ledoit & Wolf (J. Multivar. Anal. 88, 2004) say, and a random forest (Breiman, Machine Learning
45, 2001; Debian: python3-sklearn), which is left out where it is not installed."""
import numpy as np

from time_course import time_course


def cells(sounds):
    """(sounds, 140) levels, dB."""
    return time_course(sounds).levels_db.reshape(len(sounds), -1)


def shrunk_covariance(residuals):
    """Of residuals (n, d) around their means: (1 - s) S + s tr(S)/d I with Ledoit & Wolf's s."""
    n, d = residuals.shape
    covariance = residuals.T @ residuals / n
    mean = np.trace(covariance) / d
    far = np.sum((covariance - mean * np.eye(d)) ** 2)
    norms = np.sum(residuals ** 2, axis=1)
    error = (np.sum(norms ** 2) / n - np.sum(covariance ** 2)) / n
    share = min(max(error / max(far, 1e-30), 0.0), 1.0)
    return (1 - share) * covariance + share * mean * np.eye(d)


def order(classes, scores):
    """Per row all classes, the highest score first."""
    return [[classes[k] for k in row] for row in np.argsort(-scores, axis=1)]


def discriminant(train, labels, sounds):
    """Ranked labels of each sound; all labels equally likely before."""
    labels = np.asarray(labels)
    classes = sorted(set(labels))
    means = np.array([train[labels == c].mean(axis=0) for c in classes])
    at = {c: i for i, c in enumerate(classes)}
    residuals = train - means[[at[c] for c in labels]]
    weights = np.linalg.solve(shrunk_covariance(residuals) + 1e-6 * np.eye(train.shape[1]), means.T)
    scores = sounds @ weights - 0.5 * np.sum(means.T * weights, axis=0)
    return order(classes, scores)


def forest(train, labels, sounds, trees=300):
    """Ranked labels of each sound by a forest in which all labels weigh the same."""
    from sklearn.ensemble import RandomForestClassifier
    made = RandomForestClassifier(trees, class_weight="balanced", random_state=1)
    made.fit(train, labels)
    return order(list(made.classes_), made.predict_proba(sounds))


def classifiers():
    """{name: function of (train, labels, sounds)} of those at hand."""
    found = {"bands in time, discriminant": discriminant}
    try:
        import sklearn.ensemble  # noqa: F401
        found["bands in time, forest"] = forest
    except ImportError:
        pass
    return found
