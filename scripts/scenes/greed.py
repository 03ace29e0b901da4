"""Every preset of greed~, blown from silence to full pressure and back, with spectrograms

One [greed~] per preset in headless Pd, at its own bore length and reed frequency. The mouth pressure rises for three
seconds, stays for one and falls for two. Blown-closed reeds choke when the pressure holds the reed shut; blown-open
lips and the swinging syrinx do not.
"""
import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import spectrogram

PATCH = "build/tactus/greed~-help.pd"
NEEDS = "greed~"
RATE = 48000
# Every preset of the object, and the pressure at the end of the rise, Pa: about twice that at which it plays well.
TOP_PRESSURE = {"clarinet": 4500, "sax": 5000, "oboe": 4500, "trumpet": 8000, "trombone": 4000,
                "voice": 3000, "syrinx": 2000}


def breath(top):
    rise, hold, fall = (numpy.linspace(0, top, 3 * RATE), numpy.full(RATE, float(top)),
                        numpy.linspace(top, 0, 2 * RATE))
    return numpy.concatenate([rise, hold, fall])


def play(preset, pressure):
    patch = Patch()
    reed = patch.signal(pressure) >> patch.obj("greed~", "-preset", preset)
    patch.record("sound", reed)
    patch.record("bore", reed[2])
    return patch.render(len(pressure) / RATE + 0.5, RATE)


def pitch(samples):
    """Fundamental in Hz: the first tall peak of the autocorrelation, refined by a parabola."""
    x = numpy.asarray(samples, float) - numpy.mean(samples)
    power = abs(numpy.fft.rfft(x, 2 * len(x))) ** 2
    r = numpy.fft.irfft(power)[: RATE // 25]
    if r[0] <= 1e-9 * len(x):
        return float("nan")
    after = numpy.argmax(r < 0)  # begins after the peak at zero
    peaks = [i for i in range(max(after, 8), len(r) - 1)
             if r[i] > r[i - 1] and r[i] >= r[i + 1] and r[i] > 0.8 * r[after:].max()]
    if not peaks:
        return float("nan")
    i = peaks[0]
    return RATE / (i + (r[i - 1] - r[i + 1]) / (2 * (r[i - 1] - 2 * r[i] + r[i + 1])))


def note(frequency):
    if not frequency > 0:
        return "-"
    midi = 69 + 12 * numpy.log2(frequency / 440)
    name = "C C# D D# E F F# G G# A A# B".split()[round(midi) % 12]
    return f"{name}{round(midi) // 12 - 1} {100 * (midi - round(midi)):+.0f} cents"


def starts_at(sound, pressure):
    """Mouth pressure at which the sound first comes within 40 dB of its maximum."""
    window = RATE // 50
    frames = abs(sound[: len(sound) // window * window].reshape(-1, window)).max(axis=1)
    return pressure[min(int(numpy.argmax(frames > 0.01 * frames.max())) * window, len(pressure) - 1)]


def draw(scene, preset, sound, pressure):
    figure, axes = plt.subplots(figsize=(9, 3.2))
    spectrogram(axes, sound, RATE)
    axes.set_xlim(0, len(sound) / RATE)
    other = axes.twinx()
    other.plot(numpy.arange(len(pressure)) / RATE, pressure / 1000, color="#7fd4e8", linewidth=1.2)
    other.set_ylabel("mouth pressure, kPa")
    axes.set_title(preset, loc="left")
    scene.picture(preset, figure, "spectrogram, with the mouth pressure as a line")


def make(scene):
    rows = []
    for preset, top in TOP_PRESSURE.items():
        pressure = breath(top)
        result = play(preset, pressure)
        sound = result["sound"]
        scene.progress(f"{preset}: {len(sound) / RATE:.1f} s of sound in {result.wall_seconds:.1f} s")
        loudest = int(abs(sound[: 3 * RATE]).argmax())
        here = slice(max(loudest - RATE // 4, 0), max(loudest - RATE // 4, 0) + RATE // 2)
        frequency = pitch(sound[here]) if sound.any() else float("nan")
        rows.append([preset, f"{starts_at(sound, pressure):.0f}" if sound.any() else "-",
                     f"{frequency:.1f}", note(frequency), f"{abs(sound).max():.2f}",
                     f"{abs(result['bore']).max() / 1000:.1f}"])
        scene.heading(preset)
        scene.sound(preset, sound, RATE, f"{preset}, blown up to {pressure.max() / 1000:g} kPa")
        draw(scene, preset, sound, pressure)
    scene.heading("In numbers")
    scene.table(["preset", "speaks at, Pa", "pitch, Hz", "note", "peak of the sound",
                 "peak bore pressure, kPa"], rows, "pitch in the loudest half second of the rise")
