"""A hand strikes a disk in the servo's scene: position, force and sound of each contact

`patches/haptic/struck_disk.pd` with the simulated device. A hand on a spring of 500 N/m goes down and up over an
aluminium disk, 100 mm across and 12 mm thick, 25 mm beside its middle. The servo tests for contact a thousand times a
second; its `hit` excites [modal_impact~]. While the hand touches the disk, the loudness of the sound returns to the
hand through [phantom~] as a vibration of 250 Hz along the surface's normal.
"""
import csv
import tempfile

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import fade_out, spectrogram

PATCH = "patches/haptic/struck_disk.pd"
NEEDS = "stage_patches phantom phantom~ modal_impact~ stage_disk"
RATE = 48000
SECONDS = 4
TOP = 6  # mm, height of the face that is struck


def strike(felt):
    """(stereo sound, rows of the servo's trace) with the vibration felt or not."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        patch = Patch(opens=PATCH)
        for channel in (1, 2):
            patch.record(str(channel), patch.dac(channel))
        patch.send(0, "struck-hand", f"trace {folder}/ticks.csv")
        patch.send(10, "help-play", "bang")
        patch.send(20, "struck-felt", felt)
        patch.send(1000 * SECONDS - 5, "struck-hand", "trace stop")
        result = patch.render(SECONDS, RATE)
        with open(f"{folder}/ticks.csv", encoding="utf-8") as file:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    return numpy.stack([result["1"], result["2"]], axis=1), rows


def column(rows, name):
    return numpy.array([row[name] for row in rows])


def draw(sound, rows):
    figure, axes = plt.subplots(4, 1, figsize=(12, 10), sharex=True, constrained_layout=True)
    seconds = column(rows, "ms") / 1000
    axes[0].plot(seconds, column(rows, "z_mm"), color="#2b5c8a")
    axes[0].axhspan(-TOP, TOP, color="#cccccc", alpha=0.6)
    axes[0].set_ylabel("handle, mm\n(grey: the disk)")
    axes[1].plot(seconds, column(rows, "fz_n"), color="#c4552d", linewidth=0.8)
    axes[1].set_ylabel("force written, N")
    axes[2].plot(numpy.arange(len(sound)) / RATE, sound[:, 0], color="#6d8f3a", linewidth=0.4)
    axes[2].set_ylabel("sound, left")
    spectrogram(axes[3], sound[:, 0], RATE, top_hz=20000)
    axes[3].set_xlim(0, SECONDS)
    return figure


def draw_contact(rows, still):
    """One contact in detail, with and without the vibration."""
    figure, axes = plt.subplots(figsize=(12, 4), constrained_layout=True)
    for name, chosen, colour in (("felt", rows, "#c4552d"), ("without vibration", still, "#888888")):
        force, ms = column(chosen, "fz_n"), column(chosen, "ms")
        begin = int(numpy.argmax((force > 0) & (ms > 1500)))
        part = slice(begin - 10, begin + 160)
        axes.plot(ms[part] - ms[begin], force[part], color=colour, label=name, linewidth=1)
    axes.set_xlabel("ms since the contact began")
    axes.set_ylabel("force written, N")
    axes.legend()
    return figure


def make(scene):
    sound, rows = strike(1)
    scene.progress("strike: with the vibration felt")
    _, still = strike(0)
    scene.sound("struck_disk", fade_out(sound, RATE, 0.3), RATE, "a hand strikes the disk every 480 ms")
    scene.picture("strike", draw(sound, rows), "handle, force and sound")
    scene.picture("strike_blow", draw_contact(rows, still),
                  "one contact: force of the scene's spring, with the disk's loudness as a vibration of 250 Hz")
    vibration = numpy.array(column(rows, "fz_n")) - column(still, "fz_n")[:len(rows)]
    scene.table(["strikes", "largest depth, mm", "largest force, N", "vibration, N RMS in contact"],
                [[str(int(((column(rows, "z_mm")[1:] < TOP) & (column(rows, "z_mm")[:-1] >= TOP)).sum())),
                  f"{TOP - column(rows, 'z_mm').min():.2f}", f"{column(rows, 'fz_n').max():.2f}",
                  f"{vibration[column(rows, 'z_mm') < TOP].std():.2f}"]],
                "contacts of the hand")
