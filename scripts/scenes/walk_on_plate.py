"""A walk over a wooden plank and a steel sheet: every heel and ball strikes the body's modes where it lands

patches/footsteps/walk_on_plate.pd: [footstep~] walks, and its info outlet reports which part of which foot lands and
how fast; [modal_impact~] is struck there, with the mass of a heel and the stiffness of a shoe. So a walker can step on
any body that has a table. Here two bodies from modal_fem are fixed at both ends, with a loss factor of 0.02, caused by
joists and feet.
"""
import pathlib
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from make_scene import spectrogram

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _bodies  # noqa: E402
import _room  # noqa: E402
from _bodies import RATE  # noqa: E402

PATCH = "build/tactus/walk_on_plate.pd"
NEEDS = "stage_patches footstep~ modal_impact~ modal_fem"
PATH = pathlib.Path(__file__).resolve().parents[2] / "patches" / "footsteps" / "walk_on_plate.pd"
FLOORS = {
    "spruce plank": ("board", "--length", 1200, "--width", 400, "--thickness", 20,
                     "--fix", "x=-600", "--fix", "x=600", "--modes", 40),
    "steel sheet": ("plate", "--length", 800, "--width", 400, "--thickness", 8, "--material", "steel",
                    "--fix", "x=-400", "--fix", "x=400", "--modes", 40, "--tolerance", 1),
}
SHOES = ((0, 0.15, "soft rubber"), (5, 0.5, "leather"), (10, 0.95, "hard heel"))
SECONDS, HALT = 15, 2.5  # s of walking, and for the last step and its decay


def walk(table, seconds=SECONDS):
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        for name in ("plank", "floor"):
            (pathlib.Path(folder) / f"{name}.modal.npz").symlink_to(table)
        patch = Patch(opens=PATH, own="walk-on-plate")
        patch.record("left", patch.dac(1))
        patch.record("right", patch.dac(2))
        patch.log("body", patch.obj("r", "walk-on-plate-body"))
        for message in ("load floor.modal.npz -sync", "gain 0.01", "loss 0.02", "listener 1 -90 500 1600", "listener 2 90 500 1600"):
            patch.send(0, "walk-on-plate-body", message)
        patch.send(0, "walk-on-plate-volume", 1)
        patch.send(10, "help-play", "bang")
        for time, shoe, _ in SHOES:
            patch.send(1000 * time, "walk-on-plate-shoe", shoe)
        patch.send(1000 * seconds, "walk-on-plate-walker", "walk 0")
        return patch.render(seconds + HALT, RATE, path=[folder], timeout=300)


def centroid(x):
    power = abs(numpy.fft.rfft(x)) ** 2
    return (power * numpy.fft.rfftfreq(len(x), 1 / RATE)).sum() / power.sum()


def make(scene):
    figure, axes = plt.subplots(len(FLOORS), 1, figsize=(12, 7), constrained_layout=True)
    rows = []
    for axis, (name, words) in zip(axes, FLOORS.items()):
        table = _bodies.table(*words)
        scene.progress(f"{name}: modes computed")
        render = walk(table)
        sound = numpy.stack([render["left"], render["right"]], axis=1)
        hits = [(ms / 1000, atoms) for ms, atoms in render.logs["body"] if atoms[0] == "hit"]
        scene.sound(name, _room.full_scale(_room.reverberate(sound.sum(axis=1), RATE, wet=0.15), 0.7), RATE,
                    f"{name}: " + ", then ".join(word for _, _, word in SHOES))
        spectrogram(axis, sound.sum(axis=1), RATE, top_hz=6000)
        axis.set_title(name, loc="left")
        for (begin, _, word), end in zip(SHOES, [s[0] for s in SHOES[1:]] + [SECONDS]):
            part = sound[begin * RATE:end * RATE].sum(axis=1)
            speeds = [atoms[4] for time, atoms in hits if begin <= time < end]
            rows.append([name, word, len(speeds), f"{numpy.mean(speeds):.2f}", f"{100 * abs(part).max() / 2:.2g}",
                         f"{centroid(part):.0f}", f"{numpy.load(table)['freq'][0]:.1f}"])
        scene.progress(f"{name}: walk rendered")
    scene.picture("spectrograms", figure, "a walk of fifteen seconds, three shoes")
    scene.table(["floor", "shoe", "strikes", "mean speed, m/s", "loudest, Pa", "centroid, Hz", "first mode, Hz"], rows)
