#!/usr/bin/python3
"""Whether a preset's timbre depends on the sample rate: harmonics below 10 kHz against 768 kHz.

  bench/realism_reed/rates.py --programs build/bench/realism_reed [--presets trumpet ...] [--harmonics]

Plays each preset with `tune 1` at the notes and pressures of docs/results/reed_sound.md and at loud
ones, at each sample rate and with `os` 2 and 4, and prints the largest difference in level of a
harmonic of the sound outlet from the same note at 768 kHz, dB, with its number. Harmonics more than
--floor dB below the strongest are left out. The levels are those of the sound before the soft clip
(the gain is lowered and made up for)."""

import argparse
from pathlib import Path

import numpy as np

from lab import Request, play
from measure import peak_in, pitch, spectrum
from recordings import key_frequency

NOTES = {  # preset: [(key, pressures in Pa)]
    "clarinet": [(53, (2000, 3000)), (60, (2000, 3000, 5000))],
    "sax": [(58, (1800, 2500)), (50, (2500,))],
    "oboe": [(64, (1900, 2200, 3000))],
    "trumpet": [(58, (3000, 5000, 8000)), (67, (3000, 5000, 8000))],
    "trombone": [(50, (2000, 3000, 6000)), (62, (2000, 3000))],
    "voice": [(50, (2500,))],
    "syrinx": [(80, (600, 1000))],
}
REFERENCE = 768000
VARIANTS = [(44100, 1), (48000, 1), (96000, 1), (192000, 1), (48000, 2), (48000, 4)]
HIGHEST = 10e3         # Hz
GAIN = 1e-3            # of the renders: far below the soft clip
SECONDS, STEADY = 2.4, (1.4, 2.4)


def levels(signal, rate, near):
    """Levels of the harmonics below HIGHEST over the steady part, dB, and the pitch in Hz."""
    steady = signal[int(STEADY[0] * rate):int(STEADY[1] * rate)]
    frequencies, amplitudes = spectrum(steady, rate)
    keep = frequencies < 1.1 * HIGHEST
    frequencies, amplitudes = frequencies[keep], amplitudes[keep]
    f0 = pitch(frequencies, amplitudes, near)
    count = int(HIGHEST / f0)
    peaks = [peak_in(frequencies, amplitudes, (n - 0.25) * f0, (n + 0.25) * f0)[1]
             for n in range(1, count + 1)]
    return 20 * np.log10(np.maximum(peaks, 1e-30)), f0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=Path, required=True)
    parser.add_argument("--presets", nargs="+", default=list(NOTES), choices=list(NOTES))
    parser.add_argument("--floor", type=float, default=40)
    parser.add_argument("--harmonics", action="store_true", help="print every harmonic's difference")
    parser.add_argument("--signal", choices=("sound", "bore_pressure"), default="sound")
    parser.add_argument("--set", nargs=2, action="append", default=[], metavar=("NAME", "VALUE"))
    arguments = parser.parse_args()
    own = {name: float(value) for name, value in arguments.set}
    head = [f"{rate / 1000:g}" + (f" os {os}" if os > 1 else "") for rate, os in VARIANTS]
    print("| preset, key, Pa | " + " | ".join(head) + " |\n" + "|---" * (len(head) + 1) + "|")
    worst = 0.0
    for preset in arguments.presets:
        for key, pressures in NOTES[preset]:
            near = key_frequency(key)
            for pressure in pressures:
                # A swinging valve computes at four times the rate anyway.
                requests = [Request(preset, pressure, near, rate=rate, seconds=SECONDS, options={
                    "tune": 1, "gain": GAIN, "os": 4 if preset == "syrinx" and os == 1 else os, **own})
                    for rate, os in [*VARIANTS, (REFERENCE, 1)]]
                played = play(arguments.programs / "render_reed", requests)
                found = [levels(getattr(p, arguments.signal), r.rate, near)
                         for p, r in zip(played, requests)]
                reference, f0 = found[-1]
                cells = []
                for level, f in found[:-1]:
                    count = min(level.size, reference.size)
                    apart = level[:count] - reference[:count]
                    apart[reference[:count] < reference.max() - arguments.floor] = 0
                    n = int(np.argmax(np.abs(apart)))
                    worst = max(worst, abs(apart[n]))
                    cells.append(f"{apart[n]:+.2f} (H{n + 1})"
                                 + ("" if abs(1200 * np.log2(f / f0)) < 20 else " other pitch"))
                    if arguments.harmonics:
                        print("    " + " ".join(f"{a:+.2f}" for a in apart))
                print(f"| {preset} {key}, {pressure} | " + " | ".join(cells) + " |", flush=True)
    print(f"\nlargest difference: {worst:.2f} dB")


if __name__ == "__main__":
    main()
