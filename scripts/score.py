"""Tunes from Standard MIDI Files, as a player reads them: notes, slurs, phrases."""
import dataclasses

import mido

REST = 0.15  # s of silence in the score in which a player breathes
NAMES = "C C# D Eb E F F# G Ab A Bb B".split()


@dataclasses.dataclass
class Note:
    onset: float           # s
    duration: float        # s
    pitch: float           # MIDI, 69 is 440 Hz
    velocity: int          # loudness, 1..127
    slurred: bool = False  # begins at the end of the last note, without tonguing
    first: bool = False    # first note of its phrase
    last: bool = False     # last note before a rest

    @property
    def end(self):
        return self.onset + self.duration


def name(pitch):
    return f"{NAMES[round(pitch) % 12]}{round(pitch) // 12 - 1}"


def frequency(pitch):
    return 440 * 2 ** ((pitch - 69) / 12)


def read(path, transpose=0, channel=None):
    """The notes of one voice, in order; a note that begins before the previous one has ended cuts that one off.

    channel 0..15 picks one of several voices. Raises ValueError if there is no note."""
    now, open_notes, notes = 0.0, {}, []
    for message in mido.MidiFile(path):
        now += message.time
        if message.type not in ("note_on", "note_off"):
            continue
        if channel is not None and message.channel != channel:
            continue
        if message.note in open_notes:
            note = open_notes.pop(message.note)
            note.duration = now - note.onset
        if message.type == "note_on" and message.velocity > 0:
            note = Note(now, 0, message.note + transpose, message.velocity)
            open_notes[message.note] = note
            notes.append(note)
    notes = [n for n in notes if n.duration > 0]
    if not notes:
        raise ValueError(f"{path}: no notes" + ("" if channel is None else f" on channel {channel}"))
    return phrased(notes)


def phrased(notes):
    """Marks slurs and the ends of phrases; a clarinet has one voice, so overlaps are cut."""
    notes[0].first = notes[-1].last = True
    for before, after in zip(notes, notes[1:]):
        before.duration = min(before.duration, after.onset - before.onset)
        gap = after.onset - before.end
        after.slurred = gap < 1e-3
        before.last = after.first = gap > REST
    return notes
