"""[particle~] in a headless Pd: statistics, energy, spectra and limits as a patch meets them."""
import itertools
import math

import numpy
import pytest
import scipy.signal
import scipy.stats

from harness import Patch

RATE = 48000
OUTLETS = ("sound", "collisions", "energy")
PRESETS = ("maraca", "sekere", "cabasa", "tambourine", "gravel", "ice", "coins", "rain", "sand", "leaves",
           "bubbles")


def render(words=(), messages=(), power=None, seconds=1.0, rate=RATE, block=64):
    """Sound, collisions and energy; messages are (ms, text); power is a number or samples."""
    patch = Patch(block=block)
    box = patch.obj("particle~", *words)
    if power is not None:
        (patch.signal(power) if numpy.ndim(power) else patch.obj("sig~", power)) >> box
    for ms, message in messages:
        patch.at(ms, box, message)
    for i, name in enumerate(OUTLETS):
        patch.record(name, box[i])
    patch.log("info", box[3])
    return patch.render(seconds, rate=rate, timeout=120)


def double(values):
    return numpy.asarray(values, dtype=float)


@pytest.mark.parametrize("rate", [44100, 48000, 96000])
def test_collisions_are_a_poisson_process_of_rate_count_times_power(rate):
    count, power, seconds = 40, 5, 40
    result = render(("-count", count, "-largest", 2), power=power, seconds=seconds, rate=rate)
    # From 0.3 s on the energy is steady: power * decay, within 2e-3 of it.
    collisions = double(result["collisions"])[int(0.3 * rate):]
    times = numpy.nonzero(collisions)[0] / rate
    expected = count * power * len(collisions) / rate
    assert abs(len(times) - expected) < 4 * math.sqrt(expected)
    assert scipy.stats.kstest(numpy.diff(times), "expon", args=(0, 1 / (count * power))).pvalue > 0.005
    windows = numpy.histogram(times, bins=numpy.arange(0.3, seconds, 0.1))[0]
    # Variance over mean of a Poisson count is 1; its standard error sqrt(2 / 397) = 0.07.
    assert windows.var() / windows.mean() == pytest.approx(1, abs=0.25)


def test_a_shake_of_energy_e_causes_count_times_e_collisions_and_no_more():
    count, shakes = 30, 60
    result = render(("-count", count, "-decay", 0.03, "-attack", 0.001),
                    [(10 + 500 * i, "shake 2") for i in range(shakes)], seconds=shakes / 2 + 0.5)
    number = numpy.count_nonzero(result["collisions"])
    expected = 2 * count * shakes
    # Two collisions in one sample count as one: at 2000 a second and less, 2 % of them.
    assert abs(number - expected) < 4 * math.sqrt(expected) + 0.02 * expected


@pytest.mark.parametrize("decay", [0.02, 0.3])
def test_energy_decays_in_its_time_and_settles_at_power_times_decay(decay):
    struck = double(render(("-decay", decay, "-attack", 1e-4), [(0, "shake 3")])["energy"])
    begin, end = int(0.002 * RATE), int(min(0.9, 10 * decay) * RATE)
    time = numpy.arange(begin, end) / RATE
    slope, offset = numpy.polyfit(time, numpy.log(struck[begin:end]), 1)
    assert -1 / slope == pytest.approx(decay, rel=1e-3)
    # The attack's share of the decay is lost, 1 / (1 - attack / decay) in amplitude.
    assert math.exp(offset) == pytest.approx(3 / (1 - 1e-4 / decay), rel=2e-3)
    fed = double(render(("-decay", decay), power=7, seconds=10 * decay + 0.1)["energy"])
    time = numpy.arange(1, len(fed) + 1) / RATE
    assert fed == pytest.approx(7 * decay * (1 - numpy.exp(-time / decay)), rel=1e-4)


