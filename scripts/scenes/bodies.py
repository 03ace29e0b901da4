"""A tour of struck bodies: bowl, glass, bell, wood, tube, ring, disks, and a machine part from CAD

Eleven bodies from modal_fem's shapes, two profiles in data/bodies and one surface model in Debian's
gmsh-doc, each struck in [modal_impact~] at three points with a suitable striker and heard at
two ears 35 cm in front, through the air around the whole body (boundary elements). The first run computes the
modes, which takes a minute or two; the tables are kept in the build folder. Pictures show each body deformed by
its first modes, red where the surface moves outwards.
"""
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy
from make_scene import fade_out, spectrogram

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _bodies  # noqa: E402
import _room  # noqa: E402
import _tour  # noqa: E402
from _bodies import RATE  # noqa: E402

PATCH = "build/tactus/modal_impact~-help.pd"
NEEDS = "modal_impact~ modal_fem"


def mono_room(parts):
    """The piece in a small room. Each body keeps its stereo sound; the room processes the sum."""
    dry = fade_out(sum(parts.values()), RATE, 0.8)  # because the bell and the lever still ring
    placed = _room.reverberate(dry.sum(axis=1), RATE, wet=0.12)
    wet = placed - numpy.pad(dry.sum(axis=1), (0, len(placed) - len(dry)))[:, None] * 0.5 ** 0.5
    return numpy.pad(dry, ((0, len(placed) - len(dry)), (0, 0))) + wet


def show_sheet(scene, name):
    file = name.replace(" ", "_").replace("(", "").replace(")", "")
    scene.drawn(_bodies.picture_of(_tour.table(name)), file, f"{name}: its first modes")


def make(scene):
    sounds = {}
    for name in _tour.BODIES:
        sounds[name] = fade_out(_tour.visit(name), RATE, 0.8)
        scene.progress(f"{name}")
    scene.heading("A piece for nine bodies")
    piece = mono_room(_tour.perform())
    scene.sound("piece", _room.full_scale(piece), RATE, "nine bodies together, in a small room")
    scene.heading("The tour")
    scene.sound("tour", numpy.concatenate([_room.full_scale(s, 0.7) for s in sounds.values()]), RATE,
                "all bodies in the order of the table, struck at three points each, of equal peak level")
    scene.table(["body", "kg", "first mode, Hz", "T60 of the material, s", "T60 in air, s", "striker", "loudest peaks, Hz",
                 "loudest, Pa"], [_tour.in_numbers(n, s) for n, s in sounds.items()],
                "T60 of the first mode by the losses of the material alone, and with those by radiation; hands would shorten it further")
    figure, axes = plt.subplots(len(sounds), 1, figsize=(12, 2.1 * len(sounds)), sharex=True,
                                constrained_layout=True)
    for a, (name, sound) in zip(axes, sounds.items()):
        spectrogram(a, sound.sum(axis=1), RATE, top_hz=16000)
        a.set_title(name, loc="left")
        a.set_xlabel("")
    axes[-1].set_xlabel("time, s")
    scene.picture("tour_spectrograms", figure, "each body struck at three points")
    scene.heading("The bodies")
    for name, sound in sounds.items():
        file = name.replace(" ", "_").replace("(", "").replace(")", "")
        scene.sound(f"{file}_sound", _room.full_scale(sound, 0.7), RATE, name)
        show_sheet(scene, name)
