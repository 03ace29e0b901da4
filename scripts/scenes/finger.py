"""A finger on the reed: a hand touches the reed of a blown clarinet, feels it vibrate and stops its note

patches/audiohaptics/finger_on_reed.pd. A finger of 300 N/m comes down on the reed of a `greed~` under 2200 Pa:
it stiffens the valve and closes it, so the note becomes softer and thinner and stops; when the finger is lifted,
the note returns. The finger feels the force of the same spring at audio rate, ten times as large, written by the servo.
"""
import csv
import math
import pathlib
import tempfile

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import spectrogram

PATCH = "patches/audiohaptics/finger_on_reed.pd"
NEEDS = "stage_patches greed~ playability~ phantom phantom~"
PATH = pathlib.Path(__file__).resolve().parents[2] / PATCH
RATE, SECONDS, DECAY = 48000, 11, 0.8  # s until the breath ends, and until the note has decayed
BLUE, RED, GREEN = "#2b5c8a", "#c4552d", "#6d8f3a"
MOMENTS = (("free", 1.3), ("touched", 2.9), ("pressed", 5.4), ("closed", 8.0), ("lifted", 10.4))


def play():
    """Plays the patch's own demonstration: the sound and the force at the reed as the patch sends them, and the servo's
    ticks (ms, mm, N)."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        patch = Patch(opens=PATH, own="own")
        patch.record("sound", patch.dac(1))
        patch.record("force", patch.obj("r~", "own-force"))
        patch.log("opening", patch.obj("r", "own-opening-now"))
        patch.send(90, "own-bus.phantom", f"trace {folder}/ticks.csv")
        patch.send(100, "help-play", "bang")
        patch.send(1000 * SECONDS - 5, "own-bus.phantom", "trace stop")
        patch.send(1000 * SECONDS, "own-breath", 0)
        result = patch.render(SECONDS + DECAY, RATE, timeout=120)
        with open(f"{folder}/ticks.csv", encoding="utf-8") as file:
            ticks = numpy.array([[float(row[key]) for key in ("ms", "z_mm", "fz_n")]
                                 for row in csv.DictReader(file)]).T
    return result, ticks


def pitch(x):
    """Hz of the strongest fundamental of 100 to 200 Hz; nan for silence."""
    if x.std() < 1e-3:
        return math.nan
    size = 1 << 17
    spectrum = numpy.log(abs(numpy.fft.rfft((x - x.mean()) * numpy.hanning(len(x)), size)))
    first = 100 * size // RATE
    peak = first + int(numpy.argmax(spectrum[first:2 * first]))
    a, b, c = spectrum[peak - 1:peak + 2]
    return (peak + 0.5 * (a - c) / (a - 2 * b + c)) * RATE / size


def make(scene):
    result, (ms, height, felt) = play()
    sound, force = result["sound"], result["force"]
    scene.sound("finger", 0.9 * sound / abs(sound).max(), RATE,
                "free, touched, pressed, closed by the finger, and free again")
    length = 4800
    times = numpy.arange(0, len(sound) - length, length // 2)
    hz = [pitch(numpy.asarray(sound[t:t + length], float)) for t in times]
    opening = numpy.array([(when / 1000, atoms[0]) for when, atoms in result.logs["opening"]]).T
    figure, axes = plt.subplots(5, 1, figsize=(12, 12), sharex=True, constrained_layout=True)
    axes[0].plot(ms / 1000, (height - 3) / 20, color=BLUE, label="finger")
    axes[0].plot(*opening, color=GREEN, label="reed, mean")
    axes[0].set_ylim(-1, 1)
    axes[0].set_ylabel("mm from the mouthpiece")
    axes[0].legend(loc="upper left")
    axes[1].plot(numpy.arange(len(force)) / RATE, force, color=RED, linewidth=0.4)
    axes[1].set_ylabel("force at the reed, N")
    axes[2].plot(ms / 1000, felt, color=RED, linewidth=0.4)
    axes[2].set_ylabel("force on the hand, N")
    axes[3].plot((times + length / 2) / RATE, hz, ".-", color=BLUE)
    axes[3].set_ylim(142, 146)
    axes[3].set_ylabel("pitch, Hz")
    spectrogram(axes[4], sound, RATE, top_hz=5000)
    axes[4].set_xlim(0, SECONDS)
    scene.picture("finger", figure, "the finger presses, the reed closes, the note stops and returns")
    rows = []
    for name, t in MOMENTS:
        part = numpy.asarray(sound[int(t * RATE):int((t + 0.3) * RATE)], float)
        hand = felt[(ms >= 1000 * t) & (ms < 1000 * (t + 0.3))]
        note = pitch(part)
        rows.append([name, f"{20 * math.log10(part.std() + 1e-9):.1f}" if part.std() > 1e-6 else "silent",
                     "-" if math.isnan(note) else f"{note:.1f}", f"{hand.mean():.2f}", f"{hand.std():.3f}"])
    scene.table(["", "level, dB", "pitch, Hz", "mean force on the hand, N", "vibration of that force, N rms"], rows,
                "five moments")
