"""[greed~] in a headless Pd: playing states, silence, messages, robustness."""

import math

import numpy
import pytest

from harness import Patch

OUTLETS = ("sound", "theta", "p_b", "U")


def play(arguments, pressure, f_r=0, f_b=0, seconds=1.95, rate=48000, block=64, ramp=20,
         messages=(), errors=None):
    """The pressure rises in `ramp` ms; f_r and f_b are numbers, or samples, in inlets 2 and 3."""
    patch = Patch(block=block)
    line = patch.obj("line~")
    patch.at(0, line, [pressure, ramp])
    reed = line >> patch.obj("greed~", *arguments)
    for inlet, value in ((1, f_r), (2, f_b)):
        source = patch.obj("sig~", value) if numpy.ndim(value) == 0 else patch.signal(value)
        source >> reed[inlet]
    for time, message in messages:
        patch.at(time, reed, message)
    for outlet, name in enumerate(OUTLETS):
        patch.record(name, reed[outlet])
    patch.log("info", reed[4])
    return patch.render(seconds, rate=rate, **({"expect_errors": errors} if errors else {}))


def window(result, name, rate=48000, start=1.2, end=1.9):
    return numpy.asarray(result[name], dtype=float)[int(start * rate):int(end * rate)]


def component(x, rate, frequency):
    n = numpy.arange(len(x))
    shape = numpy.blackman(len(x))
    return abs(numpy.sum((x - x.mean()) * shape * numpy.exp(-2j * numpy.pi * frequency / rate * n)))


def pitch(x, rate, low, high):
    """Peak of a windowed, zero-padded spectrum, by parabola."""
    size = 1 << 19
    spectrum = abs(numpy.fft.rfft((x - x.mean()) * numpy.blackman(len(x)), size))
    first, last = int(low * size / rate), int(high * size / rate)
    peak = first + int(numpy.argmax(spectrum[first:last]))
    a, b, c = numpy.log(spectrum[peak - 1:peak + 2])
    return (peak + 0.5 * (a - c) / (a - 2 * b + c)) * rate / size


def cents(a, b):
    return 1200 * math.log2(a / b)


def harmonic(x, rate, f0, number):
    return 20 * math.log10(component(x, rate, number * f0) / component(x, rate, f0))


# The reference instruments, spelled out: the presets may be voiced anew.
def clarinet(length=0.48, **more):
    return flags(type="closed", theta0=-0.04, arm=0.01, mass=3.376e-6, q=5, width=13e-3,
                 lambda_m=6.5e-3, lambda_b=6.5e-3, mu=0, xmax=5e-3, bore="cyl", radius=7.5e-3,
                 radius_end=7.5e-3, cup=0, length=length, **{"lambda": 1e-3, **more})


def trumpet():
    return flags(type="open", theta0=0.01, arm=0.01, mass=8e-5, q=4, width=8e-3, lambda_m=5e-3,
                 lambda_b=5e-3, mu=0, xmax=2e-3, bore="cone", radius=5e-3, radius_end=40e-3,
                 apex=0.25, cup=1.1e-6, length=1.2, **{"lambda": 1e-3})


def voice():
    return flags(type="open", theta0=0.02, arm=0.01, mass=1e-4, q=5, width=14e-3, lambda_m=1e-3,
                 lambda_b=1e-3, mu=3e-3, xmax=3e-3, bore="cyl", radius=8e-3, radius_end=8e-3,
                 length=0.17, **{"lambda": 3e-3})


def syrinx():
    return flags(type="swing", theta0=0.03, arm=0.003, mass=5e-7, q=5, width=3e-3,
                 lambda_m=0.5e-3, lambda_b=0.5e-3, mu=1.5e-3, xmax=1.5e-3, bore="cyl",
                 radius=1.75e-3, radius_end=3e-3, length=0.05, **{"lambda": 1e-3})


def flags(**values):
    return [atom for name, value in values.items() for atom in ("-" + name, value)]


@pytest.mark.parametrize("rate", [44100, 48000, 96000])
@pytest.mark.parametrize("arguments, f_r, pressure, f0, rms, levels", [
    (clarinet(), 2500, 2000, 172.49, 1855, {3: -10.52, 5: -16.15}),
    (trumpet(), 330, 4000, 390.92, 1445, {}),
    (trumpet(), 220, 2000, 260.10, 709, {}),
    (voice(), 120, 1500, 131.01, 289, {2: -10.5}),
    (syrinx(), 1200, 300, 1021.3, 239, {}),
], ids=["clarinet", "trumpet", "trumpet-slack", "voice", "syrinx"])
def test_playing_states_are_those_of_the_finer_model(arguments, f_r, pressure, f0, rms, levels,
                                                     rate):
    result = play(arguments, pressure, f_r=f_r, rate=rate)
    bore = window(result, "p_b", rate)
    found = pitch(bore, rate, 0.6 * f0, 1.6 * f0)
    assert abs(cents(found, f0)) < 8
    assert abs(bore.std() / rms - 1) < 0.04
    for number, level in levels.items():
        assert abs(harmonic(bore, rate, found, number) - level) < 1
    assert abs(result["sound"]).max() <= 1
    assert window(result, "sound", rate).std() > 1e-3


