"""Lets render_footstep play steps and measures them."""
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from features import features, to_rate

RATE = 44100


def render(program, recipe, count, seed=1, speed=1.4, rate=RATE, shares=False):
    """List of `count` single steps of one foot at 22.05 kHz; with `shares` also the energies of the
    recipe's sections, each alone and without the room: [(name, energy)]."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "steps")
        command = [program, recipe, out, str(count), str(seed), str(speed), str(rate)]
        done = subprocess.run(command + ["shares"] * shares, check=True, capture_output=True, text=True,
                              timeout=300)
        length, *sections = done.stdout.splitlines()
        steps = np.fromfile(out, np.float32).reshape(count, int(length))
    steps = [to_rate(step, rate) for step in steps]
    if not shares:
        return steps
    return steps, [(name, float(energy)) for name, energy in map(str.split, sections)]


def measure(steps):
    """Vectors, named features and band profiles, one row a step."""
    vectors, named, profiles = zip(*(features(step) for step in steps))
    names = list(named[0])
    return (np.array(vectors), {n: np.array([row[n] for row in named]) for n in names},
            np.array(profiles))
