"""The mass-spring network inside [phantom]'s servo: felt by the hand and heard by [phantom~]."""

import csv
import random

import numpy
import pytest

from harness import Patch
from test_phantom import DevicePatch, force_after

RATE = 48000


def heard(messages, seconds=1.0, block=64, rate=RATE, device="-hand rigid -walls 0", rows=None):
    """The two network outlets of a [phantom~] while those (ms, message) go to its [phantom]."""
    patch = Patch(block=block)
    box = patch.obj("phantom", "-name", "hand", *device.split())
    patch.log("info", box[3])
    for ms, message in messages:
        patch.at(ms, box, message)
    if rows:
        patch.at(0, box, f"trace {rows}")
        patch.at(1000 * seconds - 2, box, "trace stop")
    signals = patch.obj("phantom~", "hand")
    patch.record("left", signals[7])
    patch.record("right", signals[8])
    return patch.render(seconds, rate=rate)


def peaks(samples, rate, count, floor=1e-4):
    """The lowest `count` spectral peaks in Hz, by a parabola through the log of a Hann spectrum."""
    window = numpy.hanning(len(samples))
    spectrum = numpy.abs(numpy.fft.rfft(samples * window, 4 * len(samples)))
    level = numpy.log(spectrum + 1e-30)
    tops = [k for k in range(2, len(level) - 1)
            if level[k] > level[k - 1] and level[k] >= level[k + 1]
            and spectrum[k] > floor * spectrum.max() and spectrum[k] == spectrum[max(0, k - 40):k + 41].max()]
    found = []
    for k in tops[:count]:
        a, b, c = level[k - 1:k + 2]
        found.append((k + 0.5 * (a - c) / (a - 2 * b + c)) * rate / (4 * len(samples)))
    return numpy.array(found)


STRING = "network string s 19 -50 0 0 50 0 0 0.001 10 0.0005"


def string_hertz(j, n=19, mass=1e-3, tension=10, length=0.1, steps=48000):
    omega = 2 * numpy.sqrt(tension / (mass / n * length / (n + 1))) * numpy.sin(j * numpy.pi / (2 * (n + 1)))
    return numpy.arcsin(0.5 * omega / steps) * steps / numpy.pi  # the scheme's own dispersion


