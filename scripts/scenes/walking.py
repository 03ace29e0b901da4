"""One walker sets off, turns, runs, jumps, sneaks, climbs stairs, scuffs, drags a foot and halts

One walker of [footstep~] in one take: over gravel, wood and concrete, with every gait and every
movement; then each of them alone on gravel, with the forces under both feet.
"""
import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import fade_out, spectrogram

PATCH = "build/tactus/footstep~-help.pd"
NEEDS = "footstep~"
RATE = 48000
ALONE, HALT = 4, 1.5  # s of each movement alone, and for the last steps
TOUR = (  # Time in s, message, description.
    (0.2, "walk 1", "walk"), (5.0, "turn 90", "turn"), (7.0, "surface wood", ""),
    (8.5, "speed 3, gait run", "run"), (11.5, "speed 1.4, gait walk", "walk"), (13.0, "jump 0.35", "jump"),
    (18.5, "surface concrete", ""), (19.0, "speed 1.2, gait sneak", "sneak"),
    (25.0, "speed 1.4, gait upstairs", "upstairs"), (30.0, "gait downstairs", "downstairs"),
    (34.0, "surface gravel", ""), (34.2, "gait walk", "walk"), (36.0, "scuff left", "scuff"),
    (38.5, "scuff right", "scuff"), (40.5, "walk 0", "halt"), (43.0, "drag right 0.8 0.6", "drag"), (46.0, "walk 1", "set off"),
    (50.0, "walk 0", "halt"))
EACH = (("walk", "walk 1"), ("run", "speed 3, gait run, walk 1"), ("sneak", "gait sneak, walk 1"),
        ("upstairs", "gait upstairs, walk 1"), ("downstairs", "gait downstairs, walk 1"),
        ("jump", "jump 0.4"), ("drag", "drag left 1 0.5"), ("turn", "turn 180"))


def walk(seconds, surface, messages, *flags):
    patch = Patch()
    box = patch.obj("footstep~", surface, "-feet", 2, *flags)
    for i, name in ((0, "sound"), (3, "force"), (4, "sound_2"), (7, "force_2")):
        patch.record(name, box[i])
    for t, text in messages:
        for message in text.split(", "):
            patch.at(1000 * t, box, message)
    result = patch.render(seconds, RATE)
    sound = fade_out(numpy.stack([result["sound"], result["sound_2"]], axis=1), RATE, HALT / 2)
    return sound, numpy.asarray(result["force"], float), numpy.asarray(result["force_2"], float)


def forces(axes, left, right):
    time = numpy.arange(len(left)) / RATE
    axes.plot(time, left, color="#2b5c8a", linewidth=0.8, label="left")
    axes.plot(time, right, color="#c4552d", linewidth=0.8, label="right")
    axes.set_xlim(0, time[-1])
    axes.set_ylabel("force, N")


def make(scene):
    scene.heading("In one take")
    seconds = 53
    sound, left, right = walk(seconds, "gravel", [(t, m) for t, m, _ in TOUR])
    scene.sound("tour", sound, RATE, ", ".join(word for *_, word in TOUR if word) + "; over gravel, wood, concrete, gravel")
    figure, axes = plt.subplots(4, 1, figsize=(15, 11), constrained_layout=True)
    for half in (0, 1):
        a, b = (int(part * seconds * RATE / 2) for part in (half, half + 1))
        spectrogram(axes[2 * half], sound[a:b].sum(axis=1), RATE, top_hz=12000)
        forces(axes[2 * half + 1], left[a:b], right[a:b])
        for t, _, word in TOUR:
            if word and a <= t * RATE < b:
                axes[2 * half + 1].annotate(word, (t - a / RATE, 1.02), xycoords=("data", "axes fraction"),
                                            rotation=30)
    axes[1].legend(loc="upper right")
    scene.picture("tour", figure, "sound and forces of both feet, in two halves of the take")
    scene.progress("walking: the tour")
    scene.heading("Each alone")
    figure, axes = plt.subplots(len(EACH), 2, figsize=(15, 2.2 * len(EACH)), constrained_layout=True)
    rows = []
    for (name, text), (above, below) in zip(EACH, axes):
        sound, left, right = walk(ALONE + HALT, "gravel", [(0.1, text), (ALONE, "walk 0")], "-weight", 700)
        scene.sound(name, sound, RATE, name)
        spectrogram(above, sound.sum(axis=1), RATE, top_hz=12000)
        above.set_title(name, loc="left")
        forces(below, left, right)
        rms = 20 * numpy.log10(numpy.sqrt(numpy.mean(sound[:ALONE * RATE] ** 2)) + 1e-9)
        rows.append([name, f"{max(left.max(), right.max()) / 700:.2f}", f"{(left + right).max() / 700:.2f}",
                     f"{rms:.1f}"])
    scene.picture("each", figure, "each gait and movement on gravel")
    scene.table(["", "largest force under one foot, body weights", "under both feet", "level, dB"], rows)
