#!/usr/bin/python3
"""Writes core/reed/bore/termination_tables.cpp: what [greed~]'s notes meet at the end of their line.

  bench/reed_bores/terminations.py [--check]

For each fingering of bores.py, reflectance and radiation (transfer_matrix.py) as sums of a few poles
(vector_fit.py). Prints how good each fit is; --check writes nothing and ends with status 1 if the
committed table is another one."""

import argparse
import sys
from pathlib import Path

import numpy as np

from bores import SOUND_SPEED, WOODWINDS
from transfer_matrix import bore_radius_at, respond
from vector_fit import evaluate, fit, residues

TABLE = Path(__file__).resolve().parents[2] / "core/reed/bore/termination_tables.cpp"
REFLECTION_BLOCKS, RADIATION_BLOCKS = 6, 4
GRID = np.concatenate([[1.0], np.arange(10, 8000, 10)])  # Hz


def minimum_phase(magnitude_at, frequency):
    """Response of least phase whose magnitude is magnitude_at(Hz), by the cepstrum; it is 0 at 0 Hz
    in proportion to the frequency."""
    full = np.arange(0, 40001, 20.0)
    full[0] = 1
    corner = 500.0
    zero = 1j * full / (1j * full + corner)
    smooth = np.log(np.maximum(magnitude_at(full), 1e-12) / np.abs(zero))
    cepstrum = np.fft.ifft(np.concatenate([smooth, smooth[-2:0:-1]])).real
    fold = np.zeros(cepstrum.size)
    fold[0] = fold[full.size - 1] = 1
    fold[1:full.size - 1] = 2
    phase = np.fft.fft(cepstrum * fold)[:full.size].imag
    return np.exp(1j * np.interp(frequency, full, phase)) * np.interp(
        frequency, full, np.exp(smooth)) * (1j * frequency / (1j * frequency + corner))


def blocks_of(poles, found):
    """Rows (oscillates, a, b, c, d): pole a +- jb with residue c +- jd, or real poles a and b with
    residues c and d."""
    rows = [(True, p.real, p.imag, r.real, r.imag)
            for p, r in zip(poles, found) if p.imag]
    real = [(p.real, r.real) for p, r in zip(poles, found) if not p.imag]
    if len(real) % 2:
        real.append((-1.0, 0.0))
    rows += [(False, p, q, r, t) for (p, r), (q, t) in zip(real[::2], real[1::2])]
    return rows


def approximate(s, response, weight, at_zero, blocks, top):
    start = [2 * np.pi * complex(-0.15 * f, f) for f in np.geomspace(top / 4, top, blocks - 1)]
    start.append(2 * np.pi * complex(-4000, 2000))
    poles = fit(s, [response], [weight], [at_zero], start)
    return poles, residues(s, response, weight, at_zero, poles)


class Row:
    """One fingering: numbers for the table and how good they are."""

    def __init__(self, key, beyond, lattice, delay=0.0):
        s = 2j * np.pi * GRID
        plane = bore_radius_at(beyond, 0.0)
        reflected, _ = respond(beyond, GRID)
        reflected = reflected * np.exp(2 * s * delay / SOUND_SPEED)
        radiated = minimum_phase(lambda f: respond(beyond, f)[1] / plane, GRID)
        weight = 1 / (0.1 + (GRID / lattice)**3) / np.sqrt(GRID + 200)
        self.key, self.delay = key, delay
        poles, found = approximate(s, reflected, weight, -1, REFLECTION_BLOCKS, 2.8 * lattice)
        wide = 2j * np.pi * np.geomspace(0.1, 1e6, 40000)
        self.largest = np.abs(evaluate(wide, -1, poles, found)).max()
        self.scale = min(1.0, 1 / self.largest)  # no more than all comes back, at any frequency
        self.reflection = blocks_of(poles, found * self.scale)
        low = GRID < lattice
        error = evaluate(s, -1, poles, found) * self.scale - reflected
        self.error = np.abs(error[low]).max()
        steady = 1 / (np.abs(radiated) + 0.02 * np.abs(radiated).max()) / (1 + GRID / 4000)
        poles, found = approximate(s, radiated, steady, 0, RADIATION_BLOCKS, 4 * lattice)
        self.radiation = blocks_of(poles, found)
        level = 20 * np.log10(np.abs(evaluate(s, 0, poles, found) / radiated))
        self.level_error = np.abs(level[GRID > 40]).max()
        if max(len(self.reflection) - REFLECTION_BLOCKS, len(self.radiation) - RADIATION_BLOCKS) > 0:
            raise ValueError(f"key {key}: more poles than the table has room for")

    def text(self) -> str:
        def block(row):
            kind, *numbers = row
            return (f"{{{'true' if kind else 'false'}, " +
                    ", ".join(f"{x:.9g}" for x in numbers) + "}")
        return (f"    {{{self.key}, {-self.scale:.9g}, {self.delay:.9g},\n     {{{{" +
                ",\n       ".join(map(block, self.reflection)) + "}},\n     {{" +
                ",\n       ".join(map(block, self.radiation)) + "}}},\n")


def rows_of(name: str) -> list[Row]:
    wind = WOODWINDS[name]
    return [Row(key, wind.beyond(key), wind.cutoff_at(key)) for key in wind.keys]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    text = ("// Written by bench/reed_bores/terminations.py; geometry and sources are in bores.py there.\n"
            "// Poles in rad/s at 20 deg C; see termination.hpp.\n"
            "#include \"core/reed/bore/termination.hpp\"\n\n#include <array>\n\n"
            "namespace tactus::reed {\nnamespace {\n\n// clang-format off\n")
    cases = []
    for name in WOODWINDS:
        rows = rows_of(name)
        text += (f"constexpr std::array<Termination, {len(rows)}> k{name.capitalize()}{{{{\n" +
                 "".join(row.text() for row in rows) + "}};\n")
        cases.append(name)
        print(f"{name}: largest |R| before scaling {max(r.largest for r in rows):.6f}, error of R "
              f"below the cut-off {max(r.error for r in rows):.4f}, of the radiated level "
              f"{np.median([r.level_error for r in rows]):.1f} dB (median of the fingerings' largest)")
    text += "// clang-format on\n\n} // namespace\n\n"
    text += ("std::span<const Termination> terminations(BoreEnd end) noexcept {\n  switch (end) {\n" +
             "".join(f"  case BoreEnd::k{name.capitalize()}:\n    return k{name.capitalize()};\n"
                     for name in cases) +
             "  default:\n    return bells(end);\n  }\n}\n\n} // namespace tactus::reed\n")
    if arguments.check:
        same = TABLE.exists() and close(TABLE.read_text(), text)
        print("the committed table is this one" if same else "the committed table is another one")
        return 0 if same else 1
    TABLE.write_text(text)
    return 0


def close(one: str, other: str) -> bool:
    """The same words, numbers to 1e-4 of themselves: linear algebra differs between machines."""
    def words(text):
        return text.replace("{", " ").replace("}", " ").replace(",", " ").split()
    mine, theirs = words(one), words(other)
    def alike(a, b):
        try:
            return np.isclose(float(a), float(b), rtol=1e-4, atol=1e-7)
        except ValueError:
            return a == b
    return len(mine) == len(theirs) and all(map(alike, mine, theirs))


if __name__ == "__main__":
    sys.exit(main())
