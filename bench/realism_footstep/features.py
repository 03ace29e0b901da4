"""45 numbers that tell footsteps apart: spectrum, its change, time course, events, tonality.

Sounds are cut to 1.2 s, limited to 11 kHz and brought to the same energy, so that neither level nor
length of a recording counts.
"""
import math

import numpy as np
from scipy.fft import dct
from scipy.io import wavfile
from scipy.signal import butter, resample_poly, sosfiltfilt

RATE = 22050
LONGEST = 1.2  # s
SHORTEST = 0.06
FRAME, HOP, BANDS = 512, 128, 26
FREQUENCY = np.fft.rfftfreq(FRAME, 1 / RATE)
WINDOW = np.hanning(FRAME)
SMALL = 1e-12
VECTOR = """cepstrum_1 cepstrum_2 cepstrum_3 cepstrum_4 cepstrum_5 cepstrum_6 cepstrum_7 cepstrum_8 cepstrum_9
    cepstrum_10 cepstrum_11 cepstrum_12 frames_1 frames_2 frames_3 frames_4 frames_5 duration attack
    middle skew crest kurtosis decay20 density events centroid bandwidth rolloff flatness crossings
    centroid_spread peakiness harmonicity flux high_3hz high_12hz high_40hz high_120hz high_depth
    low_3hz low_12hz low_40hz low_120hz low_depth""".split()


def mel_centres():
    """Edges and centres of the bands, Hz: even on the mel scale from 60 to 9500 Hz."""
    low, high = (2595 * np.log10(1 + f / 700) for f in (60, 9500))
    return 700 * (10 ** (np.linspace(low, high, BANDS + 2) / 2595) - 1)


def band_weights():
    edges = mel_centres()
    weights = np.zeros((BANDS, len(FREQUENCY)))
    for i, (a, b, c) in enumerate(zip(edges, edges[1:], edges[2:])):
        rise, fall = (FREQUENCY - a) / (b - a), (c - FREQUENCY) / (c - b)
        weights[i] = np.clip(np.minimum(rise, fall), 0, None)
        if not weights[i].any():
            weights[i, np.argmin(abs(FREQUENCY - b))] = 1
    return weights


WEIGHTS = band_weights()


def high_pass(order, hz):
    return butter(order, hz / (RATE / 2), "high", output="sos")


RUMBLE, BRIGHT = high_pass(2, 60), high_pass(2, 1500)
TWO_BANDS = [butter(2, [lo / (RATE / 2), hi / (RATE / 2)], "band", output="sos")
             for lo, hi in ((2500, 9500), (150, 1000))]


