#!/usr/bin/python3
"""Writes core/reed/bore/bell_tables.cpp: what the wave of a trumpet or trombone meets where its tube flares.

  bench/reed_bores/bells.py [--check]

A bell is a Bessel horn, radius b (d + d_0)^-gamma at the distance d from its mouth (Benade & Jansson,
Acustica 31, 1974; Causse, Kergomard & Lurton, J. Acoust. Soc. Am. 75, 1984, fit real bells by a few
such parts): exponent 0.6 to 0.7 is a trumpet's or trombone's. The tube before it is a cylinder and
[greed~]'s line. Reflectance and radiation are transfer matrices of plane waves (transfer_matrix.py),
fitted by a few poles (vector_fit.py). A weight by the inverse of what leaves the horn keeps the heights
of the peaks; |R| <= 1 is checked from 0.1 Hz to 1 MHz, and reached by a scale where a fit exceeds it.
--check writes nothing and ends with status 1 if the committed table is another one."""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bores import SOUND_SPEED, Beyond
from terminations import RADIATION_BLOCKS, REFLECTION_BLOCKS, approximate, blocks_of, close, \
    minimum_phase
from transfer_matrix import respond
from vector_fit import evaluate, fit, residues

TABLE = Path(__file__).resolve().parents[2] / "core/reed/bore/bell_tables.cpp"
GRID = np.concatenate([[1.0], np.arange(5, 300, 5), np.arange(300, 10000, 10)])  # Hz


@dataclass
class Bell:
    bore: float     # radius of the tube, m
    mouth: float    # radius of the bell, m
    length: float   # of the flare
    exponent: float
    cutoff: float   # Hz, up to which peaks count
    delay: float    # m of the flare that count as tube
    knee: float     # Hz, above which the fit matters less

    def radius(self, distance: float) -> float:
        """At a distance from the flare's beginning."""
        end = self.length / ((self.mouth / self.bore) ** (1 / self.exponent) - 1)
        return self.mouth * (end / (self.length - distance + end)) ** self.exponent

    def beyond(self, corners: int = 160) -> Beyond:
        """Straight walls between corners, the closer the wider the horn opens."""
        ratio = (self.mouth / self.bore) ** (1 / self.exponent)
        end = self.length / (ratio - 1)
        positions = self.length + end - end * ratio ** np.linspace(1, 0, corners)
        positions[0], positions[-1] = 0.0, self.length
        return Beyond([(float(x), float(self.radius(x))) for x in positions])


BELLS = {
    # B flat trumpet: bore 11.7 mm, mouth 122 mm. Length and exponent: of those tried the ones that bring
    # the naturals nearest to a harmonic series with half of the power leaving above 850 Hz.
    "trumpet": Bell(5.85e-3, 61e-3, 0.70, 0.7, 1000.0, 0.05, 800.0),
    # Tenor trombone: bore 13.9 mm, mouth 216 mm; all that widens beyond the slide. 650 Hz.
    "trombone": Bell(6.95e-3, 108e-3, 1.0, 0.7, 700.0, 0.10, 500.0),
}


class Row:
    """One bell: numbers for the table and how good they are."""

    def __init__(self, bell: Bell):
        beyond = bell.beyond()
        s = 2j * np.pi * GRID
        reflected, _ = respond(beyond, GRID)
        weight = 1 / (1.02 - np.abs(reflected)) / (1 + (GRID / bell.knee)**3) / np.sqrt(GRID + 50)
        reflected = reflected * np.exp(2 * s * bell.delay / SOUND_SPEED)
        start = [2 * np.pi * complex(-0.2 * f, f) for f in np.geomspace(0.4, 2.5, 5) * bell.cutoff]
        start += [complex(-2 * np.pi * f) for f in (10, 200)]
        poles = fit(s, [reflected], [weight], [-1], start)
        found = residues(s, reflected, weight, -1, poles)
        wide = 2j * np.pi * np.geomspace(0.1, 1e6, 40000)
        self.largest = np.abs(evaluate(wide, -1, poles, found)).max()
        self.delay = bell.delay
        self.scale = min(1.0, 1 / self.largest)
        self.reflection = blocks_of(poles, found * self.scale)
        low = GRID < bell.cutoff
        self.error = np.abs(evaluate(s, -1, poles, found) * self.scale - reflected)[low].max()

        radiated = minimum_phase(lambda f: respond(beyond, f)[1] / bell.bore, GRID)
        steady = 1 / (np.abs(radiated) + 0.02 * np.abs(radiated).max()) / (1 + GRID / 4000)
        poles, found = approximate(s, radiated, steady, 0, RADIATION_BLOCKS, 3 * bell.cutoff)
        self.radiation = blocks_of(poles, found)
        level = 20 * np.log10(np.abs(evaluate(s, 0, poles, found) / radiated))
        self.level_error = np.abs(level[(GRID > 80) & (GRID < 6000)]).max()
        if len(self.reflection) != REFLECTION_BLOCKS or len(self.radiation) > RADIATION_BLOCKS:
            raise ValueError("another number of poles than the table has room for")

    def text(self) -> str:
        def block(row):
            kind, *numbers = row
            return (f"{{{'true' if kind else 'false'}, " +
                    ", ".join(f"{x:.9g}" for x in numbers) + "}")
        return (f"    {{0, {-self.scale:.9g}, {self.delay:.9g},\n     {{{{" +
                ",\n       ".join(map(block, self.reflection)) + "}},\n     {{" +
                ",\n       ".join(map(block, self.radiation)) + "}}},\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    text = ("// Written by bench/reed_bores/bells.py; geometry and sources are there.\n"
            "// Poles in rad/s at 20 deg C; see termination.hpp.\n"
            "#include \"core/reed/bore/termination.hpp\"\n\n#include <array>\n\n"
            "namespace tactus::reed {\nnamespace {\n\n// clang-format off\n")
    for name, bell in BELLS.items():
        row = Row(bell)
        text += (f"constexpr std::array<Termination, 1> k{name.capitalize()}{{{{\n{row.text()}}}}};\n")
        power = np.abs(respond(bell.beyond(), GRID)[0])**2
        print(f"{name}: half of the power leaves at {GRID[np.argmax(power < 0.5)]:.0f} Hz; largest |R| "
              f"before scaling {row.largest:.7f}, error of R below {bell.cutoff:.0f} Hz {row.error:.4f}, "
              f"of the radiated level {row.level_error:.1f} dB (80 Hz to 6 kHz)")
    text += ("// clang-format on\n\n} // namespace\n\n"
             "std::span<const Termination> bells(BoreEnd end) noexcept {\n  switch (end) {\n" +
             "".join(f"  case BoreEnd::k{name.capitalize()}:\n    return k{name.capitalize()};\n"
                     for name in BELLS) +
             "  default:\n    return {};\n  }\n}\n\n} // namespace tactus::reed\n")
    if arguments.check:
        same = TABLE.exists() and close(TABLE.read_text(), text)
        print("the committed table is this one" if same else "the committed table is another one")
        return 0 if same else 1
    TABLE.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
