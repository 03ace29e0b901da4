"""A beam and a lift arm are reshaped by hand, their stress felt as a spring: error, force, and a search by feel

`patches/design/beam.pd` and `arm.pd` with the simulated hand on a recorded path, for three mappings of the
stress and for spring and damper. Ten times a second the stress that [stress_haptic] feels is compared with a
new solution by part_stress.

Then a hand lowers the largest stress of the arm by feel alone, 20 times, at equal volume. It chooses points at random,
pulls each by 10 mm in both directions of x and y (which moves it by 2 mm), and moves one by 3 mm in the direction of
the weaker spring of [stress_haptic]: one point per move with the paper's mean stress, and the point with the clearest
difference of three with `power 30`, which follows the largest stresses. Forces that differ by less than 7 % count as
equal (Pang, Tan & Durlach 1991). For comparison: random directions, and steepest descent of the largest stress with
all points at once, for which stress and derivatives are solved again at every move. No coordinate moves by more than
8 mm.

At the end the beam is struck every half second while it is reshaped: its frequencies follow the derivatives,
and
modal_fem recomputes its modes in the background (`patches/design/struck_beam.pd`).
"""
import concurrent.futures
import os
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy
from harness import Patch

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _struck_beam  # noqa: E402
from _design import Part  # noqa: E402
from _design_search import CHOSEN, NOTICED, PAPER, ROUNDS, STEP, Shapes, at_random, by_feel, descend  # noqa: E402

PATCH = "patches/design/beam.pd"
NEEDS = "stage_patches phantom stress_haptic modal_impact~ part_stress modal_fem stage_cantilever stage_lift_arm stage_struck_cantilever"
# Patch, table, number of control points in a layer, number of the dragged one, seconds of its path.
PARTS = {"beam": ("cantilever", 10, 6, 8.9), "arm": ("lift_arm", 18, 15, 9.9)}
FEELS = {"mean, spring": (), "weighted, spring": ("mode weighted",), "each axis, spring": ("mode axis",),
         "mean, damper": ("render damper",)}
BEGIN_MS = 500  # the hand has taken the point
SEEDS = range(101, 121)  # the setups were chosen on seeds 1 to 20
FEEL_COLOURS = dict(zip(FEELS, ("#2f4f9f", "#d08020", "#7f7f7f", "#4d8f4d")))
AXIS_COLOURS = {"x": "#c0392b", "y": "#7d3c98", "z": "#16a085"}


def render(name, words):
    """Logs of a patch whose hand reshapes its part; messages set the felt quantity."""
    _, layer, handle, seconds = PARTS[name]
    patch = Patch(opens=f"patches/design/{name}.pd")
    patch.send(10, "help-play", "bang")
    for word in words:
        patch.send(5, "design-part", word)
    for ms in range(BEGIN_MS, int(1000 * seconds), 100):
        patch.send(ms, "design-part", "bang, draw")
    patch.log("gamma", patch.obj("r design-gamma"))
    patch.log("force", patch.obj("r design-force"))
    info = patch.obj("r design-info")
    route = patch.obj("route", "mean", "peak", "ms", "point")
    info >> route
    for i, label in enumerate(("mean", "peak", "ms")):
        patch.log(label, route[i])
    point = patch.obj("route", handle)
    route[3] >> point
    patch.log("point", point)
    return patch.render(seconds).logs


def at(log, ms):
    """The message at that time, else the last one before it."""
    return [atoms for t, atoms in log if t <= ms + 0.5][-1]


def compare(name, part, log, solver):
    """Rows for every tenth of a second: time, displacement (mm), felt and solved mean and peak, rms of the series' error."""
    _, _, handle, seconds = PARTS[name]
    rows, shapes = [], []
    for ms in range(BEGIN_MS, int(1000 * seconds), 100):
        by = 1e-3 * numpy.array(at(log["point"], ms)[:2]) - part.points[handle][:2]
        parameters = part.displaced(handle, by)
        solved, took = solver.solve(parameters)
        rms = numpy.sqrt(numpy.sum((part.taylor(parameters) - solved) ** 2) / numpy.sum(solved ** 2))
        rows.append([1e-3 * ms, *(1000 * by), at(log["mean"], ms)[0], part.weights @ solved, at(log["peak"], ms)[0],
                     solved.max(), rms, took])
        shapes.append((parameters, solved))
    return numpy.array(rows), shapes


