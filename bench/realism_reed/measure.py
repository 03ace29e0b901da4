"""What a sustained note sounds like, in numbers: harmonics, brightness, attack, pitch."""

from dataclasses import dataclass

import numpy as np

HARMONICS = 10
FLOOR_DB = -40.0
STEADY = (0.4, 1.2)  # seconds after the onset
ENVELOPE_S = 0.01    # length of the envelope's running rms


@dataclass
class Note:
    frequency: float       # Hz, measured
    harmonics: np.ndarray  # H1..H10, dB relative to the strongest of them
    centroid: float        # of the power spectrum, in multiples of the frequency
    attack: float          # s, 5 % to 90 % of the envelope's maximum
    rms: float
    peak: float


def envelope(sound: np.ndarray, rate: float, window: float = ENVELOPE_S) -> np.ndarray:
    """Running rms over `window` seconds, centred."""
    length = max(1, int(window * rate))
    total = np.concatenate([[0.0], np.cumsum(sound**2)])
    ends = np.arange(sound.size)
    low = np.clip(ends - length // 2, 0, sound.size)
    high = np.clip(ends + (length + 1) // 2, 0, sound.size)
    return np.sqrt(np.maximum(total[high] - total[low], 0) / length)


def spectrum(sound: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and amplitudes under a Blackman-Harris window, four times zero-padded."""
    n = np.arange(sound.size) / sound.size
    window = sum(a * np.cos(2 * np.pi * k * n) for k, a in
                 enumerate((0.35875, -0.48829, 0.14128, -0.01168)))
    padded = 4 * sound.size
    amplitude = np.abs(np.fft.rfft((sound - sound.mean()) * window, padded)) * 2 / window.sum()
    return np.fft.rfftfreq(padded, 1 / rate), amplitude


def peak_in(frequencies, amplitudes, low, high) -> tuple[float, float]:
    """Frequency and amplitude of the largest peak in a band, by a parabola through decibels."""
    band = np.flatnonzero((frequencies >= low) & (frequencies <= high))
    if band.size < 3:
        return 0.0, 0.0
    at = int(np.clip(band[np.argmax(amplitudes[band])], 1, amplitudes.size - 2))
    left, middle, right = np.log(amplitudes[at - 1:at + 2] + 1e-30)
    bend = left - 2 * middle + right
    shift = np.clip(0.5 * (left - right) / bend, -0.5, 0.5) if bend < 0 else 0.0
    spacing = frequencies[1] - frequencies[0]
    return frequencies[at] + shift * spacing, float(np.exp(middle - 0.25 * (left - right) * shift))


def pitch(frequencies, amplitudes, near: float) -> float:
    """Fundamental within a semitone and a half of `near`, from the strongest harmonics."""
    estimates = []
    for n in range(1, HARMONICS + 1):
        frequency, amplitude = peak_in(frequencies, amplitudes, n * near * 0.92, n * near * 1.08)
        if n > 1 and estimates:  # a higher harmonic is looked for where the lower ones point
            centre = np.median([f for f, _, _ in estimates])
            frequency, amplitude = peak_in(frequencies, amplitudes, (n - 0.4) * centre,
                                           (n + 0.4) * centre)
        if amplitude > 0:
            estimates.append((frequency / n, amplitude, n))
    if not estimates:
        return 0.0
    return max(estimates, key=lambda e: e[1] * np.sqrt(e[2]))[0]


def measure(sound: np.ndarray, rate: float, near: float) -> Note:
    """Measures one note that begins somewhere in `sound`; `near` is the pitch meant, Hz."""
    loudness = envelope(sound, rate)
    top = loudness.max()
    if not top > 1e-6:
        return Note(0.0, np.full(HARMONICS, FLOOR_DB), 0.0, 0.0, 0.0, 0.0)
    onset = int(np.argmax(loudness >= 0.05 * top))
    full = int(np.argmax(loudness >= 0.9 * top))
    steady = sound[onset + int(STEADY[0] * rate):onset + int(STEADY[1] * rate)]
    if steady.size < 0.2 * rate:  # it began too late to be a note
        return Note(0.0, np.full(HARMONICS, FLOOR_DB), 0.0, 0.0, 0.0, 0.0)
    frequencies, amplitudes = spectrum(steady, rate)
    f0 = pitch(frequencies, amplitudes, near)
    if not f0 > 0:
        f0 = near
    levels = np.array([peak_in(frequencies, amplitudes, (n - 0.25) * f0, (n + 0.25) * f0)[1]
                       for n in range(1, HARMONICS + 1)])
    decibels = 20 * np.log10(np.maximum(levels, 1e-12) / max(levels.max(), 1e-12))
    audible = frequencies > 20
    power = amplitudes[audible]**2
    centroid = float((frequencies[audible] * power).sum() / power.sum() / f0)
    return Note(f0, decibels, centroid, (full - onset) / rate, float(np.sqrt((steady**2).mean())),
                float(np.abs(sound).max()))


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Root-mean-square difference of two rows of harmonics, dB; below -40 dB counts as -40."""
    return float(np.sqrt(np.mean((np.maximum(one, FLOOR_DB) - np.maximum(other, FLOOR_DB))**2)))


def cents(frequency: float, wanted: float) -> float:
    return 1200 * np.log2(frequency / wanted) if frequency > 0 else float("nan")
