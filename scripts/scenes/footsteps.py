"""Footsteps on fifteen grounds, heard and felt, and a walk across five of them

[footstep~] walks: first the four surfaces of Nordahl and others (EuroHaptics 2010), wood, creaking
wood, snow and underbrush, at three speeds, with the signals for the two actuators in a sandal (heel and
ball, 50 to 500 Hz); then all fifteen grounds, beside a recording where Debian's minetest-data or
ardentryst is installed; finally a walk across five grounds, each fading into the next.
"""
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import fade_out, spectrogram

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "bench" / "realism_footstep"))

PATCH = "build/tactus/footstep~-help.pd"
NEEDS = "footstep~"
RATE = 48000
FOUR = ("wood", "creak", "snow", "underbrush")
ALL = ("wood", "creak", "underbrush", "snow", "frozensnow", "sand", "gravel", "metal", "highgrass",
       "dryleaves", "concrete", "dirt", "puddle", "water", "carpet")
HALT = 1.5       # s for the last steps and their decay
FELT_GAIN = 0.5  # gain of the actuator signals stored as sounds, since quick steps on snow reach an actuator's limit
SPEEDS = (("slow", 0.9), ("usual", 1.4), ("quick", 1.9))
PATH = ("wood", "gravel", "snow", "dryleaves", "water")
NAMES = ("sound", "heel_drive", "ball_drive", "force", "sound_2", "heel_drive_2", "ball_drive_2",
         "force_2")


def walk(seconds, surface, speed=1.4, *flags):
    """Lets both feet walk for some seconds and halt; returns every outlet by name."""
    patch = Patch()
    box = patch.obj("footstep~", surface, "-feet", 2, "-speed", speed, *flags)
    for i, name in enumerate(NAMES):
        patch.record(name, box[i])
    patch.at(100, box, "walk 1")
    patch.at(1000 * seconds, box, "walk 0")
    return patch.render(seconds + HALT, RATE)


def stereo(result):
    """Stereo sound of both feet, with the last rustle faded out."""
    return fade_out(numpy.stack([result["sound"], result["sound_2"]], axis=1), RATE, HALT / 2)


def recorded():
    """One recording per label, with its rate, if the games are installed."""
    try:
        from features import RATE as rate
        from recordings import recordings
        return {r.label: r.sound() for r in recordings()}, rate
    except ImportError:
        return {}, 22050


def four_surfaces(scene):
    scene.heading("Four surfaces, three speeds")
    for surface in FOUR:
        figure, axes = plt.subplots(3, 3, figsize=(14, 7), constrained_layout=True,
                                    gridspec_kw={"height_ratios": [3, 1.2, 1.2]})
        for column, (word, speed) in zip(axes.T, SPEEDS):
            result = walk(6, surface, speed, "-drive_gain", FELT_GAIN)
            sound = stereo(result)
            scene.sound(f"{surface}_{word}", sound, RATE, f"{surface}, {word}: {speed} m/s")
            felt = numpy.stack([result["heel_drive"], result["ball_drive"]], axis=1)
            scene.sound(f"{surface}_{word}_felt", felt, RATE,
                        f"{surface}, {word}: actuator signals of the left foot, heel on the left channel, ball on the right; at half gain")
            spectrogram(column[0], sound.sum(axis=1), RATE)
            column[0].set_title(f"{surface}, {speed} m/s", loc="left")
            time = numpy.arange(len(felt)) / RATE
            column[1].plot(time, result["force"], color="#2b5c8a", label="left")
            column[1].plot(time, result["force_2"], color="#c4552d", label="right")
            column[1].set_ylabel("force, N")
            column[2].plot(time, felt[:, 0], color="#2b5c8a", linewidth=0.6)
            column[2].plot(time, felt[:, 1], color="#6d8f3a", linewidth=0.6)
            column[2].set_ylabel("heel, ball")
            column[2].set_xlabel("s")
        scene.picture(f"four_{surface}", figure, f"{surface}: sound, forces, actuator signals")
        scene.progress(f"footsteps: {surface}")


def fifteen_surfaces(scene):
    scene.heading("Fifteen grounds")
    recordings, rate = recorded()
    columns = 2 if recordings else 1
    figure, axes = plt.subplots(5, 3 * columns, figsize=(16, 15), constrained_layout=True)
    rows = []
    for k, surface in enumerate(ALL):
        seconds = 5
        result = walk(seconds, surface)
        sound = stereo(result)
        scene.sound(f"ground_{surface}", sound, RATE, surface)
        ours, beside = axes.flat[columns * k], axes.flat[columns * k + columns - 1]
        first = sound[:, 0][int(0.05 * RATE):int(0.85 * RATE)]
        spectrogram(ours, first, RATE, top_hz=10000)
        ours.set_title(surface, loc="left")
        if surface in recordings:
            real = recordings[surface][:int(0.8 * rate)]
            spectrogram(beside, numpy.pad(real, (0, max(0, int(0.8 * rate) - len(real)))), rate,
                        top_hz=10000)
            beside.set_title("a recording", loc="left")
        elif recordings:
            beside.axis("off")
        drives = [numpy.sqrt(numpy.mean(result[n][:seconds * RATE] ** 2)) for n in ("heel_drive", "ball_drive")]
        peaks = [abs(result[n]).max() for n in ("heel_drive", "ball_drive")]
        rows.append([surface, f"{abs(sound).max():.2f}", *(f"{d:.4f}" for d in drives),
                     *(f"{3 * p:.2f}" for p in peaks)])
    scene.picture("fifteen", figure, "one step on each ground, beside a recording where there is one")
    scene.table(["ground", "peak of the sound", "heel actuator, rms", "ball actuator, rms",
                 "heel, largest, g", "ball, largest, g"], rows, "levels, walking at 1.4 m/s")


def across(scene):
    scene.heading("A walk across five grounds")
    seconds, fade = 30, 2.5
    patch = Patch()
    box = patch.obj("footstep~", PATH[0], "-feet", 2)
    for i, name in enumerate(NAMES):
        patch.record(name, box[i])
    patch.at(100, box, "walk 1")
    for k, (a, b) in enumerate(zip(PATH, PATH[1:])):
        begin = 1000 * (seconds / len(PATH) * (k + 1) - fade / 2)
        for step in range(51):
            message = f"surface {a} {b} 0" if step == 0 else f"mix {step / 50}"
            patch.at(begin + 1000 * fade * step / 50, box, message)
    patch.at(1000 * seconds, box, "walk 0")
    sound = stereo(patch.render(seconds + HALT, RATE))
    scene.sound("across", sound, RATE, ", ".join(PATH))
    figure, axes = plt.subplots(figsize=(14, 4), constrained_layout=True)
    spectrogram(axes, sound.sum(axis=1), RATE, top_hz=12000)
    scene.picture("across", figure, "from ground to ground, 2.5 s each crossfade")


def make(scene):
    four_surfaces(scene)
    fifteen_surfaces(scene)
    across(scene)
