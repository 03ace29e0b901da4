#!/usr/bin/python3
"""How well the presets' sustained notes are in tune with `tune 1`, over compass and pressure.

  bench/realism_reed/compass.py --programs build/bench/realism_reed [--rate 48000] [--presets sax,oboe]

Prints, for each preset and mouth pressure, the largest error in cents over the keys that sound, and
the keys that do not: silent, or in another register (more than 50 cents away)."""

import argparse
from pathlib import Path

import numpy as np

from lab import Request, play
from measure import cents, measure
from recordings import key_frequency

COMPASS = {  # preset: first key, last key, pressures in Pa
    "clarinet": (50, 70, (1800, 2000, 2500, 3000)),
    "sax": (50, 70, (1800, 2000, 2500)),
    "oboe": (58, 77, (1800, 2000, 2200)),
    "trumpet": (52, 76, (3000, 4000, 6000)),
    "trombone": (43, 65, (1500, 2000, 3000)),
    "voice": (43, 57, (1000, 1500, 2500)),
    "syrinx": (74, 88, (300, 600, 1000)),
}
SILENT_RMS = 50.0  # Pa in the bore


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=Path, required=True)
    parser.add_argument("--rate", type=int, default=48000)
    parser.add_argument("--presets", default=",".join(COMPASS))
    arguments = parser.parse_args()
    print("| preset | keys | p_m Pa | largest error, cents | silent | other register |\n"
          "|---|---|---|---|---|---|")
    for preset in arguments.presets.split(","):
        first, last, pressures = COMPASS[preset]
        keys = range(first, last + 1)
        for pressure in pressures:
            requests = [Request(preset, pressure, key_frequency(key), rate=arguments.rate,
                                options={"tune": 1}) for key in keys]
            errors, silent, jumped = [], [], []
            for key, played in zip(keys, play(arguments.programs / "render_reed", requests)):
                note = measure(played.sound, arguments.rate, key_frequency(key))
                bore = played.bore_pressure[played.bore_pressure.size // 2:]
                inside = measure(played.bore_pressure, arguments.rate, key_frequency(key))
                error = cents(note.frequency, key_frequency(key))
                if bore.std() < SILENT_RMS or not note.frequency > 0:
                    silent.append(str(key))
                elif abs(error) > 50 or inside.harmonics[0] < -15:
                    jumped.append(str(key))
                else:
                    errors.append(abs(error))
            largest = f"{np.max(errors):.1f}" if errors else ""
            print(f"| {preset} | {first}-{last} | {pressure} | {largest} | {' '.join(silent)} | "
                  f"{' '.join(jumped)} |")


if __name__ == "__main__":
    main()
