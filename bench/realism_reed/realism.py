#!/usr/bin/python3
"""How near the virtual reed's presets come to recorded instruments, beside STK's physical models.

  bench/realism_reed/realism.py --programs build/bench/realism_reed --out out/reed [--quick]
  bench/realism_reed/realism.py --programs build/bench/realism_reed --table sax,oboe

Measures, the same way for all, the sound font's recorded notes, greed~'s presets and STK's
Clarinet, Saxofony and Brass: H1..H10 in dB, brightness, attack and pitch. Writes realism.csv,
realism.md and realism.png. Ends with status 1 if a preset misses its goal."""

import argparse
import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from lab import Request, play, play_stk
from measure import Note, cents, distance, measure
from recordings import RATE, key_frequency, recorded
from targets import PRESETS, TARGETS

PRESSURES = {"clarinet": (2000, 2500, 3000), "sax": (1800, 2000, 2500), "oboe": (1900, 2000, 2200),
             "trumpet": (3000, 4000, 5000), "trombone": (2000, 2500, 3000)}
OTHER_KEYS = {"clarinet": (50, 55, 57, 62, 65, 69), "sax": (50, 53, 55, 62, 65, 69),
              "oboe": (60, 62, 67, 69, 72, 74), "trumpet": (55, 60, 62, 65, 70, 72),
              "trombone": (43, 46, 48, 53, 55, 58)}
STK = {"clarinet": "Clarinet", "tenor sax": "Saxofony", "trumpet": "Brass", "trombone": "Brass"}
STK_BREATH = (0.6, 0.8, 1.0, 2.0, 4.0)
GOAL_DB, GOAL_CENTROID, GOAL_ATTACK, GOAL_CENTS = 8.0, 0.35, (0.015, 0.2), 10.0


@dataclass
class Row:
    source: str
    instrument: str
    key: int
    blown: float
    note: Note
    target: np.ndarray
    centroid: float
    in_table: bool

    @property
    def distance(self) -> float:
        return distance(self.note.harmonics, self.target)

    @property
    def brightness(self) -> float:
        return self.note.centroid / self.centroid

    @property
    def off(self) -> float:
        return cents(self.note.frequency, key_frequency(self.key))

    @property
    def nearest(self) -> str:
        return min(TARGETS, key=lambda t: distance(self.note.harmonics, np.array(TARGETS[t][2])))[0]

    @property
    def silent(self) -> bool:
        return self.note.rms < 1e-4

    @property
    def meets(self) -> bool:
        return (self.distance <= GOAL_DB and abs(self.brightness - 1) <= GOAL_CENTROID and
                GOAL_ATTACK[0] <= self.note.attack <= GOAL_ATTACK[1] and
                abs(self.off) <= GOAL_CENTS and self.nearest == self.instrument)


def target_of(instrument: str, key: int) -> tuple[np.ndarray, float]:
    """H1..H10 and centroid: the table's where it has the note, else measured now."""
    if (instrument, key) in TARGETS:
        _, centroid, harmonics = TARGETS[instrument, key]
        return np.array(harmonics, float), centroid
    note = measure(recorded(instrument, key), RATE, key_frequency(key))
    return note.harmonics, note.centroid


def measure_recordings() -> list[Row]:
    rows = []
    for (instrument, key), (_, centroid, harmonics) in TARGETS.items():
        note = measure(recorded(instrument, key), RATE, key_frequency(key))
        rows.append(Row("recording", instrument, key, 110, note, np.array(harmonics, float),
                        centroid, True))
    return rows


def measure_presets(program: Path, options: dict, others: bool,
                    presets: tuple[str, ...] = tuple(PRESETS)) -> list[Row]:
    rows = []
    for preset in presets:
        instrument = PRESETS[preset]
        keys = [key for name, key in TARGETS if name == instrument]
        for key in keys + (list(OTHER_KEYS[preset]) if others else []):
            target, centroid = target_of(instrument, key)
            requests = [Request(preset, pressure, key_frequency(key), options=options)
                        for pressure in PRESSURES[preset]]
            for request, played in zip(requests, play(program, requests)):
                note = measure(played.sound, request.rate, request.bore)
                rows.append(Row(f"greed~ {preset}", instrument, key, request.pressure, note,
                                target, centroid, key in keys))
    return rows


def measure_stk(program: Path) -> list[Row]:
    """Each at the breath with which it comes nearest, for that is its best setting."""
    rows = []
    for (instrument, key), (_, centroid, harmonics) in TARGETS.items():
        if instrument not in STK:
            continue
        tried = [Row(f"STK {STK[instrument]}", instrument, key, breath,
                     measure(play_stk(program, STK[instrument], key_frequency(key), breath), RATE,
                             key_frequency(key)), np.array(harmonics, float), centroid, True)
                 for breath in STK_BREATH]
        rows.append(min(tried, key=lambda row: (row.silent, row.distance)))
    return rows


