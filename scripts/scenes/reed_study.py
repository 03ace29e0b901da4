"""Does force feedback help? Simulated hands explore a reed with and without force

Twenty simulated hands explore the plane of mouth pressure and reed frequency for a minute each,
from a silent start, without knowledge of the notes: with no force, with the slope of five
reeds' playability (the paper's), with the slope of linear theory's growth rate, and with the
guidance, which points to the nearest quick note and is zero there. The hands yield to a
lasting force within about a second. A hand is the same person with the same search whatever the force,
so differences are paired. Intervals are 95 %, by 10000 bootstrap samples of the hands.

The construction of the hands, the meaning of the numbers and their limits: docs/results/reed_study.md.
"""
import csv
import io
import pathlib
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy
from harness import stage_folder

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "programs" / "reed_study"))
import study  # noqa: E402

PATCH = "patches/reed/reed_haptic.pd"
NEEDS = "tactus_reed_map tactus_reed_study"
LONG = True
PLANES = {"trumpet": ("0", "8000", "80", "900"), "clarinet": ("0", "5000", "1000", "3500")}
COLOURS = {"off": "#8a8a8a", "reeds": "#c98b2b", "growth": "#7aa36f", "height": "#4d8fac",
           "guidance": "#2f4f9f"}
SHOWN_SEED = 2


def program(name):
    return str(stage_folder().parent / "programs" / name / f"tactus_{name}")


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


def draw_bars(axes, rows, preset, hand):
    labels, row = [], 0
    for feel, name in study.NAMES.items():
        for ceiling in (0,) if feel == "off" else (1, 2):
            value, low, high = study.interval(100 - 100 * study.column(
                rows, "playing", preset=preset, hand=hand, feel=feel, ceiling=ceiling))
            axes.barh(row, value, color=COLOURS[feel], alpha=0.6 if ceiling == 1 else 1)
            axes.plot([low, high], [row, row], color="black", linewidth=1.5)
            if feel == "off":
                axes.axvline(value / 2, color="black", linestyle=":", linewidth=1)
            labels.append(name.replace(" of the growth map", "")
                          + (f", {ceiling:g} N" if ceiling else ""))
            row += 1
    axes.set_yticks(range(row), labels)
    axes.invert_yaxis()
    axes.set(xlim=(0, 100), xlabel="time outside the playable region, %", title=study.HANDS[hand])


def draw_instruments(axes, rows):
    """Draws the paper's force and guidance at equal ceilings, for six instruments and seeds that were not used before."""
    for row, preset in enumerate(study.INSTRUMENTS):
        for shift, (feel, ceiling) in enumerate((f, c) for c in (1, 2) for f in ("reeds", "guidance")):
            value, low, high = study.time_out(rows, feel, ceiling, preset=preset, hand="searches",
                                              seeds=study.UNSEEN)
            x = row + 0.2 * (shift - 1.5)
            axes.bar(x, value, 0.19, color=COLOURS[feel], alpha=0.6 if ceiling == 1 else 1,
                     label=f"{study.NAMES[feel]}, {ceiling} N" if row == 0 else None)
            axes.plot([x, x], [low, high], color="black", linewidth=1.2)
    axes.axhline(0.5, color="black", linestyle=":", linewidth=1)
    axes.set_xticks(range(len(study.INSTRUMENTS)), study.INSTRUMENTS)
    axes.set(ylim=(0, 1), ylabel="time outside / no force")
    axes.legend(frameon=False, ncol=4, loc="upper center", bbox_to_anchor=(0.5, 1.18))


def draw_sensitivity(axes, rows, preset):
    for ceiling, mark in zip(study.CEILINGS, "os^"):
        for stiffness in study.STIFFNESSES:
            value, low, high = study.time_out(rows, "guidance", ceiling, preset=preset,
                                              hand="searches", stiffness=stiffness, seeds=(1, 10))
            reach = 1000 * ceiling / stiffness
            axes.plot([reach, reach], [low, high], color="#2f4f9f", linewidth=1)
            axes.plot(reach, value, mark, color="#2f4f9f", markersize=6,
                      label=f"{ceiling:g} N" if stiffness == 50 else None)
    axes.axhline(0.5, color="black", linestyle=":", linewidth=1)
    axes.set(xscale="log", ylim=(0, 1), title=preset,
             xlabel="largest force / stiffness of the hand, mm",
             ylabel="time outside, guidance / no force")
    axes.set_xticks([2.5, 5, 10, 20, 40, 66], ["2.5", "5", "10", "20", "40", "66"])
    axes.minorticks_off()
    axes.legend(frameon=False)


def trace(preset):
    """The course of one trial, without and with guidance."""
    text = subprocess.run([program("reed_study"), preset, "--feel", "off", "guidance", "--ceiling",
                           "2", "--trace", "--seeds", str(SHOWN_SEED), str(SHOWN_SEED)], check=True,
                          capture_output=True, text=True).stdout
    rows = list(csv.DictReader(io.StringIO(text)))
    for row in rows:
        row.update({key: float(value) for key, value in row.items() if key != "feel"})
    return {feel: [row for row in rows if row["feel"] == feel] for feel in ("off", "guidance")}


def make(scene):
    rows = study.run_all(program("reed_study"), lambda what: scene.progress(f"reed-study: {what}"))
    study.write(rows, scene.folder / "trials.csv")

    figure, axes = plt.subplots(figsize=(9, 3.4))
    draw_instruments(axes, rows)
    figure.tight_layout()
    scene.picture("reed_study_instruments", figure, "time outside the playable region, divided by that of the "
                  "same hands without force: the paper's force and guidance at equal force limits, 20 hands "
                  "that search, seeds not used before; dotted line: one half")
    scene.table(*study.equal_forces(rows), "equal forces, six instruments, 20 hands that search")

    figure, axes = plt.subplots(2, 4, figsize=(13, 6.2),
                                gridspec_kw={"width_ratios": [1, 1, 1.1, 1.1]})
    for line, preset in zip(axes, study.DESIGNED_ON):
        course = trace(preset)
        draw_traces(line[0], preset, course["off"], f"{preset}: no force")
        draw_traces(line[1], preset, course["guidance"], f"{preset}: guidance, 2 N")
        draw_bars(line[2], rows, preset, "searches")
        draw_bars(line[3], rows, preset, "wanders")
        line[3].set_yticks([])
    figure.tight_layout()
    scene.picture("reed_study", figure,
                  f"left: one minute of the same hand without and with force (seed {SHOWN_SEED}); blue "
                  "where a note plays, red where none does, grey the playability from rest. Right: "
                  "time outside the playable region, 20 hands, 95 % intervals; pale bars 1 N, dotted "
                  "line: half of the time without force")
    for preset in study.DESIGNED_ON:
        for hand, name in study.HANDS.items():
            scene.table(*study.summary(rows, preset, hand), f"{preset}, {name}, 20 hands")

    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8))
    for one, preset in zip(axes, study.DESIGNED_ON):
        draw_sensitivity(one, rows, preset)
    figure.tight_layout()
    scene.picture("reed_study_hands", figure, "dependence of the result on the hand and the force limit: 10 hands "
                  "that search; dotted line: half of the time without force")
    scene.table(*study.stiffness(rows), "guidance, 10 hands that search")
    scene.table(*study.yields(rows), "guidance, 10 hands that search, 200 N/m")
    scene.table(*study.gains(rows), "slopes with more gain: time outside / no force, mean force, speed of the "
                "hand; at most 2 N per axis, 10 hands that search")
    scene.file("trials.csv", "every trial")