@pytest.mark.parametrize("rate", [44100, 48000, 96000])
def test_a_plucked_string_sounds_at_the_discrete_chain_s_frequencies(rate):
    result = heard([(0, STRING), (0, "network drag 1"), (0, "network touch 0 0 0"), (10, "network listen s-2 z"),
                    (20, "network pluck s-3 0 0 1 2")], seconds=2, rate=rate)
    found = peaks(result["left"][rate // 10:], rate, 9)
    expected = [string_hertz(j) for j in range(1, 10)]  # the tenth has a node there
    assert found == pytest.approx(expected, rel=2e-4, abs=0.05)


def test_without_a_network_the_outlets_are_silent_and_after_a_pluck_they_are_not():
    assert not heard([], 0.3)["left"].any()
    result = heard([(0, STRING), (0, "network listen s-5 y 2"), (100, "network pluck s-5 0 0.5 0 1")], 0.5)
    assert not result["left"].any()
    assert not result["right"][:4600].any()
    assert numpy.abs(result["right"]).max() > 0.1


def test_velocity_displacement_and_force_are_one_motion():
    common = [(0, "network anchor a 0 0 0"), (0, "network mass m 0.01 0 0 0"), (0, "network drag 0"),
              (0, "network link a m 400 0 0"), (0, "network touch 0 0 0"), (50, "network pluck m 0 0 1 1")]
    result = heard(common + [(0, "network listen m z 1 displacement"), (0, "network listen a z 2 force")], 0.4)
    z, force = result["left"][4800:], result["right"][4800:]
    # 1 mN s on 10 g at 200 rad/s: 0.1 m/s and 0.5 mm; the anchor feels k z.
    assert z.max() == pytest.approx(5e-4, rel=5e-3)
    assert force == pytest.approx(400 * z, abs=1e-4)
    velocity = heard(common + [(0, "network listen m z")], 0.4)["left"][4800:]
    slope = numpy.diff(z) * RATE  # half a step from each
    assert velocity[1:] == pytest.approx(slope, abs=0.1 * 200 / RATE)


def test_blocks_of_any_size_give_the_same_samples(tmp_path):
    messages = [(0, STRING), (0, "network listen s-4 z"), (0, "network listen s-9 y 2 displacement"),
                (0, "network touch 8 300 0.2")]
    device = "-hand spring 300 3 -path circle 0 0 5 10 200 xz"
    seen = set()
    for block in (1, 16, 64, 256, 1024, 4096):
        rows = tmp_path / f"{block}.csv"
        result = heard(messages, 0.6, block, device=device, rows=rows)
        end = 400
        assert numpy.abs(result["left"][:48 * end]).max() > 1e-3
        seen.add((result["left"][:48 * end].tobytes(), result["right"][:48 * end].tobytes(),
                  tuple(rows.read_text().splitlines()[1:end])))
    assert len(seen) == 1


def test_a_pressed_string_feels_as_its_springs_in_series(tmp_path):
    """Grabbed in the middle and drawn 3 mm aside: 4 T/L with the grabbing spring."""
    patch = DevicePatch("-hand rigid -path line 0 0 3 0 0 3 1000", 1500)
    for ms, message in ((0, "network string s 21 -50 0 0 50 0 0 0.001 10 0.01"), (1, "network drag 100"),
                        (2, "network touch 0 0"), (3, "network grab s-11 400 0.5"), (1400, "bang")):
        patch.at(ms, message)
    force = force_after(patch.run(tmp_path))
    assert force == pytest.approx([0, 0, -0.003 / (1 / 400 + 1 / 400)], abs=1e-4)


def test_the_hand_pushes_a_membrane_and_it_rings_when_the_hand_leaves(tmp_path):
    rows = tmp_path / "ticks.csv"
    result = heard([(0, "path line 0 0 30 0 0 5 400"),
                    (400, "network membrane m 8 8 -40 -40 0 40 40 0 0.002 50 0.0005"),
                    (400, "network touch 12 300 0.2"), (400, "network listen m-3-3 z")], 1.2, device="-hand spring 400 3", rows=rows)
    force = numpy.array([float(row["fz_n"]) for row in csv.DictReader(rows.open())])
    assert force.max() > 0.5 and force.min() > -0.05
    assert numpy.abs(result["left"][-2400:]).max() > 0.01


@pytest.mark.parametrize("name", ["drop.txt", "bars.txt"])
def test_the_networks_that_come_with_the_package_load_and_sound(name):
    result = heard([(0, f"network load networks/{name}"), (0, "dump"),
                    (50, "network pluck drop 0 0.5 0 20" if name == "drop.txt" else "network pluck low 0 0.5 0 1")], 1)
    assert numpy.abs(result["left"]).max() > 1e-3
    counts = [atoms for _, atoms in result.logs["info"] if atoms[0] == "network"]
    assert counts[-1][1:3] == ([5, 4] if name == "drop.txt" else [9, 6])
    if name == "bars.txt":
        assert peaks(result["left"][4800:], RATE, 1)[0] == pytest.approx(110, abs=0.2)


REFUSED = [
    ("network", "network: expected"),
    ("network fly", "network fly: expected mass, anchor"),
    ("network mass m", "network mass: mass is missing: expected 1e-07..10 kg"),
    ("network mass m -1 0 0 0", "network mass: mass -1 kg: expected 1e-07..10 kg"),
    ("network mass m 1 0 0 2000", "network mass: z 2000 mm: expected -1000..1000 mm"),
    ("network anchor q", "network anchor: q: no such mass"),
    ("network link s-1 q 3", "network link: q: no such mass"),
    ("network link s-1 s-1 3", "network link: s-1: a mass is not linked to itself"),
    ("network link s-1 s-2 3 0 0 twist", "network link: twist: expected pull or push"),
    ("network link s-1 s-2 1e9", "network link: k 1e+09 N/m: expected 0..1000000 N/m"),
    ("network string t 0 0 0 0 1 1 1", "network string: n 0: expected 1..200"),
    ("network string t 5 0 0 0 0 0 0", "network string: the ends are 0 mm apart"),
    ("network string t 5 0 0 0 50 0 0 0.001 10 0 100", "network string: stiffness 100 N/m: expected 0 or at"),
    ("network string t 190 0 0 0 50 0 0", "network string: 209 masses that move: expected at most 200"),
    ("network membrane t 5 5 0 0 0 50 50 50", "network membrane: expected two corners"),
    ("network membrane t 20 20 0 0 0 50 50 0", "network membrane: 400 masses: expected at most 200"),
    ("network load nowhere.txt", "network load: nowhere.txt: no such file"),
    ("network del q", "network del: q: no such mass, string or membrane"),
    ("network listen s-3 w", "network listen: axis w: expected x, y or z"),
    ("network listen s-3 z 3", "network listen: outlet 3: expected 1..2"),
    ("network listen s-3 z colour", "network listen: quantity colour: expected velocity, displacement or force"),
    ("network pluck s-0 0 0 1 1", "network pluck: s-0: an anchor does not move"),
    ("network pluck s-3 0 0 1", "network pluck: expected a mass, fx fy fz in N and ms"),
    ("network pluck s-3 0 0 1000 1", "network pluck: fz 1000 N: expected -100..100 N"),
    ("network grab q", "network grab: q: no such mass"),
    ("network rate 1", "network rate: rate 1 Hz: expected 1000..200000 Hz"),
    ("network drag -1", "network drag: drag -1 1/s: expected 0..10000 1/s"),
    ("network mass dust 1e-6 0 0 0, network link dust s-3 1e6", "network link: mass dust (1e-06 kg) with its springs and the hand needs"),
]


@pytest.mark.parametrize("message, sentence", REFUSED)
def test_a_refused_message_is_one_sentence_and_changes_nothing(tmp_path, message, sentence):
    patch = DevicePatch("", 60)
    patch.at(0, STRING)
    patch.at(10, message.replace(", ", r" \, "))
    patch.at(30, "dump")
    result = patch.run(tmp_path)
    assert len(result.errors) == 1 and sentence in result.errors[0], result.errors
    masses = 22 if "dust" in message else 21
    assert [row for row in result.info if row[0] == "network"][-1][1:3] == [str(masses), "20"]


def test_stiff_springs_raise_the_rate_and_say_so(tmp_path):
    patch = DevicePatch("", 60)
    patch.at(0, r"network anchor a 0 0 0 \, network mass m 0.0001 10 0 0 \, network touch 0 0 0")
    patch.at(10, "network link a m 1e6")
    patch.at(30, "dump")
    result = patch.run(tmp_path)
    assert not result.errors
    assert "network: stepped at" in result.text and "mass m (0.0001 kg) with its springs and the hand needs" in result.text
    rate = float([row for row in result.info if row[0] == "network"][-1][3])
    assert rate >= 1e5 / 2 / 0.7  # w = 1e5 rad/s, w h <= 1.4


def test_a_network_that_another_servo_rate_cannot_step_rests_and_says_so(tmp_path):
    patch = DevicePatch("-rate 4000", 100)
    patch.at(0, r"network anchor a 0 0 0 \, network mass m 1e-6 10 0 0 \, network touch 0 0 0")
    patch.at(5, "network link a m 1e6")
    patch.at(50, "rate 200")
    result = patch.run(tmp_path)
    assert len(result.errors) == 1, result.errors
    assert "network: not stepped: at 200 ticks a second mass m" in result.errors[0]


WORDS = ("s", "s-1", "s-2", "m-1-1", "all", "off", "nearest", "x", "z", "force", "pull", "bars.txt", "a", "ball")
NUMBERS = (0, 1, 2, 3, 7, -1, 0.5, 1e-3, 1e-6, 10, 50, 200, 1e3, 1e9, -1e9, 1e30)
NETWORK = ("string", "membrane", "mass", "anchor", "link", "load", "del", "touch", "grab", "pluck", "listen",
           "drag", "gravity", "rate", "reset", "nonsense")
EFFECTS = ("constant", "spring", "viscous", "inertia", "friction", "texture", "relief", "off", "nonsense")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_any_messages_leave_the_force_finite_and_within_its_limit(seed):
    """Random networks and effects under a moving hand, heard and felt."""
    rng = random.Random(seed)
    messages = [(0, "path lissajous 0 0 0 30 30 30 3 2 5")]
    good = ("network string s 12 -40 0 0 40 0 0", "network membrane m 6 6 -40 -40 0 40 40 0", "network grab nearest",
            "network mass ball 0.01 0 10 0", "network link ball s-3 500 0.1", "network listen s-4 z")
    for ms in range(1, 1500, 2):
        if rng.random() < 0.1:
            messages.append((ms, rng.choice(good)))
            continue
        kind, names = rng.choice((("network", NETWORK), ("network", NETWORK), ("effect", EFFECTS)))
        arguments = [rng.choice(WORDS) if rng.random() < 0.4 else f"{rng.choice(NUMBERS):g}"
                     for _ in range(rng.choice((0, 1, 2, 3, 4, 6, 8)))]
        messages.append((ms, " ".join([kind, rng.choice(names), *arguments])))
    patch = Patch()
    box = patch.obj("phantom", "-name", "hand")
    for ms, message in messages:
        patch.at(ms, box, message)
    patch.at(0, box, "report force 1")
    patch.log("info", box[3])
    signals = patch.obj("phantom~", "hand")
    patch.record("left", signals[7])
    result = patch.render(1.55, expect_errors=["network", "effect"])
    forces = [atoms[1:] for _, atoms in result.logs["info"] if atoms[0] == "force"]
    assert len(forces) > 1000 and numpy.isfinite(forces).all()
    assert numpy.linalg.norm(forces, axis=1).max() <= 8 * (1 + 1e-6)
    assert numpy.isfinite(result["left"]).all()


def test_deleting_one_string_leaves_the_others_their_links_pickups_and_motion():
    """Two strings of other pitches; the first is taken away while the second sounds."""
    build = [(0, "network touch 0"), (0, "network string a 9 -50 0 0 50 0 0 0.001 3"),
             (0, "network string b 9 -50 20 0 50 20 0 0.001 12"), (0, "network listen b-2 z"),
             (50, "network pluck b-3 0 0 1 2")]
    whole = heard(build, 0.5)["left"]
    cut = heard(build + [(200, "network del a")], 0.5)["left"]
    assert numpy.abs(whole[-4800:]).max() > 0.1
    assert cut == pytest.approx(whole, abs=1e-5)


def test_everything_can_be_deleted_while_it_sounds_and_built_again():
    messages = [(0, STRING), (0, "network listen s-4 z"), (50, "network pluck s-4 0 0 1 2"),
                (150, "network del s"), (300, STRING), (310, "network listen s-4 z"),
                (320, "network pluck s-4 0 0 1 2"), (450, "network reset"), (500, "network del all")]
    left = heard(messages, 0.7)["left"]
    level = [numpy.abs(left[48 * a:48 * b]).max() for a, b in ((60, 150), (160, 300), (330, 450), (455, 690))]
    assert level[0] > 0.1 and level[1] == 0 and level[2] > 0.1 and level[3] == 0


@pytest.mark.parametrize("message, said", [
    ("network touch 10 900", []), ("network touch 10 1100", ["1100", "1000"]),
    ("network grab nearest 900", []), ("network grab nearest 1100", ["1100", "1000"]),
    ("scene add p plane 0 0 1 0, scene mat p 1900", []),
    ("scene add p plane 0 0 1 0, scene mat p 2100", ["2100", "2000"])])
def test_a_spring_to_the_network_is_said_to_hum_at_half_of_what_a_body_may_have(tmp_path, message, said):
    """(B + damp)/T and 2 (B + damp)/T with B = 1 N s/m: docs/network.md."""
    patch = DevicePatch("-viscous 1 -damp 0")
    patch.at(1, "network mass a 1 0 500 0")
    patch.at(2, message.replace(", ", r" \, "))
    info = patch.run(tmp_path).info
    assert [row[2:] for row in info if row[:2] == ["status", "stiff"]] == ([said] if said else [])


def test_a_string_replaces_the_masses_that_had_its_names(tmp_path):
    patch = DevicePatch()
    patch.at(0, r"network mass s-2 1 0 500 0 \, network mass other 1 0 510 0 \, network link s-2 other 10")
    patch.at(1, r"network string s 3 -50 0 0 50 0 0")  # s-0 .. s-4
    patch.at(2, "dump")
    result = patch.run(tmp_path)
    assert not result.errors
    assert [row[1:3] for row in result.info if row[0] == "network"] == [["6", "4"]]


def test_a_name_without_letters_is_no_group(tmp_path):
    patch = DevicePatch()
    patch.at(0, r"network mass a 1 0 500 0 \, network mass b 1 0 510 0")
    empty = patch.obj("symbol")
    start = patch.at(1, r"network del \$1", 0)
    patch.cords.pop(-2)  # the delay bangs the empty symbol instead
    patch.cord(start - 1, 0, empty, 0)
    patch.cord(empty, 0, start, 0)
    patch.at(2, "dump")
    result = patch.run(tmp_path)
    assert [row[1:3] for row in result.info if row[0] == "network"] == [["2", "0"]]