def test_the_energy_of_a_shake_arrives_within_the_attack():
    energy = double(render(("-decay", 0.5, "-attack", 0.1), [(0, "shake 1")])["energy"])
    time = numpy.arange(1, len(energy) + 1) / RATE
    exact = (numpy.exp(-time / 0.5) - numpy.exp(-time / 0.1)) * 0.5 / (0.5 - 0.1)
    assert abs(energy - exact).max() < 1e-3


@pytest.mark.parametrize("frequency", [800, 3200, 9000])
def test_the_spectrum_peaks_at_the_grains_frequency(frequency):
    result = render(("-frequency", frequency, "-quality", 30, "-count", 100, "-length", 0.02),
                    power=20, seconds=6)
    f, power = scipy.signal.welch(double(result["sound"]), RATE, nperseg=4096)
    # A band of Q 30 is 3 % wide; the noise of 12000 grains moves its peak by a part of that.
    assert f[power.argmax()] == pytest.approx(frequency, rel=0.02)
    assert power[f > 2 * frequency].max(initial=0) < 1e-2 * power.max()


def test_a_struck_body_rings_at_its_modes_and_loses_60_db_in_their_time():
    result = render(("-direct", 0, "-count", 3, "-decay", 0.002, "-attack", 1e-4, "-level", 0.05),
                    [(0, "modes 1500 0.8 1 4100 0.3 0.5"), (1, "shake 1")], seconds=0.7)
    struck = numpy.nonzero(result["collisions"])[0]
    assert len(struck) > 0
    ring = double(result["sound"])[struck[-1] + 1:]  # after the last collision the body is free
    for frequency, t60 in ((1500, 0.8), (4100, 0.3)):
        n = numpy.arange(len(ring)) / RATE
        base = numpy.convolve(ring * numpy.exp(-2j * math.pi * frequency * n),
                              numpy.hanning(2402)[1:-1] / 1200, "valid")[:int(0.3 * RATE)]
        time = numpy.arange(len(base)) / RATE
        assert -math.log(1000) / numpy.polyfit(time, numpy.log(abs(base)), 1)[0] == pytest.approx(t60, rel=5e-3)
        drift = numpy.polyfit(time, numpy.unwrap(numpy.angle(base)), 1)[0] / (2 * math.pi)
        assert abs(drift) < 0.2


@pytest.mark.parametrize("kind", ["grains", "bubbles", "rustle"])
def test_the_level_is_that_of_the_equation(kind):
    # rms = level E sqrt((direct^2 + sum g^2) / decay): modes far from each other add their powers.
    level, power, decay, direct = 0.002, 20, 0.05, 0.6
    result = render(("-kind", kind, "-level", level, "-decay", decay, "-direct", direct, "-count", 200,
                     "-largest", 2, "-frequency", 6000, "-length", 0.001, "-quality", 3, "-rise", 0),
                    [(0, "modes 400 0.05 0.5 1300 0.05 1")], power=power, seconds=15)
    sound = double(result["sound"])[int(0.5 * RATE):]
    expected = level * power * decay * math.sqrt((direct ** 2 + 0.5 ** 2 + 1) / decay)
    assert math.sqrt(numpy.mean(sound ** 2)) == pytest.approx(expected, rel=0.04)


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
        sound = double(result["sound"])
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
    patch.at(0, box, "dump")
    patch.at(10, box, "preset bubbles")
    patch.at(20, box, "dump")
    logs = patch.render(0.1).logs["info"]
    first = {atoms[0]: atoms[1:] for ms, atoms in logs if ms < 10}
    then = {atoms[0]: atoms[1:] for ms, atoms in logs if ms > 10}
    assert first["decay"] == [pytest.approx(0.2)] and len(first["modes"]) == 18
    assert first["kind"] == ["grains"] and then["kind"] == ["bubbles"]
    assert then["frequency"] == [3000] and then["modes"] == []
    assert then["gain"] == [0.25] and then["seed"] == [9]


