"""Part of ./play design: a beam that is struck while it is reshaped along a path, and its recomputed
modes."""
import matplotlib.pyplot as plt
import numpy
from harness import Patch, stage_folder
from make_scene import fade_out, spectrogram

RATE = 48000
SECONDS, STEP_MS, STRIKE_MS = 12.0, 20, 500
# Displacement (mm) of the lower and of the upper side, at times in s: the height of 20 mm becomes 30, then 14, then 20
# again.
TIMES = [0.0, 1.0, 3.0, 4.5, 7.5, 9.0, 11.0, SECONDS]
HEIGHT = [0.0, 0.0, 5.0, 5.0, -3.0, -3.0, 0.0, 0.0]
MODES, TOP_HZ = 8, 9000


def displacement_mm(table, seconds):
    """Displacements of all parameters. The middle of the length leads the tip by a tenth of the path, so the shape is
    not a pure stretch."""
    side = numpy.interp(seconds, TIMES, HEIGHT)
    points = table["control_points"][table["parameters"][:, 0].astype(int)]
    middle = 1 - 0.1 * numpy.sign(points[:, 0])
    return side * numpy.sign(points[:, 1]) * middle


def render(name, resolve):
    table = numpy.load(stage_folder() / name)
    patch = Patch()
    box = patch.obj("modal_impact~", name, "-sync", 1, "-resolve", resolve, "-gain", 0.02)
    patch.record("left", box[0])
    patch.record("right", box[1])
    patch.log("info", box[3])
    before = None
    for ms in range(STEP_MS, int(1000 * SECONDS), STEP_MS):
        shape = displacement_mm(table, ms / 1000)
        if before is None or (shape != before).any():
            patch.at(ms, box, "shape " + " ".join(f"{d:.6g}" for d in shape))
        before = shape
        patch.at(ms + 12, box, "info")  # an answer comes 10 ms after its request
    for ms in range(STRIKE_MS // 2, int(1000 * SECONDS), STRIKE_MS):
        patch.at(ms, box, "hit 85 12 2 0.7")
    return patch.render(SECONDS, timeout=600)


def frequencies(result):
    """Times (s) and the first frequencies (Hz) at each info."""
    rows = [(t / 1000, atoms[1:1 + MODES]) for t, atoms in result.logs["info"] if atoms[0] == "frequencies"]
    return numpy.array([t for t, _ in rows]), numpy.array([f for _, f in rows])


def make(scene):
    scene.progress("design: a beam that is struck while it is reshaped")
    solved = render("struck_cantilever.modal.npz", "auto")
    series = render("struck_cantilever.modal.npz", "off")
    sound = numpy.stack([solved["left"], solved["right"]], axis=1)
    scene.sound("struck_beam", fade_out(0.9 * sound / abs(sound).max(), RATE, 0.4), RATE,
                "a cantilever struck twice a second while its height goes from 20 mm to 30, to 14 and back")
    marks = numpy.array([[t / 1000, atoms[2]] for t, atoms in solved.logs["info"] if atoms[0] == "resolved"])
    figure, axes = plt.subplots(2, 1, figsize=(11, 8), sharex=True, constrained_layout=True)
    spectrogram(axes[0], solved["left"], RATE, top_hz=TOP_HZ, floor_db=-70)
    times, now = frequencies(solved)
    _, first = frequencies(series)
    at = numpy.searchsorted(times, marks[:, 0])
    at = at[at < len(times)]
    for k in range(MODES):
        axes[0].plot(times[at], now[at, k] / 1000, "o", markersize=3, markerfacecolor="none", markeredgecolor="white",
                     markeredgewidth=0.7, label="solved again" if k == 0 else None)
    axes[0].set_xlabel("")
    axes[0].legend(fontsize=8, loc="upper right", labelcolor="white", facecolor="#303030")
    for k in range(MODES):
        axes[1].plot(times, 100 * (first[:, k] / now[:, k] - 1), linewidth=0.9, label=f"mode {k + 1}")
    axes[1].plot(times[at], numpy.zeros(len(at)), "k|", markersize=6)
    axes[1].set(xlabel="time, s", ylabel="first derivatives alone\nagainst a new solution, %")
    axes[1].set_xlim(0, SECONDS)
    axes[1].legend(fontsize=8, ncol=4, frameon=False, loc="lower right")
    scene.picture("struck_beam", figure, "its spectrogram with the frequencies at each new solution, and the error of the "
                  "frequencies by the derivatives of the first shape alone")
    scene.table(["solutions", "median, ms", "longest, ms", "largest error of the first derivatives alone, %"],
                [[len(marks), f"{1000 * numpy.median(marks[:, 1]):.0f}", f"{1000 * marks[:, 1].max():.0f}",
                  f"{100 * abs(first / now - 1).max():.1f}"]], "a struck beam along its path")
