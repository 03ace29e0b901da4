#!/usr/bin/env python3
"""Writes fanfare.mid: two trumpets (channels 0, 1) and two trombones (2, 3), B flat major.

Composed for this project and, like the rest of it, free to use. All notes are natural harmonics of
B flat, as a bugle has them, but for the trombone's D3.
"""
import pathlib

import mido

TICKS = 480
TEMPO = 104         # quarters a minute
GAP = 0.12          # quarters of silence before the next note, at most an eighth of the note
BB2, D3, F3, BB3, D4, F4, BB4 = 46, 50, 53, 58, 62, 65, 70
REST = None
# Voice: bars of (pitch, quarters).
VOICES = {
    0: [[(REST, 4)], [(REST, 2), (F4, .75), (F4, .25), (F4, 1)],
        [(BB4, 2), (D4, 1 / 3), (D4, 1 / 3), (D4, 1 / 3), (F4, 1)],
        [(BB4, .75), (F4, .25), (D4, .5), (F4, .5), (BB3, 1), (D4, .5), (F4, .5)],
        [(BB4, 1.5), (F4, .5), (D4, 1 / 3), (D4, 1 / 3), (D4, 1 / 3), (F4, 1)],
        [(BB4, 4)]],
    1: [[(REST, 4)], [(REST, 2), (D4, .75), (D4, .25), (D4, 1)],
        [(F4, 2), (BB3, 1 / 3), (BB3, 1 / 3), (BB3, 1 / 3), (D4, 1)],
        [(F4, .75), (D4, .25), (BB3, .5), (D4, .5), (BB3, 1), (BB3, .5), (D4, .5)],
        [(F4, 1.5), (D4, .5), (BB3, 1 / 3), (BB3, 1 / 3), (BB3, 1 / 3), (D4, 1)],
        [(D4, 4)]],
    2: [[(D3, .75), (D3, .25), (D3, 1), (F3, 2)],
        [(D3, 1 / 3), (D3, 1 / 3), (D3, 1 / 3), (F3, 1), (BB3, 2)],
        [(BB3, 2), (F3, 2)],
        [(F3, 1), (D3, 1), (F3, 1), (BB3, 1)],
        [(BB3, 2), (F3, 1), (D3, 1)],
        [(F3, 4)]],
    3: [[(BB2, .75), (BB2, .25), (BB2, 1), (BB2, 2)],
        [(BB2, 1 / 3), (BB2, 1 / 3), (BB2, 1 / 3), (BB2, 1), (F3, 2)],
        [(F3, 2), (BB2, 2)],
        [(BB2, 1), (BB2, 1), (D3, 1), (F3, 1)],
        [(D3, 2), (BB2, 1), (F3, 1)],
        [(BB2, 4)]],
}
LOUDNESS = [72, 78, 88, 86, 92, 98]  # velocity, a bar each
NAMES = ["trumpet 1", "trumpet 2", "trombone 1", "trombone 2"]


def write(path):
    first = mido.MidiTrack([mido.MetaMessage("set_tempo", tempo=mido.bpm2tempo(TEMPO))])
    tracks = [first]
    for channel, bars in VOICES.items():
        events, now = [], 0.0
        for bar, velocity in zip(bars, LOUDNESS):
            for pitch, length in bar:
                if pitch is not REST:
                    end = now + length - min(GAP, length / 8)
                    events.append((round(now * TICKS), "note_on", pitch, velocity))
                    events.append((round(end * TICKS), "note_off", pitch, 0))
                now += length
        track = mido.MidiTrack([
            mido.MetaMessage("track_name", name=NAMES[channel]),
            mido.Message("program_change", channel=channel, program=56 if channel < 2 else 57)])
        before = 0
        for tick, kind, pitch, velocity in events:
            track.append(mido.Message(kind, channel=channel, note=pitch, velocity=velocity,
                                      time=tick - before))
            before = tick
        tracks.append(track)
    mido.MidiFile(type=1, ticks_per_beat=TICKS, tracks=tracks).save(path)


if __name__ == "__main__":
    write(pathlib.Path(__file__).with_name("fanfare.mid"))