def test_a_quiet_reed_rests_where_the_forces_balance():
    result = play(clarinet(), 700, f_r=2500, seconds=2.2, ramp=200)
    assert abs(result["theta"][-1] / -0.032899 - 1) < 1e-3
    assert abs(result["U"][-1] / 1.45798e-4 - 1) < 1e-3


def test_the_clarinet_has_odd_harmonics_a_quarter_wave_long():
    bore = window(play(clarinet(), 2000, f_r=2500), "p_b")
    f0 = pitch(bore, 48000, 120, 260)
    assert abs(f0 / 176.9 - 1) < 0.03
    assert harmonic(bore, 48000, f0, 2) < -35 and harmonic(bore, 48000, f0, 4) < -35


@pytest.mark.parametrize("arguments, f_r, pressure", [
    (clarinet(), 2500, 1325), (clarinet(), 2500, 5600), (clarinet(), 100, 1000),
    (trumpet(), 145, 3000), (trumpet(), 900, 5000)])
def test_what_theory_calls_stable_is_silent(arguments, f_r, pressure):
    theta = numpy.asarray(play(arguments, pressure, f_r=f_r, seconds=3)["theta"], dtype=float)
    end = theta[-9600:]
    # 32-bit samples: the angle's own rounding bounds what can be seen.
    assert end.std() < 1e-6 * abs(theta[:9600] - end.mean()).max() + 1e-8


@pytest.mark.parametrize("block", [1, 16, 1024])
def test_the_block_size_does_not_change_a_bit(block):
    sweep = 150 * 2 ** numpy.linspace(0, 1.5, 48000)
    options = dict(f_r=2400, f_b=sweep, seconds=0.8, ramp=0)
    reference = play(["-preset", "clarinet", "-noise", 0.02], 2200, **options)
    other = play(["-preset", "clarinet", "-noise", 0.02], 2200, block=block, **options)
    # The cord from the breath's [line~] starts with a block.
    for name in OUTLETS:
        assert numpy.array_equal(reference[name], other[name])


def test_every_preset_speaks_within_bounds():
    for name, pressure in (("clarinet", 2000), ("sax", 1500), ("oboe", 2200), ("trumpet", 4000),
                           ("trombone", 2000), ("voice", 1500), ("syrinx", 1000)):
        result = play(["-preset", name], pressure)
        assert abs(result["sound"]).max() <= 1, name
        assert window(result, "p_b").std() > 0.05 * pressure, name


def test_rebuilding_the_graph_keeps_the_note():
    patch = Patch()
    reed = patch.obj("sig~", 2000) >> patch.obj("greed~", "-preset", "clarinet")
    patch.record("p_b", reed[2])
    for ms in range(600, 1000, 40):
        patch.rebuild_dsp(ms)
    bore = numpy.asarray(patch.render(1.2, rate=48000)["p_b"], dtype=float)
    frame = 480
    levels = bore[int(0.55 * 48000):].reshape(-1, frame)[:, :].std(axis=1)
    assert levels.min() > 0.7 * levels.max()


def test_nothing_on_any_inlet_breaks_it():
    rng = numpy.random.default_rng(3)
    bad = [math.nan, math.inf, -math.inf, 1e38, -1e38, 1e-40, 0, -1]
    patch = Patch()
    samples = {"p": numpy.full(72000, 2000.0), "r": numpy.full(72000, 2500.0),
               "b": numpy.full(72000, 180.0)}
    for x in samples.values():
        for n in rng.integers(0, 48000, 400):
            x[n] = bad[rng.integers(len(bad))]
    reed = patch.signal(samples["p"]) >> patch.obj("greed~", "-preset", "clarinet")
    patch.signal(samples["r"]) >> reed[1]
    patch.signal(samples["b"]) >> reed[2]
    for outlet, name in enumerate(OUTLETS):
        patch.record(name, reed[outlet])
    result = patch.render(1.4, rate=48000)  # the recorder reports what is not finite
    assert abs(result["sound"]).max() <= 1
    assert window(result, "p_b", start=1.2, end=1.4).std() > 1000


def test_a_frequency_that_is_no_number_leaves_the_last_good_one():
    """As a message, and as a signal."""
    def played(*strange):
        patch = Patch()
        reed = patch.obj("sig~", 2000) >> patch.obj("greed~", "-preset", "clarinet")
        for inlet, hertz in ((1, 2300), (2, 185)):
            patch.at(10, reed[inlet], hertz)
            for ms, value in strange:
                patch.at(ms, reed[inlet], value)
        patch.record("p_b", reed[2])
        return patch.render(0.6, rate=48000)["p_b"]
    steady = played()
    assert numpy.array_equal(steady, played((200, math.nan), (300, math.inf), (400, -math.inf)))
    assert not numpy.array_equal(steady, played((200, 0)))  # 0 asks for the preset's own

    def signalled(spoilt):
        f_b = numpy.full(28800, 185.0)
        f_b[9600:] = math.nan if spoilt else 185.0
        return play(["-preset", "clarinet"], 2000, f_b=f_b, seconds=0.6)["p_b"]
    assert numpy.array_equal(signalled(False), signalled(True))


