"""Touch it, hear it, feel it: a hand taps a disk, which pushes back and sounds by its finite-element modes

All of Yano and Iwata's AudioHaptics, in `patches/audiohaptics/audiohaptics.pd`: seven modules on a bus.
A simulated hand taps an aluminium disk of 100 by 12 mm at nine places and speeds. The contact is
found in the servo at 1 kHz, where a spring of 900 N/m pushes back; the same tick strikes the disk's
modes at its sample. The loudspeaker on the grip, as in the paper, is a listener that moves with the
hand; a second listener sits in a chair. Then two disks of the same outer shape, one solid and one hollow.
"""
import pathlib
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy
from make_scene import spectrogram

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _audiohaptics  # noqa: E402
import _bodies  # noqa: E402
from _audiohaptics import FAR, NEAR, RATE  # noqa: E402

PATCH = "patches/audiohaptics/audiohaptics.pd"
NEEDS = "stage_patches phantom phantom~ modal_impact~ stage_disk stage_disk_solid stage_disk_hollow"
BLUE, RED, GREEN = "#2b5c8a", "#c4552d", "#6d8f3a"
FACE = 6  # mm


def after(take, k, seconds=0.45):
    """Sound of hit k, at most until the next one."""
    begin = int(take["hits"][k, 0] * RATE / 1000)
    end = begin + int(seconds * RATE)
    if k + 1 < len(take["hits"]):
        end = min(end, int(take["hits"][k + 1, 0] * RATE / 1000))
    return take["sound"][begin:end, 0]


def peak_force(take, k):
    t, ticks = take["hits"][k, 0], take["ticks"]
    return ticks["fz_n"][(ticks["ms"] >= t) & (ticks["ms"] < t + 250)].max()


def tap_rows(take):
    """Rows of the table, one per tap."""
    modes, rows = _audiohaptics.table_modes(), []
    for k, (t, x, y, _, *_, speed, _) in enumerate(take["hits"]):
        peaks = _bodies.peaks(after(take, k), low_hz=3000, below_db=50, apart_hz=150, count=3)
        errors = [min(abs(f - modes)) for f, _ in peaks]
        rows.append([f"{t / 1000:.2f}", f"{numpy.hypot(x, y):.0f}", f"{speed:.2f}",
                     f"{peak_force(take, k):.1f}",
                     ", ".join(f"{f:.0f} ({db:+.0f})" for f, db in peaks), f"{max(errors):.1f}"])
    return rows


def draw_take(take):
    figure, axes = plt.subplots(4, 1, figsize=(12, 10.5), sharex=True, constrained_layout=True)
    ticks, seconds = take["ticks"], take["ticks"]["ms"] / 1000
    axes[0].plot(seconds, ticks["z_mm"], color=BLUE)
    axes[0].axhspan(-FACE, FACE, color="#cccccc", alpha=0.7)
    axes[0].set_ylabel("hand, z in mm\n(grey: the disk)")
    axes[1].plot(seconds, numpy.maximum(FACE - ticks["z_mm"], 0), color=GREEN)
    axes[1].set_ylabel("penetration, mm")
    axes[2].plot(seconds, ticks["fz_n"], color=RED)
    axes[2].set_ylabel("force on the hand, N")
    spectrogram(axes[3], take["sound"][:, 0], RATE, top_hz=20000)
    axes[3].set_xlim(0, seconds[-1])
    return figure


def draw_positions(take):
    """Draws the face with every hit, as the screen shows it, and beside it the levels of its modes."""
    figure, (face, levels) = plt.subplots(1, 2, figsize=(13, 5.6), constrained_layout=True,
                                          width_ratios=(1, 1.35))
    face.set_facecolor("#1c1c39")
    face.add_patch(plt.Circle((0, 0), 50, facecolor="#55718e", edgecolor="#c6e2ff", linewidth=2))
    face.plot(take["ticks"]["x_mm"], take["ticks"]["y_mm"], color="white", alpha=0.25, linewidth=0.7)
    colours = plt.cm.autumn_r(numpy.linspace(0.1, 0.9, len(take["hits"])))
    modes = _audiohaptics.table_modes()
    modes = modes[numpy.r_[True, numpy.diff(modes) > 30] & (modes < 20000)]
    grid = numpy.zeros((len(take["hits"]), len(modes)))
    for k, (hit, colour) in enumerate(zip(take["hits"], colours)):
        size = 20 * numpy.sqrt(hit[7])
        face.add_patch(plt.Circle(hit[1:3], size / 2, fill=False, edgecolor=colour, linewidth=2))
        face.annotate(str(k + 1), hit[1:3], color="white", ha="center", va="center", fontsize=9)
        f, level = _bodies.spectrum(after(take, k))
        grid[k] = [level[abs(f - mode) < 30].max() for mode in modes]
    face.set_xlim(-60, 60)
    face.set_ylim(-60, 60)
    face.set_aspect("equal")
    face.set_xlabel("x, mm")
    face.set_ylabel("y, mm")
    db = 20 * numpy.log10(grid / grid.max(axis=1, keepdims=True) + 1e-6)
    image = levels.imshow(db, aspect="auto", cmap="magma", vmin=-60, vmax=0)
    levels.set_xticks(range(len(modes)), [f"{m / 1000:.1f}" for m in modes])
    levels.set_yticks(range(len(db)), [f"{k + 1}: {numpy.hypot(*h[1:3]):.0f} mm"
                                       for k, h in enumerate(take["hits"])])
    levels.set_xlabel("mode of the table, kHz")
    levels.set_ylabel("tap: distance from the centre")
    figure.colorbar(image, ax=levels, label="dB below the tap's loudest")
    return figure