def to_rate(samples, rate):
    """Mono at 22.05 kHz."""
    x = np.asarray(samples, float)
    if x.ndim > 1:
        x = x.mean(axis=1)
    if rate == RATE:
        return x
    common = math.gcd(int(rate), RATE)
    return resample_poly(x, RATE // common, int(rate) // common)


def load(path):
    rate, x = wavfile.read(path)
    if x.dtype.kind in "iu":
        offset = 128 if x.dtype.kind == "u" else 0
        x = (x.astype(float) - offset) / np.iinfo(np.int16 if offset else x.dtype).max
    return to_rate(x, rate)


def smooth(x, window):
    return np.convolve(x, window / window.sum(), "same")


def trim(x):
    """From 5 ms before the sound is within 35 dB of its peak until it stays 45 dB below."""
    x = np.nan_to_num(x - np.mean(x))
    if len(x) > 50:
        x = sosfiltfilt(RUMBLE, x)
    width = int(0.005 * RATE)
    level = np.sqrt(smooth(x * x, np.ones(width)))
    peak = level.max()
    if peak <= 0:
        return np.zeros(RATE // 4)
    start = max(0, np.argmax(level > peak * 10 ** (-35 / 20)) - width)
    stop = start + int(LONGEST * RATE)
    x, level = x[start:stop], level[start:stop]
    last = len(level) - np.argmax(level[::-1] > peak * 10 ** (-45 / 20))
    shortest = int(SHORTEST * RATE)
    x = x[:max(last, shortest)]
    x = np.pad(x, (0, max(0, shortest - len(x))))
    return x / np.sqrt(np.sum(x * x) + SMALL)


def modulation(x, band):
    """How the envelope of a band moves: log shares of 3-12, 12-40, 40-120, 120-340 Hz, and depth."""
    envelope = abs(sosfiltfilt(band, x))
    envelope = envelope[:len(envelope) // 32 * 32].reshape(-1, 32).mean(axis=1)
    envelope = envelope / (envelope.mean() + SMALL)
    power = abs(np.fft.rfft(envelope - envelope.mean(), 512)) ** 2
    f = np.fft.rfftfreq(512, 32 / RATE)
    whole = power[f > 3].sum() + SMALL
    shares = [np.log10(power[(f > a) & (f <= b)].sum() / whole + 1e-3)
              for a, b in ((3, 12), (12, 40), (40, 120), (120, 340))]
    return shares + [np.std(envelope)]


def peakiness(x):
    """Log ratio of maximum to mean power within 59 narrow bands, weighed by their power."""
    size = 8192 if len(x) < 8192 else 32768
    power = abs(np.fft.rfft(x * np.hanning(len(x)), size)) ** 2
    f = np.fft.rfftfreq(size, 1 / RATE)
    edges = np.searchsorted(f, np.geomspace(80, 9000, 60))
    ratios, weights = [], []
    for a, b in zip(edges, edges[1:]):
        part = power[a:b]
        if len(part) > 2:
            ratios.append(part.max() / (part.mean() + 1e-18))
            weights.append(part.sum())
    return np.log(np.dot(ratios, weights) / np.sum(weights))


def harmonicity(x, peak):
    """Highest autocorrelation, 120 to 2000 Hz, of 140 ms around the loudest moment."""
    part = x[max(0, peak - int(0.02 * RATE)):peak + int(0.12 * RATE)]
    spectrum = np.fft.rfft(part, 2 * len(part))
    correlation = np.fft.irfft(abs(spectrum) ** 2)[:len(part)]
    correlation = correlation / (correlation[0] + 1e-15)
    first, last = RATE // 2000, min(RATE // 120, len(correlation) - 2)
    first = max(first, int(np.argmax(correlation < 0)))
    return correlation[first:last].max() if last > first else 0.0


def events(x):
    """Number of peaks above 15 % in the envelope above 1.5 kHz, 4 ms apart."""
    envelope = np.convolve(abs(sosfiltfilt(BRIGHT, x)), np.hanning(45) / 22, "same")
    gap = int(0.004 * RATE)
    if len(x) <= 2 * gap:
        return 0
    from scipy.ndimage import maximum_filter1d
    # The largest of the gap before and of the gap less one after.
    around = maximum_filter1d(envelope, 2 * gap)
    inside = slice(gap, len(x) - gap)
    high = envelope > 0.15 * envelope.max()
    return int((high & (envelope >= around))[inside].sum())


def features(sound):
    """(vector of 45 numbers, dictionary of those with a meaning of their own, 26 bands in dB)."""
    x = trim(sound)
    count = len(x)
    padded = np.pad(x, (FRAME // 2, FRAME))
    frames = np.lib.stride_tricks.sliding_window_view(padded, FRAME)[::HOP][:1 + count // HOP]
    power = abs(np.fft.rfft(frames * WINDOW)) ** 2
    energy = power.sum(axis=1) + SMALL
    weight = energy / energy.sum()
    bands = power @ WEIGHTS.T
    total = bands.sum()
    profile = 10 * np.log10(bands.sum(axis=0) / total + 1e-6)
    cepstrum = dct(profile, norm="ortho")[1:13]

    levels = 10 * np.log10(bands / total + 1e-7)
    loud = np.sqrt(weight)
    loud /= loud.sum()
    mean_level = loud @ levels
    deviation = np.sqrt(loud @ (levels - mean_level) ** 2)
    flux = (loud[1:, None] * np.clip(np.diff(levels, axis=0), 0, None)).sum() / BANDS

    centroid = power @ FREQUENCY / energy
    bandwidth = np.sqrt(np.clip(power @ FREQUENCY ** 2 / energy - centroid ** 2, 0, None))
    rolloff = FREQUENCY[np.argmax(np.cumsum(power, axis=1) / energy[:, None] >= 0.85, axis=1)]
    part = power[:, 4:220] + SMALL
    flatness = np.exp(np.log(part).mean(axis=1)) / power[:, 4:220].clip(SMALL).mean(axis=1)
    c, b, r, fl = (float(weight @ v) for v in (centroid, bandwidth, rolloff, flatness))
    c_deviation = np.sqrt(weight @ (centroid - c) ** 2)
    crossings = np.mean(abs(np.diff(np.sign(x))) > 0) * RATE

    envelope = np.sqrt(smooth(x * x, np.hanning(int(0.003 * RATE))).clip(0)) + 1e-9
    passed = np.cumsum(x * x)
    time = np.arange(count) / RATE
    t05, t50, t95 = (time[min(np.searchsorted(passed / passed[-1], q), count - 1)]
                     for q in (0.05, 0.5, 0.95))
    peak = int(np.argmax(envelope))
    attack = max((peak - np.argmax(envelope > 0.1 * envelope[peak])) / RATE, 1e-3)
    duration = max(t95 - t05, 2e-3)
    middle = (time * x * x).sum() / max(time[-1], 1e-3)
    inside = x[(time >= t05) & (time <= t95)]
    crest = abs(x).max() / np.sqrt(np.mean(inside ** 2) + 1e-15)
    kurtosis = np.mean(x ** 4) / (np.mean(x ** 2) ** 2 + 1e-15)
    tail = envelope[peak:] < 0.1 * envelope[peak]
    decay = (np.argmax(tail) if tail.any() else len(tail)) / RATE
    number = events(x)
    density = number / max(duration, 0.03)
    peaky, harmonic = peakiness(x), harmonicity(x, peak)

    named = {"duration_s": duration, "attack_s": attack, "centroid_hz": c, "rolloff85_hz": r,
             "flatness": fl, "crest": crest, "event_density_hz": density, "decay20_s": decay,
             "low_band_share": power[:, FREQUENCY < 400].sum() / power.sum(), "peakiness": peaky,
             "harmonicity": harmonic}
    log = np.log
    vector = [*cepstrum, *dct(deviation, norm="ortho")[:5], log(duration), log(attack),
              log(middle + 0.005), 2 * (t50 - t05) / duration, log(crest), log(kurtosis),
              log(decay + 0.003), log(density + 3), log(number + 1), log(c), log(b + 50), log(r + 50),
              log(fl + 1e-3), log(crossings + 50), log(c_deviation + 50), peaky, 2 * harmonic, flux,
              *modulation(x, TWO_BANDS[0]), *modulation(x, TWO_BANDS[1])]
    return np.nan_to_num(np.array(vector)), named, profile
