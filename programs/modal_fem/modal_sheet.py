#!/usr/bin/python3
"""modal_sheet.py TABLE.modal.npz PICTURE.png: the body and its first modes, to look at before listening.

Each mode is drawn deformed by its own shape. The colour shows the motion of the skin along its normal (red out, blue
in). Beside it stand the frequency and the time in which the mode decays by 60 dB.
"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

INK, PAPER, METAL = "#22303c", "#fbfaf7", "#b9c3cb"
MAP = matplotlib.colormaps["RdBu_r"]
ELEVATION, AZIMUTH = np.radians(32), np.radians(-58)  # direction of the viewer, at infinity
EYE = np.array([np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)])
RIGHT = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0])
UP = np.cross(EYE, RIGHT)
LIGHT = np.array([0.35, -0.5, 0.8]) / 1.006


def face_normals(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def outer(points, triangles):
    """The triangles of shells that enclose material; shells around cavities have negative volume."""
    shell = np.arange(len(points))
    while True:  # each triangle's corners take the smallest name among them, until all agree
        least = shell[triangles].min(axis=1)
        before = shell.copy()
        for k in range(3):
            np.minimum.at(shell, triangles[:, k], least)
        shell = shell[shell]
        if np.array_equal(shell, before):
            break
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = np.bincount(shell[triangles[:, 0]], np.einsum("ij,ij->i", a, np.cross(b, c)), len(points))
    return triangles[volume[shell[triangles[:, 0]]] > 0]


def on_paper(points):
    return points @ np.stack([RIGHT, UP], axis=1)


def draw(axes, points, triangles, colours, low, high):
    """Draws the triangles that face the viewer, the farthest first, between two corners of the paper."""
    normals = face_normals(points, triangles)
    seen = np.flatnonzero(normals @ EYE > 0)
    seen = seen[np.argsort(points[triangles[seen]].mean(axis=1) @ EYE)]
    shade = (0.62 + 0.38 * np.clip(normals[seen] @ LIGHT, -1, 1))[:, None]
    rgb = np.clip(colours[seen, :3] * shade, 0, 1)
    axes.add_collection(PolyCollection(on_paper(points)[triangles[seen]], facecolors=rgb, edgecolors=rgb,
                                       linewidths=0.3))
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_axis_off()


def main(table_path, picture_path, count=11):
    table = np.load(table_path)
    meta = json.loads(bytes(table["meta"]))
    points = table["xyz"].astype(float)
    triangles = outer(points, table["tri"])
    frequency, phi, eta = table["freq"], table["phi"].astype(float), table["eta"]
    by_sound = table["alpha_rad"] if "alpha_rad" in table else np.zeros(len(frequency))
    count = min(count, len(frequency))
    low, high = points.min(axis=0), points.max(axis=0)
    reach = (high - low).max() / 2
    normals = face_normals(points, triangles)
    largest = np.linalg.norm(phi[:count], axis=2).max(axis=1)
    bent = points + phi[:count] * (0.13 * reach / largest)[:, None, None]
    paper = on_paper(np.concatenate([points, bent.reshape(-1, 3)]))
    corners = paper.min(axis=0), paper.max(axis=0)  # the same for all, so that sizes can be compared

    columns = 4
    rows = -(-(count + 1) // columns)
    width, height = corners[1] - corners[0]
    cell, title, header = np.clip(3.1 * height / width, 1.5, 3.3), 0.55, 0.85  # inches
    figure = plt.figure(figsize=(3.3 * columns, (cell + title) * rows + header + 0.1), facecolor=PAPER)
    tall = figure.get_figheight()
    grid = figure.add_gridspec(rows, columns, left=0.01, right=0.99, bottom=0.1 / tall,
                               top=1 - (header + title) / tall, wspace=0.06, hspace=title / cell)
    size = 1e3 * (high - low)
    material = ", ".join(dict.fromkeys(m["name"] for m in meta["materials"]))
    figure.text(0.02, 1 - 0.30 / tall, meta["body_name"].replace("_", " "),
                fontsize=19, color=INK, weight="bold", va="center")
    figure.text(0.02, 1 - 0.66 / tall,
                f"{material}, {float(table['mass']) * 1e3:.4g} g, {size[0]:.4g} × {size[1]:.4g} × {size[2]:.4g} mm; "
                f"{meta['bc']}; {meta['dofs']} degrees of freedom ({meta['element']}); "
                f"{len(frequency)} modes from {frequency[0]:.4g} to {frequency[-1]:.5g} Hz",
                fontsize=10.5, color=INK, va="center")
    for cell in range(count + 1):
        axes = figure.add_subplot(grid[cell // columns, cell % columns], facecolor=PAPER)
        if cell == 0:
            rgb = np.tile(np.array([*matplotlib.colors.to_rgb(METAL), 1]), (len(triangles), 1))
            draw(axes, points, triangles, rgb, *corners)
            axes.set_title("at rest", fontsize=11, color=INK)
            continue
        k = cell - 1
        shape = phi[k]
        out = (shape[triangles].mean(axis=1) * normals).sum(axis=1)
        # modes that slide in their own plane hardly move along the normal, so they are grey
        scale = max(np.abs(out).max(), 0.15 * largest[k])
        colours = MAP(0.5 + 0.5 * out / scale)
        draw(axes, bent[k], triangles, colours, *corners)
        decay = 3 * np.log(10) / (np.pi * frequency[k] * eta[k] + by_sound[k])
        pair = f"  ×{table['mult'][k]}" if table["mult"][k] > 1 else ""
        axes.set_title(f"{k + 1}.  {frequency[k]:.1f} Hz{pair}\n$T_{{60}}$ {decay:.3g} s", fontsize=10.5, color=INK)
    figure.savefig(picture_path, dpi=110, facecolor=PAPER)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
