"""A player's gesture for a score: pressure and reed frequency over time.

A reed's loudness follows the mouth pressure. If the lip tension followed the square root of the pressure, the ratio
gamma = p_m/P_M to the closing pressure, and with it the playing regime, would be the same from piano to forte, since
P_M = k x_0/(w lambda_m) grows as f_r^2; a constant lip keeps the intonation. The player takes a middle course: f_r
follows the fourth root of the pressure. So one number at each time, the target level in dB, determines both pressure
and f_r. Added to this: the tongue's attack, a small dip where fingers change under a slur, a swell in long notes, an
arch over the phrase, late vibrato, breath taken in rests, and random human variation from a seed.
"""
import dataclasses

import numpy
import scipy.signal

RATE = 1000  # rows a second


@dataclasses.dataclass
class Technique:
    """The skills of one player on one instrument; pressures in Pa, frequencies in Hz, times in s."""
    pressure: float             # pressure at mezzo forte
    reed_frequency: float       # the lip's f_r at that pressure
    level_db: dict = dataclasses.field(default_factory=dict)   # extra level of each pitch, for evenness
    lip: dict = dataclasses.field(default_factory=dict)        # reed frequency of single pitches
    dynamic_range: float = 1.0  # dB of breath for each dB of the velocities
    firmness: float = 0.25      # the lip's f_r is proportional to this power of the effort
    early: float = 0.025        # time before the beat at which a note starts from silence; half of it for other notes
    speaks: dict = dataclasses.field(default_factory=dict)  # the same for single pitches
    attack: float = 0.008       # time the pressure takes to rise
    accent: float = 0.10        # overshoot of the attack
    accent_time: float = 0.05   # decay time of the overshoot
    release: float = 0.16       # time in which the pressure falls at the end of a phrase
    tongue: float = 0.050       # time the tongue is on the reed between two notes
    # Fraction of the pressure that passes the tongue. With less, the remaining sound of the higher modes
    # starts the next note there: a squeak.
    stopped: float = 0.45
    slur_dip: float = 0.08
    vibrato_hz: float = 5.2
    vibrato_pressure: float = 0.035
    vibrato_lip: float = 0.035
    vibrato_after: float = 0.30
    swell_db: float = 0.8
    arch_db: float = 1.2
    timing: float = 0.006       # standard deviation of onsets
    unsteadiness: float = 0.006 # relative unsteadiness of the breath; the lip is three times steadier


@dataclasses.dataclass
class Gesture:
    """Pressure and reed frequency at RATE, events (s, pitch), and notes with their onsets as played."""
    pressure: numpy.ndarray
    reed: numpy.ndarray
    events: list
    notes: list
    intended_db: list

    @property
    def seconds(self):
        return len(self.pressure) / RATE


def start(note, technique):
    """Time at which the tongue releases a note: before the onset, by the time that the note takes to
    speak."""
    early = technique.speaks.get(note.pitch, technique.early) if note.first else 0.5 * technique.early
    return note.onset - early


def smoothstep(x):
    x = numpy.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def wander(random, count, low_hz, high_hz):
    """Seeded noise of standard deviation 1 between two frequencies."""
    sections = scipy.signal.butter(2, [low_hz, high_hz], "band", fs=RATE, output="sos")
    noise = scipy.signal.sosfilt(sections, random.standard_normal(count + RATE))[RATE:]
    return noise / max(noise.std(), 1e-12)


def phrases(notes):
    found = []
    for note in notes:
        if note.first or not found:
            found.append([])
        found[-1].append(note)
    return found


def play(score, technique, seed=1, lead=0.6, tail=1.0):
    """The gesture for a score (see score.read)."""
    random = numpy.random.default_rng(seed)
    notes = [dataclasses.replace(n) for n in score]
    for note in notes:
        late = lead + technique.timing * float(numpy.clip(random.standard_normal(), -2, 2))
        end = note.end + lead
        note.onset += late
        note.duration = end - note.onset
    for before, after in zip(notes, notes[1:]):
        if after.slurred:
            before.duration = after.onset - before.onset
    count = int((notes[-1].end + tail) * RATE)
    t = numpy.arange(count) / RATE
    level = wanted_level(notes, technique, t)
    envelope = breath(notes, technique, t)
    shake = vibrato(notes, technique, t, random)
    lip = numpy.full(count, technique.reed_frequency)
    for note in notes:
        lip[t >= start(note, technique)] = technique.lip.get(note.pitch, technique.reed_frequency)
    lip = glide(lip, 0.012)
    effort = 10 ** (level / 20)
    slow, tremor = wander(random, count, 0.3, 3), wander(random, count, 8, 12)
    lip_noise = wander(random, count, 0.3, 3)
    pressure = technique.pressure * effort * envelope
    pressure *= 1 + technique.vibrato_pressure * shake
    pressure *= 1 + technique.unsteadiness * (slow + 0.3 * tremor)
    reed = lip * effort ** technique.firmness * (1 + technique.vibrato_lip * shake)
    reed *= 1 + technique.unsteadiness / 3 * lip_noise
    events = [(note.onset if note.slurred else start(note, technique) if note.first
               else start(note, technique) - 0.4 * technique.tongue, note.pitch) for note in notes]
    body = [level[int(n.onset * RATE):max(int(n.end * RATE), int(n.onset * RATE) + 1)].mean()
            - technique.level_db.get(n.pitch, 0) for n in notes]
    return Gesture(pressure, reed, events, notes, body)


