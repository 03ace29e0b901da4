#!/usr/bin/python3
"""Checks that a recording begins and ends in silence, does not clip and has no clicks.

    sound_check.py FILE.wav...     prints the faults of each file; status 1 if there are any

Limits are relative to full scale, not to the loudest sample, since the loudspeaker's step is audible.

Ends    The first millisecond and the last 10 ms stay below -60 dB. (A struck body may have full level a few
        milliseconds after the beginning; it may not still sound at the end.)
Clipping  Three or more samples in a row that are equal and the largest of their channel, above -40 dB, or one
        sample beyond full scale. The output of a soft limiter never has equal samples.
Clicks  A jump of the waveform, above -60 dB, that stands out of the sound around it.
        A jump is a step that its neighbours do not have: from one sample to the next the sound moves further than
        just before and just after, in one direction, by about as much; its height is by how much. (A ramp of two
        samples counts where it is four times as steep as the sound.) So a bubble or an impact, which begins with
        a bend, does not jump.
        How far it stands out is measured by the third difference, a filter that rises by 18 dB an octave: a jump
        of height h comes out as h, -2h, h, while sounds fall off towards high frequencies. It is a click where it
        has CLICK_RATIO times the largest third difference around it: within 25 ms on each side, but for the 4
        samples next to it. 25 ms are a period of 40 Hz: the shock waves of a loud trombone jump as well, once a
        period. Of the sounds of ./play none reaches more than 5.7 times; where they were cut off they had 14 and
        more. In a tone of 440 Hz at half scale a jump of 1 % is found, in one of 2 kHz one of 5 %.
"""
import pathlib
import sys

import numpy
import scipy.io.wavfile
import scipy.ndimage

SILENCE = 1e-3         # -60 dB of full scale
START_S, END_S = 0.001, 0.01
CLICK_RATIO, RAMP_RATIO, SYMMETRY = 8.0, 4.0, 0.4
CLICK_AROUND_S, CLICK_NEXT = 0.025, 4
CLIPPED_IN_A_ROW, CLIPPED_ABOVE = 3, 0.01


def decibels(value):
    return 20 * numpy.log10(max(value, 1e-9))


def channels(samples):
    """The samples as float64 of shape (channels, n)."""
    samples = numpy.asarray(samples, float)
    return samples[None] if samples.ndim == 1 else samples.T


def heights(channel):
    """The jump at each sample, relative to full scale; 0 without a jump. Silence is assumed before and after the sound."""
    found = numpy.zeros(len(channel) + 1)
    for width in (1, 2):
        padded = numpy.pad(channel, 2 * width)
        moves = padded[width:] - padded[:-width]
        before, here, after = moves[:-2 * width], moves[width:-width], moves[2 * width:]
        onto, off = here - before, here - after
        jumps = numpy.minimum(abs(onto), abs(off))
        jumps[(onto * off <= 0) | (jumps < SYMMETRY * numpy.maximum(abs(onto), abs(off)))] = 0
        if width == 2:  # counts a ramp only if it is not the steepest part of the sound
            jumps[abs(here) < RAMP_RATIO * numpy.maximum(abs(before), abs(after))] = 0
        numpy.maximum(found, jumps[:len(found)], out=found)
    return found


def prominence(values, rate):
    """The ratio of each value to the largest around it, within CLICK_AROUND_S but without its nearest neighbours."""
    reach = int(CLICK_AROUND_S * rate)
    window = reach - CLICK_NEXT
    largest = scipy.ndimage.maximum_filter1d(numpy.pad(values, 2 * reach), window)
    middle = CLICK_NEXT + 1 + window // 2  # middle of the samples at distances CLICK_NEXT + 1 ... reach
    before = largest[2 * reach - middle:][:len(values)]
    after = largest[2 * reach + middle:][:len(values)]
    return values / numpy.maximum(numpy.maximum(before, after), 1e-12)


def jumps_and_ratios(channel, rate):
    """(height of the jump before each sample, ratio of its third difference to those around it)"""
    bends = abs(numpy.diff(numpy.pad(channel, (2, 2)), 3))
    return heights(channel), prominence(bends, rate)


def clicks(channel, rate):
    """[(s, height)] of the jumps that exceed the sound around them, the highest first."""
    jumps, ratios = jumps_and_ratios(channel, rate)
    found = numpy.flatnonzero((jumps > SILENCE) & (ratios > CLICK_RATIO))
    kept = []
    for index in found[numpy.argsort(-jumps[found])]:
        if all(abs(index - other) > CLICK_NEXT for other, _ in kept):
            kept.append((index, jumps[index]))
    return [(index / rate, height) for index, height in kept]


def clipped(channel):
    """The first sample of the first run at the channel's limit, or None."""
    beyond = numpy.flatnonzero(abs(channel) > 1)
    if len(beyond):
        return int(beyond[0])
    for top in (channel.max(), channel.min()):
        at_top = numpy.flatnonzero(channel == top)
        if abs(top) < CLIPPED_ABOVE or len(at_top) < CLIPPED_IN_A_ROW:
            continue
        runs = numpy.flatnonzero(at_top[CLIPPED_IN_A_ROW - 1:] - at_top[:1 - CLIPPED_IN_A_ROW]
                                 == CLIPPED_IN_A_ROW - 1)
        if len(runs):
            return int(at_top[runs[0]])
    return None


def faults(samples, rate):
    """The faults of a recording of shape (n,) or (n, channels): sentences, empty if there are none."""
    found = []
    for number, channel in enumerate(channels(samples), 1):
        where = f"channel {number}: " if numpy.ndim(samples) > 1 else ""
        if not numpy.isfinite(channel).all():
            found.append(f"{where}not finite at {numpy.argmin(numpy.isfinite(channel)) / rate:.3f} s")
            continue
        start = abs(channel[:max(int(START_S * rate), 1)]).max(initial=0)
        end = abs(channel[-max(int(END_S * rate), 1):]).max(initial=0)
        for word, level in (("starts", start), ("ends", end)):
            if level >= SILENCE:
                found.append(f"{where}{word} at {decibels(level):.0f} dB: expected below {decibels(SILENCE):.0f} dB")
        at = clipped(channel)
        if at is not None:
            found.append(f"{where}clips at {at / rate:.3f} s, at {abs(channel[at]):.3g} of full scale")
        jumps = clicks(channel, rate)
        if jumps:
            time, height = jumps[0]
            found.append(f"{where}{len(jumps)} click{'s' * (len(jumps) > 1)}, the largest at {time:.4f} s, "
                         f"a jump of {height:.2g} of full scale")
    return found


def main():
    bad = False
    for name in sys.argv[1:]:
        rate, samples = scipy.io.wavfile.read(pathlib.Path(name))
        if numpy.issubdtype(samples.dtype, numpy.integer):
            samples = samples / -float(numpy.iinfo(samples.dtype).min)
        for fault in faults(samples, rate):
            bad = True
            print(f"{name}: {fault}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
