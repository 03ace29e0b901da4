"""[modal_impact~] sounds as its surface accelerates, whatever strikes or pushes it."""
import functools
import os
import pathlib
import subprocess
import tempfile

import numpy
import pytest
from harness import Patch, stage_folder
from harness.struck_reference import (SPEED_OF_SOUND, StruckReference, closed_form_bar,
                                      inextensional_bowl, line, spectrum, third_octaves, transform)

LOSS = 4e-3
LATENCY = 25  # samples, of the object's band limit, while a listener is nearer than that
STRIKER = {"mass": .0071, "radius": .006, "poisson": .29}
PLACES = {"plate": (.05, .03, .0025), "bar": (.06, .008, .006), "bowl": (.079, .01, -.01),
          "disk": (.022, .01, .006), "fem_bar": (.05, 0, .02)}


@functools.cache
def body(name):
    if name == "bar":
        return closed_form_bar()
    if name == "bowl":
        return inextensional_bowl()
    if name == "fem_bar":
        return fem_bar()
    path = stage_folder() / f"{name}.modal.npz"
    if not path.is_file():
        pytest.skip("the disk's table is made where modal_fem is built")
    return dict(numpy.load(path))


def fem_bar():
    """A steel bar by the package's own finite elements: 300 x 30 x 12 mm, its 20 lowest modes."""
    program = pathlib.Path(os.environ["TACTUS_BUILD"]) / "programs/modal_fem/modal_fem"
    if not program.is_file():
        pytest.skip("modal_fem is not built")
    with tempfile.TemporaryDirectory() as folder:
        table = pathlib.Path(folder) / "bar.modal.npz"
        subprocess.run([program, *"bar --length 300 --width 30 --thickness 12 --material steel "
                        "--modes 20 --quiet -o".split(), table], check=True, capture_output=True)
        return dict(numpy.load(table))


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


def play(folder, name, listener, seconds, *arguments, hit=None, force=None, rate=48000, young=2e11,
         messages=(), loss=LOSS):
    numpy.savez(folder / "body.npz", **body(name))
    patch = Patch()
    box = patch.obj("modal_impact~", "body.npz", "-sync", 1, "-gain", .1, "-cull", 200, *arguments)
    patch.record("sound", box[0])
    patch.record("contact", box[2])
    _, position = reference(name, LOSS)
    point = " ".join(f"{x:.9g}" for x in position)
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


@pytest.mark.parametrize("name, listener, rate, young", [
    ("plate", (.1, .2, .5), 48000, 2e11), ("plate", (.1, .2, .5), 48000, 1e7),
    ("plate", (.02, .01, .04), 44100, 1e9), ("plate", (.1, .2, .5), 96000, 1e5),
    ("bar", (.05, .1, .3), 48000, 2e11), ("bar", (.1, 0, .05), 44100, 1e6),
    ("bar", (.05, .1, .3), 96000, 1e8), ("bowl", (.1, .02, .3), 48000, 2e11),
    ("bowl", (.12, .02, -.02), 44100, 1e7), ("bowl", (.1, .02, .3), 48000, 1e5),
    ("disk", (0, .02, .3), 48000, 2e11), ("disk", (.02, .02, .04), 44100, 1e6),
    ("fem_bar", (0, .02, .1), 48000, 2e11), ("fem_bar", (.1, 0, .5), 48000, 2e11)])
def test_a_strike_sounds_as_the_retarded_surface_accelerates(tmp_path, name, listener, rate, young):
    # Every third octave from 20 Hz to 20 kHz that is within 80 dB of the loudest one, and every
    # peak within 60 dB of the highest.
    beta = 12.0
    ours, _ = reference(name, LOSS)
    listener, delay = whole_samples(ours, listener, rate)
    sound, contact = play(tmp_path, name, listener, 1.1, hit=1, rate=rate, young=young)
    begin = numpy.flatnonzero(contact)[0]
    sound = sound[begin:]
    s, _, _ = line(len(sound), rate, beta)
    # A sample holds what is heard at its end.
    heard = spectrum(sound, rate, beta) * numpy.exp(-s / rate)
    force, step = ours.strike(**STRIKER, young=young, speed=1, rate=rate,
                              steps=128 if young > 1e9 else 32)
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


@pytest.mark.parametrize("radiation", ["modal", "none"])
@pytest.mark.parametrize("name", ["plate", "bar", "bowl", "disk"])
def test_a_constant_force_falls_silent(tmp_path, name, radiation):
    listener = (.1, .02, .3)
    loud, _ = play(tmp_path, name, listener, .5, "-radiation", radiation, hit=1)
    still, _ = play(tmp_path, name, listener, 2, "-radiation", radiation,
                    force=numpy.full(96000, 10.0))
    rest = still[-24000:]
    assert abs(rest.mean()) < 1e-5 * abs(loud).max()


@pytest.mark.parametrize("name", ["plate", "bar", "bowl", "disk"])
def test_a_slow_force_gives_the_slow_acceleration(tmp_path, name):
    # 10 N at 20 Hz; a strong loss, so that nothing but the driven motion is left after a second.
    loss, ours = .05, StruckReference(body(name), .05)
    ours.excite_at(numpy.linalg.norm(ours.centre - numpy.array(PLACES[name]), axis=1).argmin())
    listener = numpy.array((.1, .02, .3))
    t = numpy.arange(2 * 48000) / 48000
    sound, _ = play(tmp_path, name, listener, 2, loss=loss, force=10 * numpy.sin(40 * numpy.pi * t))
    true = 10 * abs(ours.pressure_per_force(listener, numpy.array([40j * numpy.pi]))[0])
    assert sound[48000:].std() * 2 ** .5 == pytest.approx(true, rel=.01)


