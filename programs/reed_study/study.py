#!/usr/bin/python3
"""The study of docs/results/reed_study.md: runs its trials and makes its tables.

  programs/reed_study/study.py run --program build/programs/reed_study/tactus_reed_study [--out FILE]
  programs/reed_study/study.py table equal_forces|summary|stiffness|yields|gains [PRESET HAND]

`run` runs every trial, which takes some minutes, and writes the trials, by default to
docs/results/reed_study_trials.csv; `table` prints a table of that page from the file."""
import argparse
import csv
import functools
import io
import os
import pathlib
import subprocess
import sys

import numpy

TRIALS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "results" / "reed_study_trials.csv"
DESIGNED_ON = ("trumpet", "clarinet")  # the instruments on which guidance was developed
INSTRUMENTS = ("trumpet", "clarinet", "sax", "oboe", "trombone", "voice")
UNSEEN = (101, 120)                    # seeds that were not run before guidance was finished
NAMES = {"off": "no force", "reeds": "five reeds", "growth": "growth rate",
         "height": "height of the growth map", "guidance": "guidance"}
HANDS = {"searches": "a hand that searches", "wanders": "a hand that wanders"}
WORDS = ("preset", "hand", "feel")
KEY = ("preset", "hand", "stiffness", "yield", "gain", "ceiling", "feel", "seed")
USUAL = {"stiffness": 200, "yield": 1, "gain": 0.3}
STIFFNESSES, CEILINGS, YIELDS, GAINS = (50, 100, 200, 400), (1, 2, 3.3), (0, 0.5, 2), (0.3, 1, 3)
SLOPES = ("reeds", "growth", "height")


# ---- the trials -----------------------------------------------------------------------------

def orders():
    """(label, arguments of the program) for all trials of the page."""
    for preset in INSTRUMENTS:
        yield f"{preset}, unseen seeds", (preset, "--feel", "off", "reeds", "guidance", "--seeds",
                                          *UNSEEN)
    for preset in DESIGNED_ON:
        for hand in HANDS:
            yield f"{preset}, {HANDS[hand]}", (preset, "--hand", hand)
        few = ("--seeds", 1, 10)
        yield f"{preset}, other hands", (preset, "--feel", "off", "guidance", "--ceiling", *CEILINGS,
                                         "--stiffness", *STIFFNESSES, *few)
        for seconds in YIELDS:
            yield f"{preset}, yielding within {seconds} s", (
                preset, "--feel", "off", "guidance", "--ceiling", 2, "--yield", seconds, *few)
        for gain in GAINS[1:]:
            yield f"{preset}, gain {gain}", (preset, "--feel", *SLOPES, "--ceiling", 2, "--gain", gain,
                                             *few)


def execute(program, arguments):
    """Returns the program's rows; the work is shared among the machine's cores."""
    parts = min(os.cpu_count() or 1, 8)
    runs = [subprocess.Popen([program, *map(str, arguments), "--part", f"{i}/{parts}"],
                             stdout=subprocess.PIPE, text=True) for i in range(1, parts + 1)]
    texts = [run.communicate()[0] for run in runs]
    if any(run.returncode for run in runs):
        raise RuntimeError(f"{program} failed")
    return parsed("".join(texts))


def parsed(text):
    rows = list(csv.DictReader(io.StringIO(text)))
    for row in rows:
        row.update({key: float(value) for key, value in row.items() if key not in WORDS})
    return rows


def run_all(program, progress=lambda what: None):
    """Runs every trial once."""
    found = {}
    for what, arguments in orders():
        progress(what)
        found.update({tuple(row[key] for key in KEY): row for row in execute(program, arguments)})
    return [found[key] for key in sorted(found)]


def write(rows, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: value if key in WORDS else f"{value:.6g}" for key, value in row.items()}
                         for row in rows)


@functools.cache
def committed():
    return parsed(TRIALS.read_text())


# ---- statistics -----------------------------------------------------------------------------

def column(rows, key, seeds=(1, 20), **wanted):
    """One value per seed, in order of seeds; the usual hand and gain unless others are requested."""
    wanted = USUAL | wanted
    chosen = [row for row in rows if all(row[name] == value for name, value in wanted.items())
              and seeds[0] <= row["seed"] <= seeds[1]]
    return numpy.array([row[key] for row in sorted(chosen, key=lambda row: row["seed"])])


def interval(values, statistic=lambda x: x.mean(axis=-1)):
    """Statistic and its 95 % interval over resampled hands. values: (hands,) or (k, hands)."""
    values = numpy.asarray(values, float)
    picks = numpy.random.default_rng(1).integers(values.shape[-1], size=(10000, values.shape[-1]))
    low, high = numpy.percentile(statistic(values[..., picks]), [2.5, 97.5])
    return float(statistic(values)), float(low), float(high)


def time_out(rows, feel, ceiling, gain=0.3, **wanted):
    """Time outside the playable region, relative to that without force, paired by hand."""
    pairs = [1 - column(rows, "playing", feel=feel, ceiling=ceiling, gain=gain, **wanted),
             1 - column(rows, "playing", feel="off", **wanted)]
    return interval(pairs, lambda x: x[0].mean(axis=-1) / x[1].mean(axis=-1))


