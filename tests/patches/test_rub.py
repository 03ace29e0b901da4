"""[modal_impact~] rubbed: a string in closed form against Helmholtz, and bodies that sing."""
import numpy
import pytest
from harness import Patch
from harness.struck_reference import closed_form_bar, closed_form_string

BETA, SPEED, HZ, LENGTH = .13, .1, 196., 330.


def rubbed(folder, table, normal, velocity, settings, rate=48000, moves=(), expect_errors=(), **flags):
    numpy.savez(folder / "body.npz", **table)
    patch = Patch()
    options = [x for name, value in flags.items() for x in (f"-{name}", value)]
    box = patch.obj("modal_impact~", "body.npz", "-sync", 1, "-gain", 1, *options)
    patch.signal(normal) >> box[2]
    patch.signal(velocity) >> box[3]
    for name, outlet in (("left", 0), ("contact", 2), ("friction", 6)):
        patch.record(name, box[outlet])
    for message in settings:
        patch.at(0, box, message)
    for time, message in moves:
        patch.at(1000 * time, box, message)
    return patch.render(len(normal) / rate, rate, path=[folder], timeout=120, expect_errors=list(expect_errors))


def bowed(folder, force, rate=48000):
    """Velocity under the bow over the last 0.4 s of 1.2."""
    time = numpy.arange(int(1.2 * rate)) / rate
    position = (BETA - .5) * LENGTH
    render = rubbed(folder, closed_form_string(hz=HZ), force * numpy.clip(time / .05, 0, 1),
                    SPEED * numpy.clip(time / .05, 0, 1),
                    ["radiation none", f"listener 1 {position} 0.5 0", "friction 0.8 0.3 0.1 0.5 1000000 5 0",
                     f"rub {position} 0 0.5 0 1 0"], rate)
    return numpy.asarray(render["left"], float)[int(.8 * rate):], render


def slips(velocity, rate=48000):
    """Begun in a period."""
    low = velocity < 0
    return (low[1:] & ~low[:-1]).sum() / (len(velocity) / rate * HZ)


@pytest.mark.parametrize("rate", [44100, 96000])
def test_a_bowed_string_moves_as_helmholtz_saw_it(tmp_path, rate):
    velocity, render = bowed(tmp_path, .2, rate)
    assert abs(slips(velocity, rate) - 1) < .02
    assert abs(numpy.median(velocity) - SPEED) < .01 * SPEED  # it sticks for most of the time
    slipping = velocity < .3 * SPEED
    assert abs(slipping.mean() / BETA - 1) < .1
    assert abs(numpy.median(velocity[velocity < -.5 * SPEED]) / (-SPEED * (1 - BETA) / BETA) - 1) < .1
    # No friction is above the static coefficient's, none of it is pressing.
    friction = numpy.asarray(render["friction"], float)
    assert abs(friction).max() < 1.6 * .8 * .2  # bristles' damping on top
    assert not numpy.any(render["contact"])


def test_a_bow_too_light_slips_more_than_once_and_one_too_heavy_has_no_period(tmp_path):
    light, _ = bowed(tmp_path, .01)
    assert slips(light) > 1.5
    heavy, _ = bowed(tmp_path, 8)
    begun = numpy.flatnonzero((heavy[1:] < 0) & (heavy[:-1] >= 0))
    apart = numpy.diff(begun) / 48000 * HZ
    assert apart.std() > .1 * apart.mean()


def test_a_bowed_bar_sticks_and_slips_at_a_low_mode_about_as_fast_as_the_bow(tmp_path):
    table = closed_form_bar()
    table["eta"] = 5e-4 * (table["freq"] / table["freq"][0]) ** 1.5  # high modes do not take hold first
    table["phi"][:, :, 0] = table["phi"][:, :, 2]  # the same along its face, where a bow can take hold
    time = numpy.arange(4 * 48000) / 48000
    render = rubbed(tmp_path, table, 12 * numpy.clip(time / .2, 0, 1), .06 + 0 * time,
                    ["radiation none", "listener 1 150 0 6", "friction 0.8 0.3 0.1 0.5 3000000 2 0",
                     "rub 150 0 6 1 0 0"])
    last = slice(int(3.5 * 48000), 4 * 48000)
    velocity, friction = (numpy.asarray(render[name], float)[last] for name in ("left", "friction"))
    spectrum = abs(numpy.fft.rfft(velocity * numpy.hanning(len(velocity)), 1 << 18))
    assert abs(spectrum.argmax() * 48000 / (1 << 18) / table["freq"][:3] - 1).min() < .005
    assert friction.std() > .2
    # While it sticks it goes with the bow, but for what the bristles give way.
    assert .8 < numpy.percentile(velocity, 98) / .06 < 1.5


def test_friction_takes_hold_and_lets_go(tmp_path):
    time = numpy.arange(24000) / 48000
    normal = numpy.where((time > .1) & (time < .3), 2., 0)
    table = closed_form_string(hz=HZ)
    render = rubbed(tmp_path, table, normal, .5 + 0 * time,
                    ["radiation none", "friction 0.5 0.5 0.1 0.5 100000 5 0", "rub 0 0 0.5 0 1 0"])
    friction = numpy.asarray(render["friction"], float)
    assert not friction[time < .1].any() and not friction[time > .3].any()
    # Coulomb's: both coefficients are the same.
    assert abs(friction[(time > .2) & (time < .29)].mean() / 1 - 1) < .02


def test_a_surface_slides_on_to_another_position(tmp_path):
    """Over half the string, a hundred places a second: the force goes on without gaps."""
    time = numpy.arange(48000) / 48000
    moves = [(n / 100, f"rub {-60 + 1.2 * n} 0 0.5 0 1 0") for n in range(100)]
    render = rubbed(tmp_path, closed_form_string(hz=HZ), 1 + 0 * time, .5 + 0 * time,
                    ["radiation none", "friction 0.3 0.3 0.1 0.5 100000 5 0"], moves=moves)
    friction = numpy.asarray(render["friction"], float)[4800:]
    assert abs(friction / .3 - 1).max() < .6 and abs(friction.mean() / .3 - 1) < .02


@pytest.mark.parametrize("message, sentence", [
    ("rub 1 2 3 4", "rub: expected x y z, or x y z dx dy dz"),
    ("rub 0 0 0.5 0 0 0", "rub: direction 0 0 0: expected one along the surface"),
    ("rub 0 0 0.5 0 0 1", "rub: direction 0 0 1: expected one along the surface, whose normal is 0 0 1"),
    ("friction 11", "friction: static 11: expected 0.001..10"),
    ("friction 1 1 1 2", "friction: breakaway 2: expected 0.01..0.99"),
    ("friction a", "friction a: expected numbers"),
])
def test_bad_words_are_refused_and_the_rest_goes_on(tmp_path, message, sentence):
    time = numpy.arange(9600) / 48000
    render = rubbed(tmp_path, closed_form_string(hz=HZ), 1 + 0 * time, .5 + 0 * time,
                    ["radiation none", "friction 0.5 0.5"], moves=[(.1, message)],
                    expect_errors=[f"modal_impact~: {sentence}.*"])
    friction = numpy.asarray(render["friction"], float)
    assert abs(friction[7000:].mean()) > .1
