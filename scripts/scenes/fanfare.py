"""Lips and a syrinx: a fanfare for trumpets and trombones, and birds at dawn

Both use [greed~] alone. The brass are blown-open valves: the lips follow each note and the bore is
chosen so that it is in tune (`tune 1`), as a player does with lips and valves or slide. Each player
practises first, to find the pressure of each note and the time that it takes to speak.

The birds are swinging valves on short windpipes of three sizes. Only breath and muscle
tension vary: each syllable is a pulse of pressure while the valve's frequency sweeps. A thrush, a
warbler's trill, and a dove whose loudest coo breaks into period doubling, as real ones can.
"""
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy
from make_scene import spectrogram

import listening
import score

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _birds  # noqa: E402
import _brass  # noqa: E402
import _room  # noqa: E402
from _brass import RATE  # noqa: E402

PATCH = "build/tactus/greed~-help.pd"
NEEDS = "greed~"


def mix(parts):
    """(sound, pan) pairs in one room, stereo."""
    longest = max(len(sound) for sound, _ in parts)
    total = 0
    for sound, pan in parts:
        total = total + _room.reverberate(numpy.pad(sound, (0, longest - len(sound))), RATE, pan)
    return _room.full_scale(total)


def in_numbers(voices):
    rows = []
    for preset, channel, _, _, gesture, sound in voices:
        measured = listening.measure_notes(sound, RATE, gesture.notes, score.frequency)
        off = [[j["cents"] for j, n in zip(measured, gesture.notes) if n.duration >= least]
               for least in (0.7, 0.3)]
        speaks = [j["speaks_ms"] for j in measured if j["speaks_ms"] is not None]
        lost = sum(not abs(j["cents"]) < 50 or j["fundamental_db"] < -30 for j in measured)
        uneven = numpy.array([j["level_db"] - d for j, d in zip(measured, gesture.intended_db)])
        rows.append([f"{preset} {channel % 2 + 1}", len(measured),
                     *(f"{max(map(abs, o)):.1f}" for o in off),
                     f"{min(speaks):.0f} to {max(speaks):.0f}", lost,
                     f"{abs(uneven - numpy.median(uneven)).max():.1f}", f"{abs(sound).max():.2f}"])
    return rows


def draw_birds(songs):
    figure, axes = plt.subplots(len(songs), 1, figsize=(12, 8), sharex=True, constrained_layout=True)
    for a, (bird, (sound, pressure, reed)) in zip(axes, songs.items()):
        spectrogram(a, sound, RATE, top_hz=3000 if bird == "dove" else 10000)
        t = numpy.arange(len(reed)) / RATE
        a.plot(t, numpy.where(pressure > 100, reed / 1000, numpy.nan), color="#7fd4e8", linewidth=0.8)
        a.set_title(f"{bird}; line: the valve's own frequency f_r", loc="left")
    return figure


def make(scene):
    voices = _brass.perform()
    scene.progress(f"fanfare: {voices[0][4].seconds:.0f} s in four voices")
    scene.heading("Fanfare")
    together = mix([(level * sound, pan) for _, _, pan, level, _, sound in voices])
    scene.sound("fanfare", together, RATE, "two trumpets and two trombones in a small room")
    for preset, channel, _, _, _, sound in voices:
        scene.sound(f"{preset}_{channel % 2 + 1}", _room.full_scale(sound, 0.7), RATE,
                    f"{preset} {channel % 2 + 1} alone, dry")
    figure, axes = plt.subplots(figsize=(12, 4))
    spectrogram(axes, together.sum(axis=1), RATE)
    scene.picture("fanfare_spectrogram", figure, "spectrogram of the fanfare")
    scene.table(["voice", "notes", "largest deviation: notes of 0.7 s or more, cents", "of 0.3 s or more", "speak after, ms",
                 "lost", "largest level error, dB", "peak of [greed~]"],
                in_numbers(voices), "measurements of the fanfare, from the dry voices")
    scene.heading("Dawn")
    songs = {bird: _birds.sing(bird, seed) for seed, bird in enumerate(_birds.BIRDS, 1)}
    scene.progress("birds: three voices")
    dawn = mix([(_room.full_scale(songs[b][0], _birds.BIRDS[b]["level"]), _birds.BIRDS[b]["pan"])
                for b in songs])
    scene.sound("dawn", dawn, RATE, "a thrush, a warbler and a dove: three sizes of syrinx")
    for bird, (sound, _, _) in songs.items():
        scene.sound(bird, _room.full_scale(sound, 0.7), RATE, f"{bird} alone, dry")
    scene.picture("birds", draw_birds(songs), "spectrograms of the birds")
