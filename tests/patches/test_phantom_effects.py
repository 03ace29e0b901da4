"""The force effects of [phantom]: `effect NAME numbers`, from a headless Pd."""

import csv
import math

import numpy
import pytest

from test_phantom import DevicePatch, force_after


def still(tmp_path, at, *messages, end_ms=250):
    """The force on a rigid hand that rests there, after those messages."""
    patch = DevicePatch(f"-hand rigid -path line {at} {at} 1000", end_ms)
    for n, message in enumerate(messages):
        patch.at(2 + n, message)
    patch.at(end_ms - 10, "bang")
    return patch.run(tmp_path)


def moved(tmp_path, options, rows, *messages):
    """The servo's trace of a hand on rows of ms x y z, after those messages."""
    (tmp_path / "hand.txt").write_text("\n".join(" ".join(map(str, row)) for row in rows) + "\n")
    patch = DevicePatch(f"-path hand.txt {options}", rows[-1][0] + 20)
    patch.at(0, f"trace {tmp_path}/ticks.csv")
    for message in messages:
        patch.at(0, message)
    patch.at(rows[-1][0], "trace stop")
    result = patch.run(tmp_path)
    assert not result.errors, result.errors
    table = list(csv.DictReader((tmp_path / "ticks.csv").open()))
    return {key: numpy.array([float(row[key]) for row in table]) for key in table[0]}


@pytest.mark.parametrize("message, force", [
    ("effect constant 1 -2 0.5", (1, -2, 0.5)),
    ("effect spring 200 0 0 0", (-0.8, -0.4, 1.0)),
    ("effect spring 200 4 2 10", (0, 0, 3)),
    ("effect spring 4000 4 2 10 1.5", (0, 0, 1.5)),
    ("effect texture 0.5 8", (0, 0, 0)),
    ("effect texture 0.5 16", (0.5, 0, 0)),
    ("effect texture 0.5 16 2 0 0", (0.5, 0, 0)),
    ("effect texture 0.5 8 0 1 0", (0, 0.5, 0)),
])
def test_an_effect_of_the_position_gives_its_force(tmp_path, message, force):
    result = still(tmp_path, "4 2 -5", message)
    assert not result.errors
    assert force_after(result) == pytest.approx(force, abs=2e-6)


def test_effects_add_up_and_the_newest_of_a_name_wins_until_it_is_off(tmp_path):
    assert force_after(still(tmp_path, "4 2 -5", "effect constant 9 9 9", "effect constant 1 0 0",
                             "effect spring 100 4 2 0")) == pytest.approx((1, 0, 0.5), abs=2e-6)
    assert force_after(still(tmp_path, "4 2 -5", "effect constant 1 0 0", "effect spring 100 4 2 0",
                             "effect constant off")) == pytest.approx((0, 0, 0.5), abs=2e-6)
    assert force_after(still(tmp_path, "4 2 -5", "effect constant 1 0 0", "effect spring 100 4 2 0",
                             "effect off")) == pytest.approx((0, 0, 0), abs=2e-6)


def test_viscous_and_friction_brake_a_moving_hand(tmp_path):
    rows = [(0, -20, 0, 0), (400, 20, 0, 0)]  # 0.1 m/s
    felt = moved(tmp_path, "-hand rigid", rows, "effect viscous 5")["fx_n"][100:380]
    assert felt == pytest.approx(numpy.full(280, -0.5), abs=2e-5)
    felt = moved(tmp_path, "-hand rigid", rows, "effect friction 0.7 1000")["fx_n"][100:380]
    assert felt == pytest.approx(numpy.full(280, -0.7), abs=2e-5)


def test_inertia_makes_a_free_handle_heavier(tmp_path):
    """1 N for 50 ms on 0.1 kg and on 0.1 + 0.3 kg, nobody holding it, without friction."""
    speed = {}
    for name, message in (("alone", "effect off"), ("heavy", "effect inertia 0.3")):
        patch = DevicePatch("-hand free -viscous 0 -stops 0 -interp off -passivity 0", 620)
        patch.at(0, message)
        patch.at(0, f"trace {tmp_path}/{name}.csv")
        patch.at(100, "list 0.1 0 0")
        patch.at(150, "list 0 0 0")
        patch.at(600, "trace stop")
        patch.run(tmp_path)
        rows = list(csv.DictReader((tmp_path / f"{name}.csv").open()))
        speed[name] = numpy.mean([float(row["vx_m_per_s"]) for row in rows[300:600]])
    assert speed["alone"] == pytest.approx(0.05, rel=0.01)
    assert speed["heavy"] == pytest.approx(0.1 * 0.05 / 0.4, rel=0.1)


def test_relief_is_felt_in_contact_and_not_above(tmp_path):
    for z, amplitude in ((-2, 600 * 0.0019 * math.pi * 0.2 / 4), (3, 0)):
        rows = [(0, -20, 0, z + 5), (50, -20, 0, z), (850, 20, 0, z)]
        felt = moved(tmp_path, "-hand rigid -slew 1000", rows,
                     r"scene add floor plane 0 0 1 0 \, scene mat floor 600", "effect relief 0.2 4")["fx_n"][100:700]
        assert numpy.abs(felt).max() == pytest.approx(amplitude, rel=0.02, abs=1e-9)
        if amplitude:
            spectrum = numpy.abs(numpy.fft.rfft(felt[:560]))  # 50 mm/s over 4 mm: 12.5 Hz, 7 ridges
            assert spectrum[1:].argmax() + 1 == 7


