"""does the feel help? simulated hands explore a reed with and without force

Twenty simulated hands explore the plane of mouth pressure and reed frequency for a minute each,
from a silent start, knowing nothing of where the notes are: with no force, with the slope of five
reeds' playability (the paper's), with the slope of linear theory's growth rate, and with the
guidance that leads to the nearest quick note and leaves the hand alone there. A hand is the same
person with the same search whatever it feels, so differences are paired. Intervals are 95 %,
by 10000 bootstrap samples of the hands.

How the hands are made, what the numbers mean and what they do not show: docs/results/reed_study.md.
"""
import csv
import io
import os
import subprocess

import matplotlib.pyplot as plt
import numpy
from harness import stage_folder

PATCH = "patches/reed/reed_haptic.pd"
PLANES = {"trumpet": ("0", "8000", "80", "900"), "clarinet": ("0", "5000", "1000", "3500")}
NAMES = {"off": "no force", "reeds": "five reeds", "growth": "growth rate",
         "height": "height of the growth map", "guidance": "guidance"}
HANDS = {"searches": "a hand that searches", "wanders": "a hand that wanders"}
COLOURS = {"off": "#8a8a8a", "reeds": "#c98b2b", "growth": "#7aa36f", "height": "#4d8fac",
           "guidance": "#2f4f9f"}
SHOWN_SEED = 2


def program(name):
    return str(stage_folder().parent / "programs" / name / f"tactus_{name}")


def study(*arguments):
    """Rows of the program's table; the work is shared among the machine's cores."""
    parts = min(os.cpu_count() or 1, 8)
    runs = [subprocess.Popen([program("reed_study"), *map(str, arguments), "--part", f"{i}/{parts}"],
                             stdout=subprocess.PIPE, text=True) for i in range(1, parts + 1)]
    texts = [run.communicate()[0] for run in runs]
    if any(run.returncode for run in runs):
        raise RuntimeError("tactus_reed_study failed")
    text = "".join(texts)
    rows = list(csv.DictReader(io.StringIO(text)))
    for row in rows:
        row.update({key: float(value) for key, value in row.items()
                    if key not in ("preset", "hand", "feel")})
    return text, rows


def column(rows, key, **wanted):
    """One value a seed, in order of seeds."""
    chosen = [row for row in rows if all(row[name] == value for name, value in wanted.items())]
    return numpy.array([row[key] for row in sorted(chosen, key=lambda row: row["seed"])])


def interval(values, statistic=lambda x: x.mean(axis=-1)):
    """Statistic and its 95 % interval over resampled hands. values: (hands,) or (k, hands)."""
    values = numpy.asarray(values, float)
    picks = numpy.random.default_rng(1).integers(values.shape[-1], size=(10000, values.shape[-1]))
    low, high = numpy.percentile(statistic(values[..., picks]), [2.5, 97.5])
    return float(statistic(values)), float(low), float(high)


def time_out(rows, off, **wanted):
    """Time out of the playable region over that without force, pairs of one hand each."""
    pairs = [1 - column(rows, "playing", **wanted), 1 - off]
    return interval(pairs, lambda x: x[0].mean(axis=-1) / x[1].mean(axis=-1))


def said(triple, scale=1, digits=0, unit=""):
    value, low, high = (f"{scale * x:.{digits}f}" for x in triple)
    return f"{value}{unit} ({low}..{high})"


def summary(rows, hand):
    """Rows for a table: every feel of one instrument and hand."""
    table = []
    rows = [row for row in rows if row["hand"] == hand]
    off = column(rows, "playing", feel="off")
    for feel in NAMES:
        for ceiling in sorted({row["ceiling"] for row in rows if row["feel"] == feel}):
            one = {"feel": feel, "ceiling": ceiling}
            values = lambda key: column(rows, key, **one)
            ratio = "1" if feel == "off" else said(time_out(rows, off, **one), 1, 2)
            table.append([NAMES[feel] + (f", {ceiling:g} N" if ceiling else ""),
                          said(interval(values("playing")), 100, 0, " %"), ratio,
                          said(interval(values("losses")), 1, 1),
                          said(interval(values("first_s")), 1, 1, " s"),
                          said(interval(values("silence_s")), 1, 1, " s"),
                          f"{values('force_n').mean():.2f} N",
                          f"{values('playing_force_n').mean():.2f} N",
                          f"{values('speed_mm_s').mean():.0f} mm/s",
                          f"{values('places').mean():.0f}"])
    return table


