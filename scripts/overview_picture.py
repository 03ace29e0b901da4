#!/usr/bin/python3
"""Draws docs/results/overview.png: four things that tactus does, each with its sound and its force from one render.

    overview_picture.py [FILE]

Renders in headless Pd with the library of $TACTUS_STAGE, else build/tactus (./play --library).
"""
import csv
import pathlib
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Polygon, Rectangle
from PIL import Image
from scipy.interpolate import PchipInterpolator

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "patches"))

from harness import Patch

RATE = 48000
PAPER, INK, SOUND, FORCE, METAL = "#fcfaf6", "#22303a", "#2b5c8a", "#d2691e", "#9aa4ab"


def with_times(samples, begin_s=0.0):
    return numpy.arange(len(samples)) / RATE + begin_s, samples


def clarinet():
    """A clarinet while the hand raises the mouth pressure; the force, N, along the gradient of its playability."""
    patch = Patch()
    height = patch.signal(numpy.interp(numpy.arange(4 * RATE) / RATE, [0, 2.5], [0, 0.36]))
    reed = height >> patch.obj("greed_gradient~", "clarinet")
    patch.obj("sig~", 0.5) >> reed[1]
    patch.record("sound", reed[0])
    patch.log("force", reed[4])
    result = patch.render(4, RATE)
    force = numpy.array([(ms / 1000, atoms[0]) for ms, atoms in result.logs["force"]], float)
    return with_times(result["sound"]), (force[:, 0], force[:, 1]), (1, 4)


def walk():
    """A walker on gravel; force of the ground on the left foot, N."""
    patch = Patch()
    foot = patch.obj("footstep~", "gravel")
    patch.at(20, foot, "walk 1")
    patch.record("sound", foot[0])
    patch.record("force", foot[3])
    result = patch.render(5, RATE)
    return with_times(result["sound"]), with_times(result["force"]), (1, 4)


def strike():
    """A steel ball meets the rim of a brass bowl at 1 m/s; force between them, N."""
    patch = Patch()
    bowl = patch.obj("modal_impact~", "bowl", "-sync", 1)
    patch.at(50, bowl, "hit 100 0 60 1")
    patch.record("sound", bowl[0])
    patch.record("force", bowl[2])
    result = patch.render(1.2, RATE)
    return with_times(result["sound"], -0.05), with_times(result["force"], -0.05), (-0.02, 0.4)


