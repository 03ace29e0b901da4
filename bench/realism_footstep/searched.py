"""The numbers of a recipe that a fit may change: one table, and the text that holds them.

Each number has bounds, a scale and a prior: a median and a standard deviation, of its logarithm where the
scale is "log". The prior keeps a number physical where recordings say little of it. Without a median of
its own it is the recipe's number when the fit begins. What the table does not name stays as it is, and
what a recipe does not have is not searched: numbers that the search may change have to be written down.

To search another number, add a row. The level of [solid] is not searched: the others are set against it.
Medians and deviations are estimated by ear, not measured: wide enough for the shoes, boards and soils one meets."""
from collections import namedtuple

import numpy as np

Number = namedtuple("Number", "section key low high scale median deviation")
# section, key, lowest, highest, scale, median (None: as the recipe has it), standard deviation
TABLE = [Number(*row) for row in (
    ("", "radiation", 10, 400, "log", None, 0.7),
    ("", "vary_frequency", 0.0, 0.4, "linear", 0.1, 0.08),
    ("", "vary_decay", 0.0, 0.4, "linear", 0.15, 0.1),

    ("solid", "frequency", 40, 700, "log", None, 0.4),
    ("solid", "ratio", 1.08, 1.9, "linear", None, 0.12),
    ("solid", "t60", 0.008, 0.8, "log", None, 0.5),
    ("solid", "t60_tilt", -0.3, 1.5, "linear", 0.5, 0.3),
    ("solid", "tilt", -0.8, 2.0, "linear", None, 0.5),
    ("solid", "place", 0.05, 0.8, "linear", 0.3, 0.2),
    ("solid", "stiffness", 1e4, 1e12, "log", None, 1.5),
    ("solid", "dissipation", 0.05, 3.0, "log", 0.5, 0.7),
    ("solid", "ball", 0.3, 2.5, "log", 1.0, 0.4),
    ("solid", "ball_mass", 0.01, 0.3, "log", 0.05, 0.6),
    ("solid", "patches", 1, 8, "linear", None, 2.0),
    ("solid", "patch_spread", 5e-4, 0.04, "log", None, 0.6),
    ("solid", "unevenness", 2e-4, 0.03, "log", None, 0.6),
    ("solid", "vary_frequency", 0.0, 0.4, "linear", 0.05, 0.06),
    ("solid", "vary_level", 0.0, 0.6, "linear", 0.15, 0.15),

    ("friction", "frequency", 100, 1500, "log", None, 0.4),
    ("friction", "ratio", 1.15, 3.0, "linear", None, 0.3),
    ("friction", "t60", 0.01, 0.6, "log", None, 0.5),
    ("friction", "tilt", -1.0, 1.5, "linear", None, 0.4),
    ("friction", "pressed", 0.5, 60, "log", None, 0.7),
    ("friction", "load", 1, 200, "log", None, 0.7),
    ("friction", "slip", 1e-3, 0.5, "log", None, 0.7),
    ("friction", "joint", 20, 400, "log", None, 0.5),
    ("friction", "joint_t60", 0.005, 0.5, "log", None, 0.5),
    ("friction", "wobble", 0.0, 0.6, "linear", 0.2, 0.15),
    ("friction", "level", 1e-3, 1e3, "log", None, 1.5),
    ("friction", "vary_level", 0.0, 0.6, "linear", 0.2, 0.15),

    ("grains", "count", 3, 3000, "log", None, 0.8),
    ("grains", "attack", 3e-4, 0.2, "log", None, 0.6),
    ("grains", "decay", 0.002, 0.3, "log", None, 0.6),
    ("grains", "exponent", 0.6, 4.0, "linear", 1.5, 0.6),
    ("grains", "frequency", 80, 9000, "log", None, 0.4),
    ("grains", "spread", 0.1, 1.5, "linear", 0.8, 0.4),
    ("grains", "quality", 0.35, 8, "log", 1.0, 0.7),
    ("grains", "length", 2e-4, 0.02, "log", None, 0.6),
    ("grains", "level", 1e-4, 1e3, "log", None, 1.5),
    ("grains", "ball", 0.05, 3, "log", 0.8, 0.6),
    ("grains", "load", 1e-4, 2, "log", None, 1.0),
    ("grains", "release", 1e-4, 1, "log", None, 1.0),
    ("grains", "vary_level", 0.0, 0.6, "linear", 0.2, 0.15),

    ("bubbles", "count", 3, 3000, "log", None, 0.8),
    ("bubbles", "attack", 3e-4, 0.3, "log", None, 0.6),
    ("bubbles", "decay", 0.005, 0.4, "log", None, 0.6),
    ("bubbles", "exponent", 0.6, 4.0, "linear", 1.5, 0.6),
    ("bubbles", "frequency", 300, 6000, "log", None, 0.4),
    ("bubbles", "spread", 0.1, 1.2, "linear", 0.5, 0.3),
    ("bubbles", "level", 1e-4, 1e3, "log", None, 1.5),
    ("bubbles", "ball", 0.05, 3, "log", 0.8, 0.6),
    ("bubbles", "load", 1e-4, 2, "log", None, 1.0),
    ("bubbles", "release", 1e-4, 1, "log", None, 1.0),

    ("rustle", "frequency", 100, 8000, "log", None, 0.5),
    ("rustle", "spread", 0.2, 1.5, "linear", 0.8, 0.4),
    ("rustle", "attack", 3e-4, 0.2, "log", None, 0.7),
    ("rustle", "decay", 0.005, 0.3, "log", None, 0.6),
    ("rustle", "ball", 0.05, 3, "log", 0.8, 0.6),
    ("rustle", "level", 1e-4, 1e3, "log", None, 1.5),

    ("room", "level", -40, 0, "linear", -12, 5),
    ("room", "t60", 0.1, 1.2, "log", 0.35, 0.4),
)]


