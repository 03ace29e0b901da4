#!/usr/bin/python3
"""Input impedance of the bores of bores.py by finite elements, for tests/core/reed/bore/bore_reference.hpp.

  bench/reed_bores/reference.py [--check]

Independent of transfer_matrix.py and of the poles fitted to it: the horn equation with viscous and
thermal losses,
    d/dx (p'/Z_s) = Y_p p,    Z_s = s rho/S (1 + 2/a sqrt(nu/s)),
    Y_p = s S/(rho c^2) (1 + 2 (gamma - 1)/a sqrt(nu/(Pr s))),
in its weak form with cubic elements over the whole bore from the reed's end, line and all beyond;
each hole's chimney is a branch of elements of its own with a radiating end. The impedance of the
unit flow at the input is p there. Prints peaks; writes them as a C++ table."""

import argparse
import sys
import textwrap
from pathlib import Path

import numpy as np

from bores import DENSITY, GAMMA, PRANDTL, SOUND_SPEED, VISCOSITY, WOODWINDS

TABLE = Path(__file__).resolve().parents[2] / "tests/core/reed/bore/bore_reference.hpp"
KEYS = {"clarinet": (50, 51, 54, 57, 60, 63, 66, 70), "saxophone": (47, 50, 54, 58, 62, 66, 70),
        "oboe": (58, 62, 66, 70, 74, 78)}
# Holes from the reed down: c closed, o open, h half covered, q covered to three quarters.
STATES = {"clarinet": (
    "cccccccccccccccccccc",  # the bell's note
    "cccccccccccccccchooo",  # half holes
    "ccccccccccqooooooooo", "ccccchohohohohohohoh",
    "ccccccccoccooooooooo",  # forks
    "ccccccccoccccooooooo", "ccccccocccoooooooooo", "cccccccccccocccooooo", "cccccccccccchccccooo",
    "ccccccccccccocococcc", "cccccccococooooooooo",
    "cccccccccccccoccccco",  # one hole far from the next
    "ccccccccccoccccccccc", "cccccccccccccccccooc",
)}
VENTED = {"clarinet": (50, 53, 56, 59, 62)}  # standard fingerings with the register vent
CLOSED = {"c": 1.0, "o": 0.0, "h": 0.5, "q": 0.75}
ELEMENT = 15e-3  # m
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(5)
KNOTS = np.array([-1, -1 / np.sqrt(5), 1 / np.sqrt(5), 1])  # Gauss-Lobatto


def shapes(x):
    values, slopes = np.ones(4), np.zeros(4)
    for i in range(4):
        others = [k for k in range(4) if k != i]
        scale = np.prod([KNOTS[i] - KNOTS[k] for k in others])
        values[i] = np.prod([x - KNOTS[k] for k in others]) / scale
        slopes[i] = sum(np.prod([x - KNOTS[k] for k in others if k != o]) for o in others) / scale
    return values, slopes


SHAPES = [shapes(x) for x in POINTS]


class Mesh:
    """Nodes joined by elements (for matrices that depend on s) and by lumped admittances."""

    def __init__(self):
        self.count = 0
        self.elements = []  # nodes, half length, [radius at each quadrature point]
        self.lumped = []    # node, node or None, function of s

    def node(self):
        self.count += 1
        return self.count - 1

    def tube(self, first, length, radius_at):
        parts = max(1, int(np.ceil(length / ELEMENT)))
        half = length / parts / 2
        for i in range(parts):
            nodes = [first, self.node(), self.node(), self.node()]
            middle = (2 * i + 1) * half
            self.elements.append((nodes, half, [radius_at(middle + half * x) for x in POINTS]))
            first = nodes[-1]
        return first

    def impedance(self, s, at):
        matrix = np.zeros((self.count, self.count), complex)
        for nodes, half, radii in self.elements:
            local = np.zeros((4, 4), complex)
            for (values, slopes), weight, a in zip(SHAPES, WEIGHTS, radii):
                area = np.pi * a * a
                along = s * DENSITY / area * (1 + 2 / a * np.sqrt(VISCOSITY / s))
                across = s * area / (DENSITY * SOUND_SPEED**2) * (
                    1 + 2 * (GAMMA - 1) / a * np.sqrt(VISCOSITY / (PRANDTL * s)))
                local += weight * (np.outer(slopes, slopes) / (along * half) +
                                   across * half * np.outer(values, values))
            matrix[np.ix_(nodes, nodes)] += local
        for one, other, admittance in self.lumped:
            y = admittance(s)
            matrix[one, one] += y
            if other is not None:
                matrix[other, other] += y
                matrix[one, other] -= y
                matrix[other, one] -= y
        flow = np.zeros(self.count, complex)
        flow[at] = 1
        return np.linalg.solve(matrix, flow)[at]


def radiating(radius):
    """Admittance of an unflanged opening: second-order fit of Silva et al. (2009) to the reflectance."""
    def admittance(s):
        z = s * radius / SOUND_SPEED
        numerator, denominator = 1 + 0.167 * z, 1 + 1.393 * z + 0.457 * z**2
        return (np.pi * radius**2 / (DENSITY * SOUND_SPEED) *
                (denominator + numerator) / (denominator - numerator))
    return admittance


