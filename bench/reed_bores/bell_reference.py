#!/usr/bin/python3
"""Input impedance of trumpet and trombone, cylinder and bell, for tests/core/reed/bore/bell_reference.hpp.

  bench/reed_bores/bell_reference.py

Independent of transfer_matrix.py, of its slices and of the poles fitted to them: the horn equation
with viscous and thermal losses,
    dp/dx = -Z_s U,    dU/dx = -Y_p p,    Z_s = s rho/S (1 + 2/a sqrt(nu/s)),
    Y_p = s S/(rho c^2) (1 + 2 (gamma - 1)/a sqrt(nu/(Pr s))),
over the smooth profile, from the radiating mouth back to the lips by the fourth-order Runge-Kutta method.
Prints the peaks below the bell's cut-off, also with half the step, and writes them as a C++ table."""

import sys
from pathlib import Path

import numpy as np

from bells import BELLS, Bell
from bores import DENSITY, GAMMA, PRANDTL, SOUND_SPEED, VISCOSITY
from reference import HEADER, radiating, reference_row

TABLE = Path(__file__).resolve().parents[2] / "tests/core/reed/bore/bell_reference.hpp"
LENGTHS = {"trumpet": (0.66, 0.9, 1.2), "trombone": (1.7, 2.1, 2.8)}  # of the cylinder, m
LOWEST, SPACING = 30.0, 0.5  # Hz
STEP = 1e-3                  # m


def impedance(bell: Bell, length: float, frequency, step: float):
    """Z_in over the tube's Z_0."""
    s = 2j * np.pi * np.asarray(frequency, float)

    def slope(x, state):
        a = bell.radius(max(x - length, 0.0))
        area = np.pi * a * a
        along = s * DENSITY / area * (1 + 2 / a * np.sqrt(VISCOSITY / s))
        across = s * area / (DENSITY * SOUND_SPEED**2) * (
            1 + 2 * (GAMMA - 1) / a * np.sqrt(VISCOSITY / (PRANDTL * s)))
        p, u = state
        return np.array([-along * u, -across * p])

    state = np.array([np.ones_like(s), radiating(bell.mouth)(s)])
    end = length + bell.length
    count = int(np.ceil(end / step))
    h = -end / count
    for i in range(count):
        x = end + i * h
        k1 = slope(x, state)
        k2 = slope(x + h / 2, state + h / 2 * k1)
        k3 = slope(x + h / 2, state + h / 2 * k2)
        k4 = slope(x + h, state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    zero = DENSITY * SOUND_SPEED / (np.pi * bell.bore**2)
    return state[0] / state[1] / zero


def peaks(bell: Bell, length: float, step: float):
    """(Hz, dB over Z_0), refined by a parabola."""
    frequency = np.arange(LOWEST, bell.cutoff, SPACING)
    level = 20 * np.log10(np.abs(impedance(bell, length, frequency, step)))
    at = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] >= level[2:])) + 1
    left, here, right = level[at - 1], level[at], level[at + 1]
    shift = 0.5 * (left - right) / (left - 2 * here + right)
    return np.stack([frequency[at] + SPACING * shift, here - 0.25 * (left - right) * shift], axis=1)


def main() -> int:
    text = ("// Written by bench/reed_bores/bell_reference.py, by Runge-Kutta over the horn equation. Rows as in\n"
            "// bore_reference.hpp, of a cylinder with its bell.\n" + HEADER +
            'inline constexpr std::string_view kBellReference = R"(\n')
    for name, bell in BELLS.items():
        for length in LENGTHS[name]:
            found, finer = peaks(bell, length, STEP), peaks(bell, length, STEP / 2)
            print(name, length, " ".join(f"{f:.2f} {d:.2f}" for f, d in found),
                  f"half the step: {np.abs(finer - found).max():.1e} Hz or dB")
            text += reference_row(name, "bell", length, finer)
    TABLE.write_text(text + ')";\n\n} // namespace tactus::reed::test\n')
    return 0


if __name__ == "__main__":
    sys.exit(main())
