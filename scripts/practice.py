"""A player's practice: plays one [greed~] note by note, to learn the effect of breath and lip."""
import numpy
from harness import Patch

from listening import decibels, envelope, fundamental_db, harmonic_pitch

RATE = 48000
GAP, HOLD, RISE = 0.15, 0.75, 0.008  # s
QUIET = 0.01                         # gain at which the sound stays far below the soft clip


def play(preset, trials, flags=("-tune", 1), hold=HOLD, rise=RISE):
    """Plays trials (pitch Hz or 0, pressure Pa, reed Hz or 0), each from rest, in one run of Pd.

    Returns a list of (sound, level dB of the second half, speaks ms): the sound of each trial, and
    the time until half of its final level is there (nan in silence)."""
    size = int((GAP + hold) * RATE)
    gap = int(GAP * RATE)
    ramp = numpy.minimum(numpy.arange(size - gap) / (rise * RATE), 1)
    pressure = numpy.concatenate([numpy.concatenate([numpy.zeros(gap), p * ramp])
                                  for _, p, _ in trials])
    patch = Patch()
    reed = patch.obj("greed~", "-preset", preset, *flags)
    patch.signal(pressure) >> reed[0]
    # The lip is set first: because `tune` selects the bore for the lip at the time when the note changes.
    lip = numpy.repeat([f for _, _, f in trials], size)
    bore = numpy.roll(numpy.repeat([f for f, _, _ in trials], size), 2048)
    bore[:2048] = trials[0][0]
    patch.signal(lip) >> reed[1]
    patch.signal(bore) >> reed[2]
    patch.record("sound", reed)
    result = patch.render(len(pressure) / RATE, RATE, timeout=600)
    heard = []
    for i in range(len(trials)):
        sound = result["sound"][i * size + gap:(i + 1) * size].astype(float)
        level = numpy.sqrt((sound[len(sound) // 2:] ** 2).mean())
        there = numpy.flatnonzero(envelope(sound, RATE) > 0.5 * level)
        speaks = 1000 * there[0] / RATE if level > 1e-5 else float("nan")
        heard.append((sound, float(decibels(level)), speaks))
    return heard


def pitch_of(sound, expected_hz):
    return harmonic_pitch(sound[len(sound) // 2:], RATE, expected_hz)


def own_settings(preset):
    """The dump of [greed~ -preset NAME]: {word: number}."""
    patch = Patch()
    reed = patch.obj("greed~", "-preset", preset)
    patch.log("info", reed[4])
    patch.at(50, reed, "dump")
    said = patch.render(0.1, RATE).logs["info"]
    return {a[0]: a[1] for _, a in said if len(a) == 2 and not isinstance(a[1], str)}


def reed_frequency(own):
    """The preset's own f_r, Hz, from its closing pressure P_M = k |x_0|/(w lambda_m)."""
    stiffness = own["P_M"] * own["width"] * own["lambda_m"] / abs(own["theta0"] * own["arm"])
    return float(numpy.sqrt(stiffness / own["mass"]) / (2 * numpy.pi))


def plays_its_fundamental(sound, hz):
    """False if another register sounds, that is, if the fundamental is 30 dB below the strongest partial."""
    return fundamental_db(sound[len(sound) // 2:], RATE, hz) > -30


def learn_reed(preset, pitches, frequency, shares=numpy.arange(0.66, 0.80, 0.02)):
    """For a blown-closed reed with `tune 1`: finds the ratio to the closing pressure at which to play, and the extra
    breath that each pitch needs.

    Returns (pressure Pa, reed Hz, {pitch: dB}, gain): the lowest of the shares at which every pitch speaks within 50
    ms, in its first register and within 10 cents; the breath that makes all pitches equally loud (at most 5 dB); and
    the gain of [greed~] with which this mezzo forte peaks at 0.2, so that a fortissimo stays below the soft clip. Below
    two thirds, tongued notes tend to squeak if there is air in the tone. Raises RuntimeError if no share qualifies."""
    own = own_settings(preset)
    lip = reed_frequency(own)
    pitches = sorted(pitches)
    hz = [frequency(p) for p in pitches]
    heard = play(preset, [(f, s * own["P_M"], lip) for s in shares for f in hz],
                 ("-tune", 1, "-gain", QUIET))
    for i, share in enumerate(shares):
        these = heard[i * len(hz):(i + 1) * len(hz)]
        if all(speaks < 50 and plays_its_fundamental(sound, f)
               and abs(1200 * numpy.log2(pitch_of(sound, f) / f)) < 10
               for (sound, _, speaks), f in zip(these, hz)):
            break
    else:
        raise RuntimeError(f"{preset}: no pressure makes every note speak in tune within 50 ms")
    levels = numpy.array([level for _, level, _ in these])
    trims = numpy.clip(numpy.median(levels) - levels, -5, 5)
    peak = max(abs(sound).max() for sound, _, _ in these)
    return (float(share * own["P_M"]), lip, dict(zip(pitches, trims.tolist())),
            float(QUIET * 0.2 / peak))


def learn_lips(preset, pitches, frequency, tongue_burst, slowest=100):
    """For a valve whose lips follow note and breath (`tune 1`, `breath_ref` above 0). Its loudness is proportional to
    the mouth pressure, and every pitch plays from soft to loud.

    Returns (pressure Pa, reed Hz, {pitch: dB}, {pitch: s}, gain): the preset's breath_ref; the change of breath that
    makes all pitches equally loud (-5 to +2 dB); the time that each pitch takes to speak from silence; and the gain at
    which the loudest pitch peaks at 0.25, so that a fortissimo 6 dB louder stays below the soft clip. Raises
    RuntimeError if a pitch is out of tune by 10 cents or takes longer than `slowest` ms to speak."""
    own = own_settings(preset)
    pressure = own["breath_ref"]
    pitches = sorted(pitches)
    hz = [frequency(p) for p in pitches]
    flags = ("-tune", 1, "-gain", QUIET, "-tongue_burst", tongue_burst)
    levels = [level for _, level, _ in play(preset, [(f, pressure, 0) for f in hz], flags)]
    trims = numpy.clip(numpy.median(levels) - levels, -5, 2)
    heard = play(preset, [(f, pressure * 10 ** (d / 20), 0) for f, d in zip(hz, trims)], flags)
    wrong = {f: (off, ms) for f, (sound, _, ms) in zip(hz, heard)
             for off in [1200 * numpy.log2(pitch_of(sound, f) / f)]
             if not (abs(off) < 10 and ms < slowest)}
    if wrong:
        raise RuntimeError(f"{preset}: out of tune or slow to speak: {wrong} (Hz: cents, ms)")
    loud = play(preset, [(f, 2 * pressure * 10 ** (d / 20), 0) for f, d in zip(hz, trims)], flags)
    peak = max(abs(sound[len(sound) // 2:]).max() for sound, *_ in loud)
    return (pressure, reed_frequency(own), dict(zip(pitches, trims.tolist())),
            {p: ms / 1000 for p, (_, _, ms) in zip(pitches, heard)}, float(QUIET * 0.25 / peak))