HEADER = ["force", "playing", "time out / no force", "notes lost a minute", "first note after",
          "a silence lasts", "mean force", "while playing", "hand's speed", "places played"]


def draw_traces(axes, preset, trace, title):
    text = subprocess.run([program("reed_map"), preset, "--range", *PLANES[preset], "--nodes", "61",
                           "61"], check=True, capture_output=True, text=True).stdout
    table = list(csv.DictReader(io.StringIO(text)))
    f_p = numpy.array([float(row["f_p"]) for row in table]).reshape(61, 61)
    axes.imshow(f_p, origin="lower", extent=(0, 1, 0, 1), cmap="Greys", vmin=0, vmax=1.6,
                interpolation="bilinear")
    y, z, plays = (numpy.array([row[key] for row in trace]) for key in ("y", "z", "f_p"))
    plays = plays > 0.3
    axes.plot(y, z, color="#c0392b", linewidth=0.7)
    axes.plot(numpy.where(plays, y, numpy.nan), numpy.where(plays, z, numpy.nan), color="#1f5fbf",
              linewidth=1.3)
    axes.plot(y[0], z[0], "o", color="#c0392b", markersize=5)
    axes.set(xlim=(0, 1), ylim=(0, 1), xticks=[0, 0.5, 1], yticks=[0, 0.5, 1], title=title,
             xlabel="y: mouth pressure", ylabel="z: reed frequency")


def draw_bars(axes, rows, hand):
    rows = [row for row in rows if row["hand"] == hand]
    labels, place = [], 0
    for feel in NAMES:
        for ceiling in sorted({row["ceiling"] for row in rows if row["feel"] == feel}):
            value, low, high = interval(100 - 100 * column(rows, "playing", feel=feel,
                                                           ceiling=ceiling))
            axes.barh(place, value, color=COLOURS[feel], alpha=0.6 if ceiling == 1 else 1)
            axes.plot([low, high], [place, place], color="black", linewidth=1.5)
            if feel == "off":
                axes.axvline(value / 2, color="black", linestyle=":", linewidth=1)
            labels.append(NAMES[feel].replace(" of the growth map", "")
                          + (f", {ceiling:g} N" if ceiling else ""))
            place += 1
    axes.set_yticks(range(place), labels)
    axes.invert_yaxis()
    axes.set(xlim=(0, 100), xlabel="time out of the playable region, %", title=HANDS[hand])


def draw_sensitivity(axes, preset, rows):
    for ceiling, mark in ((1, "o"), (2, "s"), (3.3, "^")):
        for stiffness in (50, 100, 200, 400):
            off = column(rows, "playing", feel="off", stiffness=stiffness)
            value, low, high = time_out(rows, off, feel="guidance", stiffness=stiffness,
                                        ceiling=ceiling)
            reach = 1000 * ceiling / stiffness
            axes.plot([reach, reach], [low, high], color="#2f4f9f", linewidth=1)
            axes.plot(reach, value, mark, color="#2f4f9f", markersize=6,
                      label=f"{ceiling:g} N" if stiffness == 50 else None)
    axes.axhline(0.5, color="black", linestyle=":", linewidth=1)
    axes.set(xscale="log", ylim=(0, 1), title=preset,
             xlabel="largest force / stiffness of the hand, mm",
             ylabel="time out, guidance / no force")
    axes.set_xticks([2.5, 5, 10, 20, 40, 66], ["2.5", "5", "10", "20", "40", "66"])
    axes.minorticks_off()
    axes.legend(frameon=False)