def test_dump_tells_all_parameters_and_what_follows_from_them():
    result = play(["-preset", "clarinet"], 0, seconds=0.1, messages=[(20, "dump")])
    told = {atoms[0]: atoms[1] for _, atoms in result.logs["info"]}
    assert abs(told["P_M"] - 3943) < 4
    assert abs(told["L"] - 0.48) < 1e-6
    assert told["type"] == "closed" and told["flow"] == "implicit"
    assert {"zeta", "theta0", "lambda_m", "radius_end", "seed", "gain"} <= set(told)


def test_the_type_turns_the_rest_angle():
    result = play(["-preset", "clarinet"], 0, seconds=0.1,
                  messages=[(10, "type open"), (20, "get theta0"), (30, "type closed"),
                            (40, "get theta0")])
    angles = [atoms[1] for _, atoms in result.logs["info"] if atoms[0] == "theta0"]
    assert numpy.allclose(angles, [0.04, -0.04])


def test_bad_messages_get_one_sentence_and_change_nothing():
    messages = [(10, "preset kazoo"), (20, "mass -1"), (30, "type oval"), (40, "presset clarinet")]
    result = play(["-preset", "clarinet"], 2000, messages=messages,
                  errors=["preset kazoo: expected clarinet", "mass -1 kg: expected", "type oval",
                          "no message"])
    plain = play(["-preset", "clarinet"], 2000)
    for name in OUTLETS:
        assert numpy.array_equal(result[name], plain[name])


def test_a_tuned_clarinet_plays_the_note_it_is_given():
    for f_b in (147, 262):
        bore = window(play(["-preset", "clarinet", "-tune", 1], 2000, f_b=f_b), "p_b")
        assert abs(cents(pitch(bore, 48000, 0.8 * f_b, 1.2 * f_b), f_b)) < 15


def test_the_papers_flow_plays_nearly_the_same_clarinet():
    bore = window(play(clarinet(flow="paper"), 2000, f_r=2500), "p_b")
    assert abs(cents(pitch(bore, 48000, 120, 260), 172.49)) < 4


@pytest.mark.parametrize("box", [["greed~"], ["greed_gradient~", "trumpet"]])
@pytest.mark.parametrize("value", [3, 2.5, 5])
def test_an_oversampling_that_is_none_is_refused_and_the_old_one_stays(box, value):
    patch = Patch()
    reed = patch.obj(*box)
    patch.at(10, reed, "os 2")
    patch.at(20, reed, f"os {value}")
    patch.at(30, reed, "get os")
    patch.log("info", reed[4 if box[0] == "greed~" else 3])
    result = patch.render(0.1, expect_errors=[f"{box[0]}: os {value}: expected 0, 1, 2 or 4"])
    assert [atoms for _, atoms in result.logs["info"] if atoms[0] == "os"] == [["os", 2]]


@pytest.mark.parametrize("message, sentence", [
    ("gian 2", "no message 'gian'; did you mean 'gain'"),
    ("tun 1", "no message 'tun'; did you mean 'tune'"),
    ("presest sax", "no message 'presest'; did you mean 'preset'"),
    ("embuchrue 1", "no message 'embuchrue'; did you mean 'embouchure'"),
    ("note 60", "no message 'note'; 'get' lists the parameters"),  # two letters from bore
    ("p 2000", "no message 'p'; 'get' lists the parameters"),  # two letters from cup
    ("volume 1", "no message 'volume'; 'get' lists the parameters"),
])
def test_a_name_is_suggested_only_where_it_was_meant(message, sentence):
    patch = Patch()
    reed = patch.obj("greed~", "clarinet")
    patch.at(10, reed, message)
    result = patch.render(0.1, expect_errors=[f"greed~: {sentence}"])
    assert len(result.errors) == 1


@pytest.mark.parametrize("preset, pressure, note", [("trumpet", 3000, 175), ("trumpet", 3000, 466),
                                                    ("trombone", 2500, 117), ("trombone", 2500, 233)])
def test_a_tube_with_a_bell_is_as_much_softer_as_the_docs_say(preset, pressure, note):
    """11 to 17 dB at the preset's gain, and 12 dB of it are four times that gain (docs/greed.md)."""
    gain = {"trumpet": 0.04, "trombone": 0.035}[preset]
    tube = ["-end", preset, "-tube", 1]

    def level(*more):
        return 20 * math.log10(numpy.std(window(play(["-preset", preset, "-tune", 1, *more], pressure, f_b=note), "sound")))
    own, soft, raised = level(), level(*tube), level(*tube, "-gain", 4 * gain)
    assert 10.5 < own - soft < 17.5
    assert raised - soft == pytest.approx(12, abs=0.2)
