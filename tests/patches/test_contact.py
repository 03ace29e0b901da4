"""[contact_impact~] and [contact_friction~] in a headless Pd: the physics as a patch hears it."""
import math

import numpy
import pytest
from scipy.special import lambertw

from harness import Patch


def strike(messages, seconds=1.0, arguments=(), rate=48000):
    """Sound, force and impacts (duration in ms, impulse in N s)."""
    patch = Patch()
    voice = patch.obj("contact_impact~", *arguments)
    for time, message in messages:
        patch.at(time, voice, message)
    patch.record("sound", voice[0])
    patch.record("contact", voice[1])
    patch.log("blow", voice[2])
    result = patch.render(seconds, rate=rate)
    impacts = [[a for a in atoms if not isinstance(a, str)] for _, atoms in result.logs["blow"]]
    return result["sound"].astype(float), result["contact"].astype(float), impacts


def restitution(mu_v):
    return float((1 + lambertw(-math.exp(-1 - mu_v + math.log1p(mu_v))).real) / mu_v)


@pytest.mark.parametrize("rate, modes, exponent", [(44100, "none", 1), (48000, "none", 1.5), (96000, "440 .5 1", 1.5)])
def test_an_impact_has_the_impulse_and_duration_of_theory(rate, modes, exponent):
    """On a rigid wall, which does not sound, and on a body of 100 t."""
    speed, mass, loss, stiffness = 1.5, 0.02, 0.3, 1e7
    words = ("-body", 1e5, "-mass", mass, "-stiffness", stiffness, "-exponent", exponent)
    played = [(0, f"modes {modes}"), (10, ["strike", speed])]
    sound, contact, [(duration, impulse)] = strike(played, 0.3, (*words, "-dissipation", loss), rate)
    expected = mass * speed * (1 + restitution(loss * speed))
    assert impulse == pytest.approx(expected, rel=1e-3)
    assert contact.sum() / rate == pytest.approx(expected, rel=1e-3)
    assert sound.any() == (modes != "none")
    # Without loss: the integral of the motion, sqrt(pi) Gamma(1 + b)/Gamma(1/2 + b) 2 x/v, b = 1/(a + 1).
    b = 1 / (exponent + 1)
    deepest = (mass * speed ** 2 * (exponent + 1) / (2 * stiffness)) ** b
    elastic = math.sqrt(math.pi) * math.gamma(1 + b) / math.gamma(.5 + b) * 2 * deepest / speed
    assert elastic < duration / 1000 < 1.25 * elastic  # loss makes it longer
    _, _, [(duration, impulse)] = strike([(0, "dissipation 0"), *played], 0.3, words, rate)
    assert duration / 1000 == pytest.approx(elastic, rel=5e-3)
    assert impulse == pytest.approx(2 * mass * speed, rel=1e-3)


def test_a_struck_bar_after_a_wall_rings_at_its_frequency_and_decays_in_its_time():
    rate = 48000
    sound, _, _ = strike([(0, "modes none"), (10, "strike 1"), (200, "modes 440 0.5 1"), (210, "strike 0.2")])
    assert not sound[:9600].any()
    tone = sound[int(0.3 * rate):int(0.8 * rate)] * numpy.exp(-2j * math.pi * 440 * numpy.arange(24000) / rate)
    smooth = numpy.convolve(tone, numpy.hanning(2401) / 1200, "valid")
    time = numpy.arange(len(smooth)) / rate
    assert -math.log(1000) / numpy.polyfit(time, numpy.log(abs(smooth)), 1)[0] == pytest.approx(0.5, rel=1e-3)
    assert abs(numpy.polyfit(time, numpy.unwrap(numpy.angle(smooth)), 1)[0]) / (2 * math.pi) < 0.01


def test_a_dropped_ball_bounces_as_high_as_its_restitution_says():
    _, _, impacts = strike([(0, "gravity 9.81"), (10, "drop 100")], 1.0,
                           ("-body", 1e5, "-mass", 0.01, "-dissipation", 0.05, "-stiffness", 1e9))
    speed = math.sqrt(2 * 9.81 * 0.1)
    assert len(impacts) >= 3
    for _, impulse in impacts[:3]:
        e = restitution(0.05 * speed)
        assert impulse == pytest.approx(0.01 * speed * (1 + e), rel=2e-3)
        speed *= e


def rub(normal, speed, arguments, modes, rate=48000):
    patch = Patch()
    voice = patch.obj("sig~", speed) >> patch.obj("contact_friction~", *arguments)
    patch.obj("sig~", normal) >> voice[1]
    patch.at(0, voice, f"modes {modes}")
    patch.record("sound", voice[0])
    patch.record("friction", voice[1])
    return patch.render(1, rate=rate)


def test_a_rubbed_body_speaks_with_the_pitch_of_theory():
    # The third of the rubbed oscillators of docs/results/contact.md: 600.798 Hz.
    result = rub(20, 0.1, ("-body", 0.05), f"600 {math.log(1000) / 20} 1", 44100)
    sound = result["sound"][-22050:].astype(float)
    sound -= sound.mean()
    up = numpy.nonzero((sound[:-1] < 0) & (sound[1:] >= 0))[0]
    crossings = up - sound[up] / (sound[up + 1] - sound[up])
    assert 44100 * (len(up) - 1) / (crossings[-1] - crossings[0]) == pytest.approx(600.798, rel=1e-3)


def test_nothing_rubs_without_a_normal_force_and_sliding_has_the_dynamic_coefficient():
    silent, fast = (rub(normal, 2.0, ("-viscosity", 0, "-dynamic", 0.3, "-body", 10), "331 .6 1") for normal in (0, 10))
    assert not numpy.any(silent["sound"]) and not numpy.any(silent["friction"])
    assert numpy.mean(fast["friction"][-4800:]) == pytest.approx(3, rel=1e-2)


SWITCHES = ("gain 0", "gain 15", "pickup 0 1", "pickup", "modes none", "modes 400 .5 .5", "body 3", "reset")


@pytest.mark.parametrize("name", ["contact_impact~", "contact_friction~"])
def test_no_switch_cuts_a_sound_in_one_sample(name):
    """Second differences: of a tone (w A)^2, of a jump its height."""
    patch = Patch()
    tone = ["modes", 300, 2, 1, 700, 2, .1]
    for i, switch in enumerate(SWITCHES):
        box = patch.obj(name, "-gain", 5)
        patch.at(0, box, tone)
        patch.at(1, box, "pickup 1")  # one mode is heard
        if name == "contact_impact~":
            patch.at(10, box, "strike 1")
        else:
            rubs = numpy.zeros(24000)
            rubs[:4800] = 1
            (patch.signal(.1 * rubs) >> box[0], patch.signal(rubs) >> box[1])
        patch.at(250, box, switch)
        patch.record(str(i), box[0])
    result = patch.render(.5)
    for i, switch in enumerate(SWITCHES):
        sound = result[str(i)].astype(float)
        level = abs(sound[11000:11900]).max()
        assert level > .01, switch
        after = max(level, abs(sound[12300:]).max())
        omega = 2 * math.pi * 400 / 48000
        assert abs(numpy.diff(sound[11900:12400], 2)).max() < 2 * after * (omega ** 2 + 2.1 * omega / 24 + 2e-4), switch
