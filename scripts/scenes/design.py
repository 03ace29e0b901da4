"""A beam and a lift arm are reshaped by hand, their stress felt as a spring: error, force, and a search by feel

`patches/design/beam.pd` and `arm.pd` with the simulated hand on a recorded path, for three mappings of the
stress and for spring and damper. Ten times a second the stress that [stress_haptic] feels is compared with a
new solution by part_stress.

Then a hand lowers the peak stress of the arm by feel alone, 20 times. Each time it takes one of the 12 points
that move, feels the spring of 2 mm where the point is and 2 mm further along x and along y (mapping mean,
gamma 0 to 1 within a quarter of a per cent of the mean at hand; all other points follow so that the volume stays), and
moves 3 mm to where the spring is softer. Differences below 7 % are not felt, as by people (Jones 1989, matching
of forces): where there is none, the hand stays. Beside it: the same hand in random directions, and descent along
the exact derivative of the peak's 12-norm with all points at once, in steps of the same length. No hand goes
further than 8 mm from where a point was.

At the end the beam is struck each half second while it is reshaped: its frequencies follow the derivatives, and
modal_fem solves its modes anew beside the sound (`patches/design/struck_beam.pd`).
"""
import concurrent.futures
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy
from harness import Patch

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _struck_beam  # noqa: E402
from _design import Part  # noqa: E402

PATCH = "patches/design/beam.pd"
# patch, table, control points in a layer, the one that is dragged, seconds of its path
PARTS = {"beam": ("cantilever", 10, 6, 8.9), "arm": ("lift_arm", 18, 15, 9.9)}
FEELS = {"mean, spring": (), "sensitive, spring": ("mode weighted",), "each axis, spring": ("mode axis",),
         "mean, damper": ("render damper",)}
BEGIN_MS = 500  # the hand has taken the point
SEEDS, ROUNDS, STEP, LIMIT = 20, 30, 3e-3, 8e-3
PROBE_MM, SETTLE_MS, NORM = 2, 120, 12
BAND, NOTICED = 2.5e-3, 0.07  # of the mean stress; of a force


def render(name, words):
    """Logs of a patch whose hand reshapes its part; messages set what is felt."""
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
    """The message of that instant, else the last before."""
    return [atoms for t, atoms in log if t <= ms + 0.5][-1]


def compare(name, part, log, solver):
    """Every tenth of a second: time, displacement (mm), felt and solved mean and peak, rms of the series' error."""
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
    far = numpy.abs(rows[:, 1:3]).max(1)
    picks = [0, int(numpy.argmin(rows[:, 2])), int(numpy.argmax(far * (rows[:, 2] > 0)))]
    scale = numpy.percentile(part.stress, 99.5)
    figure, axes = plt.subplots(len(picks), 1, figsize=(8, 8 if name == "arm" else 4), constrained_layout=True)
    for one, pick in zip(axes, picks):
        part.draw(one, *shapes[pick], scale)
        one.set_title(f"{rows[pick, 0]:.1f} s: {rows[pick, 1]:+.1f}, {rows[pick, 2]:+.1f} mm, peak "
                      f"{rows[pick, 6] / 1e6:.1f} MPa", fontsize=9)
    return figure


def draw_run(logs, rows):
    figure, axes = plt.subplots(4, 1, figsize=(11, 10), sharex=True, constrained_layout=True)
    axes[0].plot(rows[:, 0], rows[:, 1], label="x")
    axes[0].plot(rows[:, 0], rows[:, 2], label="y")
    axes[0].set_ylabel("control point, mm")
    for feel, log in logs.items():
        seconds = numpy.array([t for t, _ in log["gamma"]]) / 1000
        for k in range(3 if "axis" in feel else 1):
            axes[1].plot(seconds, [g[min(k, len(g) - 1)] for _, g in log["gamma"]], linewidth=0.9,
                         label=feel + (f", {'xyz'[k]}" if "axis" in feel else ""))
        axes[2].plot([t / 1000 for t, _ in log["force"]], [numpy.linalg.norm(f) for _, f in log["force"]],
                     linewidth=0.9, label=feel)
    axes[1].set_ylabel("gamma")
    axes[2].set_ylabel("force, N")
    axes[3].semilogy(rows[:, 0], numpy.maximum(100 * numpy.abs(rows[:, 3] / rows[:, 4] - 1), 1e-4), ".-", label="mean")
    axes[3].semilogy(rows[:, 0], numpy.maximum(100 * numpy.abs(rows[:, 5] / rows[:, 6] - 1), 1e-4), ".-", label="peak")
    axes[3].set_ylabel("error of the felt stress, %")
    axes[3].set_xlabel("time, s")
    for one in axes:
        one.legend(fontsize=8, ncol=3, frameon=False)
    return figure


