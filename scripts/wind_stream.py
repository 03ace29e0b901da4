#!/usr/bin/python3
"""The controller stream that patches/reed/wind_controller.pd plays when no player is connected.

    scripts/wind_stream.py > patches/reed/wind_controller_demo.txt

It is a short performance as a MIDI wind controller sends it: breath as CC 2 in steps of 1/127 and 10 ms, note numbers,
and bite as pitch bend. Breath rises and falls exponentially (attack 25 ms, release 30 ms, faster for single tongued
notes), follows the phrase in between, and is never quite steady. The stream has the format of Pd's [qlist], `ms
wind-event message`. Your own patch can send it, and wind_controller.pd reads it line by line."""
import dataclasses
import math
import random
import sys

STEP_S = 0.01            # interval of the sensors' readings
BEND_RANGE_CENTS = 200   # cents for a bend of 8192, a controller's usual setting
ATTACK_S, RELEASE_S = 0.025, 0.03
VIBRATO_HZ, VIBRATO_DELAY_S = 5.5, 0.35
REST_S = 0.5


@dataclasses.dataclass(frozen=True)
class Note:
    key: int
    duration: float           # s
    vibrato: float = 0        # cents, after VIBRATO_DELAY_S
    bends: tuple = ()         # (s after the note's beginning, cents), straight lines between


@dataclasses.dataclass(frozen=True)
class Phrase:
    """Notes slurred on one breath, which passes through the levels (0..127) in equal times."""
    notes: tuple
    breath: tuple
    rest: float = REST_S

    @property
    def duration(self):
        return sum(note.duration for note in self.notes)


def staccato(*keys):
    return tuple(Phrase((Note(key, 0.12),), (92,), 0.18) for key in keys)


def trill(key, upper, times, duration=0.11):
    return tuple(Note(k, duration) for _ in range(times) for k in (key, upper))


LEAD_IN_S = 0.3
PIECE = (
    Phrase((Note(60, 2.8),), (35, 118)),
    Phrase((Note(62, 0.5), Note(64, 0.5), Note(65, 0.5), Note(67, 1.5, vibrato=20), Note(65, 0.4),
            Note(64, 0.4), Note(62, 0.8)), (75, 105, 75)),
    *staccato(67, 67, 65, 64, 62, 60),
    Phrase((Note(64, 2.4, bends=((0, -100), (0.3, 0), (1.2, 0), (1.4, 100))),), (95, 100)),
    Phrase((Note(60, 0.6), Note(72, 1.2), Note(65, 0.6), *trill(67, 69, 6), Note(67, 1.2)),
           (70, 110, 80)),
    Phrase((Note(65, 0.5), Note(64, 0.5), Note(62, 0.5), Note(60, 2.6, vibrato=15)), (100, 85, 40)),
)


@dataclasses.dataclass(frozen=True)
class Played:
    """A note of the piece with its times in the stream, s."""
    note: Note
    phrase: Phrase
    onset: float
    slurred: bool

    @property
    def end(self):
        return self.onset + self.note.duration


def timetable():
    """Every note of the piece with its onset."""
    now, played = LEAD_IN_S, []
    for phrase in PIECE:
        start = now
        for note in phrase.notes:
            played.append(Played(note, phrase, now, now > start))
            now += note.duration
        now += phrase.rest
    return played


def line(points, x):
    """Straight lines through points (x, y), level beyond the ends; 0 without points."""
    if not points or x <= points[0][0]:
        return points[0][1] if points else 0
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return points[-1][1]


def breath_at(phrase, t, unsteady):
    """0..127, t seconds after the phrase's beginning; `unsteady` is a normal random number."""
    spacing = phrase.duration / max(len(phrase.breath) - 1, 1)
    level = line([(i * spacing, value) for i, value in enumerate(phrase.breath)], t)
    quick = 0.4 if phrase.duration < 0.2 else 1
    rise = 1 - math.exp(-(t + STEP_S) / (quick * ATTACK_S))
    if t > phrase.duration:
        rise *= math.exp(-(t - phrase.duration) / (quick * RELEASE_S))
    return min(127, round(level * rise + 0.4 * unsteady * rise))


def cents_at(note, t):
    vibrato = note.vibrato * min(1, max(0, t - VIBRATO_DELAY_S) / 0.3)
    return (line(note.bends, t) +
            vibrato * math.sin(2 * math.pi * VIBRATO_HZ * max(0, t - VIBRATO_DELAY_S)))


def phrase_events(phrase, start, seed):
    """[(s, message)] of one phrase; the note's number follows once there is breath."""
    generator = random.Random(seed)
    events, breath, bend, sounding = [], 0, 0, None
    onsets, now = [], 0
    for note in phrase.notes:
        onsets.append(now)
        now += note.duration
    for step in range(round((phrase.duration + min(phrase.rest, 0.3)) / STEP_S)):
        t = step * STEP_S
        reading = max(0, breath_at(phrase, t, generator.gauss(0, 1)))
        index = max(i for i, onset in enumerate(onsets) if t >= onset - 1e-9)
        note = phrase.notes[index]
        if t > phrase.duration and reading < 3:
            reading = 0
        if reading != breath:
            events.append((start + t, f"control 2 {reading}"))
        turned = round(cents_at(note, t - onsets[index]) * 8192 / BEND_RANGE_CENTS)
        turned = max(-8192, min(8191, turned)) if reading > 0 else 0
        if turned != bend:
            events.append((start + t, f"bend {turned}"))
        if reading > 0 and sounding != index and t <= phrase.duration:
            events.append((start + t, f"note {note.key} {max(1, reading)}"))
            if sounding is not None:  # a slur: first the next note's number, then the end of the last note
                events.append((start + t, f"note {phrase.notes[sounding].key} 0"))
            sounding = index
        if reading == 0 and breath > 0 and sounding is not None:
            events.append((start + t, f"note {phrase.notes[sounding].key} 0"))
            break
        breath, bend = reading, turned
    return events


def stream():
    """[(s, message)] of the whole piece, in order; at its end the controller is unplugged."""
    events, start = [], LEAD_IN_S
    for seed, phrase in enumerate(PIECE):
        events += phrase_events(phrase, start, seed)
        start += phrase.duration + phrase.rest
    return events + [(start, "forget")]


def qlist(events):
    """The stream as text for [qlist]: each line waits for its number of ms, then sends."""
    lines, now = [], 0
    for seconds, message in events:
        ms = round(1000 * seconds)
        wait = f"{ms - now} " if ms > now else ""
        lines.append(f"{wait}wind-event {message};")
        now = ms
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(qlist(stream()))
