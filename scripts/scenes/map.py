"""Where each preset plays, over mouth pressure and reed frequency

Left: the playability f_p of an instrument blown at every point of the plane, from rest. Right: the
growth rate of a note there by linear theory; white is the boundary between decay and growth.
The same boundary is drawn over the left picture. Where the two disagree, a note grows too slowly to
speak within the 0.7 s of a node (the pale rim), an instrument speaks
below the threshold of its smallest oscillations, or a valve is held at its limit. The map in the
Pd patch (reed_map) is the left one, computed in the background by [playability_map].
"""
import csv
import io
import subprocess

import matplotlib.pyplot as plt
import numpy
from harness import stage_folder

PATCH = "patches/reed/reed_haptic.pd"
NEEDS = "tactus_reed_map"
PRESETS = ["trumpet", "clarinet", "sax", "oboe", "trombone", "voice", "syrinx"]
PLAYS = 0.3  # f_p above which a reed counts as playing


def compute(preset, nodes=81):
    """Columns of the program's table as arrays of shape (rows, columns): reed frequency increases upwards."""
    program = stage_folder().parent / "programs" / "reed_map" / "tactus_reed_map"
    text = subprocess.run([program, preset, "--nodes", str(nodes), str(nodes)], check=True,
                          capture_output=True, text=True).stdout
    rows = list(csv.DictReader(io.StringIO(text)))
    return text, {name: numpy.array([float(row[name]) for row in rows]).reshape(nodes, nodes)
                  for name in rows[0]}


def draw(preset, table):
    pressure, frequency = table["pressure_pa"] / 1000, table["reed_hz"]
    starts = numpy.where(table["free"] > 0, table["growth_per_s"], -100)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), sharey=True)
    shown = left.pcolormesh(pressure, frequency, table["f_p"], cmap="viridis", vmin=0, vmax=1,
                            shading="gouraud")
    figure.colorbar(shown, ax=left, label="playability f_p")
    left.contour(pressure, frequency, starts, levels=[0], colors="white", linewidths=1)
    shown = right.pcolormesh(pressure, frequency, numpy.clip(starts, -100, 100), cmap="RdBu_r",
                             vmin=-100, vmax=100, shading="gouraud")
    figure.colorbar(shown, ax=right, label="growth rate, 1/s")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.set_xlabel("mouth pressure, kPa")
    left.set_ylabel("reed or lip frequency, Hz")
    figure.suptitle(f"{preset}: where it plays, and where a note starts by theory")
    return figure


def make(scene):
    agreement = []
    for i, preset in enumerate(PRESETS):
        scene.progress(f"map: {preset} ({i + 1} of {len(PRESETS)})")
        text, table = compute(preset)
        (scene.folder / f"{preset}.csv").write_text(text)
        scene.picture(preset, draw(preset, table), preset)
        scene.file(f"{preset}.csv", "the table")
        plays = table["f_p"] > PLAYS
        starts = (table["growth_per_s"] > 0) & (table["free"] > 0)
        agreement.append([preset, f"{100 * plays.mean():.1f} %", f"{100 * starts.mean():.1f} %",
                          f"{100 * (plays == starts).mean():.1f} %"])
    scene.table(["preset", f"plays (f_p > {PLAYS})", "a note starts (theory)", "both agree"],
                agreement, "share of the plane")
