"""[particle~] in a headless Pd: statistics, energy, spectra and limits as a patch meets them."""
import itertools
import math

import numpy
import pytest
import scipy.signal

from harness import Patch
from harness.sound import RATE

PRESETS = ("maraca", "sekere", "cabasa", "tambourine", "gravel", "ice", "coins", "rain", "sand", "leaves",
           "bubbles")
# Bubbles of one frequency that overlap: a steady tone.
TONE = ("bubbles", "-frequency", 300, "-lower_by_size", 0, "-largest", 1.001, "-rise", 0, "-count")


def render(words=(), messages=(), power=None, seconds=1.0, rate=RATE):
    """Sound, collisions and energy; messages are (ms, text)."""
    patch = Patch()
    box = patch.obj("particle~", *words)
    if power is not None:
        patch.obj("sig~", power) >> box
    for ms, message in messages:
        patch.at(ms, box, message)
    for i, name in enumerate(("sound", "collisions", "energy")):
        patch.record(name, box[i])
    result = patch.render(seconds, rate=rate, timeout=120)
    return {name: samples.astype(float) for name, samples in result.recordings.items()}


@pytest.mark.parametrize("decay, attack", [(0.02, 1e-4), (0.3, 1e-4), (0.5, 0.1)])
def test_the_energy_of_a_shake_comes_with_the_attack_and_goes_with_the_decay(decay, attack):
    energy = render(("-decay", decay, "-attack", attack), [(0, "shake 3")])["energy"]
    time = numpy.arange(1, len(energy) + 1) / RATE
    exact = 3 * (numpy.exp(-time / decay) - numpy.exp(-time / attack)) * decay / (decay - attack)
    assert numpy.allclose(energy[96:], exact[96:], rtol=3e-3, atol=1e-6)
    fed = render(("-decay", decay), power=7, seconds=10 * decay + 0.1)["energy"]
    time = numpy.arange(1, len(fed) + 1) / RATE
    assert numpy.allclose(fed, 7 * decay * (1 - numpy.exp(-time / decay)), rtol=1e-4)


@pytest.mark.parametrize("kind", ["grains", "bubbles", "rustle"])
def test_collisions_number_and_energies_and_the_level_are_those_of_the_equations(kind):
    # rms = level E sqrt((direct^2 + sum g^2) / decay): modes far from each other add their powers.
    level, power, decay, direct, count = 0.002, 20, 0.05, 0.6, 200
    result = render(("-kind", kind, "-level", level, "-decay", decay, "-direct", direct, "-count", count,
                     "-exponent", 0.5, "-largest", 3, "-frequency", 6000, "-length", 0.001, "-quality", 3, "-rise", 0),
                    [(0, "modes 400 0.05 0.5 1300 0.05 1")], power=power, seconds=8)
    expected = level * power * decay * math.sqrt((direct ** 2 + 0.5 ** 2 + 1) / decay)
    assert math.sqrt(numpy.mean(result["sound"][int(0.5 * RATE):] ** 2)) == pytest.approx(expected, rel=0.05)
    collisions = result["collisions"][int(0.5 * RATE):]
    energy = collisions[collisions != 0] ** 2
    if kind == "rustle":  # is a noise
        assert not len(energy)
    else:  # within four standard deviations, as samples may hold two
        assert len(energy) / len(collisions) == pytest.approx(1 - math.exp(-count * power / RATE), rel=0.025)
        assert numpy.median(energy) / energy.min() == pytest.approx((0.5 + 0.5 * 3 ** -0.5) ** -2, rel=0.05)


def bands(sound):
    """Power in dB in third octaves from 200 Hz to 16 kHz, over the sum."""
    f, power = scipy.signal.welch(sound, RATE, nperseg=2048)
    edges = 200 * 2 ** (numpy.arange(20) / 3)
    sums = numpy.array([power[(f >= a) & (f < b)].sum() for a, b in itertools.pairwise(edges)])
    return 10 * numpy.log10(sums / sums.sum() + 1e-7)


