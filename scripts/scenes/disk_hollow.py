"""Solid or hollow: two disks of the same outer shape, distinguished by their sound

Yano and Iwata's second experiment: two aluminium disks, 100 mm across and 25 mm thick, one with a
cavity of 80 by 13 mm inside. Six listeners classified them correctly in 97 % of the trials. Here a classifier
receives strikes on both, each with its own position, strength and listener, scaled to equal loudness and with
a
microphone's noise 30 dB below. It is trained on one set of conditions (inner positions, gentle, near) and
tested on the other (outer positions, hard, far), then vice versa.
"""
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy
from make_scene import fade_out

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _bodies  # noqa: E402
import _hollow  # noqa: E402
import _room  # noqa: E402
from _bodies import RATE  # noqa: E402

PATCH = "build/tactus/modal_impact~-help.pd"
NEEDS = "modal_impact~ modal_fem"
LONG = True
COLOURS = {"solid": "#2b5c8a", "hollow": "#c4552d"}


def one_after_another(sounds):
    """The sounds as the classifier receives them, with the microphone's noise, which fades in and out around each
    sound."""
    silence = numpy.zeros(RATE // 50)
    rise = 0.5 - 0.5 * numpy.cos(numpy.pi * numpy.arange(RATE // 1000) / (RATE // 1000))
    parts = []
    for sound in sounds:
        part = fade_out(0.8 * sound / abs(sound).max(), RATE, 0.1)
        part[:len(rise)] *= rise
        parts += [silence, part]
    return numpy.concatenate(parts)


def draw(found):
    figure, axes = plt.subplots(1, 2, figsize=(13, 5), constrained_layout=True)
    for (half, name), seen in found["features"].items():
        axes[0].scatter(2 ** seen[:, 0] / 1000, 2 ** seen[:, 2] / 1000, s=16, color=COLOURS[name],
                        marker="o" if half == "learnt" else "x",
                        label=f"{name}, {'near, gentle' if half == 'learnt' else 'far, hard'}")
    axes[0].set_xlabel("centroid, kHz")
    axes[0].set_ylabel("lowest strong peak, kHz")
    axes[0].legend()
    for name in _hollow.DISKS:
        mean = numpy.mean([abs(numpy.fft.rfft(s * numpy.hanning(len(s)))) ** 2
                           for s in found["heard"]["tried", name]], axis=0)
        f = numpy.arange(len(mean)) / _hollow.HEARD_S / 1000
        axes[1].plot(f, 10 * numpy.log10(mean / mean.max()), color=COLOURS[name], linewidth=0.8,
                     label=name)
    axes[1].set_xlim(0, 22)
    axes[1].set_xlabel("frequency, kHz")
    axes[1].set_ylabel("mean power of 120 strikes, dB")
    axes[1].legend()
    return figure


def make(scene):
    tables = {name: numpy.load(_hollow.table(name)) for name in _hollow.DISKS}
    scene.progress("modes of both disks")
    found = _hollow.experiment()
    for name in _hollow.DISKS:
        scene.sound(name, one_after_another(found["heard"]["tried", name][:6]), RATE, f"the {name} disk, six strikes of different position and strength")
    scene.table(["test", "correct"], [[k, f"{100 * v:.1f} %"] for k, v in found["right"].items()]
                + [["trained with shuffled labels", f"{100 * found['shuffled']:.0f} %"],
                   ["the paper's six listeners", "97 %"]],
                "240 strikes for training, 240 for the test; Fisher's linear discriminant of four features")
    scene.table(["feature", "trained near, tested far", "trained far, tested near"],
                [[k, f"{100 * a:.1f} %", f"{100 * b:.1f} %"] for k, (a, b) in found["single"].items()],
                "share of correct answers with one feature alone")
    scene.picture("features", draw(found), "features of the classifier, and the mean spectra")
    rows = [[k + 1, *(f"{tables[n]['freq'][k]:.1f}" for n in _hollow.DISKS)] for k in range(12)]
    scene.table(["mode", "solid, Hz", "hollow, Hz"], rows, "the two disks' modes")
