#!/usr/bin/python3
"""How near footstep~ comes to recorded footsteps.

    realism.py --render build/bench/realism_footstep/render_footstep [--steps 30] [--out FOLDER]
               [--fetch FOLDER]     recordings unpacked there when they are not installed

Against the tables of targets.py: of 11 features how many medians lie within the recordings' 10 to 90 %,
and how many dB the mean band profile is off. Against the recordings of Debian's minetest-data and
ardentryst, where they are installed: top-1, top-3, distance and spread ratio, told-apart share, with
two controls that cheat. Writes realism.md and realism.csv."""
import argparse
import csv
import warnings
from pathlib import Path

import numpy as np

import judge
import targets
from features import RATE
from recordings import fetch, recordings
from steps import measure, render

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


def against_recordings(measured, root):
    taken = recordings(root)
    if not taken:
        return None
    vectors, _, _ = measure([r.sound() for r in taken])
    labels = np.array([r.label for r in taken])
    classifier = judge.Classifier(vectors, labels)
    known = [c for c in measured if c in set(labels)]
    rows = []
    for label in known:
        made = measured[label][0]
        ranked = classifier.ranked(made)
        answers = [r[0] for r in ranked]
        common = sorted(set(answers), key=lambda a: -answers.count(a))[:3]
        ratio, spread, told = judge.compare(classifier, vectors, made, label)
        rows.append([label, np.mean([a == label for a in answers]),
                     np.mean([label in r[:3] for r in ranked]), ratio, spread, told,
                     " ".join(f"{a}:{answers.count(a)}" for a in common)])
    real = judge.leave_one_out(vectors, labels)
    cheats = []
    for label, sounds in controls().items():
        made, _, _ = measure(sounds)
        ratio, spread, told = judge.compare(classifier, vectors, made, label)
        ranked = classifier.ranked(made)
        cheats.append([f"control: {label}", np.mean([r[0] == label for r in ranked]),
                       np.mean([label in r[:3] for r in ranked]), ratio, spread, told, ""])
    return rows, cheats, (np.mean(list(judge.hits(real, labels, 1).values())),
                          np.mean(list(judge.hits(real, labels, 3).values()))), len(taken)


def percent(x):
    return f"{100 * x:.0f}"


def write_report(folder, tables, compared):
    lines = ["| material | features within 10-90 % of recordings, of 11 | band profile, dB rms | outside |",
             "|---|---|---|---|"]
    lines += [f"| {m} | {n} | {db:.1f} | {rest} |" for m, n, db, rest in tables]
    if compared:
        rows, cheats, real, count = compared
        lines += ["", f"{count} recordings; left out one by one they are named right in "
                  f"{percent(real[0])} % (first) and {percent(real[1])} % (first three).", "",
                  "| material | top-1 % | top-3 % | distance ratio | spread ratio | told apart | taken for |",
                  "|---|---|---|---|---|---|---|"]
        mean = ["mean"] + [float(np.nanmean([r[i] for r in rows])) for i in range(1, 6)] + [""]
        for m, top1, top3, ratio, spread, told, named in rows + [mean] + cheats:
            shown = "" if np.isnan(told) else f"{told:.2f}"
            lines.append(f"| {m} | {percent(top1)} | {percent(top3)} | {ratio:.2f} | {spread:.2f} | "
                         f"{shown} | {named} |")
    else:
        lines += ["", "No recordings: install Debian's minetest-data and ardentryst."]
    text = "\n".join(lines) + "\n"
    (folder / "realism.md").write_text(text)
    print(text)
    with open(folder / "realism.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["material", "features_within", "profile_db_rms", "outside"])
        table.writerows(tables)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--render", required=True)
    parser.add_argument("--recipes", type=Path, default=ROOT / "data" / "surfaces")
    parser.add_argument("--steps", type=int, default=30)
    parser.add_argument("--out", type=Path, default=Path("."))
    parser.add_argument("--fetch", type=Path)
    arguments = parser.parse_args()
    root = fetch(arguments.fetch) if arguments.fetch and not recordings() else None
    arguments.out.mkdir(parents=True, exist_ok=True)
    measured = {label: measure(render(arguments.render, arguments.recipes / f"{label}.txt",
                                      arguments.steps, 11)) for label in targets.MATERIALS}
    write_report(arguments.out, against_tables(measured), against_recordings(measured, root))


if __name__ == "__main__":
    main()
