"""A hand plucks a string and taps a membrane of masses and springs: force, sound, spectrum

`patches/haptic/mass_spring.pd` with the simulated device. The network is stepped inside the servo 48000 times a second.
The plectrum is a grabbing spring: the hand of 400 N/m grabs the nearest of the string's 40 masses, pulls it 8 mm aside
and lets go; then its sphere taps a membrane of 12 x 12 masses. The lines in the spectrum are the frequencies of the
discrete string by theory.
"""
import csv
import tempfile

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import fade_out, spectrogram

PATCH = "patches/haptic/mass_spring.pd"
NEEDS = "stage_patches phantom phantom~"
RATE = 48000
SECONDS, FADE = 5, 0.6
MASSES, MASS, TENSION, LENGTH = 40, 1e-3, 12, 0.09  # values of the patch's string


def played(button):
    """(stereo sound, the servo's trace) after a click on that button."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        patch = Patch(opens=PATCH)
        for channel in (1, 2):
            patch.record(str(channel), patch.dac(channel))
        patch.send(0, "spring-hand", f"trace {folder}/ticks.csv")
        patch.send(10, button, "bang")
        patch.send(1000 * SECONDS - 5, "spring-hand", "trace stop")
        result = patch.render(SECONDS, RATE)
        with open(f"{folder}/ticks.csv", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
    rows = {key: numpy.array([float(row[key]) for row in table]) for key in table[0]}
    return numpy.stack([result["1"], result["2"]], axis=1), rows


def string_hertz(j):
    """Frequencies of the discrete string, with the dispersion of steps at 48 kHz."""
    spacing, mass = LENGTH / (MASSES + 1), MASS / MASSES
    omega = 2 * numpy.sqrt(TENSION / (mass * spacing)) * numpy.sin(j * numpy.pi / (2 * (MASSES + 1)))
    return numpy.arcsin(0.5 * omega / 48000) * 48000 / numpy.pi


def draw(sound, rows, axis, top_hz):
    figure, axes = plt.subplots(4, 1, figsize=(12, 10), sharex=True, constrained_layout=True)
    seconds = rows["ms"] / 1000
    axes[0].plot(seconds, rows[f"{axis}_mm"], color="#2b5c8a")
    axes[0].set_ylabel(f"handle, {axis} in mm")
    axes[1].plot(seconds, rows[f"f{axis}_n"], color="#c4552d", linewidth=0.8)
    axes[1].set_ylabel("force on the hand, N")
    axes[2].plot(numpy.arange(len(sound)) / RATE, sound[:, 0], color="#6d8f3a", linewidth=0.4)
    axes[2].set_ylabel("sound, left")
    spectrogram(axes[3], sound[:, 0], RATE, top_hz=top_hz)
    axes[3].set_xlim(0, SECONDS)
    return figure


def draw_spectrum(sound):
    """Draws one pluck from its release on, with the theory's partials."""
    loud = numpy.abs(sound[:, 0]).reshape(-1, 480).max(1)
    begin = 480 * (int(numpy.argmax((loud > 0.3) & (numpy.arange(len(loud)) > 200))) + 2)
    part = sound[begin:begin + 16384, 0]
    level = numpy.abs(numpy.fft.rfft(part * numpy.hanning(len(part)), 1 << 17))
    hertz = numpy.fft.rfftfreq(1 << 17, 1 / RATE)
    figure, axes = plt.subplots(figsize=(12, 4), constrained_layout=True)
    axes.plot(hertz, 20 * numpy.log10(level / level.max() + 1e-9), color="#2b5c8a", linewidth=0.8)
    for j in range(1, 16):
        axes.axvline(string_hertz(j), color="#c4552d", linewidth=0.6, alpha=0.6)
    axes.set_xlim(0, 2800)
    axes.set_ylim(-90, 3)
    axes.set_xlabel("Hz")
    axes.set_ylabel("dB")
    near = (hertz > 0.9 * string_hertz(1)) & (hertz < 1.1 * string_hertz(1))
    return figure, hertz[near][level[near].argmax()]


def make(scene):
    string, rows = played("help-play")
    scene.progress("spring: the string")
    membrane, taps = played("spring-drum")
    scene.sound("string", fade_out(string, RATE, FADE), RATE, "the string, plucked every 900 ms")
    scene.picture("spring_string", draw(string, rows, "y", 4000), "handle, force and sound of the string")
    spectrum, first = draw_spectrum(string)
    scene.picture("spring_spectrum", spectrum, "one pluck; lines: the discrete string's partials")
    scene.sound("membrane", fade_out(membrane, RATE, FADE), RATE, "the membrane, tapped three times a second")
    scene.picture("spring_membrane", draw(membrane, taps, "z", 2000), "handle, force and sound of the membrane")
    scene.table(["", "theory", "render"],
                [["string's first partial, Hz", f"{string_hertz(1):.2f}", f"{first:.2f}"],
                 ["largest force of a pluck, N", "", f"{numpy.abs(rows['fy_n'][500:]).max():.2f}"],
                 ["largest force of a tap, N", "", f"{numpy.abs(taps['fz_n'][500:]).max():.2f}"]],
                "partial of the sound, and forces on the hand")