# ---- the arm by feel


class Search:
    """Coordinates of handles at equal volume."""

    def __init__(self, part):
        self.part = part
        self.slope = part.spread.T @ part.slope  # of the stress to handles' coordinates
        self.volume = part.volume(numpy.zeros(len(part.control)))
        step = 1e-5
        self.volume_slope = numpy.array([(part.volume(step * e) - part.volume(-step * e)) / (2 * step)
                                         for e in part.spread.T])

    def restored(self, x):
        """The nearest coordinates with the first volume."""
        for _ in range(3):
            x = x - self.volume_slope * (self.part.volume(self.part.spread @ x) - self.volume) \
                / (self.volume_slope @ self.volume_slope)
        return x

    def moved(self, x, by):
        return self.restored(numpy.clip(x + by, -LIMIT, LIMIT))

    def along(self, handle, x, y):
        return numpy.array([(x, y)[a] if c == handle else 0.0 for c, a in self.part.coordinates])

    def peak(self, x):
        return (self.part.stress + x @ self.slope).max()


def felt_forces(part, shapes):
    """Newtons with which the spring pulls back 2 mm at each shape: (mean stress in the middle of gamma, parameters)."""
    patch = Patch()
    box = patch.obj("stress_haptic", str(part.path), "-weights", "volume")
    patch.at(1, box, "gains 100 500 0 0, anchor 0 0 0")
    for i, (mean, shape) in enumerate(shapes):
        ms = 10 + i * SETTLE_MS
        patch.at(ms, box, f"range fixed {(1 - BAND) * mean:.7g} {(1 + BAND) * mean:.7g}, list " + " ".join(f"{1000 * p:.7g}" for p in shape))
        patch.at(ms + SETTLE_MS - 4, box[1], f"{PROBE_MM} 0 0 0 0 0")
    patch.log("force", box[1])
    force = patch.render(1e-3 * (20 + len(shapes) * SETTLE_MS)).logs["force"]
    return [-at(force, 10 + (i + 1) * SETTLE_MS - 2)[0] for i in range(len(shapes))]


def by_feel(scene, search):
    """(seeds, rounds + 1) peaks and last coordinates; and the relative differences that were felt."""
    part = search.part
    mean_slope = search.slope @ part.weights
    draws = [numpy.random.default_rng(seed) for seed in range(SEEDS)]
    x = [numpy.zeros(len(part.coordinates)) for _ in draws]
    peaks, differences = [[search.peak(one) for one in x]], []
    for i in range(ROUNDS):
        if i % 10 == 0:
            scene.progress(f"design: the arm by feel, {i} of {ROUNDS} moves")
        handles = [part.handles[draw.integers(len(part.handles))] for draw in draws]
        shapes = []
        for one, handle in zip(x, handles):
            mean = part.weights @ part.stress + mean_slope @ one
            for dx, dy in ((0, 0), (2e-3, 0), (0, 2e-3)):
                shapes.append((mean, part.spread @ search.restored(one + search.along(handle, dx, dy))))
        force = numpy.reshape(felt_forces(part, shapes), (SEEDS, 3))
        softer = force[:, :1] - force[:, 1:]
        differences.append(numpy.abs(softer / force[:, :1]).ravel())
        softer[numpy.abs(softer) < NOTICED * force[:, :1]] = 0
        for k, handle in enumerate(handles):
            length = numpy.linalg.norm(softer[k])
            if length > 0:
                x[k] = search.moved(x[k], search.along(handle, *(STEP * softer[k] / length)))
        peaks.append([search.peak(one) for one in x])
    return numpy.array(peaks).T, x, numpy.concatenate(differences)


def at_random(search):
    peaks, last = [], []
    for seed in range(SEEDS):
        draw, x = numpy.random.default_rng(seed), numpy.zeros(len(search.part.coordinates))
        peaks.append([search.peak(x)])
        for _ in range(ROUNDS):
            handle, angle = search.part.handles[draw.integers(len(search.part.handles))], draw.uniform(0, 2 * numpy.pi)
            x = search.moved(x, search.along(handle, STEP * numpy.cos(angle), STEP * numpy.sin(angle)))
            peaks[-1].append(search.peak(x))
        last.append(x)
    return numpy.array(peaks), last