def draw_shapes(name, part, rows, shapes):
    """Draws the first shape, the lowest and the highest, with the same colour scale; mm."""
    _, _, handle, _ = PARTS[name]
    far = numpy.abs(rows[:, 1:3]).max(1)
    picks = [0, int(numpy.argmin(rows[:, 2])), int(numpy.argmax(far * (rows[:, 2] > 0)))]
    scale = max(part.face_stress(shapes[pick][1]).max() for pick in picks)
    figure, axes = plt.subplots(len(picks), 1, figsize=(9, 11 if name == "arm" else 5.4), sharex=True, sharey=True,
                                constrained_layout=True)
    for one, pick in zip(axes, picks):
        colours = part.draw(one, *shapes[pick], scale)
        first = 1000 * part.points[handle][:2]
        there = first + rows[pick, 1:3]
        if far[pick] > 0.05:
            one.annotate("", there, first, arrowprops={"arrowstyle": "-|>", "color": "black", "shrinkA": 0, "shrinkB": 0})
        one.plot(*there, "o", markerfacecolor="white", markeredgecolor="black", markersize=6)
        moved = f"point moved by ({rows[pick, 1]:+.1f}, {rows[pick, 2]:+.1f}) mm" if far[pick] > 0.05 else "first shape"
        one.set_title(f"{rows[pick, 0]:.1f} s, {moved}: largest stress {rows[pick, 6] / 1e6:.1f} MPa", fontsize=10)
        one.set_ylabel("y, mm")
        one.margins(0.03, 0.08)
    axes[-1].set_xlabel("x, mm")
    figure.colorbar(colours, ax=axes, label="von Mises stress of the surface, MPa", shrink=0.6)
    return figure


def draw_run(part, logs, rows):
    figure, axes = plt.subplots(5, 1, figsize=(11, 12.5), sharex=True, constrained_layout=True,
                                height_ratios=(1, 1.5, 1.2, 0.8, 1.2))
    path, gamma, spring, damper, errors = axes
    for k, axis in enumerate("xy"):
        if k in part.axis:
            path.plot(rows[:, 0], rows[:, 1 + k], color=AXIS_COLOURS[axis], label=axis)
    path.set_ylabel("displacement of the\ncontrol point, mm")
    for feel, log in logs.items():
        begin = next(i for i, (ms, _) in enumerate(log["gamma"]) if ms >= BEGIN_MS + 20)
        seconds = numpy.array([t for t, _ in log["gamma"][begin:]]) / 1000
        for k, axis in enumerate("xyz") if "axis" in feel else [(0, "")]:
            if axis and k not in part.axis:
                continue  # no parameter: gamma is 0
            gamma.plot(seconds, [g[min(k, len(g) - 1)] for _, g in log["gamma"][begin:]],
                       color=AXIS_COLOURS.get(axis, FEEL_COLOURS[feel]), linestyle="--" if axis or "damper" in feel else "-",
                       linewidth=1.4, label=feel + (f": {axis}" if axis else ""))
        unit = 1000 if "damper" in feel else 1
        force = [(t / 1000, unit * numpy.linalg.norm(f)) for t, f in log["force"] if t >= BEGIN_MS]
        shown = damper if "damper" in feel else spring
        shown.plot(*numpy.transpose(force), color=FEEL_COLOURS[feel], linewidth=1.4, label=feel,
                   linestyle="--" if "axis" in feel else "-")
    gamma.set_ylabel("gamma")
    spring.set_ylabel("force of\nthe spring, N")
    damper.set_ylabel("force of\nthe damper, mN")
    for column, what, marker in ((3, "mean stress", "o"), (5, "largest stress", "s")):
        error = 100 * numpy.abs(rows[:, column] / rows[:, column + 1] - 1)
        errors.semilogy(rows[:, 0], numpy.where(error > 1e-3, error, numpy.nan), marker + "-", markersize=3, linewidth=1,
                        label=what)
    errors.set_ylabel("error of the\nfelt stress, %")
    errors.text(1.02, 0.45, "gaps: below 0.001 %,\njust solved again,\nor the first shape", transform=errors.transAxes, fontsize=8)
    errors.set_xlabel("time, s")
    for one in axes:
        one.grid(alpha=0.25)
        one.set_ylim(*numpy.array(one.get_ylim()))
        one.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.005, 1), frameon=False)
    return figure


def draw_search(part, searches):
    """searches: name, colour, peaks of shape (runs, moves + 1), peaks of the last shapes, solved again, Pa."""
    figure, axes = plt.subplots(figsize=(10, 5.6), constrained_layout=True)
    for name, colour, peaks, solved in searches:
        axes.plot(peaks.T / 1e6, color=colour, linewidth=0.5, alpha=0.4)
        axes.plot(peaks.mean(0) / 1e6, color=colour, linewidth=2.4)
        end = peaks.shape[1] - 0.2
        axes.plot(numpy.full(len(solved), end), solved / 1e6, "_", color=colour, markersize=9)
        axes.text(end + 0.6, solved.mean() / 1e6, f"{name}\n{solved.mean() / 1e6:.1f} MPa "
                  f"({100 * (solved.mean() / part.stress.max() - 1):+.1f} %)", color=colour, va="center", fontsize=9)
    axes.axhline(part.stress.max() / 1e6, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel=f"moves of {1000 * STEP:.0f} mm at equal volume", ylabel="largest von Mises stress of the arm, MPa",
             xlim=(0, 1.32 * ROUNDS), xticks=range(0, ROUNDS + 1, 5))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure


