#!/usr/bin/python3
"""stress_sheet.py PART.npz PICTURE.png: a loaded part in the colours of its von Mises stress, before and after its
control points moved.

Supports are drawn in grey, loads as red arrows, control points that may move as blue dots (others hollow); the large
dot marks the highest stress. part_stress --sheet writes PART.npz and calls this script.
"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.patheffects import withStroke
from matplotlib.tri import Triangulation

INK, PAPER, FAINT, HELD, LOAD, CONTROL = "#22303c", "#fbfaf7", "#a9b4bd", "#3d4c5a", "#b3262e", "#1d5fa8"
MAP = matplotlib.colormaps["turbo"]
ELEVATION, AZIMUTH = np.radians(20), np.radians(16)  # the viewer is above and to the right of the z axis, which points
                                                     # at the viewer
EYE = np.array([np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION), np.cos(ELEVATION) * np.cos(AZIMUTH)])
RIGHT = np.array([np.cos(AZIMUTH), 0, -np.sin(AZIMUTH)])
UP = np.cross(EYE, RIGHT)
LIGHT = np.array([-0.35, 0.8, 0.5]) / 1.006


def on_paper(points):
    return np.asarray(points) @ np.stack([RIGHT, UP], axis=1)


def draw_body(axes, points, triangles, stress, top):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    seen = np.flatnonzero(normals @ EYE > 0)
    seen = seen[np.argsort(points[triangles[seen]].mean(axis=1) @ EYE)]
    shade = (0.72 + 0.28 * np.clip(normals[seen] @ LIGHT, -1, 1))[:, None, None]
    corners = triangles[seen]
    colours = np.clip(MAP(np.clip(stress[corners] / top, 0, 1))[:, :, :3] * shade, 0, 1)
    # Each triangle has its own corners, since neighbouring triangles are lit differently.
    flat = on_paper(points)[corners]
    own = Triangulation(*flat.reshape(-1, 2).T, triangles=np.arange(3 * len(corners)).reshape(-1, 3))
    rgb = colours.mean(axis=1)  # drawn below, against hairlines between triangles
    axes.add_collection(PolyCollection(flat, facecolors=rgb, edgecolors=rgb, linewidths=0.5, zorder=1.9))
    smooth = TriMesh(own, zorder=2)
    smooth.set_facecolor(np.concatenate([colours.reshape(-1, 3), np.ones((3 * len(corners), 1))], axis=1))
    axes.add_collection(smooth)


def lattice_lines(controls, shape):
    grid = on_paper(controls).reshape(shape[2], shape[1], shape[0], 2)
    lines = []
    for axis in range(3):
        rows = np.moveaxis(grid, axis, 2)
        lines += list(rows.reshape(-1, rows.shape[2], 2))
    return lines


def draw_state(axes, data, meta, state, top, reach):
    points = data["nodes"][state]
    controls = data["moved_controls"] if state else data["controls"]
    draw_body(axes, points, data["triangles"], data["stress"][state], top)
    axes.add_collection(LineCollection(lattice_lines(controls, meta["lattice"]), colors=FAINT, linewidths=0.6,
                                       zorder=3, alpha=0.7))
    free = data["is_free"] > 0
    flat = on_paper(controls)
    axes.plot(*flat[~free].T, "o", ms=3.5, mfc=PAPER, mec=FAINT, zorder=4)
    axes.plot(*flat[free].T, "o", ms=4.6, mfc=CONTROL, mec="white", mew=0.7, zorder=4)
    moved = np.linalg.norm(data["moved_controls"] - data["controls"], axis=1) > 1e-9
    if state and moved.any():
        start, end = on_paper(data["controls"])[moved], flat[moved]
        for from_, to in zip(start, end):
            axes.annotate("", to, from_, arrowprops={"arrowstyle": "-|>", "color": CONTROL, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
                          zorder=6)
    for number in np.flatnonzero(moved if moved.any() else free & False):
        axes.annotate(str(number), flat[number], xytext=(6, 6), textcoords="offset points", fontsize=9.5, color=CONTROL,
                      weight="bold", zorder=9, path_effects=[withStroke(linewidth=2.5, foreground="white")])
    held = data["held"]
    if len(held):
        facing = on_paper(held)
        axes.plot(*facing.T, "s", ms=2.2, color=HELD, zorder=3, alpha=0.55)
    longest = max((np.linalg.norm(a[3:]) for a in data["arrows"]), default=0)
    for words, arrow in zip(meta["arrows"], data["arrows"]):
        size = np.linalg.norm(arrow[3:])
        if size == 0:
            continue
        at = on_paper(arrow[:3])
        along = on_paper(arrow[3:]) / size * reach * (0.16 + 0.10 * size / longest)
        axes.annotate("", at + along, at, zorder=7,
                      arrowprops={"arrowstyle": "-|>", "color": LOAD, "lw": 2.2, "mutation_scale": 16, "shrinkA": 0,
                                  "shrinkB": 0})
        axes.annotate(words, at + along, xytext=(7, 0), textcoords="offset points", fontsize=10, color=LOAD,
                      va="center", zorder=7)
    peak = on_paper(data["numbers"][state][1:4])
    axes.plot(*peak, "o", ms=9, mfc="none", mec="white", mew=2.6, zorder=8)
    axes.plot(*peak, "o", ms=9, mfc="none", mec=INK, mew=1.2, zorder=8)
    axes.set_aspect("equal")
    axes.set_axis_off()


def words_of(numbers):
    largest, x, y, z, error, mean, mean_error, displacement, volume, singular = numbers
    corner = ", a singularity" if singular else ""
    return (f"largest {largest / 1e6:.4g} ± {error / 1e6:.2g} MPa at ({1e3 * x:.1f}, {1e3 * y:.1f}, {1e3 * z:.1f}) mm{corner}\n"
            f"mean {mean / 1e6:.3g} ± {mean_error / 1e6:.2g} MPa, "
            f"displacement up to {1e3 * displacement:.4g} mm, volume {1e6 * volume:.5g} cm³")


def main(data_path, picture_path):
    data = np.load(data_path)
    meta = json.loads(bytes(data["meta"]))
    states = len(data["nodes"])
    # Otherwise a few nodes at re-entrant corners would determine the scale.
    top = max(np.percentile(data["stress"][0], 99.8), 1e-3)
    everything = [data["nodes"].reshape(-1, 3), data["controls"], data["moved_controls"]]
    flat = on_paper(np.concatenate(everything))
    reach = np.ptp(data["nodes"].reshape(-1, 3), axis=0).max()
    tips = [on_paper(a[:3] + a[3:] / max(np.linalg.norm(a[3:]), 1e-30) * 0.28 * reach) for a in data["arrows"]]
    flat = np.concatenate([flat, *[t[None] for t in tips]])
    low, high = flat.min(axis=0), flat.max(axis=0)
    low, high = low - 0.03 * (high - low), high + 0.03 * (high - low)
    width, height = high - low
    wide = 11.0
    panel = float(np.clip(wide * height / width, 2.2, 6.5))
    header, caption, foot = 0.95, 0.62, 1.15
    with_taylor = len(data["taylor"]) > 0
    tall = header + states * (panel + caption) + foot
    figure = plt.figure(figsize=(wide, tall), facecolor=PAPER)
    figure.text(0.03, 1 - 0.34 / tall, meta["title"].replace("_", " "), fontsize=20, color=INK, weight="bold",
                va="center")
    figure.text(0.03, 1 - 0.70 / tall, meta["subtitle"], fontsize=10.5, color=INK, va="center")
    for state in range(states):
        base = tall - header - (state + 1) * (panel + caption)
        axes = figure.add_axes([0.02, base / tall, 0.96, panel / tall], facecolor=PAPER)
        draw_state(axes, data, meta, state, top, reach)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        label = "unchanged" if states == 1 else ("before", "after")[state]
        figure.text(0.03, (base + panel + caption - 0.3) / tall, label, fontsize=13, color=INK, weight="bold",
                    va="center")
        figure.text(0.13, (base + panel + caption - 0.3) / tall, words_of(data["numbers"][state]), fontsize=10.5,
                    color=INK, va="center", linespacing=1.35)
    bar = figure.add_axes([0.03, 0.62 / tall, 0.42, 0.16 / tall])
    bar.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=MAP, extent=(0, top / 1e6, 0, 1))
    bar.set_yticks([])
    bar.tick_params(colors=INK, labelsize=9.5)
    bar.set_title("von Mises stress, MPa (at nodes)", fontsize=10, color=INK, loc="left", pad=4)
    for spine in bar.spines.values():
        spine.set_visible(False)
    if with_taylor:
        taylor, solved = data["taylor"], data["solved"]
        error = np.sqrt(np.sum((taylor - solved) ** 2) / np.sum(solved**2))
        figure.text(0.50, 0.68 / tall, f"The Taylor series about the first shape differs from the new solution by\n"
                    f"{100 * error:.2g} % (root mean square), {100 * np.abs(taylor - solved).max() / solved.max():.2g} % "
                    "of the largest stress", fontsize=10.5, color=INK, va="center", linespacing=1.35)
    x = 0.03
    for mark, colour, words in (("s", HELD, "support"), (r"$\rightarrow$", LOAD, "load"), ("o", CONTROL, "control point"),
                                ("o", PAPER, "fixed control point"), ("o", "none", "largest stress")):
        y = 0.14 / tall
        figure.add_artist(plt.Line2D([x + 0.008], [y], marker=mark, ms=7 if mark[0] == "$" else 5, mfc=colour,
                                     mec=INK if colour == "none" else FAINT if colour == PAPER else colour))
        figure.text(x + 0.018, y, words, fontsize=9.5, color=INK, va="center")
        x += 0.045 + 0.0068 * len(words)
    figure.savefig(picture_path, dpi=110, facecolor=PAPER)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
