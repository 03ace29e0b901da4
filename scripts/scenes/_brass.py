"""The fanfare of ./play fanfare: four players of lip reeds, each one [greed~]."""
import dataclasses
import pathlib

import numpy
from harness import Patch

import gesture as gestures
import listening
import practice
import score

FANFARE = pathlib.Path(__file__).resolve().parents[2] / "data" / "music" / "fanfare.mid"
RATE = 48000
GLIDE = 0.01  # s in which the lips move from note to note
SOFTER_DB = 6    # breath of velocity 64 below the preset's breath_ref, dB; the score has 72 to 98
BURST = 0.3      # of the tongue: softer than the presets', which speak from soft breath too
# preset, MIDI channel, -1 left to 1 right, dB in the mix
VOICES = [("trumpet", 0, -0.45, 0), ("trumpet", 1, -0.15, -2), ("trombone", 2, 0.2, -3),
          ("trombone", 3, 0.5, -3)]


def players():
    """{preset: (technique, gain)}, each for all notes of its voices."""
    found = {}
    for preset in {preset for preset, *_ in VOICES}:
        pitches = {n.pitch for p, channel, *_ in VOICES if p == preset
                   for n in score.read(FANFARE, channel=channel)}
        pressure, lip, level_db, speaks, gain = practice.learn_lips(
            preset, pitches, score.frequency, BURST)
        found[preset] = gestures.Technique(
            pressure * 10 ** (-SOFTER_DB / 20), lip, level_db, speaks=speaks, firmness=0, early=0.03,
            attack=0.02, accent=0.1, accent_time=0.08, release=0.10, tongue=0.04, stopped=0.65,
            vibrato_pressure=0.02, vibrato_lip=0.006, vibrato_after=0.5, swell_db=0.8, arch_db=1,
            dynamic_range=3), gain
    return found


def play(preset, gesture, gain, rate=RATE):
    """The voice's sound, from one [greed~]."""
    count = int(gesture.seconds * rate)
    t = numpy.arange(count) / rate
    rows = numpy.arange(len(gesture.pressure)) / gestures.RATE
    begins = numpy.array([max(time, 0) for time, _ in gesture.events])
    pitches = numpy.array([pitch for _, pitch in gesture.events], float)
    bore = score.frequency(numpy.interp(
        t, numpy.stack([begins, begins + GLIDE], 1).ravel(),
        numpy.stack([numpy.concatenate([pitches[:1], pitches[:-1]]), pitches], 1).ravel()))
    patch = Patch()
    valve = patch.obj("greed~", "-preset", preset, "-tune", 1, "-gain", gain,
                      "-tongue_burst", BURST)
    patch.signal(numpy.interp(t, rows, gesture.pressure)) >> valve[0]
    patch.signal(numpy.interp(t, rows, gesture.reed)) >> valve[1]
    patch.signal(bore) >> valve[2]
    patch.record("sound", valve)
    return patch.render(gesture.seconds, rate, timeout=300)["sound"]


def lost(sound, notes):
    """The pitches that were missed, because they are out of tune or in another register."""
    return {n.pitch for n, j in zip(notes, listening.measure_notes(sound, RATE, notes, score.frequency))
            if not abs(j["cents"]) < 9 or j["fundamental_db"] < -30}


def rehearse(preset, notes, technique, gain, seed):
    """(gesture, sound): missed notes are tried again with less or more breath, up to four times; the best try counts."""
    best = None
    for change in (0, -1, 1, -2, 2):  # change of breath, dB
        if best:
            technique = dataclasses.replace(technique, level_db={
                **best[3].level_db, **{p: best[3].level_db.get(p, 0) + change for p in best[0]}})
        gesture = gestures.play(notes, technique, seed, tail=0.6)
        sound = play(preset, gesture, gain)
        missed = lost(sound, gesture.notes)
        if best is None or len(missed) < len(best[0]):
            best = missed, gesture, sound, technique
        if not best[0]:
            break
    return best[1:3]


def perform():
    """[(preset, channel, pan, level in the mix, gesture, sound)] of the fanfare's voices."""
    known, found = players(), []
    for seed, (preset, channel, pan, level_db) in enumerate(VOICES, 1):
        technique, gain = known[preset]
        found.append((preset, channel, pan, 10 ** (level_db / 20), *rehearse(
            preset, score.read(FANFARE, channel=channel), technique, gain, seed)))
    return found