def search(scene, part, descent):
    """Lowers the arm's stress by feel, for comparison with random directions and with the descent, a future that has
    begun."""
    shapes = Shapes(part)
    runs, felt = [], []
    for name, colour, setup in (("by feel, mean stress", "#6f8fdf", PAPER), ("by feel, power 30", "#2f4f9f", CHOSEN)):
        peaks, last, moves, differences = by_feel(
            shapes, setup, SEEDS, NOTICED, progress=lambda i, name=name: i % 10 or scene.progress(
                f"design: the arm {name}, {i} of {ROUNDS} moves"))
        runs.append((name, colour, peaks, last, f"{moves.mean():.1f}"))
        felt.append(f"{name}: {100 * numpy.median(differences):.0f} % (median), "
                    f"{100 * numpy.mean(differences >= NOTICED):.0f} of 100 are noticeable")
    runs.append(("random direction", "#c0392b", *at_random(shapes, SEEDS), str(ROUNDS)))
    scene.progress("design: the arm by descent, solved again with derivatives at each move")
    peaks, last = descent.result()
    runs.append(("descent", "#4d8f4d", peaks, last, str(numpy.count_nonzero(numpy.diff(peaks[0])))))
    searches, table = [], []
    with part.solver() as solver:
        for name, colour, peaks, last, moves in runs:
            solved = numpy.array([solver.solve(part.spread @ x)[0].max() for x in last])
            searches.append((name, colour, peaks, solved))
            volumes = [shapes.volume(x) / shapes.first_volume - 1 for x in last]
            table.append([name, len(last), moves, f"{solved.mean() / 1e6:.1f} ({solved.min() / 1e6:.1f}..{solved.max() / 1e6:.1f})",
                          f"{100 * (solved.mean() / part.stress.max() - 1):+.1f} %",
                          f"{(solved < part.stress.max()).sum()} of {len(solved)}", f"{numpy.abs(volumes).max():.0e}"])
    scene.picture("design_search", draw_search(part, searches), "largest stress at equal volume. By feel and at random: computed by the "
                  "series; thin lines: each of 20 hands, thick: their mean. Descent: solved again at every move. Dashes: the "
                  "last shapes, solved again; dotted: the first shape")
    scene.table(["method", "runs", "moves", "largest stress, MPa: mean (range)", "change from the first shape",
                 "lower than the first", "largest change of volume"], table,
                f"the last shapes, solved again; the first shape has {part.stress.max() / 1e6:.1f} MPa")
    scene.text("Difference between the forces of two pulls: " + "; ".join(felt) + ".")


def descended(part):
    with part.solver() as solver:
        return descend(Shapes(part), solver)


def make(scene):
    # For the child processes, because Pd and solvers run at the same time and idle threads of OpenBLAS wait by
    # spinning.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    parts = {name: Part(table, layer) for name, (table, layer, *_) in PARTS.items()}
    update_rows, error_rows = [], []
    with concurrent.futures.ThreadPoolExecutor(1) as aside, concurrent.futures.ThreadPoolExecutor(2) as pool:
        descent = aside.submit(descended, parts["arm"])  # one processor, half a minute
        renders = {name: {feel: pool.submit(render, name, words) for feel, words in FEELS.items()} for name in parts}
        for name, part in parts.items():
            scene.progress(f"design: the {name} along a path, with {len(FEELS)} settings of the force")
            logs = {feel: future.result() for feel, future in renders[name].items()}
            scene.progress(f"design: the {name} solved again every tenth of a second")
            with part.solver() as solver:
                rows, shapes = compare(name, part, next(iter(logs.values())), solver)
            scene.picture(f"design_{name}_shapes", draw_shapes(name, part, rows, shapes),
                          f"{name}: von Mises stress along the path, solved again; white: the dragged control point; "
                          "black: the outline of the first shape")
            scene.picture(f"design_{name}", draw_run(part, logs, rows),
                          f"{name}: displacement of the dragged control point, gamma, force, and the error of the felt stress "
                          "against a new solution every tenth of a second")
            for what, felt, solved in (("mean", 3, 4), ("largest", 5, 6)):
                error = 100 * numpy.abs(rows[:, felt] / rows[:, solved] - 1)
                error_rows.append([name, what, f"{numpy.median(error):.2f}", f"{error.max():.2f}"])
            error_rows.append([name, "series about the first shape, all elements, rms", f"{100 * numpy.median(rows[:, 7]):.2f}",
                               f"{100 * rows[:, 7].max():.2f}"])
            times = numpy.array([atoms[0] for _, atoms in next(iter(logs.values()))["ms"]])
            update_rows.append([name, len(part.stress), len(part.control), f"{numpy.median(times):.3f}",
                                f"{numpy.percentile(times, 99):.3f}", f"{1000 * numpy.median(rows[:, 8]):.0f}"])
        scene.table(["part", "stress", "median, %", "largest, %"], error_rows, "felt stress against a new solution")
        scene.table(["part", "elements", "parameters", "update, median ms", "99th percentile, ms", "new solution, median ms"],
                    update_rows, "times on this machine: one evaluation of the series, and one solution by conjugate "
                    "gradients preconditioned by the old factor")
        search(scene, parts["arm"], descent)
    _struck_beam.make(scene)
