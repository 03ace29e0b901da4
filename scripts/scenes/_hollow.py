"""Solid or hollow? Two disks that look alike are struck, and a classifier distinguishes them by sound
alone."""
import _bodies
import numpy
from _bodies import RATE

DISKS = {"solid": ("disk", "--diameter", 100, "--thickness", 25, "--material", "aluminium"),
         "hollow": ("hollow_disk", "--diameter", 100, "--thickness", 25, "--cavity-diameter", 80,
                    "--cavity-thickness", 13, "--material", "aluminium", "--h", 9)}
TOP = 12.5       # mm, height of the struck face
HEARD_S = 0.4    # s of each strike that the classifier hears
NOISE_DB = -30   # white noise of the microphone relative to the strike's rms
FEATURES = ("centroid, octaves", "loudest peak, octaves", "lowest peak, octaves",
            "spread about the centroid, octaves")


def table(name):
    return _bodies.table(*DISKS[name])


def draw_strikes(count, radii_mm, speeds, distances_mm, generator):
    """[(x, y, v, listener)] drawn at random: area-uniform points between two radii on the face,
    speeds uniform in logarithm, listeners in the half space before the face."""
    drawn = []
    for _ in range(count):
        r = numpy.sqrt(generator.uniform(radii_mm[0] ** 2, radii_mm[1] ** 2))
        a = generator.uniform(0, 2 * numpy.pi)
        v = numpy.exp(generator.uniform(*numpy.log(speeds)))
        direction = generator.standard_normal(3)
        direction[2] = abs(direction[2])
        listener = generator.uniform(*distances_mm) * direction / numpy.linalg.norm(direction)
        drawn.append((r * numpy.cos(a), r * numpy.sin(a), v, listener + [0, 0, TOP]))
    return drawn


def record(name, drawn, generator):
    """The sound of each strike, scaled to equal rms so that loudness carries no information, with noise."""
    step = HEARD_S + 0.1
    messages = []
    for i, (x, y, v, listener) in enumerate(drawn):
        where = " ".join(f"{c:.6g}" for c in listener)
        messages += [(i * step, ("reset", f"listener 1 {where}", f"listener 2 {where}")),
                     (i * step + 0.06, f"hit {x:.6g} {y:.6g} {TOP} {v:.6g}")]
    sound = _bodies.strike(table(name), messages, len(drawn) * step, [_bodies.ball()], gain=1)["left"]
    heard = []
    for i in range(len(drawn)):
        first = int((i * step + 0.06) * RATE)
        part = sound[first:first + int(HEARD_S * RATE)].astype(float)
        part /= numpy.sqrt((part ** 2).mean())
        heard.append(part + 10 ** (NOISE_DB / 20) * generator.standard_normal(len(part)))
    return heard


def features(sound):
    """The features of a sound that the classifier uses: FEATURES."""
    power = abs(numpy.fft.rfft(sound * numpy.hanning(len(sound)))) ** 2
    f = numpy.fft.rfftfreq(len(sound), 1 / RATE)
    audible = (f > 1000) & (f < 18000)
    f, power = f[audible], power[audible]
    noise = numpy.median(power)
    clear = numpy.maximum(power - 4 * noise, 0)
    centroid = (f * clear).sum() / clear.sum()
    strong = f[power > max(1e-3 * power.max(), 100 * noise)]
    spread = ((f - centroid) ** 2 * clear).sum() / clear.sum()
    return numpy.array([numpy.log2(centroid), numpy.log2(f[power.argmax()]), numpy.log2(strong[0]),
                        0.5 * numpy.log2(spread + 100.0 ** 2)])


class Discriminant:
    """Fisher's linear discriminant between two sets of features, with the threshold half-way."""

    def __init__(self, solid, hollow):
        both = numpy.concatenate([solid - solid.mean(0), hollow - hollow.mean(0)])
        spread = numpy.atleast_2d(both.T @ both / len(both))
        spread = spread + 1e-3 * numpy.eye(len(spread)) * numpy.trace(spread) / len(spread)
        self.direction = numpy.linalg.solve(spread, solid.mean(0) - hollow.mean(0))
        self.middle = (solid.mean(0) + hollow.mean(0)) / 2

    def hears_solid(self, heard):
        return (heard - self.middle) @ self.direction > 0

    def right(self, solid, hollow):
        """Fraction of both sets that is classified correctly."""
        return float(numpy.concatenate([self.hears_solid(solid), ~self.hears_solid(hollow)]).mean())


# The classifier learns from one half of the conditions and is tested on the other. No position, strength or distance is
# in both.
LEARNT = {"radii_mm": (5, 30), "speeds": (0.3, 1.2), "distances_mm": (80, 250)}
TRIED = {"radii_mm": (30, 46), "speeds": (1.2, 3.0), "distances_mm": (250, 600)}


def experiment(count=120, seed=1):
    """A dictionary of results: sounds and features by disk for both conditions, fraction correct in both
    directions, for single features, and for a discriminant trained on shuffled labels."""
    generator = numpy.random.default_rng(seed)
    heard = {(half, name): record(name, draw_strikes(count, **world, generator=generator), generator)
             for half, world in (("learnt", LEARNT), ("tried", TRIED)) for name in DISKS}
    seen = {key: numpy.array([features(s) for s in sounds]) for key, sounds in heard.items()}
    found = {"heard": heard, "features": seen}

    def share_right(taught, asked, columns=slice(None)):
        learnt = [seen[taught, name][:, columns] for name in DISKS]
        return Discriminant(*learnt).right(*(seen[asked, name][:, columns] for name in DISKS))

    found["right"] = {"trained on near and gentle, tested on far and hard": share_right("learnt", "tried"),
                      "trained on far and hard, tested on near and gentle": share_right("tried", "learnt")}
    found["single"] = {FEATURES[k]: (share_right("learnt", "tried", slice(k, k + 1)),
                                     share_right("tried", "learnt", slice(k, k + 1)))
                       for k in range(len(FEATURES))}
    mixed = numpy.concatenate([seen["learnt", name] for name in DISKS])
    wrong = []
    for _ in range(50):
        order = generator.permutation(len(mixed))
        wrong.append(Discriminant(mixed[order[:count]], mixed[order[count:]]).right(
            *(seen["tried", name] for name in DISKS)))
    found["shuffled"] = float(numpy.mean(wrong))
    return found