def bore_mesh(name, beyond, length, vented=False):
    wind = WOODWINDS[name]
    start = beyond.corners[0][1]
    mesh = Mesh()
    at = mesh.node()
    along = lambda x: wind.input_radius + (start - wind.input_radius) * x / length
    if vented:
        vent = wind.vent
        here = mesh.tube(at, vent.distance, along)
        # Inner correction of a hole far narrower than the bore: Nederveen et al. (1998).
        top = mesh.tube(here, vent.height + 0.82 * vent.radius, lambda x: vent.radius)
        mesh.lumped.append((top, None, radiating(vent.radius)))
        here = mesh.tube(here, length - vent.distance, lambda x: along(x + vent.distance))
    else:
        here = mesh.tube(at, length, along)
    xs, rs = np.array(beyond.corners).T
    position = 0.0
    stops = sorted({x for x in xs if x > 0} | {h.distance for h in beyond.holes})
    for stop in stops:
        if stop > position:
            here = mesh.tube(here, stop - position, lambda x, o=position: np.interp(o + x, xs, rs))
            position = stop
        for hole in (h for h in beyond.holes if h.distance == stop):
            b, a, t = hole.radius, float(np.interp(stop, xs, rs)), hole.height
            ratio = b / a
            # Lengths of the T-section: Dubos et al. (1999), Nederveen et al. (1998).
            shunt = t + b * (0.82 + ratio * (-0.193 + ratio * (-1.09 + ratio * (1.27 - 0.71 * ratio))))
            shunt += b * ratio * (1 + 0.207 * ratio**3) / 8
            along = -b * ratio**2 / (1.78 / np.tanh(1.84 * t / b) + 0.940 + 0.540 * ratio +
                                     0.285 * ratio**2)
            half = lambda s, m=DENSITY * along / (2 * np.pi * a * a): 1 / (s * m)
            middle, after = mesh.node(), mesh.node()
            mesh.lumped += [(here, middle, half), (middle, after, half)]
            top = mesh.tube(middle, shunt, lambda x, b=b: b)
            mesh.lumped.append((top, None, radiating(b)))
            here = after
    mesh.lumped.append((here, None, radiating(rs[-1])))
    return mesh, at


def line_length(name, key):
    """Of the line in the test, m."""
    wind = WOODWINDS[name]
    return wind.position(key) - wind.apex


def peaks_of(name, key, beyond=None, vented=False):
    """(Hz, dB over the input's Z_0) of the first five peaks below the lattice's cut-off."""
    wind = WOODWINDS[name]
    length = line_length(name, key)
    mesh, at = bore_mesh(name, beyond or wind.beyond(key), length, vented)
    zero = DENSITY * SOUND_SPEED / (np.pi * wind.input_radius**2)
    level = lambda f: 20 * np.log10(abs(mesh.impedance(2j * np.pi * f, at)) / zero)
    grid = np.arange(60.0, wind.cutoff, 15)
    coarse = [level(f) for f in grid]
    found = []
    for i in range(1, grid.size - 1):
        if coarse[i - 1] < coarse[i] >= coarse[i + 1] and len(found) < 5:
            low, high = grid[i - 1], grid[i + 1]
            for _ in range(22):  # golden section
                a, b = high - 0.618034 * (high - low), low + 0.618034 * (high - low)
                low, high = (low, b) if level(a) > level(b) else (a, high)
            found.append(((low + high) / 2, level((low + high) / 2)))
    return length, found


HEADER = "#pragma once\n\n#include <string_view>\n\nnamespace tactus::reed::test {\n\n"


def reference_row(name, fingering, length, peaks) -> str:
    """As tests/core/reed/bore/bore_echo.hpp reads it."""
    text = f"{name} {fingering} {length:.6f} " + " ".join(f"{f:.6g} {d:.2f}" for f, d in peaks)
    return textwrap.fill(text, 100, subsequent_indent="  ") + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="this instrument's alone, printed")
    arguments = parser.parse_args()
    text = ("// Written by bench/reed_bores/reference.py, by finite elements. A row: bore, fingering, length of\n"
            "// the line in m, then Hz and dB over the input's Z_0 of each peak of the input impedance.\n" + HEADER)
    tables = ("/// Standard fingerings, by MIDI number.\n", "kBoreReference", KEYS), (
        "/// Any state of the holes, from the reed down: c closed, o open, h half, q three quarters covered.\n",
        "kFingeredReference", STATES), (
        "/// Standard fingerings with the register vent open.\n", "kVentedReference", VENTED)
    for comment, table, fingerings in tables:
        text += f'{comment}inline constexpr std::string_view {table} = R"(\n'
        for name in fingerings:
            if arguments.only not in (None, name):
                continue
            for fingering in fingerings[name]:
                key, beyond = fingering, None
                if table == "kFingeredReference":
                    key, beyond = WOODWINDS[name].fingered([CLOSED[letter] for letter in fingering])
                length, peaks = peaks_of(name, key, beyond, table == "kVentedReference")
                row = reference_row(name, fingering, length, peaks)
                print(row, end="", flush=True)
                text += row
        text += ')";\n\n'
    text += "} // namespace tactus::reed::test\n"
    if arguments.only is None:
        TABLE.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
