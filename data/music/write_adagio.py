#!/usr/bin/env python3
"""Writes mozart_k622_adagio.mid: the solo clarinet's first sixteen bars of the Adagio.

W. A. Mozart, Concerto for clarinet and orchestra in A major, K. 622 (1791), second movement. The
tutti that repeats bars 1 to 8 is left out. Notes as written for the clarinet in A (F major); the
file holds them as they sound, a minor third lower (D major).
"""
import pathlib

import mido

TICKS = 480
SOUNDING = -3                    # semitones, clarinet in A
NAMES = {"c": 0, "d": 2, "e": 4, "f": 5, "g": 7, "a": 9, "bes": 10}
GRACE = 0.14                     # quarters, taken from the note that it adorns
DETACHED = 0.88                  # of its length sounds of a note that the tongue ends

# One bar a line: NOTE/QUARTERS, r a rest, ( and ) begin and end a slur, ~ a short appoggiatura.
# Digits are octaves, c4 the middle one.
BARS = """
(c5/1 f5/1.5 a5/.5)
(a5/.5 g5/.5 f5/1) r/1
(c5/1.5 f5/.5 a5/.5 c6/.5)
(c6/.5 bes5/.5 a5/1) r/1
(g5/1.5 c6/.5 a5/.5 c6/.5)
(g5/1.5 c6/.5 d5/.5 a5/.5
c5/2 ~e5 d5/.75 c5/.25)
c5/1 r/2
(a5/1.5 g5/.5 f5/.5 e5/.5)
d5/1 r/2
(bes5/1.5 a5/.5 g5/.5 f5/.5)
e5/1 r/2
(c6/1.5 bes5/.5 a5/.5 g5/.5)
(f5/.5 bes5/.5) (bes5/1.5 a5/.5)
(a5/.25 g5/.25 bes5/.25 g5/.25 f5/1 ~a5 g5/.75 f5/.25)
f5/1 r/2
"""
# Dynamics as velocities at the beginnings of bars, straight lines between: p espressivo, poco
# crescendo from the ninth, mf in the thirteenth, a diminuendo in the fifteenth.
DYNAMICS = {1: 56, 3: 60, 5: 64, 6: 66, 7: 58, 8: 52, 9: 58, 11: 66, 13: 78, 14: 80, 15: 72, 16: 54}
# Quarters a minute from the beginning of a bar on; the last two bars are held back.
TEMPO = {1: 63, 15: 58, 15.67: 50, 16: 46}


def pitch(name):
    return 12 * (int(name[-1]) + 1) + NAMES[name[:-1]] + SOUNDING


def velocity(quarter):
    bar, known = 1 + quarter / 3, sorted(DYNAMICS)
    before = max(b for b in known if b <= bar)
    after = min((b for b in known if b > bar), default=before)
    share = 0 if after == before else (bar - before) / (after - before)
    return round(DYNAMICS[before] + share * (DYNAMICS[after] - DYNAMICS[before]))


def notes():
    """(begin, end, pitch, velocity) in quarters; a slurred note ends where the next begins."""
    now, slurred, grace, found = 0.0, False, None, []
    for word in BARS.split():
        if word.startswith("~"):
            grace = pitch(word[1:])
            continue
        slurred |= word.startswith("(")
        last = word.endswith(")")
        name, length = word.strip("()").split("/")
        length = float(length)
        if name != "r":
            begin = now
            if grace is not None:
                found.append((now, now + GRACE, grace, velocity(now)))
                begin, grace = now + GRACE, None
            sounds = length if slurred and not last else length * DETACHED
            found.append((begin, now + sounds, pitch(name), velocity(now)))
        now += length
        slurred &= not last
    return found


def write(path):
    events = []
    for begin, end, key, strength in notes():
        events.append((round(begin * TICKS), 1, mido.Message("note_on", note=key, velocity=strength)))
        events.append((round(end * TICKS), 0, mido.Message("note_off", note=key, velocity=0)))
    for bar, tempo in TEMPO.items():
        events.append((round((bar - 1) * 3 * TICKS), -1,
                       mido.MetaMessage("set_tempo", tempo=mido.bpm2tempo(tempo))))
    track = mido.MidiTrack([
        mido.MetaMessage("track_name", name="W. A. Mozart, K. 622, Adagio: clarinet, as it sounds"),
        mido.MetaMessage("time_signature", numerator=3, denominator=4),
        mido.MetaMessage("key_signature", key="D"),
        mido.Message("program_change", program=71)])
    now = 0
    for tick, _, message in sorted(events, key=lambda event: event[:2]):
        track.append(message.copy(time=tick - now))
        now = tick
    track.append(mido.MetaMessage("end_of_track", time=2 * TICKS))
    mido.MidiFile(type=0, ticks_per_beat=TICKS, tracks=[track]).save(path)


if __name__ == "__main__":
    write(pathlib.Path(__file__).with_name("mozart_k622_adagio.mid"))
