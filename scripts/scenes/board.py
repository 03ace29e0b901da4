"""A steel bar struck on a wooden board: alone, on felt, screwed to it, and loose so that it rattles

Two tables in closed form in one [modal_impact~]: `board` lays the bar on a simply supported plate of spruce, `rest`
sets the points of contact, `rest_stiffness` and `rest_force` the layer between them and its preload.
"""
import pathlib
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy
from harness import Patch
from harness.struck_reference import closed_form_bar, closed_form_board
from make_scene import fade_out, spectrogram

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _room  # noqa: E402
from _bodies import RATE  # noqa: E402

NEEDS = "modal_impact~"
BOARD = ["board board.npz 0 0 -15", "rest -110 0 -6 60 0 -6"]
HARD = ["rest_exponent 1.5", "rest_loss 0.2"]
WAYS = {
    "alone": [],
    "on felt": BOARD,
    "screwed on": [*BOARD, *HARD, "rest_stiffness 1e8", "rest_force 200"],
    "loose": [*BOARD, *HARD, "rest_stiffness 1e9"],
}


def strike(folder, settings, seconds=2.5):
    """Pressure in Pa at both listeners under two blows of a hard mallet."""
    patch = Patch()
    body = patch.obj("modal_impact~", "bar.npz", "-sync", 1, "-gain", 1)
    for name, outlet in (("left", 0), ("right", 1)):
        patch.record(name, body[outlet])
    for message in ("listener 1 -100 -150 500", "listener 2 100 -150 500", "hardness 1e8 2", *settings):
        patch.at(0, body, message)
    patch.at(50, body, "hit 20 0 6 0.7")
    patch.at(1200, body, "hit 100 0 6 2")
    render = patch.render(seconds, RATE, path=[folder], timeout=300)
    return numpy.stack([render["left"], render["right"]], axis=1).astype(float)


def make(scene):
    figure, axes = plt.subplots(len(WAYS), 1, figsize=(12, 2.6 * len(WAYS)), constrained_layout=True)
    rows = []
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        numpy.savez(pathlib.Path(folder) / "bar.npz", **closed_form_bar())
        board = closed_form_board()
        numpy.savez(pathlib.Path(folder) / "board.npz", **board)
        for axis, (name, settings) in zip(axes, WAYS.items()):
            sound = strike(folder, settings)
            mono = sound.sum(axis=1)
            scene.sound(name.replace(" ", "-"), fade_out(_room.full_scale(mono, 0.7), RATE, 0.7), RATE,
                        f"the bar {name}")
            spectrogram(axis, mono, RATE, top_hz=6000)
            axis.set_title(name, loc="left")
            spectrum = abs(numpy.fft.rfft(mono[:RATE] * numpy.hanning(RATE)))  # 1 Hz per bin
            low = [20 * numpy.log10((spectrum[int(hz) - 15:int(hz) + 15] ** 2).sum() ** .5) for hz in board["freq"][:2]]
            rows.append([name, f"{abs(sound).max():.2g}", *(f"{x:.0f}" for x in low)])
            scene.progress(name)
    scene.picture("spectrograms", figure, "two strikes on the bar, alone and on the board")
    scene.table(["bar", "loudest, Pa", *(f"dB about {hz:.0f} Hz" for hz in board["freq"][:2])], rows)
