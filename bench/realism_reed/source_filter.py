#!/usr/bin/python3
"""How near one instrument of any kind could come to the recorded notes of another.

  bench/realism_reed/source_filter.py [sax] [oboe] ...

Fits, in decibels and by least squares, level(key) + source(harmonic number) + filter(frequency) to
H1..H10 of the recordings at the keys that realism.py measures: the source a parabola over the
logarithm of the number and a step between odd and even, the filter straight between two points an
octave. What is left over is no model's fault."""

import sys

import numpy as np

from measure import FLOOR_DB, distance
from realism import OTHER_KEYS, target_of
from recordings import key_frequency
from targets import PRESETS, TARGETS

POINTS_AN_OCTAVE = 2


def leftover(keys, targets) -> list[float]:
    number = np.arange(1, 11)
    pitch = np.log2(np.outer([key_frequency(key) for key in keys], number))
    points = np.linspace(pitch.min(), pitch.max(),
                         int(np.ptp(pitch) * POINTS_AN_OCTAVE) + 2)
    rows = []
    for i in range(len(keys)):
        for n in number:
            share = np.maximum(0, 1 - np.abs(pitch[i, n - 1] - points) / (points[1] - points[0]))
            rows.append(np.concatenate([np.eye(len(keys))[i], share,
                                        [np.log2(n), np.log2(n)**2, n % 2]]))
    matrix = np.array(rows)
    wanted = np.maximum(targets, FLOOR_DB)
    ridge = 1e-2 * np.eye(matrix.shape[1])  # a constant may be in level, source or filter
    found, *_ = np.linalg.lstsq(np.vstack([matrix, ridge]),
                                np.concatenate([wanted.ravel(), np.zeros(len(ridge))]), rcond=None)
    fitted = (matrix @ found).reshape(wanted.shape)
    fitted -= fitted.max(axis=1, keepdims=True)
    return [distance(one, other) for one, other in zip(fitted, wanted)]


def main() -> None:
    for preset in sys.argv[1:] or list(PRESETS):
        instrument = PRESETS[preset]
        keys = sorted([key for name, key in TARGETS if name == instrument] +
                      list(OTHER_KEYS[preset]))
        left = leftover(keys, np.array([target_of(instrument, key)[0] for key in keys]))
        print(f"{preset}: mean {np.mean(left):.1f} dB,",
              ", ".join(f"{key} {d:.1f}" for key, d in zip(keys, left)))


if __name__ == "__main__":
    main()
