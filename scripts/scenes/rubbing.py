"""Bodies that are rubbed: a bowed bell, a sung glass, a bar bowed at its end, a scraped board, a string

The tables of ./play bodies, rubbed instead of struck: [modal_impact~]'s inlets 3 and 4 press a surface
onto the body and drag it along, `rub` sets the position and `friction` the friction law. The contact is that
of
[contact_friction~], on any number of modes. The string's table is in closed form: its motion is Helmholtz'
(one corner that runs round, one slip per period), and follows Schelleng's limits of the bow's force.
"""
import pathlib
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from harness.struck_reference import closed_form_string
from make_scene import fade_out, spectrogram

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _bodies  # noqa: E402
import _room  # noqa: E402
import _tour  # noqa: E402
from _bodies import RATE  # noqa: E402

PATCH = "build/tactus/modal_impact~-help.pd"
NEEDS = "modal_impact~ modal_fem"
ROSIN = "friction 0.8 0.3 0.1 0.5 3000000 2 0.1"
WET_FINGER = "friction 0.7 0.3 0.08 0.5 50000 1 0.1"
STICK = "friction 0.5 0.35 0.05 0.3 200000 5 0.1 0.6"


def rub(path, normal, velocity, settings, moves=(), rate=RATE, gain=1):
    """Render of [modal_impact~] rubbed with this force, N, and velocity, m/s, sample by sample; moves
    are [(s, message)]."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        (pathlib.Path(folder) / "body.modal.npz").symlink_to(path)
        patch = Patch()
        body = patch.obj("modal_impact~", "body.modal.npz", "-sync", 1, "-gain", gain)
        patch.signal(normal) >> body[2]
        patch.signal(velocity) >> body[3]
        for name, outlet in (("left", 0), ("right", 1), ("friction", 6)):
            patch.record(name, body[outlet])
        for message in settings:
            patch.at(0, body, message)
        for time, message in moves:
            patch.at(1000 * time, body, message)
        return patch.render(len(normal) / rate, rate, path=[folder], timeout=300)


def curve(seconds, points, rate=RATE):
    """Straight lines through [(s, value)], sample by sample."""
    times, values = zip(*points)
    return numpy.interp(numpy.arange(int(seconds * rate)) / rate, times, values)


def rub_message(path, where, along):
    """The message `rub` at the vertex nearest to a point, with -1 to 1 spanning the body's box."""
    xyz = 1000 * numpy.load(path)["xyz"][_tour.vertices(path, [where])[0]]
    return f"rub {xyz[0]:.4f} {xyz[1]:.4f} {xyz[2]:.4f} {along[0]:.4f} {along[1]:.4f} {along[2]:.4f}"


def bell():
    """A violin bow on the rim, lifted, and put down again with more force."""
    path = _tour.table("bronze bell")
    normal = curve(9, [(0.1, 0), (0.3, 5), (4, 6), (4.1, 0), (4.9, 0), (5, 6), (7.5, 9), (7.6, 0)])
    velocity = curve(9, [(0, 0.07), (4, 0.08), (4.9, 0.08), (9, 0.11)])
    return path, normal, velocity, [ROSIN, rub_message(path, (1, 0, -1), (0, 1, 0))], []


def glass():
    """A wet finger that rubs around the rim once in four seconds."""
    path = _tour.table("drinking glass")
    xyz = 1000 * numpy.load(path)["xyz"].astype(float)
    top, radius = xyz[:, 2].max(), numpy.hypot(xyz[:, 0], xyz[:, 1]).max()
    moves = []
    for step in range(1200):
        angle = 2 * numpy.pi * step / 600
        x, y = radius * numpy.cos(angle), radius * numpy.sin(angle)
        moves.append((step / 150, f"rub {x:.4f} {y:.4f} {top - 1:.4f} {-y:.4f} {x:.4f} 0"))
    normal = curve(10, [(0.1, 0), (1, 1.2), (7.5, 1.2), (7.9, 0)])
    return path, normal, curve(10, [(0, 0.05), (10, 0.05)]), [WET_FINGER], moves


def bar():
    """A bow up and down over the end of a bar, as vibraphones are played."""
    path = _tour.table("rosewood bar")
    normal = curve(6, [(0.1, 0), (0.3, 4), (2.4, 4), (2.5, 0), (2.7, 0), (2.8, 5), (5, 5), (5.1, 0)])
    velocity = curve(6, [(0, 0.08), (2.5, 0.1), (2.6, -0.08), (6, -0.1)])
    return path, normal, velocity, [ROSIN, rub_message(path, (1, 0, 0), (0, 0, 1))], []


