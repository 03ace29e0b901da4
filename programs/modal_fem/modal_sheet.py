#!/usr/bin/python3
"""modal_sheet.py TABLE.modal.npz PICTURE.png: the body and its first modes, to look at before listening.

Each mode is drawn bent by its own shape and coloured by how far the skin moves along its normal
(red out, blue in), with its frequency and the time in which it decays by 60 dB.
"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

INK, PAPER, METAL = "#22303c", "#fbfaf7", "#b9c3cb"
MAP = matplotlib.colormaps["RdBu_r"]


def face_normals(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def draw(axes, points, triangles, colours, centre, reach):
    light = np.clip(face_normals(points, triangles) @ (np.array([0.35, -0.5, 0.8]) / 1.006), -1, 1)
    shade = (0.62 + 0.38 * light)[:, None]
    rgb = np.clip(colours[:, :3] * shade, 0, 1)
    axes.add_collection3d(Poly3DCollection(points[triangles], facecolors=rgb, edgecolors=rgb, linewidths=0.3))
    for setter, middle in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), centre):
        setter(middle - reach, middle + reach)
    axes.set_box_aspect((1, 1, 1), zoom=1.5)
    axes.view_init(elev=32, azim=-58)
    axes.set_axis_off()


def main(table_path, picture_path, count=11):
    table = np.load(table_path)
    meta = json.loads(bytes(table["meta"]))
    points, triangles = table["xyz"].astype(float), table["tri"]
    frequency, phi, eta = table["freq"], table["phi"].astype(float), table["eta"]
    count = min(count, len(frequency))
    low, high = points.min(axis=0), points.max(axis=0)
    centre, reach = (low + high) / 2, (high - low).max() / 2
    normals = face_normals(points, triangles)

    columns = 4
    rows = -(-(count + 1) // columns)
    figure = plt.figure(figsize=(3.3 * columns, 3.05 * rows + 0.8), facecolor=PAPER)
    grid = figure.add_gridspec(rows, columns, left=0.01, right=0.99, bottom=0.02,
                               top=1 - 1.02 / (3.05 * rows + 0.8), wspace=0.02, hspace=0.2)
    size = 1e3 * (high - low)
    material = ", ".join(dict.fromkeys(m["name"] for m in meta["materials"]))
    figure.text(0.02, 1 - 0.30 / figure.get_figheight(), meta["body_name"].replace("_", " "),
                fontsize=19, color=INK, weight="bold", va="center")
    figure.text(0.02, 1 - 0.66 / figure.get_figheight(),
                f"{material}, {float(table['mass']) * 1e3:.4g} g, {size[0]:.4g} × {size[1]:.4g} × {size[2]:.4g} mm; "
                f"{meta['bc']}; {meta['dofs']} degrees of freedom ({meta['element']}); "
                f"{len(frequency)} modes from {frequency[0]:.4g} to {frequency[-1]:.5g} Hz",
                fontsize=10.5, color=INK, va="center")
    for cell in range(count + 1):
        axes = figure.add_subplot(grid[cell // columns, cell % columns], projection="3d", facecolor=PAPER)
        axes.computed_zorder = False
        if cell == 0:
            rgb = np.tile(np.array([*matplotlib.colors.to_rgb(METAL), 1]), (len(triangles), 1))
            draw(axes, points, triangles, rgb, centre, reach)
            axes.set_title("at rest", fontsize=11, color=INK, y=1.03)
            continue
        k = cell - 1
        shape = phi[k]
        largest = np.linalg.norm(shape, axis=1).max()
        out = (shape[triangles].mean(axis=1) * normals).sum(axis=1)
        # modes that slide in their own plane hardly move along the normal: grey
        scale = max(np.abs(out).max(), 0.15 * largest)
        colours = MAP(0.5 + 0.5 * out / scale)
        draw(axes, points + shape * (0.13 * reach / largest), triangles, colours, centre, reach)
        decay = 3 * np.log(10) / (np.pi * frequency[k] * eta[k])
        pair = f"  ×{table['mult'][k]}" if table["mult"][k] > 1 else ""
        axes.set_title(f"{k + 1}.  {frequency[k]:.1f} Hz{pair}\n$T_{{60}}$ {decay:.3g} s", fontsize=10.5,
                       color=INK, y=0.985)
    figure.savefig(picture_path, dpi=110, facecolor=PAPER)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