@pytest.mark.parametrize("effect", ["inertia 0.3", "friction 1", "spring 300 0 0 0", "viscous 4",
                                    "texture 0.3 4", "inertia 2 300 0"])
@pytest.mark.parametrize("hand", ["free", "spring 200 2", "person 200 2 0.1 1 1000"])
def test_effects_leave_the_hand_calm(tmp_path, effect, hand):
    """A knock, then 3 s: the handle does not hum, whoever holds it; encoder and observer as usual."""
    hold = hand.split()[0]
    patch = DevicePatch("-resolution 0.02", 3300)
    for ms, message in ((0, f"hand {hand}"), (0, "path line 5 0 0 5 0 0 1000"), (5, f"effect {effect}"),
                        (100, "list 2 0 0"), (130, "list 0 0 0"), (2300, f"trace {tmp_path}/ticks.csv"),
                        (3290, "trace stop")):
        patch.at(ms, message)
    patch.run(tmp_path)
    force = numpy.array([float(row["fx_n"]) for row in csv.DictReader((tmp_path / "ticks.csv").open())])
    hum = numpy.abs(numpy.diff(force, 2)).max()  # what a hum at half the servo's rate would make 4 N
    assert hum < (0.5 if hold == "person" else 0.3)


@pytest.mark.parametrize("message, sentence", [
    ("effect glue 1", "effect glue: expected constant, spring, viscous, inertia, friction, texture, relief or off"),
    ("effect spring 100", "effect spring: x is missing: expected -10000..10000 mm"),
    ("effect spring -1 0 0 0", "effect spring: k -1 N/m: expected 0..5000 N/m"),
    ("effect spring soft 0 0 0", "effect spring: k soft: expected 0..5000 N/m"),
    ("effect viscous 1e9", "effect viscous: b 1e+09 N s/m: expected 0..50 N s/m"),
    ("effect viscous 1 2", "effect viscous: takes 1 number at most"),
    ("effect inertia 0", "effect inertia: mass 0 kg: expected 0.001..20 kg"),
    ("effect texture 1 2 0 0 0", "effect texture: direction 0 0 0: expected one that is not zero"),
    ("effect texture 1 2 1", "effect texture: expected amplitude and wavelength"),
    ("effect relief 1 2", "effect relief: depth 1 mm: expected at most a quarter of the wavelength, 0.5 mm"),
])
def test_a_refused_effect_is_one_sentence_and_the_last_stays(tmp_path, message, sentence):
    result = still(tmp_path, "4 2 -5", "effect constant 1 0 0", message)
    assert len(result.errors) == 1 and sentence in result.errors[0], result.errors
    assert force_after(result) == pytest.approx((1, 0, 0), abs=2e-6)


def test_dump_tells_the_effects_that_are_on(tmp_path):
    result = still(tmp_path, "0 0 0", "effect inertia 0.2", "effect texture 0.5 2 0 0 3",
                   "effect viscous 1", "effect viscous off", "dump")
    rows = [row[1:] for row in result.info if row[0] == "effect"]
    assert rows == [["inertia", "0.2", "300", "1"], ["texture", "0.5", "2", "0", "0", "1"]]


def test_a_stiff_effect_is_said(tmp_path):
    result = still(tmp_path, "0 0 0", "effect spring 3000 0 0 0")
    assert "effect spring has 3000 N/m, above the 1000 N/m that this device holds" in result.text


@pytest.mark.parametrize("effect, rate, bound", [("viscous 50", 200, 4), ("viscous 50", 1000, 20),
                                                 ("viscous 15", 1000, 20), ("inertia 0.2 300 15", 500, 10),
                                                 ("inertia 0.5 200 18", 500, 10)])
def test_no_damper_hums_that_is_above_what_the_device_holds(tmp_path, effect, rate, bound):
    """200/s of 0.1 kg at 1 kHz, a fifth of it at 200 Hz: it is felt up to there, and said."""
    rows = [(0, -20, 0, 0), (200, 20, 0, 0), (1200, 20, 0, 0)]
    felt = moved(tmp_path, f"-hand spring 300 2 -rate {rate}", rows, f"effect {effect}")
    rest = numpy.stack([felt[axis][felt["ms"] > 700] for axis in ("fx_n", "fy_n", "fz_n")])
    assert numpy.abs(numpy.diff(rest, 2)).max() < 0.02
    result = still(tmp_path, "0 0 0", f"rate {rate}", f"effect {effect}")
    damping = float(effect.split()[-1])
    said = [row[2:] for row in result.info if row[:2] == ["status", "damped"]]
    assert said == ([[f"{damping:g}", f"{bound:g}"]] if damping > bound else [])
