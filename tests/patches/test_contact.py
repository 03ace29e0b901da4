"""[contact_impact~] and [contact_friction~] in a headless Pd: the physics as a patch hears it."""
import math

import numpy
import pytest
from scipy.special import lambertw

from harness import Patch


def strike(rate, messages, seconds=1.0, arguments=(), press=0):
    """Sound, force and impacts (duration in ms, impulse in N s)."""
    patch = Patch()
    voice = patch.obj("sig~", press) >> patch.obj("contact_impact~", *arguments)
    for time, message in messages:
        patch.at(time, voice, message)
    patch.record("sound", voice[0])
    patch.record("contact", voice[1])
    patch.log("blow", voice[2])
    return patch.render(seconds, rate=rate)


def impacts(result):
    return [[a for a in atoms if not isinstance(a, str)] for _, atoms in result.logs["blow"]]


def restitution(mu_v):
    return float((1 + lambertw(-math.exp(-1 - mu_v + math.log1p(mu_v))).real) / mu_v)


@pytest.mark.parametrize("rate", [44100, 48000, 96000])
def test_an_impact_on_a_heavy_body_has_the_impulse_of_theory_at_any_rate(rate):
    speed, mass, loss = 2, 0.02, 0.6
    result = strike(rate, [(10, ["strike", speed])], 0.3,
                    ("-body", 1e5, "-mass", mass, "-dissipation", loss))
    assert len(impacts(result)) == 1
    _, impulse = impacts(result)[0]
    expected = mass * speed * (1 + restitution(loss * speed))
    assert impulse == pytest.approx(expected, rel=1e-3)
    # The contact outlet is the same impulse, sample by sample.
    assert numpy.sum(result["contact"]) / rate == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("exponent", [1, 1.5, 2.3])
def test_on_a_rigid_wall_a_mass_rebounds_as_theory_says_and_nothing_sounds(exponent):
    speed, mass, loss, stiffness = 1.5, 0.02, 0.3, 1e7
    result = strike(48000, [(0, "modes none"), (10, ["strike", speed])], 0.3,
                    ("-mass", mass, "-dissipation", loss, "-stiffness", stiffness, "-exponent", exponent))
    assert len(impacts(result)) == 1
    duration, impulse = impacts(result)[0]
    assert impulse == pytest.approx(mass * speed * (1 + restitution(loss * speed)), rel=1e-3)
    # Without loss: the integral of the motion, sqrt(pi) Gamma(1 + b)/Gamma(1/2 + b) 2 x/v, b = 1/(a + 1).
    b = 1 / (exponent + 1)
    deepest = (mass * speed ** 2 * (exponent + 1) / (2 * stiffness)) ** b
    elastic = math.sqrt(math.pi) * math.gamma(1 + b) / math.gamma(.5 + b) * 2 * deepest / speed
    assert elastic < duration / 1000 < 1.25 * elastic  # loss makes it longer
    assert not numpy.any(result["sound"])
    again = strike(48000, [(0, "modes none"), (0, "dissipation 0"), (10, ["strike", speed])], 0.3,
                   ("-mass", mass, "-stiffness", stiffness, "-exponent", exponent))
    assert impacts(again)[0][0] / 1000 == pytest.approx(elastic, rel=5e-3)
    assert impacts(again)[0][1] == pytest.approx(2 * mass * speed, rel=1e-3)


def test_a_body_after_a_wall_sounds_again():
    result = strike(48000, [(0, "modes none"), (10, "strike 1"), (200, "modes 440 .5 1"), (210, "strike 1")], .5)
    sound = abs(numpy.asarray(result["sound"], float))
    assert not sound[:9600].any() and sound[10100:].max() > .01


def test_a_struck_bar_rings_at_its_frequency_and_decays_in_its_time():
    rate = 48000
    result = strike(rate, [(0, "modes 440 0.5 1"), (10, "strike 0.2")])
    sound = numpy.asarray(result["sound"], dtype=float)[int(0.1 * rate):int(0.6 * rate)]
    n = numpy.arange(len(sound)) / rate
    analytic = sound * numpy.exp(-2j * math.pi * 440 * n)
    smooth = numpy.convolve(analytic, numpy.hanning(2401) / 1200, "valid")
    slope = numpy.polyfit(numpy.arange(len(smooth)) / rate, numpy.log(abs(smooth)), 1)[0]
    turn = numpy.polyfit(numpy.arange(len(smooth)) / rate, numpy.unwrap(numpy.angle(smooth)), 1)[0]
    assert -math.log(1000) / slope == pytest.approx(0.5, rel=1e-3)
    assert abs(turn) / (2 * math.pi) < 0.01


