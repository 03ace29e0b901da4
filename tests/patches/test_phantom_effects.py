"""The force effects of [phantom], `effect NAME numbers`, and its passivity controller, from a headless Pd."""
import math

import numpy
import pytest

from device import moved, play, still

slow = pytest.mark.slow


@pytest.mark.parametrize("message, force", [
    ("effect constant 1 -2 0.5", (1, -2, 0.5)),
    ("effect spring 200 0 0 0", (-0.8, -0.4, 1.0)),
    ("effect spring 4000 4 2 10 1.5", (0, 0, 1.5)),
    ("effect texture 0.5 16", (0.5, 0, 0)),
    ("effect texture 0.5 16 2 0 0", (0.5, 0, 0)),
    ("effect texture 0.5 8 0 1 0", (0, 0.5, 0)),
    ("effect constant 9 9 9, effect constant 1 0 0, effect spring 100 4 2 0", (1, 0, 0.5)),  # the newest wins; they add
    ("effect constant 1 0 0, effect spring 100 4 2 0, effect constant off", (0, 0, 0.5)),
    ("effect constant 1 0 0, effect spring 100 4 2 0, effect off", (0, 0, 0))])
def test_an_effect_of_the_position_gives_its_force(tmp_path, message, force):
    assert still(tmp_path, "4 2 -5", message).force == pytest.approx(force, abs=2e-6)


def test_dump_tells_the_effects_that_are_on_and_a_stiff_one_is_said(tmp_path):
    answer = still(tmp_path, "0 0 0", "effect inertia 0.2, effect texture 0.5 2 0 0 3, effect viscous 1",
                   "effect viscous off, dump, effect spring 3000 0 0 0")
    assert answer.told("effect") == [["inertia", pytest.approx(0.2), 300, 1], ["texture", 0.5, 2, 0, 0, 1]]
    assert "effect spring has 3000 N/m, above the 1000 N/m up to which this device" in answer.result.output


@pytest.mark.parametrize("effect, newton", [("viscous 5", -0.5), ("friction 0.7 1000", -0.7)])
def test_viscous_and_friction_brake_a_moving_hand(tmp_path, effect, newton):
    felt = moved(tmp_path, [(0, -20, 0, 0), (400, 20, 0, 0)], f"effect {effect}").trace["fx_n"][100:380]  # 0.1 m/s
    assert felt == pytest.approx(numpy.full(280, newton), abs=2e-5)


@pytest.mark.parametrize("effect, speed, rel", [("off", 0.05, 0.01), ("inertia 0.3", 0.1 * 0.05 / 0.4, 0.1)])
def test_inertia_makes_a_free_handle_heavier(tmp_path, effect, speed, rel):
    """0.1 N for 50 ms on 0.1 kg and on 0.1 + 0.3 kg, nobody holding it, without friction."""
    answer = play(tmp_path, [(0, f"effect {effect}"), (100, "list 0.1 0 0"), (150, "list 0 0 0")],
                  "-hand free -viscous 0 -stops 0 -interp off -passivity 0", 600, traced=True)
    assert answer.trace["vx_m_per_s"][300:580].mean() == pytest.approx(speed, rel=rel)


@pytest.mark.parametrize("z, amplitude", [(-2, 600 * 0.0019 * math.pi * 0.2 / 4), (3, 0)])
def test_relief_is_felt_in_contact_and_not_above(tmp_path, z, amplitude):
    answer = moved(tmp_path, [(0, -20, 0, z + 5), (50, -20, 0, z), (850, 20, 0, z)],
                   "scene add floor plane 0 0 1 0, scene mat floor 600", "effect relief 0.2 4",
                   arguments="-hand rigid -slew 1000")
    felt = answer.trace["fx_n"][100:700]
    assert numpy.abs(felt).max() == pytest.approx(amplitude, rel=0.02, abs=1e-9)
    if amplitude:
        spectrum = numpy.abs(numpy.fft.rfft(felt[:560]))  # 50 mm/s over 4 mm: 12.5 Hz, 7 ridges
        assert spectrum[1:].argmax() + 1 == 7