def said(triple, scale=1, digits=0, unit=""):
    value, low, high = (f"{scale * x:.{digits}f}" for x in triple)
    return f"{value}{unit} ({low}..{high})"


# ---- tables: (header, rows) -----------------------------------------------------------------

def equal_forces(rows):
    """Compares the paper's force with guidance at equal ceilings of 1 and 2 N, on unseen seeds."""
    table = []
    for preset in INSTRUMENTS:
        common = {"preset": preset, "hand": "searches", "seeds": UNSEEN}
        ratios = [said(time_out(rows, feel, ceiling, **common), 1, 2)
                  for ceiling in (1, 2) for feel in ("reeds", "guidance")]
        out = 100 - 100 * column(rows, "playing", feel="off", **common).mean()
        table.append([preset, "yes" if preset in DESIGNED_ON else "no", f"{out:.0f} %", *ratios])
    return (["instrument", "used to design guidance", "time outside, no force", "five reeds, 1 N",
             "guidance, 1 N", "five reeds, 2 N", "guidance, 2 N"], table)


def summary(rows, preset, hand):
    """Compares all forces for one instrument and hand."""
    table = []
    for feel in NAMES:
        for ceiling in (0,) if feel == "off" else (1, 2):
            common = {"preset": preset, "hand": hand, "feel": feel, "ceiling": ceiling}
            values = functools.partial(column, rows, **common)
            ratio = "1" if feel == "off" else said(time_out(rows, **common), 1, 2)
            table.append([NAMES[feel] + (f", {ceiling:g} N" if ceiling else ""),
                          said(interval(values("playing")), 100, 0, " %"), ratio,
                          said(interval(values("losses")), 1, 1),
                          said(interval(values("first_s")), 1, 1, " s"),
                          said(interval(values("silence_s")), 1, 1, " s"),
                          f"{values('force_n').mean():.2f} N",
                          f"{values('playing_force_n').mean():.2f} N",
                          f"{values('speed_mm_s').mean():.0f} mm/s",
                          f"{values('places').mean():.0f}"])
    return (["force", "playing", "time outside / no force", "notes lost per minute", "first note after",
             "length of a silence", "mean force", "while playing", "hand's speed", "places played"], table)


def stiffness(rows):
    table = []
    for preset in DESIGNED_ON:
        for newtons_per_m in STIFFNESSES:
            common = {"preset": preset, "hand": "searches", "stiffness": newtons_per_m,
                      "seeds": (1, 10)}
            out = 100 - 100 * column(rows, "playing", feel="off", **common).mean()
            table.append([preset, f"{newtons_per_m} N/m", f"{out:.0f} %",
                          *(said(time_out(rows, "guidance", ceiling, **common), 1, 2)
                            for ceiling in CEILINGS)])
    return (["instrument", "hand's stiffness", "time outside, no force", "ratio at 1 N", "2 N", "3.3 N"],
            table)


def yields(rows):
    return (["instrument", "yields within", "ratio at 2 N"],
            [[preset, f"{seconds:g} s" if seconds else "never",
              said(time_out(rows, "guidance", 2, preset=preset, hand="searches", seeds=(1, 10),
                            **{"yield": seconds}), 1, 2)]
             for preset in DESIGNED_ON for seconds in YIELDS])


def gains(rows):
    table = []
    for preset in DESIGNED_ON:
        for feel in SLOPES:
            cells = [preset, NAMES[feel]]
            for gain in GAINS:
                common = {"preset": preset, "hand": "searches", "seeds": (1, 10)}
                mine = {"feel": feel, "ceiling": 2, "gain": gain}
                cells.append(f"{said(time_out(rows, **mine, **common), 1, 2)}, "
                             f"{column(rows, 'force_n', **mine, **common).mean():.1f} N, "
                             f"{column(rows, 'speed_mm_s', **mine, **common).mean():.0f} mm/s")
            table.append(cells)
    return ["instrument", "force", "gain 0.3 N", "1 N", "3 N"], table


TABLES = {"equal_forces": equal_forces, "summary": summary, "stiffness": stiffness, "yields": yields,
          "gains": gains}


def markdown(header, rows):
    return "".join("| " + " | ".join(row) + " |\n" for row in (header, *rows)).replace(
        "\n", "\n" + "|---" * len(header) + "|\n", 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run")
    run.add_argument("--program", required=True)
    run.add_argument("--out", type=pathlib.Path, default=TRIALS)
    table = commands.add_parser("table")
    table.add_argument("name", choices=TABLES)
    table.add_argument("of", nargs="*", help="summary: preset and hand")
    arguments = parser.parse_args()
    if arguments.command == "run":
        write(run_all(arguments.program, lambda what: print(what, file=sys.stderr, flush=True)),
              arguments.out)
    else:
        sys.stdout.write(markdown(*TABLES[arguments.name](committed(), *arguments.of)))


if __name__ == "__main__":
    main()
