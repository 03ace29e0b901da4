"""Eleven kinds of particles shaken, poured and stepped on, and a piece for them

[particle~] shakes each of its presets in one rhythm, pours it (a steady power) and steps on it (a push of
power for heel and ball). Then a piece: maraca, cabasa, tambourine and coins enter one bar after the other, over
rain and bubbles.
"""
import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import fade_out, spectrogram

PATCH = "build/tactus/particle~-help.pd"
NEEDS = "particle~"

RATE = 48000
PRESETS = ("maraca", "sekere", "cabasa", "tambourine", "gravel", "ice", "coins", "rain", "sand", "leaves",
           "bubbles")
BEAT = 0.5  # s
RHYTHM = ((0, 1.2), (0.5, 0.3), (0.75, 0.2), (1, 0.8), (1.5, 0.3), (1.75, 0.5))  # (beat, energy) of each shake
PIECE = {  # Preset: gain, position from left (-1) to right, energies at the beats of a bar of four.
    "maraca": (0.6, -0.5, [(i / 4, (1, 0.25, 0.45, 0.25)[i % 4]) for i in range(16)]),
    "cabasa": (0.8, 0.5, [(0.5, 0.7), (1.5, 0.7), (2.5, 0.7), (3.5, 0.7), (3.75, 0.4)]),
    "tambourine": (0.7, 0.2, [(1, 1.2), (3, 1.2), (3.5, 0.4)]),
    "coins": (0.5, -0.2, [(0, 0.8), (2.75, 0.6)]),
}


def power_of_a_visit(seconds):
    """Power of 2 s poured, then of two steps of heel and ball, in 1/s."""
    t = numpy.arange(int(seconds * RATE)) / RATE
    power = 4.0 * ((t > 2.2) & (t < 4.2))
    for begin in (4.6, 5.4):
        for after, height, width in ((0, 14, 0.06), (0.08, 6, 0.12)):
            x = (t - begin - after) / width
            power += height * numpy.sin(numpy.pi * numpy.clip(x, 0, 1)) ** 2
    return power


def visit(preset, seconds=6.5):
    patch = Patch()
    box = patch.signal(power_of_a_visit(seconds)) >> patch.obj("particle~", preset)
    for bar in range(2):
        for beat, energy in RHYTHM:
            patch.at(100 + 1000 * BEAT * (2 * bar + beat), box, f"shake {energy}")
    for i, name in enumerate(("sound", "collisions", "energy")):
        patch.record(name, box[i])
    return patch.render(seconds, RATE)


def piece(bars=8):
    """Left and right channel; each player enters one bar after the previous one."""
    seconds = bars * 4 * BEAT + 2
    patch = Patch()
    pans = {}
    for number, (preset, (gain, pan, shakes)) in enumerate(PIECE.items()):
        box = patch.obj("particle~", preset, "-gain", gain, "-seed", number + 1)
        for bar in range(number, bars):
            for beat, energy in shakes:
                patch.at(1000 * BEAT * (4 * bar + beat), box, f"shake {energy}")
        patch.record(preset, box[0])
        pans[preset] = pan
    t = numpy.arange(int(seconds * RATE)) / RATE
    swell = numpy.sin(numpy.pi * t / seconds) ** 2
    for number, (preset, power, pan) in enumerate((("rain", 0.7, -0.8), ("rain", 0.7, 0.8), ("bubbles", 1.5, 0))):
        box = patch.signal(power * swell) >> patch.obj("particle~", preset, "-gain", 0.5, "-seed", 20 + number)
        patch.record(f"bed{number}", box[0])
        pans[f"bed{number}"] = pan
    render = patch.render(seconds, RATE, timeout=300)
    stereo = numpy.zeros((len(t), 2))
    for name, pan in pans.items():
        angle = (pan + 1) * numpy.pi / 4
        stereo += numpy.outer(render[name][:len(t)], (numpy.cos(angle), numpy.sin(angle)))
    return stereo / max(1, abs(stereo).max() / 0.9)


def make(scene):
    scene.heading("Each kind")
    scene.text("Two bars shaken, two seconds poured, two steps.")
    figure, axes = plt.subplots(len(PRESETS), 1, figsize=(12, 2.1 * len(PRESETS)), constrained_layout=True)
    rows = []
    for axis, preset in zip(axes, PRESETS):
        result = visit(preset)
        sound = numpy.asarray(result["sound"], float)
        scene.sound(preset, fade_out(sound, RATE, 0.5), RATE, preset)
        spectrogram(axis, sound, RATE, top_hz=16000)
        axis.set_title(preset, loc="left")
        rows.append([preset, numpy.count_nonzero(result["collisions"]), f"{abs(sound).max():.2f}",
                     f"{result['energy'].max():.2f}"])
        scene.progress(preset)
    scene.picture("spectrograms", figure, "shaken, poured, stepped on")
    scene.table(["preset", "collisions", "loudest sample", "largest energy"], rows)
    scene.heading("A piece")
    stereo = piece()
    scene.sound("piece", stereo, RATE, "maraca, cabasa, tambourine, coins; rain and bubbles")
    figure, axis = plt.subplots(figsize=(12, 4), constrained_layout=True)
    spectrogram(axis, stereo.sum(axis=1), RATE, top_hz=16000)
    scene.picture("piece", figure, "the piece")
