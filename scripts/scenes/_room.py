"""A small room for finished recordings: four delay lines in a feedback network, drawn in Pd."""
import numpy
from harness import Patch

DELAYS_MS = (31.3, 37.9, 43.7, 49.1)  # no common multiples, to avoid coloration
T60_S = 1.3
DAMPING_HZ = 3800                     # absorption of the walls above this
WET = 0.22


def reverberate(samples, rate, pan=0.0, wet=WET):
    """Stereo (n + 2 s, 2): the samples at pan -1 (left) to 1, with the room around them."""
    patch = Patch()
    dry = patch.signal(numpy.concatenate([samples, numpy.zeros(2 * rate, numpy.float32)]))
    # Orthogonal mixing (Hadamard, 1/2) keeps the energy; each line loses 60 dB in T60.
    reads = [patch.obj("delread~", f"room-{i}", ms) for i, ms in enumerate(DELAYS_MS)]
    lines = [r >> patch.obj("lop~", DAMPING_HZ) >> patch.obj("*~", 10 ** (-3e-3 * ms / T60_S) / 2)
             for r, ms in zip(reads, DELAYS_MS)]
    for i, ms in enumerate(DELAYS_MS):
        total = patch.obj("+~")
        dry >> total
        for j, line in enumerate(lines):
            line >> patch.obj("*~", -1 if bin(i & j).count("1") % 2 else 1) >> total
        total >> patch.obj("hip~", 60) >> patch.obj("delwrite~", f"room-{i}", ms + 10)
    for channel, gain in (("left", (1 - pan) / 2), ("right", (1 + pan) / 2)):
        out = patch.obj("+~")
        dry >> patch.obj("*~", float(numpy.sqrt(gain))) >> out
        for i, read in enumerate(reads):
            sign = (1, 1, -1, -1)[i] if channel == "left" else (1, -1, 1, -1)[i]
            read >> patch.obj("*~", sign * wet) >> out
        patch.record(channel, out)
    result = patch.render(len(samples) / rate + 2, rate, timeout=600)
    return numpy.stack([result["left"], result["right"]], axis=1)


def full_scale(samples, peak=0.9):
    return samples * (peak / abs(samples).max())
