#!/usr/bin/python3
"""How near footstep~ comes to recorded footsteps.

    realism.py --render build/bench/realism_footstep/render_footstep [--steps 30] [--out FOLDER]
    realism.py --pd build/tactus [--feet 2] [--speed 1.4] [--rate 48000] [--by onsets] [--seed 1]
               the object itself walks in Pd and its sound is cut into steps
               [--fetch FOLDER]     recordings unpacked there when they are not installed
               [--without SECTION...]     leaves out rustle, room, grains ... to hear what they are for

Against the tables of targets.py: of 11 features how many medians lie within the recordings' 10 to 90 %,
and how many dB the mean band profile is off. Against those of recorded_steps.py: two contacts, energy by
time, and a picture of time by band for each ground. Against the recordings of Debian's minetest-data and
ardentryst, where they are installed: top-1, top-3, distance and spread ratio, told-apart share, with
two controls that cheat; then three classifiers on collections that they were not trained on.
Writes realism.md, realism.csv and a .png for each ground."""
import argparse
import csv
import re
import tempfile
import warnings
from pathlib import Path

import numpy as np

import comparison
import targets
import band_classifiers
from features import RATE, VECTOR
from population import Population
from recordings import fetch, recordings
from steps import RATE as RENDER_RATE
from steps import measure, render
from time_course import time_course
from time_report import contact_lines, energy_lines, picture
from validation import Recorded
from validation import lines as validation_lines
from walks import walked_steps

ROOT = Path(__file__).resolve().parents[2]
warnings.filterwarnings("ignore")


def controls():
    """Sounds that are no footsteps: a damped sine called wood, decaying noise called snow."""
    t = np.arange(RATE) / RATE
    random = np.random.RandomState(3)
    sines = [np.sin(2 * np.pi * 200 * t) * np.exp(-t / 0.02) for _ in range(10)]
    noises = [random.randn(RATE) * np.exp(-t / 0.05) for _ in range(10)]
    return {"wood": sines, "snow": noises}


def against_tables(measured):
    rows = []
    for label, (_, named, profiles) in measured.items():
        medians = {n: float(np.median(v)) for n, v in named.items()}
        off = profiles.mean(axis=0)[::2] - np.array(targets.PROFILES[label])
        outside = [n for n, (_, low, high) in zip(targets.NAMES, targets.FEATURES[label][1])
                   if not low <= medians[n] <= high]
        rows.append([label, targets.within(label, medians), float(np.sqrt(np.mean(off ** 2))),
                     " ".join(outside)])
    return rows


def compared(classifier, vectors, label, made):
    """A row of a table: how `made` fares as `label` among the classifier's sounds."""
    ranked = classifier.ranked(made)
    answers = [r[0] for r in ranked]
    common = sorted(sorted(set(answers)), key=lambda a: -answers.count(a))[:3]
    ratio, spread, told = comparison.compare(classifier, vectors, made, label)
    return {"top1": np.mean([a == label for a in answers]),
            "top3": np.mean([label in r[:3] for r in ranked]), "ratio": ratio, "spread": spread,
            "told": told, "taken": " ".join(f"{a}:{answers.count(a)}" for a in common)}


def mean_of(rows):
    """Of each figure over the materials that have it."""
    return {key: float(np.nanmean([row[key] for row in rows.values()]))
            for key in next(iter(rows.values())) if key != "taken"} | {"taken": ""}


def against_recordings(measured, vectors, labels):
    classifier = comparison.Classifier(vectors, labels)
    rows = {}
    for label in (c for c in measured if c in set(labels)):
        rows[label] = compared(classifier, vectors, label, measured[label][0])
        rows[label]["left_out"] = comparison.left_out_ratio(vectors, labels, label)
    rows["mean"] = mean_of(rows)
    for label, sounds in controls().items():
        rows[f"control: {label}"] = compared(classifier, vectors, label, measure(sounds)[0])
    return rows


def largest_deviations(measured, vectors, labels):
    """Rows of the features in which our medians differ most from the recordings' over all materials
    at once: a fault of the model rather than of a recipe. In units of the recordings' spread."""
    within = Population(vectors, labels).within
    known = [c for c in measured if c in set(labels)]
    off = np.array([(np.median(measured[c][0], axis=0) - np.median(vectors[labels == c], axis=0))
                    / within for c in known])
    order = np.argsort(-np.sqrt((off ** 2).mean(axis=0)))[:8]
    return {VECTOR[i]: {"mean": off[:, i].mean(), "rms": np.sqrt((off[:, i] ** 2).mean())}
            for i in order} | {"all 45": {"mean": off.mean(), "rms": np.sqrt((off ** 2).mean())}}