def by_gradient(search):
    part, x = search.part, numpy.zeros(len(search.part.coordinates))
    peaks = [search.peak(x)]
    for _ in range(ROUNDS):
        stress = numpy.maximum(part.stress + x @ search.slope, 0)
        slope = search.slope @ (part.weights * (stress / stress.max()) ** (NORM - 1))
        slope -= search.volume_slope * (slope @ search.volume_slope) / (search.volume_slope @ search.volume_slope)
        x = search.moved(x, -STEP * slope / numpy.linalg.norm(slope))
        peaks.append(search.peak(x))
    return numpy.array([peaks]), [x]


def make(scene):
    parts = {name: Part(table, layer) for name, (table, layer, *_) in PARTS.items()}
    update_rows, error_rows = [], []
    for name, part in parts.items():
        scene.progress(f"design: the {name} along a path, felt in {len(FEELS)} ways")
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            logs = dict(zip(FEELS, pool.map(lambda words, name=name: render(name, words), FEELS.values())))
        with part.solver() as solver:
            rows, shapes = compare(name, part, next(iter(logs.values())), solver)
        scene.picture(f"design_{name}_shapes", draw_shapes(name, part, rows, shapes),
                      f"{name}: von Mises stress along the way, solved anew")
        scene.picture(f"design_{name}", draw_run(logs, rows),
                      f"{name}: the control point that is dragged, gamma, force, and the error of the felt stress "
                      "against a new solution every tenth of a second")
        for what, felt, solved in (("mean", 3, 4), ("peak", 5, 6)):
            error = 100 * numpy.abs(rows[:, felt] / rows[:, solved] - 1)
            error_rows.append([name, what, f"{numpy.median(error):.2f}", f"{error.max():.2f}"])
        error_rows.append([name, "all elements, rms", f"{100 * numpy.median(rows[:, 7]):.2f}", f"{100 * rows[:, 7].max():.2f}"])
        times = numpy.array([atoms[0] for _, atoms in next(iter(logs.values()))["ms"]])
        update_rows.append([name, len(part.stress), len(part.control), f"{numpy.median(times):.3f}",
                            f"{numpy.percentile(times, 99):.3f}", f"{1000 * numpy.median(rows[:, 8]):.0f}"])
    scene.table(["part", "of", "median, %", "largest, %"], error_rows, "felt stress against a new solution")
    scene.table(["part", "elements", "parameters", "update, median ms", "99 of 100, ms", "new solution, median ms"],
                update_rows, "times on this machine: one evaluation of the series, and one solution by conjugate "
                "gradients on the old factor")

    search = Search(parts["arm"])
    felt, felt_last, differences = by_feel(scene, search)
    ways = {"by feel": (felt, felt_last), "random direction": at_random(search),
            "descent on the derivative": by_gradient(search)}
    figure, axes = plt.subplots(figsize=(9, 4.5), constrained_layout=True)
    table = []
    with parts["arm"].solver() as solver:
        first = solver.solve(numpy.zeros(len(parts["arm"].control)))[0].max() / 1e6
        for (way, (peaks, last)), colour in zip(ways.items(), ("#2f4f9f", "#c0392b", "#4d8f4d")):
            axes.plot(peaks.T / 1e6, color=colour, linewidth=0.5, alpha=0.5)
            axes.plot(peaks.mean(0) / 1e6, color=colour, linewidth=2.2, label=way)
            solved = numpy.array([solver.solve(parts["arm"].spread @ x)[0].max() for x in last]) / 1e6
            axes.plot(numpy.full(len(solved), ROUNDS + 0.5), solved, "_", color=colour)
            volumes = [parts["arm"].volume(parts["arm"].spread @ x) / search.volume - 1 for x in last]
            table.append([way, len(last), f"{peaks[:, -1].mean() / 1e6:.1f}",
                          f"{solved.mean():.1f} ({solved.min():.1f}..{solved.max():.1f})",
                          f"{100 * (solved.mean() / first - 1):+.1f} %", f"{(solved < first).sum()} of {len(solved)}",
                          f"{100 * numpy.abs(volumes).max():.1g} %"])
    axes.set(xlabel="moves of 3 mm", ylabel="peak stress of the arm, MPa")
    axes.legend(frameon=False)
    scene.picture("design_search", figure, "peak stress at equal volume, by the series; thin: each of 20 hands; "
                  "dashes at the right: the last shapes solved anew")
    scene.table(["way", "runs", "peak by the series, MPa", "solved anew, MPa", "against the first shape",
                 "lower than the first", "volume changed by at most"], table,
                f"after {ROUNDS} moves; the first shape has {first:.1f} MPa")
    scene.text(f"What there was to feel: the force of a probe differed by {100 * numpy.median(differences):.2g} % (median); "
               f"{100 * numpy.mean(differences >= NOTICED):.0f} of 100 differences were noticed.")
    _struck_beam.make(scene)