def markdown(rows: list[Row]) -> str:
    lines = ["| source | note | blown | cents | distance dB | centroid ratio | attack ms | nearest |"
             " H1 H2 ... H10 |", "|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        if row.silent:
            lines.append(f"| {row.source} | {row.instrument} {row.key} | | | silent | | | | |")
            continue
        levels = " ".join(f"{round(float(level))}" for level in row.note.harmonics)
        lines.append(f"| {row.source} | {row.instrument} {row.key} | {row.blown:g} | {row.off:+.1f} | "
                     f"{row.distance:.1f} | {row.brightness:.2f} | {row.note.attack * 1e3:.0f} | "
                     f"{row.nearest} | {levels} |")
    return "\n".join(lines) + "\n"


def matrix(rows: list[Row]) -> str:
    """Mean distance of each source from each instrument of the table (nearest of its notes)."""
    instruments = list(dict.fromkeys(name for name, _ in TARGETS))
    lines = ["| source | " + " | ".join(instruments) + " |", "|---" * (len(instruments) + 1) + "|"]
    for source in dict.fromkeys(row.source for row in rows if not row.silent):
        own = [row for row in rows if row.source == source and row.in_table and not row.silent]
        if source == "recording":
            continue
        far = [np.mean([min(distance(row.note.harmonics, np.array(t[2]))
                            for (name, _), t in TARGETS.items() if name == instrument)
                        for row in own]) for instrument in instruments]
        lines.append(f"| {source} | " + " | ".join(f"{d:.1f}" for d in far) + " |")
    return "\n".join(lines) + "\n"


def draw(rows: list[Row], path: Path) -> None:
    figure, axes = plt.subplots(len(TARGETS), 1, figsize=(7, 1.35 * len(TARGETS)), sharex=True)
    for axis, (instrument, key) in zip(axes, TARGETS):
        here = [r for r in rows if (r.instrument, r.key) == (instrument, key)]
        reed = [r for r in here if r.source.startswith("greed~")]
        shown = ([r for r in here if r.source == "recording"] + reed[len(reed) // 2:][:1] +
                 [r for r in here if r.source.startswith("STK") and not r.silent])
        for i, row in enumerate(shown):
            levels = np.maximum(row.note.harmonics, -40) + 40
            axis.bar(np.arange(1, 11) + 0.26 * (i - 1), levels, 0.25, bottom=-40,
                     color=("#444444", "#d9662b", "#9db4c0")[i],
                     label=row.source if row.source == "recording" else
                     f"{row.source}, {row.distance:.1f} dB")
        axis.set_ylim(-40, 2)
        axis.set_ylabel("dB", fontsize=7)
        axis.tick_params(labelsize=7)
        axis.set_title(f"{instrument}, {key_frequency(key):.0f} Hz", fontsize=8, loc="left", pad=2)
        axis.legend(fontsize=6, ncol=3, loc="lower right", bbox_to_anchor=(1, 0.98), frameon=False,
                    borderaxespad=0.1)
    axes[-1].set_xticks(range(1, 11))
    axes[-1].set_xlabel("harmonic", fontsize=8)
    figure.tight_layout(pad=0.4)
    figure.savefig(path, dpi=80)
    plt.close(figure)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=Path, required=True, help="where render_reed was built")
    parser.add_argument("--out", type=Path, default=Path("out/reed"))
    parser.add_argument("--quick", action="store_true", help="the table's notes alone, without STK")
    parser.add_argument("--plain", action="store_true",
                        help="presets without bell, brassiness and ear: how they sounded before")
    parser.add_argument("--table", metavar="PRESETS",
                        help="print the rows of these presets at the table's notes, no more: needs "
                             "neither recordings nor STK")
    arguments = parser.parse_args()
    options: dict = {"tune": 1}
    if arguments.plain:
        options |= {"bell": 0, "end": 0, "ear": 0, "embouchure": 0, "lip_mass": 1, "lip_opening": 1,
                    "lip_width": 1, "lip_q": 1, "lip_channel": 1, "gain": 0.5}
    if arguments.table:
        print(markdown(measure_presets(arguments.programs / "render_reed", options, False,
                                       tuple(arguments.table.split(",")))))
        return 0
    rows = measure_recordings()
    rows += measure_presets(arguments.programs / "render_reed", options, not arguments.quick)
    stk = arguments.programs / "render_stk"
    if not arguments.quick and stk.exists():
        rows += measure_stk(stk)

    arguments.out.mkdir(parents=True, exist_ok=True)
    table = markdown(rows) + "\n" + matrix(rows)
    (arguments.out / "realism.md").write_text(table)
    with open(arguments.out / "realism.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["source", "instrument", "key", "blown", "in_table", "cents", "distance_db",
                         "centroid_ratio", "attack_s", "nearest", "rms", "peak"] +
                        [f"h{n}" for n in range(1, 11)])
        for r in rows:
            writer.writerow([r.source, r.instrument, r.key, r.blown, int(r.in_table),
                             f"{r.off:.2f}", f"{r.distance:.2f}", f"{r.brightness:.3f}",
                             f"{r.note.attack:.4f}", r.nearest, f"{r.note.rms:.4f}",
                             f"{r.note.peak:.4f}"] + [f"{h:.1f}" for h in r.note.harmonics])
    draw(rows, arguments.out / "realism.png")
    print(table)
    missed = [r for r in rows if r.source.startswith("greed~") and r.in_table and not r.meets]
    for r in missed:
        print(f"missed: {r.source} {r.key} at {r.blown:g} Pa")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
