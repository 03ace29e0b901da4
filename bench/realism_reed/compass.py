#!/usr/bin/python3
"""What a player gets from the presets with `tune 1` over the whole compass, from soft to loud.

  bench/realism_reed/compass.py --programs build/bench/realism_reed [--presets trumpet,oboe]
      [--every 1] [--from 0] [--set "embouchure 0.8 ..."]

Every key is held at three pressures, swelled from soft to loud and back, played short and blown by a
breath that rises for 2 s. A note is right within 50 cents, in its register; a foreign tone is the
strongest partial of the sound that is no harmonic of the note."""

import argparse
from pathlib import Path

import numpy as np

from notes import Heard, hear, held, short, slow, swell

# preset: lowest and highest key of the written compass, pressures pp, mf, ff in Pa
COMPASS = {
    "clarinet": (50, 83, (850, 2000, 5500)),
    "sax": (44, 76, (500, 2000, 6000)),
    "oboe": (58, 84, (500, 2000, 5000)),
    "trumpet": (52, 78, (700, 3000, 7000)),
    "trombone": (40, 72, (400, 2000, 4500)),
    "voice": (40, 73, (500, 1500, 4000)),
    "syrinx": (68, 99, (300, 700, 1500)),
}


def names(keys) -> str:
    return " ".join(str(key) for key in keys)


def db(x: float) -> float:
    return 20 * float(np.log10(max(x, 1e-12)))


class Compass:
    """One preset's notes, measured."""

    def __init__(self, program: Path, preset: str, keys: list[int], pressures: tuple,
                 options: dict, brief: bool = False):
        self.keys, self.pressures = keys, pressures
        requests, self.index = [], {}

        def ask(name, key, level, request):
            self.index[name, key, level] = len(requests)
            requests.append(request)

        for key in keys:
            for level, pressure in enumerate(pressures):
                ask("held", key, level, held(preset, key, pressure, options=options))
                if not brief:
                    for ms in (60, 120):
                        ask(ms, key, level, short(preset, key, pressure, ms / 1e3,
                                                  options=options))
            ask("swell", key, 0, swell(preset, key, pressures[0], pressures[-1], options=options))
            if not brief:
                ask("slow", key, 0, slow(preset, key, pressures[1], options=options))
        self.heard = hear(program, requests)

    def of(self, name, key, level=0) -> Heard:
        return self.heard[self.index[name, key, level]]

    def tuning_rows(self, preset: str) -> list[str]:
        rows = []
        for level, pressure in enumerate(self.pressures):
            notes = {key: self.of("held", key, level) for key in self.keys}
            right = [key for key in self.keys if notes[key].right]
            worst = max((abs(notes[key].cents) for key in right), default=float("nan"))
            foreign = max((notes[key].foreign_db for key in right), default=float("nan"))
            silent = [key for key in self.keys if notes[key].bore_rms <= 20]
            wrong = [key for key in self.keys if key not in right and key not in silent]
            two = [key for key in right if notes[key].foreign_db > -30]
            rows.append(f"| {preset} | {self.keys[0]}-{self.keys[-1]} | {pressure} | {worst:.1f} | "
                        f"{foreign:.0f} | {names(silent)} | {names(wrong)} | {names(two)} |")
        notes = {key: self.of("swell", key) for key in self.keys}
        wrong = [key for key in self.keys if notes[key].swell_wrong]
        two = [key for key in self.keys if key not in wrong and notes[key].swell_db > -30]
        foreign = max((n.swell_db for n in notes.values() if not n.swell_wrong),
                      default=float("nan"))
        worst = max((n.swell_cents for n in notes.values() if not n.swell_wrong),
                    default=float("nan"))
        rows.append(f"| {preset} | {self.keys[0]}-{self.keys[-1]} | swell | {worst:.1f} | "
                    f"{foreign:.0f} | | {names(wrong)} | {names(two)} |")
        return rows

    def playing_row(self, preset: str) -> str:
        def over(values, worst=max):
            return f"{np.median(values):.0f} ({worst(values):.0f})" if values else ""

        levels = range(len(self.pressures))
        right = [(key, level) for key in self.keys for level in levels
                 if self.of("held", key, level).right]
        half = [1e3 * self.of("held", *note).half_s for note in right]
        brief = [[db(self.of(ms, *note).top / self.of("held", *note).rms) for note in right]
                 for ms in (60, 120)]
        whole = [key for key in self.keys
                 if all(self.of("held", key, level).right for level in levels)]
        spread = [db(self.of("held", key, levels[-1]).rms / self.of("held", key, 0).rms)
                  for key in whole]
        brighter = [self.of("held", key, levels[-1]).centroid / self.of("held", key, 0).centroid
                    for key in whole]
        speaks = [1e3 * self.of("slow", key).tenth_s for key in self.keys
                  if self.of("slow", key).right]
        ratio = f"{np.median(brighter):.2f} ({min(brighter):.2f})" if brighter else ""
        return (f"| {preset} | {over(half)} | {over(brief[0], min)} | {over(brief[1], min)} | "
                f"{over(speaks)} | {over(spread, min)} | {ratio} |")


TUNING_HEAD = ("| preset | keys | p_m Pa | largest error, cents | foreign tone dB | silent | "
               "other register | foreign tone above -30 dB |\n|---|---|---|---|---|---|---|---|")
PLAYING_HEAD = ("| preset | ms to half level | 60 ms note dB | 120 ms note dB | "
                "ms until a 2 s breath speaks | pp to ff dB | centroid ff/pp |\n"
                "|---|---|---|---|---|---|---|")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=Path, required=True)
    parser.add_argument("--presets", default=",".join(COMPASS))
    parser.add_argument("--every", type=int, default=1, help="of the keys one in so many")
    parser.add_argument("--from", type=int, default=0, dest="first", help="keys left out below")
    parser.add_argument("--pressures", default="")
    parser.add_argument("--set", default="", help="NAME VALUE ... for every note")
    arguments = parser.parse_args()
    words = arguments.set.split()
    options = {name: float(value) for name, value in zip(words[::2], words[1::2])}
    playing = []
    print(TUNING_HEAD)
    for preset in arguments.presets.split(","):
        low, high, pressures = COMPASS[preset]
        if arguments.pressures:
            pressures = tuple(float(p) for p in arguments.pressures.split(","))
        keys = list(range(low, high + 1))[arguments.first::arguments.every]
        compass = Compass(arguments.programs / "measure_reed", preset, keys, pressures, options)
        print("\n".join(compass.tuning_rows(preset)), flush=True)
        playing.append(compass.playing_row(preset))
    print("\nMedian, in brackets the worst; of notes that are right.\n")
    print(PLAYING_HEAD + "\n" + "\n".join(playing))


if __name__ == "__main__":
    main()
