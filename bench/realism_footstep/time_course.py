"""What a listener's recorder tells of a step in time: energy by time and band, two contacts, decays.

The tables of recorded_steps.py do not say how they were measured. These definitions, found by a search,
reproduce what the tables' authors measured of sixty steps of footstep~ on each of fifteen grounds: energies
within 0.5 dB (median of 315; rounding makes 0.25), levels of peaks and dips within 1 dB, intervals within 4 ms,
decay times within 3 to 14 % (medians over the grounds). Further out are concrete, whose steps were of two
kinds, and carpet, whose sound began slowly.

* The step is trimmed as in features.py. Its onset is where the mean square over 5 ms first lies within
  26 dB of its maximum.
* Energy: frames of 512 samples (23 ms, Hann), a frame's energy at its middle; twenty triangular bands, not
  overlapping, so that they hold half of the energy: all figures lie 3 dB low. Floor: 1e-6 a band.
* Contacts: peaks of the level over 8 ms (Hann) that stand 4 dB above their surroundings, 30 ms apart and
  within 20 dB of the maximum; the first of them, and the highest of those that follow.
* Decay: from the maximum of a band's level over 4 ms (Hann) until it is 20 dB lower."""
from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft
from scipy.ndimage import convolve1d
from scipy.signal import butter, find_peaks, sosfiltfilt

from features import RATE, trim
from recorded_steps import BAND_EDGES_HZ, WINDOW_EDGES_S

FRAME, HOP = 512, 64
FLOOR = 1e-6
ONSET_DB, ONSET_S = 26, 0.005
CONTACT_S, PROMINENCE_DB, APART_S, BELOW_DB = 0.008, 4, 0.03, 20
DECAY_S, DECAY_DB = 0.004, 20
DECAY_BANDS = [butter(2, [low / (RATE / 2), high / (RATE / 2)], "band", output="sos")
               for low, high in ((60, 400), (400, 2000), (2000, 9500))]
ENVELOPE_HOP = 8  # samples
BURST_BAND = butter(2, [1000 / (RATE / 2), 4000 / (RATE / 2)], "band", output="sos")
BURST_FROM_S, BURST_TO_S, BURST_PROMINENCE_DB, BURST_APART_S, BURST_BELOW_DB = 0.12, 0.45, 6, 0.015, 22
CONTACT_NAMES = ("interval_ms", "second_db", "dip_db", "first_ms")


def _triangles():
    frequency = np.fft.rfftfreq(FRAME, 1 / RATE)
    weights = np.zeros((len(BAND_EDGES_HZ) - 1, len(frequency)))
    for row, a, b in zip(weights, BAND_EDGES_HZ, BAND_EDGES_HZ[1:]):
        middle = (a + b) / 2
        row[:] = np.clip(np.minimum(frequency - a, b - frequency) / (middle - a), 0, None)
    return weights


_WEIGHTS = _triangles().T.astype(np.float32)
_HANN = np.hanning(FRAME).astype(np.float32)


def _envelope(x, seconds):
    """Mean square of each row under a Hann window of so many seconds, every ENVELOPE_HOP samples."""
    window = np.hanning(round(seconds * RATE / ENVELOPE_HOP) + 2)[1:-1]
    x = np.pad(x, ((0, 0), (0, -x.shape[1] % ENVELOPE_HOP)))
    blocks = (x * x).reshape(len(x), -1, ENVELOPE_HOP).mean(axis=2)
    return convolve1d(blocks, window / window.sum(), axis=1, mode="constant")


@dataclass
class TimeCourse:
    """Of n steps."""
    levels_db: np.ndarray    # (n, 7, 20): energy of each window and band over the whole
    energy_db: np.ndarray    # (n, 7): of each window
    contacts: np.ndarray     # (n, 4): CONTACT_NAMES; not a number where there is no second, or no peak
    decays_ms: np.ndarray    # (n, 3): below 400 Hz, to 2 kHz, above
    onset_s: np.ndarray      # (n): in the trimmed step

    @property
    def share_of_two(self):
        """Share of steps with two contacts, per cent."""
        return 100 * float(np.mean(np.isfinite(self.contacts[:, 1])))