def board():
    """A dry stick drawn over a board to and fro, its grain felt as roughness."""
    path = _tour.table("spruce board")
    time = numpy.arange(int(4 * RATE)) / RATE
    velocity = 0.5 * numpy.sin(2 * numpy.pi * time)
    displacement = 75 * -numpy.cos(2 * numpy.pi * time)  # mm
    top = 1000 * float(numpy.load(path)["xyz"][:, 2].max())
    moves = [(n / 250, f"rub {displacement[n * RATE // 250]:.4f} 30 {top:.4f} 1 0 0") for n in range(0, 1000)]
    normal = curve(4, [(0.05, 0), (0.1, 3), (3.9, 6), (3.95, 0)])
    return path, normal, velocity, [STICK], moves


RUBBED = {"bell": bell, "glass": glass, "bar": bar, "board": board}


def string(scene):
    """Draws the motion under the bow beside Helmholtz motion, for a bow that is too light, right and too heavy."""
    speed, beta, hz = 0.1, 0.13, 196.0
    sounds, rows = [], []
    figure, axes = plt.subplots(3, 1, figsize=(12, 8), sharex=True, constrained_layout=True)
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        path = pathlib.Path(folder) / "string.npz"
        numpy.savez(path, **closed_form_string(hz=hz))
        length, side = 330.0, 0.5
        for axis, (word, force) in zip(axes, (("too small", 0.02), ("in between", 0.2), ("too large", 6.0))):
            render = rub(path, curve(2, [(0, 0), (0.05, force), (1.7, force), (1.75, 0)]),
                         curve(2, [(0, 0), (0.05, speed)]),
                         ["radiation none", f"listener 1 {(beta - .5) * length} {side} 0",
                          f"listener 2 {.4 * length} {side} 0", "friction 0.8 0.3 0.1 0.5 1000000 5 0",
                          f"rub {(beta - .5) * length} 0 {side} 0 1 0"], gain=1)
            velocity = numpy.asarray(render["left"], float)
            part = slice(int(1.4 * RATE), int(1.43 * RATE))
            time = 1000 * numpy.arange(part.stop - part.start) / RATE
            axis.plot(time, velocity[part], color="#2b5c8a", linewidth=1)
            axis.axhline(speed, color="#c4552d", linewidth=0.8, linestyle="--")
            axis.axhline(-speed * (1 - beta) / beta, color="#6d8f3a", linewidth=0.8, linestyle="--")
            axis.set_title(f"{word}: {force} N", loc="left")
            axis.set_ylabel("m/s")
            slips = ((velocity[part][1:] < 0) & (velocity[part][:-1] >= 0)).sum()
            rows.append([word, force, f"{slips / (0.03 * hz):.1f}"])
            sounds.append(fade_out(_room.full_scale(numpy.asarray(render["right"], float), 0.5), RATE, 0.2))
    axes[-1].set_xlabel("time, ms")
    scene.heading("A bowed string")
    scene.sound("string", numpy.concatenate(sounds), RATE, "bow force too small, in between, and too large")
    scene.picture("string", figure, "velocity under the bow; dashed: velocity of the bow, and of the slip in Helmholtz motion")
    scene.table(["bow force", "N", "slips per period"], rows)


def make(scene):
    rendered = {}
    for name, body in RUBBED.items():
        path, normal, velocity, settings, moves = body()
        render = rub(path, normal, velocity, ["radiation body", *_tour.LISTENERS, *settings], moves)
        rendered[name] = numpy.stack([render["left"], render["right"]], axis=1), normal, velocity, path
        scene.progress(f"{name}")
    rows = []
    figure, axes = plt.subplots(len(rendered), 1, figsize=(12, 2.6 * len(rendered)), constrained_layout=True)
    for axis, (name, (sound, normal, velocity, path)) in zip(axes, rendered.items()):
        scene.sound(name, _room.full_scale(_room.reverberate(fade_out(sound.sum(axis=1), RATE, 0.8), RATE, wet=0.1), 0.7),
                    RATE, RUBBED[name].__doc__)
        spectrogram(axis, sound.sum(axis=1), RATE, top_hz=12000)
        axis.set_title(name, loc="left")
        pressed = numpy.flatnonzero(normal > 0.7 * normal.max())
        last = slice(pressed[-1] - RATE // 2, pressed[-1])  # half a second before it lets go
        found = _bodies.peaks(sound[last].sum(axis=1), low_hz=40, count=3)
        rows.append([name, f"{normal.max():g}", f"{abs(velocity).max():g}",
                     f"{numpy.load(path)['freq'][0]:.1f}", ", ".join(f"{hz:.1f}" for hz, _ in found),
                     f"{abs(sound).max():.2g}"])
    scene.picture("spectrograms", figure, "the bodies while and after they are rubbed")
    scene.table(["body", "largest force, N", "largest speed, m/s", "first mode, Hz", "loudest peaks, Hz", "loudest, Pa"], rows)
    string(scene)
