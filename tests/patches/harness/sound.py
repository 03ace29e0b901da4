"""Measures of a recorded sound: levels, spectra, pitches."""
import numpy

RATE = 48000


def part(sound, begin, end=None, rate=RATE):
    """The samples between two times in s."""
    return numpy.asarray(sound[int(begin * rate):None if end is None else int(end * rate)], dtype=float)


def level(sound):
    """dB of full scale, without what stands still."""
    return 20 * numpy.log10(max(numpy.std(sound, dtype=float), 1e-9))


def spectrum(sound, rate=RATE, size=1 << 19, window=numpy.hanning):
    """Frequencies in Hz and magnitudes, zero-padded."""
    size = max(size, len(sound))
    sound = numpy.asarray(sound, float)
    return (numpy.fft.rfftfreq(size, 1 / rate),
            abs(numpy.fft.rfft((sound - sound.mean()) * window(len(sound)), size)))


def peak(sound, low, high, rate=RATE, window=numpy.blackman):
    """Frequency in Hz of the highest peak between two others, by a parabola through the logarithm."""
    hz, magnitude = spectrum(sound, rate, window=window)
    near = (hz >= low) & (hz <= high)
    top = numpy.flatnonzero(near)[magnitude[near].argmax()]
    a, b, c = numpy.log(magnitude[top - 1:top + 2] + 1e-30)
    return (top + 0.5 * (a - c) / (a - 2 * b + c)) * hz[1]


def component(sound, hz, rate=RATE):
    """Amplitude of a sinusoid of that frequency."""
    window = numpy.hanning(len(sound))
    turns = numpy.exp(-2j * numpy.pi * hz / rate * numpy.arange(len(sound)))
    return 2 * abs(((sound - numpy.mean(sound)) * window * turns).sum()) / window.sum()


def centroid(sound, rate=RATE):
    """Centre of gravity of the power spectrum, Hz."""
    power = abs(numpy.fft.rfft(sound)) ** 2
    return (power * numpy.fft.rfftfreq(len(sound), 1 / rate)).sum() / power.sum()


def far_from_tones(sound, tones, width, rate=RATE):
    """Energy further than `width` Hz from all tones, over the whole, dB: a click shows there."""
    hz, magnitude = spectrum(sound, rate, len(sound), numpy.blackman)
    far = numpy.min([abs(hz - tone) for tone in tones], axis=0) > width
    return 10 * numpy.log10((magnitude[far] ** 2).sum() / (magnitude ** 2).sum())


def cents(hz, reference):
    return 1200 * numpy.log2(hz / reference)