@pytest.mark.parametrize("message, sentence", [
    ("preset moon", "preset moon: expected maraca"),
    ("preset 3", "preset 3: expected maraca"),
    ("shake -1", "shake -1: expected an energy in 0..1000"),
    ("shake much", "shake much: expected an energy in 0..1000"),
    ("shake 1e6", "shake 1000000: expected an energy in 0..1000"),
    ("modes 100 1", "modes: 2 numbers: expected three for each mode, a frequency in 20..20000 Hz"),
    ("modes 100 1 1 5 1 1", "modes: frequency 5 Hz of mode 2: expected 20..20000"),
    ("modes 100 0 1", "modes: time 0 s of mode 1: expected 0.001..60"),
    ("modes 100 1 tin", "modes: gain tin of mode 1: expected 0..100"),
    ("decay 0", "decay 0 s: expected"),
    ("frequency 1e5", "frequency 100000 Hz: expected"),
    ("kind dust", "kind dust: expected"),
    ("shake", "shake: expected 1 argument"),
])
def test_a_bad_message_is_one_error_and_changes_nothing(message, sentence):
    def sound(*more):
        patch = Patch()
        box = patch.obj("particle~", "ice")
        for ms, text in [*more, (20, "bang")]:
            patch.at(ms, box, text)
        patch.record("sound", box)
        return patch.render(0.3, expect_errors=[f"particle~: {sentence}"] if more else [])
    good, bad = sound(), sound((10, message))
    assert len(bad.errors) == 1
    assert good["sound"].any() and numpy.array_equal(good["sound"], bad["sound"])


def test_what_is_no_number_or_endless_stays_finite_and_passes():
    power = numpy.zeros(RATE, dtype=numpy.float32)
    power[1000:2000] = numpy.nan
    power[3000:3100] = numpy.inf
    power[4000:4100] = -numpy.inf
    power[5000:5100] = 1e-40
    power[6000:6100] = -5
    for words in (("coins",), ("bubbles",), ("sand", "-kind", "rustle"),
                  ("rain", "-count", 50000, "-level", 1e4, "-gain", 1000, "-quality", 200, "-length", 1)):
        result = render((*words, "-decay", 0.01), power=power)
        for name in OUTLETS:
            assert numpy.isfinite(result[name]).all(), (words, name)
        assert abs(result["sound"]).max() <= 1
        assert not result["sound"][:3000].any()      # NaN is no power
        assert result["sound"][3000:4000].any()
        assert not result["energy"][-1000:].any()    # 10 ms and 170 dB later it is empty


@pytest.mark.parametrize("preset", ["coins", "bubbles"])
def test_the_bits_do_not_depend_on_the_block_size(preset):
    power = numpy.maximum(0, numpy.sin(numpy.arange(RATE) / 900)).astype(numpy.float32) * 20
    rendered = [render((preset, "-seed", 5), [(0, "shake 1")], power, 0.8, block=block)
                for block in (1, 64, 512, 4096)]
    # A signal reaches a sub-patch of larger blocks when its first is full.
    for name in OUTLETS:
        reference = rendered[0][name][:int(0.7 * RATE)]
        assert reference.any()
        for other in rendered[1:]:
            values = other[name]
            later = numpy.nonzero(values)[0][0] - numpy.nonzero(rendered[0][name])[0][0]
            assert 0 <= later <= 4096
            assert numpy.array_equal(values[later:later + len(reference)], reference), name


def test_a_seed_repeats_and_another_does_not():
    one, again, other = (render(("ice", "-seed", seed), [(10, "bang")], seconds=0.5)["sound"]
                         for seed in (3, 3, 4))
    assert numpy.array_equal(one, again) and not numpy.array_equal(one, other)
    twice = render(("ice", "-seed", 3), [(10, "bang"), (5000, "reset"), (5100, "seed 3"), (5110, "bang")],
                   seconds=5.6)["sound"]
    begin = int(0.1 * RATE)
    first, then = (numpy.trim_zeros(twice[:RATE]), numpy.trim_zeros(twice[5 * RATE:]))
    assert len(first) > begin and numpy.array_equal(first[:begin], then[:begin])