def scaled(number, value):
    return np.log(value) if number.scale == "log" else value


def rounded(value):
    """Three digits, as one writes them: 0.0123, 1700, 6.45e9."""
    text = f"{value:.3g}"
    if "e" not in text:
        return text
    digits, exponent = text.split("e")
    return f"{float(text):.0f}" if 0 < int(exponent) < 5 else f"{digits}e{int(exponent)}"


class RecipeText:
    """A recipe's lines and its searched numbers as a point in the unit cube, one coordinate a number."""

    def __init__(self, text):
        self.lines = text.splitlines()
        self.numbers, self.rows = [], []
        wanted = {(n.section, n.key): n for n in TABLE}
        section = ""
        for row, line in enumerate(self.lines):
            words = line.split("#")[0].split()
            if words and words[0].startswith("["):
                section = words[0].strip("[]")
            elif words and (section, words[0]) in wanted:
                self.numbers.append(wanted[section, words[0]])
                self.rows.append(row)
        values = [self.value(row) for row in self.rows]
        low, high = (np.array([scaled(n, b) for n, b in zip(self.numbers, bounds)])
                     for bounds in ([n.low for n in self.numbers], [n.high for n in self.numbers]))
        self.low, self.width = low, high - low
        self.start = self.coordinates(values)
        median = self.coordinates([v if n.median is None else n.median
                                   for n, v in zip(self.numbers, values)])
        deviation = np.array([n.deviation for n in self.numbers]) / self.width
        self.median, self.deviation = median, deviation

    def value(self, row):
        return float(self.lines[row].split("#")[0].split()[1])

    def coordinates(self, values):
        inside = [scaled(n, min(max(v, n.low), n.high)) for n, v in zip(self.numbers, values)]
        return (np.array(inside) - self.low) / self.width

    def at(self, point):
        """The recipe's text with the numbers of a point."""
        lines = list(self.lines)
        values = self.low + np.clip(point, 0, 1) * self.width
        for number, row, value in zip(self.numbers, self.rows, values):
            value = np.exp(value) if number.scale == "log" else value
            if number.key == "patches":
                value = round(value)
            comment = lines[row].partition("#")[2]
            lines[row] = f"{number.key} {rounded(value)}" + (f"  #{comment}" if comment else "")
        return "\n".join(lines) + "\n"

    def beyond_prior(self, point):
        """How far each number is from its prior's median, in standard deviations."""
        return (np.asarray(point) - self.median) / self.deviation