def glide(values, seconds):
    """A raised-cosine average over that time, without delay."""
    window = numpy.hanning(max(int(seconds * RATE), 1) + 2)[1:-1]
    padded = numpy.pad(values, len(window), "edge")
    return numpy.convolve(padded, window / window.sum(), "same")[len(window):-len(window)]


def wanted_level(notes, technique, t):
    """The level in dB relative to mezzo forte, without attacks and releases."""
    begins = [n.onset for n in notes]
    level = numpy.interp(t, begins, [technique.dynamic_range * 20 * numpy.log10(n.velocity / 64)
                                     for n in notes])
    for phrase in phrases(notes):
        begin, end = phrase[0].onset, phrase[-1].end
        inside = (t >= begin) & (t < end)
        u = (t[inside] - begin) / (end - begin)
        level[inside] += technique.arch_db * (numpy.sin(numpy.pi * u ** 0.8) - 0.6)
    trim = numpy.interp(t, *numpy.array([[x, technique.level_db.get(n.pitch, 0)] for n in notes
                                         for x in (n.onset - 0.03,
                                                   max(n.end - 0.07, n.onset - 0.02))]).T)
    for note in notes:
        if note.duration > 0.4:
            inside = (t >= note.onset) & (t < note.end)
            u = (t[inside] - note.onset) / note.duration
            level[inside] += technique.swell_db * (numpy.sin(numpy.pi * u) - 0.6)
    return glide(level, 0.06) + trim


def breath(notes, technique, t):
    """Share of the pressure that reaches the reed: attacks, tongue, slurs, phrase ends."""
    share = numpy.zeros(len(t))
    for i, note in enumerate(notes):
        begin = start(note, technique)
        follower = notes[i + 1] if i + 1 < len(notes) else None
        if note.slurred:
            dip = numpy.exp(-0.5 * ((t - note.onset) / 0.010) ** 2)
            share *= 1 - technique.slur_dip * dip
        else:
            since = t - begin
            rise = smoothstep(since / technique.attack)
            rise *= 1 + technique.accent * numpy.exp(-numpy.clip(since, 0, None) / technique.accent_time)
            floor = 0 if note.first else technique.stopped
            share = numpy.where(t >= begin, floor + (1 - floor) * rise, share)
        if note.last or follower is None:
            fall = 1 - smoothstep((t - (note.end - 0.6 * technique.release)) / technique.release)
            share *= numpy.where(t > note.onset, fall, 1)
        elif not follower.slurred:
            stop = min(note.end, start(follower, technique) - technique.tongue)
            share *= numpy.where(t > note.onset,
                                 1 - (1 - technique.stopped) * smoothstep((t - stop) / 0.012), 1)
    return share


def vibrato(notes, technique, t, random):
    """The vibrato, -1..1. It grows in long notes after a while, with slightly uneven rate and depth."""
    depth = numpy.zeros(len(t))
    for note in notes:
        if note.duration < 2 * technique.vibrato_after:
            continue
        rise = smoothstep((t - note.onset - technique.vibrato_after) / 0.4)
        fall = 1 - smoothstep((t - note.end + 0.12) / 0.12)
        depth += (1 + 0.15 * random.standard_normal()) * rise * fall
    rate = technique.vibrato_hz * (1 + 0.05 * wander(random, len(t), 0.2, 1))
    return depth * numpy.sin(2 * numpy.pi * numpy.cumsum(rate) / RATE)


def fitting_sigma(gesture, sigma):
    """sigma, with its upper ends raised to the next multiple of 500 if the gesture would leave its box."""
    low, high, slow, fast = sigma
    up = [500 * int(numpy.ceil(1.02 * values.max() / 500))
          for values in (gesture.pressure, gesture.reed)]
    return low, max(high, up[0]), slow, max(fast, up[1])


def positions(gesture, sigma):
    """y and z in 0..1 by the inverse of the patch's map: p_m = p_lo + y (p_hi - p_lo), f_r = f_lo (f_hi/f_lo)^z. sigma
    is (p_lo, p_hi, f_lo, f_hi). Raises ValueError if the hand would have to leave its workspace."""
    low, high, slow, fast = sigma
    y = (gesture.pressure - low) / (high - low)
    z = numpy.log(gesture.reed / slow) / numpy.log(fast / slow)
    for axis, values in (("y", y), ("z", z)):
        if values.min() < 0 or values.max() > 1:
            raise ValueError(f"the gesture reaches {axis} from {values.min():.3f} to "
                             f"{values.max():.3f}: expected 0..1")
    return y, z


def write_path(path, y, z, half_width_mm=50.0):
    """Writes the hand's path for [phantom]: rows `ms x y z`, mm; rows on a straight line are omitted."""
    mm = numpy.round((numpy.stack([y, z]) - 0.5) * 2 * half_width_mm, 4)
    keep = numpy.ones(mm.shape[1], bool)
    bend = numpy.abs(mm[:, 2:] - 2 * mm[:, 1:-1] + mm[:, :-2]).max(axis=0)
    keep[1:-1] = bend > 0
    with open(path, "w") as file:
        file.write("# ms x y z, mm\n")
        for i in numpy.flatnonzero(keep):
            file.write(f"{1000 * i / RATE:.0f} 0 {mm[0, i]:.4f} {mm[1, i]:.4f}\n")