def make(scene):
    searches, wanders, sensitive, gains, traces = {}, {}, {}, {}, {}
    for preset in PLANES:
        scene.progress(f"reed-study: {preset}, a hand that searches")
        text, searches[preset] = study(preset)
        (scene.folder / f"{preset}_searches.csv").write_text(text)
        scene.progress(f"reed-study: {preset}, a hand that wanders")
        text, wanders[preset] = study(preset, "--hand", "wanders")
        (scene.folder / f"{preset}_wanders.csv").write_text(text)
        scene.progress(f"reed-study: {preset}, other hands")
        text, sensitive[preset] = study(preset, "--feel", "off", "guidance", "--ceiling", 1, 2, 3.3,
                                        "--stiffness", 50, 100, 200, 400, "--seeds", 1, 10)
        (scene.folder / f"{preset}_stiffness.csv").write_text(text)
        for seconds in (0, 0.5, 2):
            text, rows = study(preset, "--feel", "off", "guidance", "--ceiling", 2, "--yield",
                               seconds, "--seeds", 1, 10)
            sensitive[preset, seconds] = rows
        gains[preset, 0.3] = [row for row in searches[preset]
                              if row["seed"] <= 10 and row["ceiling"] in (0, 2)]
        for gain in (1, 3):
            text, rows = study(preset, "--feel", "reeds", "growth", "height", "--ceiling", 2,
                               "--gain", gain, "--seeds", 1, 10)
            gains[preset, gain] = rows
        _, rows = study(preset, "--feel", "off", "guidance", "--ceiling", 2, "--trace", "--seeds",
                        SHOWN_SEED, SHOWN_SEED)
        traces[preset] = {feel: [row for row in rows if row["feel"] == feel]
                          for feel in ("off", "guidance")}

    figure, axes = plt.subplots(2, 4, figsize=(13, 6.2),
                                gridspec_kw={"width_ratios": [1, 1, 1.1, 1.1]})
    for line, preset in zip(axes, PLANES):
        draw_traces(line[0], preset, traces[preset]["off"], f"{preset}: no force")
        draw_traces(line[1], preset, traces[preset]["guidance"], f"{preset}: guidance, 2 N")
        draw_bars(line[2], searches[preset], "searches")
        draw_bars(line[3], wanders[preset], "wanders")
        line[3].set_yticks([])
    figure.tight_layout()
    scene.picture("reed_study", figure,
                  f"left: the same hand's minute without and with force (seed {SHOWN_SEED}); blue "
                  "where a note plays, red where none does, grey the playability from rest. Right: "
                  "time out of the playable region, 20 hands, 95 % intervals; pale bars 1 N, dotted "
                  "line half of the time without force")
    for preset in PLANES:
        for rows, hand in ((searches, "searches"), (wanders, "wanders")):
            scene.table(HEADER, summary(rows[preset], hand), f"{preset}, {HANDS[hand]}, 20 hands")

    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8))
    stiffness_rows = []
    for one, preset in zip(axes, PLANES):
        draw_sensitivity(one, preset, sensitive[preset])
        for stiffness in (50, 100, 200, 400):
            off = column(sensitive[preset], "playing", feel="off", stiffness=stiffness)
            ratios = [said(time_out(sensitive[preset], off, feel="guidance", stiffness=stiffness,
                                    ceiling=ceiling), 1, 2) for ceiling in (1, 2, 3.3)]
            stiffness_rows.append([preset, f"{stiffness} N/m",
                                   f"{100 * (1 - off.mean()):.0f} %", *ratios])
    figure.tight_layout()
    scene.picture("reed_study_hands", figure, "how the result depends on hand and ceiling: 10 hands "
                  "that search; dotted line half of the time without force")
    scene.table(["instrument", "hand's stiffness", "time out, no force", "ratio at 1 N", "2 N",
                 "3.3 N"], stiffness_rows, "guidance, 10 hands that search")
    yield_rows = []
    for preset in PLANES:
        for seconds in (0, 0.5, 2):
            rows = sensitive[preset, seconds]
            off = column(rows, "playing", feel="off")
            yield_rows.append([preset, f"{seconds:g} s" if seconds else "never",
                               said(time_out(rows, off, feel="guidance"), 1, 2)])
    scene.table(["instrument", "gives way within", "ratio at 2 N"], yield_rows,
                "guidance, 10 hands that search, 200 N/m")
    gain_rows = []
    for preset in PLANES:
        for feel in ("reeds", "growth", "height"):
            cells = [preset, NAMES[feel]]
            for gain in (0.3, 1, 3):
                rows, off = gains[preset, gain], column(gains[preset, 0.3], "playing", feel="off")
                ratio, low, high = time_out(rows, off, feel=feel)
                cells.append(f"{ratio:.2f} ({low:.2f}..{high:.2f}), "
                             f"{column(rows, 'force_n', feel=feel).mean():.1f} N, "
                             f"{column(rows, 'speed_mm_s', feel=feel).mean():.0f} mm/s")
            gain_rows.append(cells)
    scene.table(["instrument", "force", "gain 0.3 N", "1 N", "3 N"], gain_rows,
                "more gain for the slopes: time out / no force, mean force, hand's speed; at most "
                "2 N an axis, 10 hands that search")
    for preset in PLANES:
        for name in ("searches", "wanders", "stiffness"):
            scene.file(f"{preset}_{name}.csv", f"every trial: {preset}, {name}")