def test_a_dropped_ball_bounces_as_high_as_its_restitution_says():
    result = strike(48000, [(0, "gravity 9.81"), (10, "drop 100")], 1.0,
                    ("-body", 1e5, "-mass", 0.01, "-dissipation", 0.05, "-stiffness", 1e9))
    impulses = [impulse for _, impulse in impacts(result)]
    speed = math.sqrt(2 * 9.81 * 0.1)
    for impulse in impulses[:3]:
        e = restitution(0.05 * speed)
        assert impulse == pytest.approx(0.01 * speed * (1 + e), rel=2e-3)
        speed *= e
    assert len(impulses) >= 3


def rub(normal, speed, seconds=1.0, rate=48000, arguments=(), messages=()):
    patch = Patch()
    velocity = patch.obj("sig~", speed)
    voice = velocity >> patch.obj("contact_friction~", *arguments)
    patch.obj("sig~", normal) >> voice[1]
    for time, message in messages:
        patch.at(time, voice, message)
    patch.record("sound", voice[0])
    patch.record("friction", voice[1])
    return patch.render(seconds, rate=rate)


def test_a_rubbed_body_speaks_with_the_pitch_of_theory():
    # The third of the rubbed oscillators of docs/contact.md: 600.798 Hz.
    result = rub(20, 0.1, 1.0, 44100, ("-body", 0.05), [(0, f"modes 600 {math.log(1000) / 20} 1")])
    sound = numpy.asarray(result["sound"], dtype=float)[-22050:]
    sound = sound - sound.mean()
    up = numpy.nonzero((sound[:-1] < 0) & (sound[1:] >= 0))[0]
    crossings = up - sound[up] / (sound[up + 1] - sound[up])
    assert 44100 * (len(up) - 1) / (crossings[-1] - crossings[0]) == pytest.approx(600.798, rel=1e-3)


def test_nothing_rubs_without_a_normal_force_and_sliding_has_the_dynamic_coefficient():
    silent = rub(0, 0.3)
    assert not numpy.any(silent["sound"]) and not numpy.any(silent["friction"])
    fast = rub(10, 2.0, arguments=("-viscosity", 0, "-dynamic", 0.3, "-body", 10))
    assert numpy.mean(fast["friction"][-4800:]) == pytest.approx(3, rel=1e-2)


@pytest.mark.parametrize("message, sentence", [
    ("strike 2000", "strike 2000: expected a velocity in -1000..1000 m/s"),
    ("strike hard", "strike hard: expected a velocity"),
    ("drop -1", "drop -1: expected a height in 0..100000 mm"),
    ("pickup 1 loud", "pickup 1 loud: expected gains in -100..100"),
    ("modes 412 6", "modes: 2 numbers: expected three for each mode, a frequency in 1..20000 Hz, a time in 0.001..1000 s"),
    ("modes 412 6 1 825 0 1", "modes: time 0 s of mode 2: expected 0.001..1000"),
    ("modes 412 6 1 825 2 1000", "modes: gain 1000 of mode 2: expected -100..100"),
    ("modes 412 6 1 high 2 1", "modes: frequency high Hz of mode 2: expected 1..20000"),
    ("pickup " + "1 " * 60 + "1000", "pickup 1 1 1 1 1 1 1 1 \\.\\.\\.: expected gains"),
    ("pickup " + "w" * 200, "pickup " + "w" * 120 + "\\.\\.\\.: expected gains"),
])
def test_a_mistake_is_answered_with_one_sentence_that_names_the_value(message, sentence):
    patch = Patch()
    box = patch.obj("contact_impact~")
    patch.at(10, box, message)
    result = patch.render(0.1, expect_errors=[f"contact_impact~: {sentence}"])
    assert len(result.errors) == 1