@pytest.mark.parametrize("effect, rate, bound", [
    ("viscous 50", 200, 4), pytest.param("viscous 50", 1000, 20, marks=slow), ("viscous 15", 1000, 20),
    pytest.param("inertia 0.2 300 15", 500, 10, marks=slow), ("inertia 0.5 200 18", 500, 10)])
def test_no_damper_hums_that_is_above_what_the_device_holds(tmp_path, effect, rate, bound):
    """200/s of 0.1 kg at 1 kHz, a fifth of it at 200 Hz: it is felt up to there, and said."""
    answer = moved(tmp_path, [(0, -20, 0, 0), (200, 20, 0, 0), (1200, 20, 0, 0)], f"effect {effect}",
                   arguments=f"-hand spring 300 2 -rate {rate}")
    felt = answer.trace
    rest = numpy.stack([felt[axis][felt["ms"] > 700] for axis in ("fx_n", "fy_n", "fz_n")])
    assert numpy.abs(numpy.diff(rest, 2)).max() < 0.02
    damping = float(effect.split()[-1])
    assert answer.told("status", "damped") == ([[damping, bound]] if damping > bound else [])


def last_second(folder, passivity, flags, messages):
    """RMS of the force about its mean, N, and the largest motion of an axis, mm."""
    answer = play(folder, messages, f"-passivity {passivity} {flags}", 3000, traced=True)
    rows = answer.trace
    forces, positions = (numpy.stack([rows[name.format(axis)] for axis in "xyz"], axis=1) for name in ("f{}_n", "{}_mm"))
    assert numpy.linalg.norm(numpy.diff(forces, axis=0), axis=1).max() <= 2 + 1e-6  # 2 N a millisecond
    forces, positions = forces[-1000:], positions[-1000:]
    return numpy.sqrt(((forces - forces.mean(axis=0)) ** 2).sum(axis=1).mean()), numpy.ptp(positions, axis=0).max()


def wall(stiffness, *more):
    return [(1, "scene add wall plane 0 1 0 0"), (2, f"scene mat wall {stiffness} 0 0"), *((3, m) for m in more)]


PERSON = "-resolution 0.034 -hand person 200 2 0.1 0 0"


@pytest.mark.parametrize("flags, messages", [
    (PERSON, wall(300)),  # 4.74 N rms against 0.04, with a brake that had no bound
    ("-resolution 0.034 -hand spring 50 0.5", wall(500, "path line 0 -5 0 0 -5 0 1000")),  # 5.6 mm against 0.06
    pytest.param("-hand free", wall(200, "list 0 -1 0"), marks=slow),  # ideal readings: 2.5 mm against 0.04
    pytest.param(PERSON, wall(2000, "path line 0 -2 0 0 -2 0 1000"), marks=slow)])
def test_the_passivity_controller_makes_no_quiet_contact_worse(tmp_path, flags, messages):
    off, on = (last_second(tmp_path, passivity, flags, messages) for passivity in (0, 1))
    stiffness = next(float(words.split()[3]) for _, words in messages if words.startswith("scene mat"))
    quiet_n = 0.034e-3 * stiffness if "resolution" in flags else 2e-3  # one step of the encoder (docs/results/passivity.md)
    assert on[0] <= max(1.1 * off[0], quiet_n) and on[1] <= max(1.1 * off[1], 0.02)


def test_a_wall_too_stiff_for_the_servo_is_tamed(tmp_path):
    """5000 N/m with 0.5 N s/m at 1 kHz is five times what friction holds: 1 N of push hums 10 mm."""
    off, on = (last_second(tmp_path, passivity, "-hand free", wall(5000, "list 0 -1 0"))[1] for passivity in (0, 1))
    assert off > 5 and on < 1.5