def touch():
    """A hand plucks a string of masses and springs; force on the hand, N."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        patch = Patch(opens=ROOT / "patches" / "haptic" / "mass_spring.pd")
        patch.record("sound", patch.dac(1))
        patch.send(0, "spring-hand", f"trace {folder}/ticks.csv")
        patch.send(10, "help-play", "bang")
        patch.send(2995, "spring-hand", "trace stop")
        result = patch.render(3, RATE)
        with open(f"{folder}/ticks.csv", encoding="utf-8") as file:
            rows = [(float(row["ms"]) / 1000, float(row["fy_n"])) for row in csv.DictReader(file)]
    return with_times(result["sound"]), tuple(numpy.array(rows).T), (0.8, 3)


def push(axes, begin, end):
    axes.add_patch(FancyArrowPatch(begin, end, arrowstyle="-|>", mutation_scale=22, lw=3.2, color=FORCE, zorder=4))


def waves(axes, x, y):
    for radius in (0.28, 0.42, 0.56):
        axes.add_patch(Arc((x, y), 2 * radius, 2 * radius, theta1=-38, theta2=38, color=SOUND, lw=2.4))


def draw_clarinet(axes):
    bell = numpy.linspace(0, 1, 40)
    upper = numpy.c_[2.9 + 0.55 * bell, 1.08 + 0.26 * bell**3]
    body = [(0.1, 0.9), (0.35, 1.02), (0.5, 1.08), *upper, *(upper * [1, -1] + [0, 2])[::-1], (0.5, 0.92), (0.35, 0.92)]
    axes.add_patch(Polygon(body, fc="#3a3f44", ec=INK))
    for x in numpy.linspace(0.95, 2.75, 8):
        axes.add_patch(Circle((x, 1), 0.05, fc="#c9ced2", ec="none"))
    waves(axes, 3.42, 1)
    push(axes, (0.24, 0.1), (0.24, 0.86))


def draw_sole(axes):
    x = 2 - 1.75 * numpy.cos(numpy.linspace(0, numpy.pi, 120))
    half = PchipInterpolator([0, 0.1, 0.3, 0.5, 0.68, 0.85, 1], [0.30, 0.34, 0.33, 0.28, 0.42, 0.47, 0.44])
    part = (x - x[0]) / (x[-1] - x[0])
    width = half(part) * (1 - numpy.abs(2 * part - 1)**8)**0.5
    grains = numpy.random.default_rng(3)
    for px, py, radius in zip(*(grains.uniform(*span, 220) for span in ((0, 4.1), (0.1, 1.9), (0.015, 0.055)))):
        axes.add_patch(Circle((px, py), radius, fc="#b5aea2", ec="none"))
    axes.add_patch(Polygon([*zip(x, 1 + width), *zip(x[::-1], 1 - width[::-1])], fc="#ded3c2", ec=INK, lw=1.5))
    for px in (0.85, 2.85):
        axes.add_patch(Circle((px, 1), 0.08, fc=FORCE))
        for radius in (0.16, 0.25):
            axes.add_patch(Circle((px, 1), radius, fill=False, ec=FORCE, lw=2.2))


def draw_bowl(axes):
    modes = Image.open(ROOT / "docs" / "results" / "modal_fem_bowl.png").convert("RGB")
    axes.imshow(modes.crop((425, 472, 690, 667)), extent=(0.75, 3.3, 0.05, 1.93))
    axes.add_patch(Circle((0.62, 1.62), 0.14, fc=METAL, ec=INK, zorder=3))
    push(axes, (0.02, 1.86), (0.5, 1.67))
    waves(axes, 3.2, 1.2)


def draw_string(axes):
    x = numpy.linspace(0.15, 3.9, 27)
    y = numpy.interp(x, [0.15, 2.3, 3.9], [0.55, 1.3, 0.55])
    axes.plot(x, y, "o-", ms=6, lw=1.2, color=INK)
    for end in (0.15, 3.9):
        axes.add_patch(Rectangle((end - 0.08, 0.3), 0.16, 0.5, fc=METAL, ec=INK))
    axes.add_patch(Circle((2.3, 1.52), 0.17, fc="#e8c547", ec=INK, zorder=3))
    push(axes, (2.3, 1.23), (2.3, 0.35))


def main(path):
    figure = plt.figure(figsize=(12, 5.6), facecolor=PAPER)
    for index, (name, render, draw) in enumerate((("Blow", clarinet, draw_clarinet), ("Walk", walk, draw_sole),
                                                  ("Strike", strike, draw_bowl), ("Touch", touch, draw_string))):
        left, bottom = 0.02 + 0.5 * (index % 2), 0.52 - 0.5 * (index // 2)
        figure.text(left + 0.005, bottom + 0.4, name, fontsize=20, weight="bold", color=INK)
        axes = figure.add_axes([left, bottom, 0.25, 0.4])
        draw(axes)
        axes.set(xlim=(-0.05, 4.15), ylim=(0, 2), aspect="equal")
        axes.axis("off")
        sound, force, (begin, end) = render()
        for row, (label, (seconds, values), colour) in enumerate((("sound", sound, SOUND), ("force", force, FORCE))):
            axes = figure.add_axes([left + 0.265, bottom + 0.215 - 0.2 * row, 0.2, 0.165])
            shown = (seconds >= begin) & (seconds <= end)
            axes.plot(seconds[shown], values[shown], color=colour, lw=1.8 if row else 0.6)
            axes.set_xlim(begin, end)
            axes.axis("off")
            axes.text(0, 1, label, transform=axes.transAxes, color=colour, fontsize=13, va="bottom")
    figure.savefig(path, dpi=100, facecolor=PAPER)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else ROOT / "docs" / "results" / "overview.png")