def test_it_is_silent_before_energy_and_after_it():
    result = render(("coins",), [(500, "bang")], seconds=6)
    for name in OUTLETS:
        assert not result[name][:RATE // 2].any()
        assert result[name].any() and not result[name][-RATE // 2:].any()


def test_reset_fades_and_a_shake_within_the_fade_is_not_lost():
    # A steady tone of bubbles that overlap; without a reset it goes on for seconds.
    words = ("bubbles", "-count", 3, "-frequency", 300, "-lower_by_size", 0, "-largest", 1.001, "-rise", 0)
    result = render(words, [(0, "shake 20"), (100, "reset")], seconds=0.4)
    sound = double(result["sound"])
    first = int(0.0995 * RATE)
    assert abs(sound[first - 480:first]).max() > 0.05
    assert not sound[int(0.107 * RATE):].any() and not result["energy"][int(0.107 * RATE):].any()
    # Faded, not cut: no step larger than the tone's own steepest, 2 pi 300 / 48000 of its size, twice.
    tail = sound[first:int(0.107 * RATE)]
    assert abs(numpy.diff(tail)).max() < 0.1 * abs(sound[:first]).max()
    shaken = render(words, [(0, "shake 20"), (100, "reset"), (102, "shake 20")], seconds=0.4)
    assert abs(shaken["sound"][int(0.12 * RATE):]).max() > 0.01


def test_gain_moves_smoothly_and_holds_from_the_first_sample():
    words = ("bubbles", "-count", 30, "-frequency", 300, "-lower_by_size", 0, "-largest", 1.001, "-rise", 0)
    sound = double(render(words, [(0, "shake 3"), (100, "gain 0")], seconds=0.3)["sound"])
    before = abs(sound[:int(0.1 * RATE)])
    begin = int(0.0995 * RATE)
    assert before.max() > 0.05
    assert abs(numpy.diff(sound[begin:])).max() < 0.1 * before.max()
    assert abs(sound[int(0.16 * RATE):]).max() < 1e-4 * before.max()
    loud, soft = (double(render(("ice", "-gain", gain), [(10, "bang")], seconds=0.3)["sound"])
                  for gain in (0.8, 0.2))
    quiet = abs(loud) < 0.5  # what is not clipped
    assert numpy.allclose(loud[quiet], 4 * soft[quiet], atol=1e-6)


def test_another_kind_lets_what_sounds_ring_out():
    words = ("bubbles", "-count", 30, "-frequency", 300, "-lower_by_size", 0, "-largest", 1.001, "-rise", 0,
             "-decay", 0.01)
    alone, changed = (double(render(words, [(0, "shake 1"), *more], seconds=0.4)["sound"])
                      for more in ((), ((150, "kind grains"),)))
    # The energy is empty by then: 30 exp(-15) collisions are to be expected.
    late = alone[int(0.16 * RATE):]
    assert abs(late).max() > 1e-3
    assert numpy.array_equal(alone, changed)


def test_the_impulses_make_any_other_body_sound():
    patch = Patch()
    box = patch.obj("particle~", "maraca")
    patch.at(10, box, "shake 1")
    bar = box[1] >> patch.obj("*~", 2000) >> patch.obj("contact_impact~")
    patch.at(0, bar, "modes 700 0.4 1")
    patch.at(5, bar, "strike 0")
    patch.record("sound", bar)
    sound = double(patch.render(0.5)["sound"])
    f, power = scipy.signal.welch(sound[int(0.1 * RATE):], RATE, nperseg=8192)
    assert f[power.argmax()] == pytest.approx(700, rel=0.05)