def test_presets_are_heard_alike_have_headroom_and_differ():
    described = {}
    for name in PRESETS:
        result = render((name,), [(50 + 500 * i, "shake 1") for i in range(12)], seconds=6.2)
        sound = result["sound"]
        assert not sound[:int(0.05 * RATE)].any()
        assert 0.1 < abs(sound).max() < 0.9, name
        # 12 shakes of 24 to 600 collisions: a shake is heard, and its loudest sample seldom clips.
        assert numpy.mean(abs(sound) > 0.5) < 2e-3, name
        each = sound[int(0.05 * RATE):int(6.05 * RATE)].reshape(12, -1)
        assert (abs(each).max(axis=1) > 0.03).all(), name
        rate = numpy.count_nonzero(result["collisions"]) / 12
        time = numpy.arange(each.shape[1]) / RATE
        length = (each ** 2 * time).sum() / (each ** 2).sum()
        described[name] = (bands(sound), 10 * math.log10(rate), 10 * math.log10(length))
    for (one, a), (other, b) in itertools.combinations(described.items(), 2):
        apart = [numpy.sqrt(numpy.mean((a[0] - b[0]) ** 2)), abs(a[1] - b[1]), abs(a[2] - b[2])]
        assert max(apart) > 3, f"{one} and {other} are as good as the same: {apart}"


def test_a_preset_sets_every_number_and_keeps_gain_and_seed():
    patch = Patch()
    box = patch.obj("particle~", "coins", "-gain", 0.25, "-seed", 9, "-decay", 0.2)
    patch.log("info", box[3])
    for ms, message in ((0, "dump"), (10, "preset bubbles"), (20, "dump")):
        patch.at(ms, box, message)
    logs = patch.render(0.1).logs["info"]
    first, then = ({atoms[0]: atoms[1:] for ms, atoms in logs if ms // 10 == at} for at in (0, 2))
    assert first["decay"] == [pytest.approx(0.2)] and len(first["modes"]) == 18
    assert (first["kind"], then["kind"]) == (["grains"], ["bubbles"])
    assert then["frequency"] == [3000] and then["modes"] == []
    assert then["gain"] == [0.25] and then["seed"] == [9]


def test_a_seed_repeats_also_after_a_reset_and_another_does_not():
    one, other = (render(("ice", "-seed", seed), [(10, "bang")], seconds=0.5)["sound"] for seed in (3, 4))
    assert not numpy.array_equal(one, other)
    twice = render(("ice", "-seed", 3), [(10, "bang"), (5000, "reset"), (5100, "seed 3"), (5110, "bang")],
                   seconds=5.6)["sound"]
    first, then = (numpy.trim_zeros(part)[:RATE // 10] for part in (twice[:RATE], twice[5 * RATE:]))
    assert numpy.array_equal(first, numpy.trim_zeros(one)[:RATE // 10]) and numpy.array_equal(first, then)
    # Silent before energy and after it.
    assert not twice[:480 - 64].any() and not twice[4 * RATE:5 * RATE].any()


def test_gain_moves_smoothly_and_holds_from_the_first_sample():
    sound = render((*TONE, 30), [(0, "shake 3"), (100, "gain 0")], seconds=0.3)["sound"]
    before = abs(sound[:int(0.1 * RATE)])
    assert before.max() > 0.05
    assert abs(numpy.diff(sound[int(0.0995 * RATE):])).max() < 0.1 * before.max()
    assert abs(sound[int(0.16 * RATE):]).max() < 1e-4 * before.max()
    loud, soft = (render(("ice", "-gain", gain), [(10, "bang")], seconds=0.3)["sound"] for gain in (0.8, 0.2))
    quiet = abs(loud) < 0.5  # what is not clipped
    assert numpy.allclose(loud[quiet], 4 * soft[quiet], atol=1e-6)