LOSSES = [1e-9, 1e-3, .05, .2, .5, 1]


@pytest.mark.parametrize("name", ["plate", "bar", "bowl"])
@pytest.mark.parametrize("radiation, listener", [("modal", (.1, .02, .3)),
                                                 ("modal", (.03, .02, .05)),
                                                 ("none", (.1, .02, .3))])
def test_damping_never_makes_it_louder(tmp_path, name, radiation, listener):
    sounds = [play(tmp_path, name, listener, .3, "-radiation", radiation, hit=1, loss=loss)[0]
              for loss in LOSSES]
    peak = numpy.array([20 * numpy.log10(abs(x).max()) for x in sounds])
    energy = numpy.array([10 * numpy.log10((x ** 2).sum()) for x in sounds])
    assert numpy.diff(peak).max() < .1
    assert numpy.diff(energy).max() < .1


@pytest.mark.parametrize("message", ["rayleigh 2000 1e-4", "losscurve 100 0.01 2000 1 10000 0.3",
                                     "preset wood", "preset rubber"])
def test_no_damping_of_any_kind_is_louder_than_none(tmp_path, message):
    # A lighter material is louder for the same strike: it is compared with itself.
    listener = (.05, .1, .3)
    free, _ = play(tmp_path, "bar", listener, .5, hit=1, messages=[message, "loss 1e-9"])
    damped, _ = play(tmp_path, "bar", listener, .5, hit=1, messages=[message])
    choked, _ = play(tmp_path, "bar", listener, .5, "-choke", .002, hit=1,
                     messages=[message, "loss 1e-9"])
    # Damping stiffens soft rubber against the ball, whose force is then a little higher: 0.5 dB.
    for sound in (damped, choked):
        assert abs(sound).max() < 1.06 * abs(free).max()
        assert (sound ** 2).sum() < 1.12 * (free ** 2).sum()


def peak_and_energy(values, rate, beta, chosen, size):
    """Of a spectrum on the line, in dB: what is between 17.5 Hz and 20 kHz, without its window."""
    whole = numpy.zeros(size // 2 + 1, complex)
    whole[chosen] = values
    sound = numpy.fft.irfft(whole, size) * rate * numpy.exp(beta * numpy.arange(size) / rate)
    sound = sound[:size // 8]  # later the window has left too little
    return numpy.array([20 * numpy.log10(abs(sound).max()), 10 * numpy.log10((sound ** 2).sum())])


@pytest.mark.parametrize("name, listener, messages", [
    ("disk", (.02, .02, .04), ()), ("disk", (0, .005, .036), ()), ("bar", (.05, .1, .3), ()),
    ("bar", (.05, .1, .3), ("preset rubber",))])
def test_level_over_damping_is_what_the_surface_gives(tmp_path, name, listener, messages):
    # The ringing falls with the loss. What is left is the direct sound of the strike, from which
    # the body's own swing takes away the less the more it is damped: its peak may rise by tenths
    # of a dB, in the reference as here.
    rate, beta, losses = 48000, 30.0, [.02, .05, .1, .2, .3, .5, 1]
    ours, true = [], []
    for loss in losses:
        table = body(name)
        if messages:
            table = closed_form_bar(young=.05e9, density=1100)
        reference_body = StruckReference(table, loss)
        away = numpy.linalg.norm(reference_body.centre - numpy.array(PLACES[name]), axis=1)
        reference_body.excite_at(away.argmin())
        pickup, delay = whole_samples(reference_body, listener, rate)
        sound, contact = play(tmp_path, name, pickup, .5, hit=1,
                              messages=[*messages, f"loss {loss}"])
        sound = sound[numpy.flatnonzero(contact)[0]:][:16384]
        s, chosen, size = line(16384, rate, beta)
        force, step = reference_body.strike(**STRIKER, young=2e11, speed=1, rate=rate, steps=64)
        pressure = reference_body.pressure_per_force(pickup, s) * transform(force, step, s)
        pressure *= numpy.exp(s * (1 / rate - delay))
        true.append(peak_and_energy(pressure, rate, beta, chosen, size))
        ours.append(peak_and_energy(spectrum(sound, rate, beta), rate, beta, chosen, size))
    ours, true = numpy.array(ours), numpy.array(true)
    # A peak of a steel ball's strike lies between samples and depends on the phases at 20 kHz.
    assert (abs(ours - true).max(0) < (.3, .1)).all()
    assert (abs(numpy.diff(ours - true, axis=0)).max(0) < (.2, .1)).all()
    assert true[-1, 1] < true[0, 1] + (.5 if messages else -1)


@pytest.mark.parametrize("young", [2e11, 1e7, 1e5])
@pytest.mark.parametrize("name", ["plate", "bar", "bowl", "disk"])
def test_a_pulse_sounds_as_the_coupled_contact(tmp_path, name, young):
    # Third octaves below half the inverse contact time.
    rate, beta, found = 48000, 12.0, []
    for kind in ("coupled", "pulse"):
        sound, contact = play(tmp_path, name, (.1, .02, .3), 1.1, "-contact", kind, hit=1,
                              young=young)
        sound = sound[numpy.flatnonzero(contact)[0]:][:40000]
        s, _, _ = line(len(sound), rate, beta)
        found.append(third_octaves(s.imag / (2 * numpy.pi), spectrum(sound, rate, beta)))
        if kind == "coupled":
            time = numpy.count_nonzero(contact > 1e-3 * contact.max()) / rate
    upper = 20 * 2 ** (numpy.arange(30) / 3 + 1 / 6)
    counts = upper < 1 / (2 * time)
    assert counts.sum() >= 4
    assert abs(found[1] - found[0])[counts].max() < .5