def _onsets(x):
    width = int(ONSET_S * RATE)
    total = np.cumsum(np.pad(x * x, ((0, 0), (width // 2 + 1, width - width // 2 - 1))), axis=1)
    level = total[:, width:] - total[:, :-width]
    return np.argmax(level > level.max(axis=1, keepdims=True) * 10 ** (-ONSET_DB / 10), axis=1) / RATE


def _levels(x, onset):
    """(n, 7, 20) shares of the energy."""
    padded = np.pad(x, ((0, 0), (FRAME // 2, FRAME))).astype(np.float32)
    frames = np.lib.stride_tricks.sliding_window_view(padded, FRAME, axis=1)[:, ::HOP]
    frames = frames[:, :1 + x.shape[1] // HOP] * _HANN
    spectrum = rfft(frames)
    power = spectrum.real ** 2 + spectrum.imag ** 2
    bands = power @ _WEIGHTS
    total = np.concatenate([np.zeros_like(bands[:, :1]), np.cumsum(bands, axis=1)], axis=1, dtype=float)
    edges = np.ceil((onset[:, None] + WINDOW_EDGES_S) * RATE / HOP).astype(int)
    at = np.take_along_axis(total, np.minimum(edges, total.shape[1] - 1)[:, :, None], axis=1)
    whole = np.maximum(power.sum(axis=(1, 2), dtype=float), 1e-20)
    return np.diff(at, axis=1) / whole[:, None, None]


def _contacts(level, onset):
    """CONTACT_NAMES of one step; level: dB, every ENVELOPE_HOP samples."""
    rate = RATE / ENVELOPE_HOP
    padded = np.concatenate([[-150], level, [-150]])
    peaks = find_peaks(padded, height=level.max() - BELOW_DB, prominence=PROMINENCE_DB,
                       distance=max(1, int(APART_S * rate)))[0] - 1
    if not len(peaks):
        return [np.nan] * 4
    first = peaks[0]
    rise = 1000 * (first / rate - onset)
    later = peaks[peaks - first >= APART_S * rate]
    if not len(later):
        return [np.nan, np.nan, np.nan, rise]
    second = later[np.argmax(level[later])]
    dip = level[first:second].min() - max(level[first], level[second])
    return [1000 * (second - first) / rate, level[second] - level[first], dip, rise]


def _decays(x, ends):
    """(n, 3) ms."""
    found = np.empty((len(x), len(DECAY_BANDS)))
    for column, band in enumerate(DECAY_BANDS):
        power = _envelope(sosfiltfilt(band, x, axis=1), DECAY_S)
        for row, end in enumerate(ends):
            part = power[row, :-(-end // ENVELOPE_HOP)]
            peak = int(np.argmax(part))
            low = part[peak:] < part[peak] * 10 ** (-DECAY_DB / 10)
            count = np.argmax(low) if low.any() else len(low)
            found[row, column] = 1000 * count * ENVELOPE_HOP / RATE
    return found


def time_course(sounds):
    """TimeCourse of sounds at 22.05 kHz, one step each."""
    trimmed = [trim(sound) for sound in sounds]
    ends = [len(t) for t in trimmed]
    x = np.zeros((len(trimmed), max(ends)))
    for row, t in zip(x, trimmed):
        row[:len(t)] = t
    onset = _onsets(x)
    shares = _levels(x, onset) + FLOOR
    level = 10 * np.log10(_envelope(x, CONTACT_S).clip(1e-12))
    contacts = [_contacts(row[:-(-end // ENVELOPE_HOP)], o)
                for row, end, o in zip(level, ends, onset)]
    return TimeCourse(10 * np.log10(shares), 10 * np.log10(shares.sum(axis=2)), np.array(contacts),
                      _decays(x, ends), onset)


def summary_of_contacts(course):
    """Figures in the order of recorded_steps.TWO_CONTACTS."""
    def at(column, *shares):
        values = course.contacts[:, column]
        values = values[np.isfinite(values)]
        return tuple(np.percentile(values, shares)) if len(values) else (np.nan,) * len(shares)
    return (course.share_of_two, at(0, 10, 50, 90), at(1, 10, 50, 90), at(2, 50)[0], at(3, 50, 90),
            tuple(np.median(course.decays_ms, axis=0)))


def bursts(sounds):
    """Of each sound's bursts at 1 to 4 kHz from 0.12 to 0.45 s after the onset, as a creak has them: their
    number; the highest under the step's peak in that band, dB; energy of that time over the time before,
    dB. (n, 3). A burst stands 6 dB above its surroundings, 15 ms from the next, at most 22 dB under the
    peak."""
    found = []
    for sound in sounds:
        x = trim(sound)[None]
        onset = _onsets(x)[0]
        power = _envelope(sosfiltfilt(BURST_BAND, x, axis=1), DECAY_S)[0]
        rate = RATE / ENVELOPE_HOP
        first, last = (min(int((onset + t) * rate), len(power)) for t in (BURST_FROM_S, BURST_TO_S))
        level = 10 * np.log10(power.clip(1e-12))
        peaks = find_peaks(level, height=level.max() - BURST_BELOW_DB, prominence=BURST_PROMINENCE_DB,
                           distance=max(1, int(BURST_APART_S * rate)))[0]
        number = np.sum((peaks >= first) & (peaks < last))
        highest = level[first:last].max() - level.max() if last > first else -60
        energy = 10 * np.log10((power[first:last].sum() + 1e-12) / (power[:first].sum() + 1e-12))
        found.append((number, max(highest, -60), max(energy, -60)))
    return np.array(found)
