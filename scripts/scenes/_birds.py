"""Birds on [greed~ -preset syrinx]: a swinging valve on a short windpipe, swept by its muscles.

A bird's song is breath and muscle: each syllable is a pulse of pressure while the tension of the valve, its f_r, moves.
The three birds differ in size: the windpipe's length and width, and the valve's mass. A wide windpipe loads the valve
less and gives a fluted tone.
"""
import numpy
from harness import Patch

RATE = 48000
SECONDS = 19.0

# Flags of [greed~]; position, -1 left to 1 right; level in the mix.
BIRDS = {
    "thrush": {"flags": ("-length", 0.02, "-radius", 3e-3, "-radius_end", 6e-3, "-mass", 2e-7),
               "pan": -0.35, "level": 0.55},
    "warbler": {"flags": ("-length", 0.012, "-radius", 2.2e-3, "-radius_end", 4e-3,
                          "-mass", 1.5e-7, "-q", 8), "pan": 0.7, "level": 0.26},
    "dove": {"flags": ("-length", 0.17, "-radius", 3e-3, "-radius_end", 3e-3, "-mass", 6e-6, "-q", 8,
                       "-width", 4e-3), "pan": 0.15, "level": 0.32},
}


def thrush():
    """Fluted phrases of a few notes, with a twitter at the end; each syllable is (begin s, length s, f_r points Hz,
    pressure Pa)."""
    phrase = [
        [(0.00, 0.26, [2050, 2250, 2200], 3000), (0.30, 0.16, [2650, 2900], 3400),
         (0.48, 0.34, [2450, 2350, 2100], 3200), (0.90, 0.09, [3500, 3900], 4000),
         (1.00, 0.08, [3900, 3400], 3800), (1.09, 0.10, [3300, 4000, 3500], 3800)],
        [(0.00, 0.18, [2300, 2300], 3000), (0.22, 0.18, [2800, 2700], 3400),
         (0.44, 0.40, [2000, 2100, 2500], 3200), (0.88, 0.22, [3000, 2600], 3600)],
        [(0.00, 0.30, [2600, 2400, 2700], 3400), (0.36, 0.12, [3100, 3100], 3600),
         (0.50, 0.12, [2900, 2900], 3600), (0.64, 0.42, [2200, 2050, 2000], 3000),
         (1.14, 0.07, [3700, 4000], 4000), (1.22, 0.07, [3700, 4000], 4000),
         (1.30, 0.07, [3700, 4000], 4000), (1.38, 0.12, [4000, 3300], 3800)],
    ]
    begins = [(1.0, 0), (4.4, 1), (7.7, 2), (11.6, 0), (14.6, 2)]
    return [(at + b, d, f, p) for at, i in begins for b, d, f, p in phrase[i]]


def warbler():
    """A trill of falling chirps that becomes faster."""
    found = []
    for at, count, rate in ((2.6, 12, 11.0), (9.6, 16, 12.5), (16.6, 10, 10.0)):
        now = at
        for i in range(count):
            found.append((now, 0.06, [5000, 4300 - 25 * i, 3600 - 30 * i], 2400 + 40 * i))
            now += 1 / (rate * (1 + 0.02 * i))
    return found


def dove():
    """coo COO coo, coo coo: twice."""
    figure = [(0.00, 0.36, [490, 510], 520), (0.46, 0.62, [520, 580, 540], 800),
              (1.14, 0.50, [520, 505], 600), (1.86, 0.34, [500, 510], 520),
              (2.28, 0.42, [500, 480], 560)]
    return [(at + b, d, f, p) for at in (5.6, 12.9) for b, d, f, p in figure]


SONGS = {"thrush": thrush, "warbler": warbler, "dove": dove}


def controls(syllables, seed):
    """Mouth pressure and reed frequency at the sample rate, slightly different each time."""
    random = numpy.random.default_rng(seed)
    count = int(SECONDS * RATE)
    pressure = numpy.zeros(count)
    reed = numpy.full(count, float(syllables[0][2][0]))
    for begin, length, points, strength in syllables:
        first = int((begin + 0.004 * random.standard_normal()) * RATE)
        u = numpy.linspace(0, 1, int(length * RATE))
        edge = min(0.020, 0.3 * length) / length
        rise = numpy.sin(0.5 * numpy.pi * numpy.clip(u / edge, 0, 1)) ** 2
        fall = numpy.sin(0.5 * numpy.pi * numpy.clip((1 - u) / (1.6 * edge), 0, 1)) ** 2
        here = slice(first, first + len(u))
        pressure[here] = strength * (1 + 0.03 * random.standard_normal()) * rise * fall
        bend = numpy.interp(u, numpy.linspace(0, 1, len(points)), points)
        width = max(len(u) // 6, 2)
        bend = numpy.convolve(numpy.pad(bend, width, "edge"), numpy.hanning(width + 2)[1:-1], "same")
        bend = bend[width:-width] / numpy.hanning(width + 2).sum()
        reed[here] = bend * (1 + 0.006 * random.standard_normal())
        reed[here.stop:] = reed[here.stop - 1]
    return pressure, reed


def sing(bird, seed=1):
    """(sound, pressure, reed) of one bird."""
    pressure, reed = controls(SONGS[bird](), seed)
    patch = Patch()
    valve = patch.obj("greed~", "-preset", "syrinx", "-gain", 0.5, *BIRDS[bird]["flags"])
    patch.signal(pressure) >> valve[0]
    patch.signal(reed) >> valve[1]
    patch.record("sound", valve)
    return patch.render(SECONDS, RATE, timeout=300)["sound"], pressure, reed
