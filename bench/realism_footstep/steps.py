"""Lets render_footstep play steps and measures them."""
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from features import features, to_rate

RATE = 44100


def render(program, recipe, count, seed=1, speed=1.4, rate=RATE):
    """(count, samples) at 22.05 kHz: single steps of one foot."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "steps")
        done = subprocess.run([program, recipe, out, str(count), str(seed), str(speed), str(rate)],
                              check=True, capture_output=True, text=True, timeout=300)
        steps = np.fromfile(out, np.float32).reshape(count, int(done.stdout))
    return [to_rate(step, rate) for step in steps]


def measure(steps):
    """Vectors, named features and band profiles, one row a step."""
    vectors, named, profiles = zip(*(features(step) for step in steps))
    names = list(named[0])
    return (np.array(vectors), {n: np.array([row[n] for row in named]) for n in names},
            np.array(profiles))