SHARES = "top1", "top3"


def percent(x):
    return f"{100 * x:.0f}"


def table(rows, columns):
    """Lines of a table; columns: heading and key, shares as per cent."""
    lines = ["| material | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for name, row in rows.items():
        cells = []
        for key in columns.values():
            value = row.get(key, np.nan)
            if isinstance(value, str):
                cells.append(value)
            elif np.isnan(value):
                cells.append("")
            else:
                cells.append(percent(value) if key in SHARES else f"{value:.2f}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


COLUMNS = {"top-1 %": "top1", "top-3 %": "top3", "distance ratio": "ratio",
           "of a recording left out": "left_out", "spread ratio": "spread", "told apart": "told",
           "taken for": "taken"}


def write_report(folder, tables, taken, measured, courses):
    lines = ["| material | features within 10-90 % of recordings, of 11 | band profile, dB rms | outside |",
             "|---|---|---|---|"]
    lines += [f"| {m} | {n} | {db:.1f} | {rest} |" for m, n, db, rest in tables]
    lines += ["", *contact_lines(courses), "", "Energy after the onset, dB of the whole, median (10, 90 %):",
              "", *energy_lines(courses)]
    if taken:
        sounds = [r.sound() for r in taken]
        vectors = measure(sounds)[0]
        labels, sources = (np.array([getattr(r, k) for r in taken]) for k in ("label", "source"))
        recorded = Recorded(vectors, band_classifiers.cells(sounds), labels, sources)
        cells = {m: c.levels_db.reshape(len(c.levels_db), -1) for m, c in courses.items()}
        lines += ["", f"{len(taken)} recordings:", "",
                  *table(against_recordings(measured, vectors, labels), COLUMNS), "",
                  "Features most out over all materials, in units of the recordings' spread:", "",
                  *table(largest_deviations(measured, vectors, labels), {"mean": "mean", "rms": "rms"}), "",
                  "Three judges, and collections that they have not heard:", "",
                  *validation_lines(recorded, {m: v for m, (v, _, _) in measured.items()}, cells)]
    else:
        lines += ["", "No recordings: install Debian's minetest-data and ardentryst."]
    text = "\n".join(lines) + "\n"
    (folder / "realism.md").write_text(text)
    print(text)
    with open(folder / "realism.csv", "w", newline="") as file:
        sheet = csv.writer(file)
        sheet.writerow(["material", "features_within", "profile_db_rms", "outside"])
        sheet.writerows(tables)


def played(arguments, label):
    """The steps of a material, its recipe with or without some of its sections."""
    if arguments.pd:
        return walked_steps(arguments.pd, label, arguments.steps, arguments.speed, arguments.rate,
                            arguments.feet, arguments.seed, arguments.by)
    text = (arguments.recipes / f"{label}.txt").read_text()
    parts = re.split(r"(?m)^(?=\[)", text)
    kept = [p for p in parts if p[1:].partition("]")[0] not in arguments.without]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"{label}.txt")
        # A recipe of nothing but what is left out keeps it.
        path.write_text("".join(kept if any(p.startswith("[") for p in kept) else parts))
        return render(arguments.render, path, arguments.steps, arguments.seed, arguments.speed,
                      arguments.rate)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--render")
    source.add_argument("--pd", help="folder of the library")
    parser.add_argument("--recipes", type=Path, default=ROOT / "data" / "surfaces")
    parser.add_argument("--steps", type=int, default=30)
    parser.add_argument("--out", type=Path, default=Path("."))
    parser.add_argument("--fetch", type=Path)
    parser.add_argument("--speed", type=float, default=1.4, help="of the walker, m/s")
    parser.add_argument("--rate", type=int, default=RENDER_RATE)
    parser.add_argument("--feet", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--by", choices=("contacts", "onsets"), default="contacts")
    parser.add_argument("--without", nargs="*", default=[])
    arguments = parser.parse_args()
    root = fetch(arguments.fetch) if arguments.fetch and not recordings() else None
    arguments.out.mkdir(parents=True, exist_ok=True)
    measured, courses = {}, {}
    for label in targets.MATERIALS:
        steps = played(arguments, label)
        measured[label], courses[label] = measure(steps), time_course(steps)
        picture(label, courses[label], steps, arguments.out / f"{label}.png")
    write_report(arguments.out, against_tables(measured), recordings(root), measured, courses)


if __name__ == "__main__":
    main()