def pair_path(folder):
    """Five taps on each disk in turn, at the same distances from their centres."""
    rows, ms = ["0 -54 0 40"], 0
    for radius in (0, 15, 25, 35, 45):
        for centre in (-54, 54):
            x = centre + radius * numpy.sign(-centre)
            for dt, z in ((260, 40), (70, 9), (40, 9), (90, 40), (240, 40)):
                ms += dt
                rows.append(f"{ms} {x} 0 {z}")
    path = pathlib.Path(folder) / "pair.txt"
    path.write_text("\n".join(rows) + "\n")
    return path, ms / 1000


def make(scene):
    seconds = _audiohaptics.taps_seconds() + 0.8
    takes = {name: _audiohaptics.render(listener, seconds)
             for name, listener in (("chair", FAR), ("hand", NEAR))}
    take = takes["chair"]
    scene.sound("taps_chair", 0.9 * take["sound"] / abs(take["sound"]).max(), RATE,
                "nine taps, heard from a chair half a metre away")
    scene.sound("taps_hand", 0.9 * takes["hand"]["sound"] / abs(takes["hand"]["sound"]).max(), RATE,
                "the same taps, heard from the loudspeaker on the hand")
    scene.picture("audiohaptics", draw_take(take), "hand, penetration, force and sound")
    scene.picture("audiohaptics_places", draw_positions(take),
                  "positions of the taps (the diameter of a ring grows with the square root of the speed), and the level of each mode")
    scene.table(["s", "radius, mm", "speed, m/s", "force, N", "strongest partials, Hz (dB)",
                 "largest distance from a mode of the table, Hz"], tap_rows(take), "the taps")
    scene.heading("From the contact to the hand and the ear")
    chain = numpy.array(_audiohaptics.latencies("taps.txt", seconds=seconds))
    scene.table(["", "after the servo's contact, ms", "the paper"],
                [["force written to the device", f"{(chain[:, 1] - chain[:, 0]).max():.3f}",
                  "1 kHz: up to 1 ms"],
                 ["sound of the contact", f"{(chain[:, 2] - chain[:, 0]).max():.3f}",
                  "16 Hz: up to 62 ms"]],
                f"largest of {len(chain)} taps by a rigid hand, in logical time; a sound card adds its "
                "buffer, and the servo finds a contact up to one tick, 1 ms, after it happens")
    scene.heading("Solid or hollow")
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        path, length = pair_path(folder)
        pair = _audiohaptics.render(FAR, length + 0.6, path=path, pair=True)
    scene.sound("pair", 0.9 * pair["sound"] / abs(pair["sound"]).max(), RATE,
                "solid, hollow, solid, hollow ... from the centre outwards")
    figure, axes = plt.subplots(figsize=(12, 4.2), constrained_layout=True)
    spectrogram(axes, pair["sound"].sum(axis=1), RATE, top_hz=20000)
    for hit, body in zip(pair["hits"], pair["bodies"]):
        axes.annotate(body, (hit[0] / 1000, 19), color="white", fontsize=9)
    scene.picture("audiohaptics_pair", figure, "the two disks in turn")
    rows = []
    for name in ("solid", "hollow"):
        sounds = [after(pair, k) for k, body in enumerate(pair["bodies"]) if body == name]
        strongest = _bodies.peaks(numpy.concatenate(sounds), low_hz=2000, apart_hz=700, count=3)
        modes = _audiohaptics.table_modes(f"disk_{name}")
        rows.append([name, len(sounds), ", ".join(f"{f:.0f}" for f, _ in strongest),
                     f"{max(min(abs(f - modes)) for f, _ in strongest):.1f}", f"{modes[0]:.0f}"])
    scene.table(["disk", "taps", "strongest partials, Hz", "largest distance from a mode of the table, Hz",
                 "first mode of the table, Hz"], rows, "each disk by its own modal table")
