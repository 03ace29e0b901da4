"""Measures of sounds: pitch, level, onset of notes, clicks."""
import numpy
import scipy.fft
import scipy.signal


def pitch_near(samples, rate, expected_hz, cents=150):
    """Frequency of the partial nearest to expected_hz (Hann window, parabola through the peak of a
    padded spectrum); nan if there is no distinct peak."""
    x = numpy.asarray(samples, float)
    if len(x) < 4 * rate / expected_hz:
        return float("nan")
    size = scipy.fft.next_fast_len(4 * len(x), real=True)
    spectrum = numpy.abs(scipy.fft.rfft(x * numpy.hanning(len(x)), size))
    low, high = (int(expected_hz * 2 ** (c / 1200) * size / rate) for c in (-cents, cents))
    k = low + int(numpy.argmax(spectrum[low:high + 1]))
    if k in (low, high) or spectrum[k] <= 1e-9 * len(x):
        return float("nan")
    a, b, c = numpy.log(spectrum[k - 1:k + 2] + 1e-30)
    return (k + 0.5 * (a - c) / (a - 2 * b + c)) * rate / size


def harmonic_pitch(samples, rate, expected_hz, harmonics=6, cents=150):
    """The fundamental from several partials, each weighted with its amplitude times its number. It is right even if the
    fundamental itself is weak."""
    x = numpy.asarray(samples, float)
    window = numpy.hanning(len(x))
    found, weights = [], []
    for h in range(1, harmonics + 1):
        if expected_hz * h > 0.4 * rate:
            break
        f = pitch_near(x, rate, expected_hz * h, cents)
        if f == f:
            turn = numpy.exp(-2j * numpy.pi * f * numpy.arange(len(x)) / rate)
            found.append(f / h)
            weights.append(h * abs((x * window * turn).sum()))
    if not found:
        return float("nan")
    found, weights = numpy.array(found), numpy.array(weights)
    middle = found[numpy.argmax(weights)]
    good = abs(found / middle - 1) < 0.01
    return float((found * weights)[good].sum() / weights[good].sum())


def fundamental_db(samples, rate, hz, harmonics=8):
    """Level of the fundamental relative to the strongest harmonic, dB."""
    x = numpy.asarray(samples, float)
    spectrum = numpy.abs(scipy.fft.rfft(x * numpy.hanning(len(x))))
    levels = []
    for h in range(1, harmonics + 1):
        low, high = (int(hz * h * turn * len(x) / rate) for turn in (0.985, 1.015))
        levels.append(spectrum[max(low - 1, 0):high + 2].max(initial=1e-12))
    return float(decibels(levels[0] / max(levels)))


def cents(frequency, reference):
    return 1200 * numpy.log2(frequency / reference)


def decibels(x):
    return 20 * numpy.log10(numpy.maximum(x, 1e-12))


def envelope(samples, rate, window=0.01):
    """Root mean square over a centred Hann window."""
    w = numpy.hanning(int(window * rate) | 1)
    power = scipy.signal.fftconvolve(numpy.asarray(samples, float) ** 2, w / w.sum(), "same")
    return numpy.sqrt(numpy.maximum(power, 0))


def steady(note, skip=0.10):
    """The part of a note that counts for pitch and level, s."""
    return note.onset + min(skip, 0.3 * note.duration), note.end - min(0.05, 0.15 * note.duration)


def track(samples, rate, notes, frequency, step=0.01, window=0.06):
    """Times and deviations from the score in cents, along the notes, from the phase advance of the fundamental."""
    times, values = [], []
    for note in notes:
        f = frequency(note.pitch)
        begin, end = steady(note, 0.05)
        half = max(window, 4 / f) / 2
        for now in numpy.arange(begin + half, end - half, step):
            part = samples[int((now - half) * rate):int((now + half) * rate)]
            times.append(now)
            values.append(cents(pitch_near(part, rate, f, 200), f))
        times.append(end)
        values.append(float("nan"))
    return numpy.array(times), numpy.array(values)


def clicks(samples, rate):
    """Times of sounds above 15 kHz that are shorter than 5 ms, exceed everything within 60 ms on both sides by 6 dB,
    and are louder than -66 dB of full scale. The edges of a beating reed are as bright, once per period, and hide
    smaller clicks. An attack is followed by such edges and does not count."""
    sections = scipy.signal.butter(4, 15000, "high", fs=rate, output="sos")
    high = scipy.signal.sosfiltfilt(sections, numpy.asarray(samples, float))
    frame = int(0.005 * rate)
    peak = abs(high[:len(high) // frame * frame].reshape(-1, frame)).max(axis=1)
    found = []
    for i in numpy.flatnonzero(peak > 10 ** (-66 / 20)):
        before, after = peak[max(i - 12, 0):max(i - 1, 0)], peak[i + 2:i + 13]
        if peak[i] > 2 * max(before.max(initial=0), after.max(initial=0)):
            found.append(i * frame / rate)
    return found


def measure_notes(samples, rate, notes, frequency):
    """One dictionary per note: hz, cents, level_db, speaks_ms (from the onset until half the note's level is reached;
    None for slurred notes), fundamental_db, sustained (0.3 s or more)."""
    loud = envelope(samples, rate)
    rows = []
    for note in notes:
        begin, end = (int(s * rate) for s in steady(note))
        part = samples[begin:end]
        f = frequency(note.pitch)
        heard = harmonic_pitch(part, rate, f)
        level = numpy.sqrt((numpy.asarray(part, float) ** 2).mean())
        start = int((note.onset - 0.08) * rate)
        start += int(numpy.argmin(loud[start:start + int(0.1 * rate)]))
        there = numpy.flatnonzero(loud[start:end] > 0.5 * level)
        rows.append({"hz": heard, "cents": cents(heard, f), "level_db": float(decibels(level)),
                     "speaks_ms": None if note.slurred or not len(there)
                     else 1000 * ((there[0] + start) / rate - note.onset),
                     "fundamental_db": fundamental_db(part, rate, f),
                     "sustained": note.duration >= 0.3})
    return rows
