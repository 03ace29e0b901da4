"""[modal_impact~] sounds as its surface accelerates, whatever strikes or pushes it."""
import functools

import numpy
import pytest
from harness import Patch, stage_folder
from harness.struck_reference import (SPEED_OF_SOUND, StruckReference, closed_form_bar, line, spectrum, third_octaves,
                                      transform)

slow = pytest.mark.slow
LOSS = 4e-3
LATENCY = 25  # samples, of the object's band limit, while a listener is nearer than that
STRIKER = {"mass": .0071, "radius": .006, "poisson": .29}
PLACES = {"plate": (.05, .03, .0025), "bar": (.06, .008, .006), "bowl": (.079, .01, -.01), "disk": (.022, .01, .006)}
FAR = (.1, .02, .3)


@functools.cache
def body(name):
    if name == "bar":
        return closed_form_bar()
    path = stage_folder() / f"{name}.modal.npz"  # by the package's own finite elements
    if not path.is_file():
        pytest.skip("the table is made where modal_fem is built")
    return dict(numpy.load(path))


@functools.cache
def reference(name, loss):
    ours = StruckReference(body(name), loss)
    away = numpy.linalg.norm(ours.centre - numpy.array(PLACES[name]), axis=1)
    return ours, ours.excite_at(away.argmin())


def whole_samples(ours, listener, rate):
    """The listener moved outwards until its delay is a whole number of samples, so that no delay
    line's interpolation takes part; or where it is, when it is nearer than the latency."""
    listener = numpy.array(listener)
    delay = lambda stretch: ours.radiating(listener * stretch)[1].min() / SPEED_OF_SOUND * rate
    if delay(1) < LATENCY:
        return listener, LATENCY / rate
    target, low, high = numpy.ceil(delay(1)), 1., 1.2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if delay(middle) < target else (low, middle)
    return listener * high, target / rate


def play(folder, name, listener, seconds, *arguments, hit=None, force=None, rate=48000, young=2e11, messages=(),
         loss=LOSS):
    numpy.savez(folder / "body.npz", **body(name))
    patch = Patch()
    box = patch.obj("modal_impact~", "body.npz", "-sync", 1, "-gain", .1, "-cull", 200, *arguments)
    patch.record("sound", box[0])
    patch.record("contact", box[2])
    point = " ".join(f"{x:.9g}" for x in reference(name, LOSS)[1])
    for message in (f"loss {loss}", "listener 1 " + " ".join(f"{x * 1000:.9g}" for x in listener),
                    f"striker {STRIKER['mass']} {STRIKER['radius']} {young} {STRIKER['poisson']}",
                    f"point {point}", *messages):
        patch.at(1, box, message)
    if hit:
        patch.at(100, box, f"hit {point} {hit}")
    if force is not None:
        patch.signal(force) >> box[0]
    result = patch.render(seconds, rate=rate, path=[folder])
    return result["sound"].astype(float) / .1, result["contact"].astype(float)


STRIKES = [("plate", (.1, .2, .5), 48000, 2e11), ("plate", (.1, .2, .5), 48000, 1e7),
           ("plate", (.02, .01, .04), 44100, 1e9), ("plate", (.1, .2, .5), 96000, 1e5),
           ("bar", (.05, .1, .3), 48000, 2e11), ("bar", (.1, 0, .05), 44100, 1e6), ("bar", (.05, .1, .3), 96000, 1e8),
           ("bowl", FAR, 48000, 2e11), ("bowl", (.12, .02, -.02), 44100, 1e7), ("bowl", FAR, 48000, 1e5),
           ("disk", (0, .02, .3), 48000, 2e11), ("disk", (.02, .02, .04), 44100, 1e6)]
QUICK = {("plate", 44100), ("bar", 44100)}


@pytest.mark.parametrize("name, listener, rate, young", [
    pytest.param(*row, marks=() if (row[0], row[2]) in QUICK else slow) for row in STRIKES])
def test_a_strike_sounds_as_the_retarded_surface_accelerates(tmp_path, name, listener, rate, young):
    # Every third octave from 20 Hz to 20 kHz that is within 80 dB of the loudest one, and every
    # peak within 60 dB of the highest.
    beta = 12.0
    ours, _ = reference(name, LOSS)
    listener, delay = whole_samples(ours, listener, rate)
    sound, contact = play(tmp_path, name, listener, 1.1, hit=1, rate=rate, young=young)
    sound = sound[numpy.flatnonzero(contact)[0]:]
    s, _, _ = line(len(sound), rate, beta)
    # A sample holds what is heard at its end.
    heard = spectrum(sound, rate, beta) * numpy.exp(-s / rate)
    force, step = ours.strike(**STRIKER, young=young, speed=1, rate=rate, steps=128 if young > 1e9 else 32)
    true = ours.pressure_per_force(listener, s) * transform(force, step, s) * numpy.exp(-s * delay)
    assert contact.sum() / rate == pytest.approx(force.sum() * step, rel=2e-3)
    f = s.imag / (2 * numpy.pi)
    ours_db, true_db = third_octaves(f, heard), third_octaves(f, true)
    counts = true_db > true_db.max() - 80
    assert counts.sum() >= 15
    assert abs(ours_db - true_db)[counts].max() < .5
    size = abs(true)
    peak = numpy.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])
                             & (size[1:-1] > 1e-3 * size.max())) + 1
    assert abs(20 * numpy.log10(abs(heard[peak]) / size[peak])).max() < .5


@pytest.mark.parametrize("name", ["plate", pytest.param("bar", marks=slow), pytest.param("bowl", marks=slow),
                                  pytest.param("disk", marks=slow)])
def test_a_slow_force_gives_the_slow_acceleration_and_a_constant_one_none(tmp_path, name):
    # 10 N at 20 Hz; a strong loss, so that nothing but the driven motion is left after a second.
    loss = .05
    ours, _ = reference(name, loss)
    t = numpy.arange(2 * 48000) / 48000
    sound, _ = play(tmp_path, name, FAR, 2, loss=loss, force=10 * numpy.sin(40 * numpy.pi * t))
    true = 10 * abs(ours.pressure_per_force(numpy.array(FAR), numpy.array([40j * numpy.pi]))[0])
    assert sound[48000:].std() * 2 ** .5 == pytest.approx(true, rel=.01)
    still, _ = play(tmp_path, name, FAR, 2, force=numpy.full(96000, 10.0))
    assert abs(still[-24000:].mean()) < 1e-5 * abs(play(tmp_path, name, FAR, .5, hit=1)[0]).max()


@pytest.mark.parametrize("name", [pytest.param("plate", marks=slow), "bar", pytest.param("bowl", marks=slow)])
@pytest.mark.parametrize("radiation, listener", [("modal", FAR), pytest.param("modal", (.03, .02, .05), marks=slow),
                                                 pytest.param("none", FAR, marks=slow)])
def test_damping_never_makes_it_louder(tmp_path, name, radiation, listener):
    sounds = [play(tmp_path, name, listener, .3, "-radiation", radiation, hit=1, loss=loss)[0]
              for loss in (1e-9, 1e-3, .05, .2, .5, 1)]
    peak = numpy.array([20 * numpy.log10(abs(x).max()) for x in sounds])
    energy = numpy.array([10 * numpy.log10((x ** 2).sum()) for x in sounds])
    assert numpy.diff(peak).max() < .1
    assert numpy.diff(energy).max() < .1
