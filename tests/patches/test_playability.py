"""[playability~], [greed_gradient~] and [playability_map] in a headless Pd."""

import math

import numpy
import pytest

from harness import Patch, stage_folder
from harness.run import ROOT
from harness.sound import RATE, level

REED = ROOT / "patches" / "reed"
TRUMPET = ["trumpet", "-range", 0, 8000, 80, 900]


def numbers(log):
    return [[atom for atom in atoms if not isinstance(atom, str)] for _, atoms in log]


def last(result, name):
    return numbers(result.logs[name])[-1]


def sine(amplitude, frequency, seconds):
    return amplitude * numpy.sin(2 * numpy.pi * frequency * numpy.arange(int(seconds * RATE)) / RATE)


def test_a_sine_has_its_closed_form_envelope_rate_and_pitch():
    patch = Patch()
    estimator = patch.signal(sine(0.03, 220, 4)) >> patch.obj(
        "playability~", "-attack", 100, "-release", 100)
    for outlet, name in enumerate(("f_p", "envelope", "rate", "variation", "analysis", "regime")):
        patch.log(name, estimator[outlet])
    result = patch.render(1.9)
    envelope = last(result, "envelope")[0]
    assert abs(envelope / (0.06 / math.pi) - 1) < 0.01
    assert abs(last(result, "f_p")[0] - envelope / (envelope + 0.03)) < 1e-5
    assert abs(last(result, "rate")[0] - 220) <= 20
    assert last(result, "variation")[0] < 1e-3
    pitch, periodicity, harmonicity, centroid = last(result, "analysis")
    assert abs(pitch - 220) < 0.1 and abs(centroid - 220) < 5
    assert periodicity > 0.999 and harmonicity > 30
    assert last(result, "regime") == [1]


def f_p_of(theta, *arguments, analysis=False):
    patch = Patch()
    estimator = patch.signal(theta) >> patch.obj("playability~", *arguments)
    patch.log("f_p", estimator[0])
    patch.log("analysis", estimator[4])
    result = patch.render(1.2)
    assert bool(result.logs["analysis"]) == analysis
    return numpy.array(numbers(result.logs["f_p"]))[:, 0]


def shaken_valve(seconds, level):
    """White noise through a resonance of 600 Hz and Q = 1: as a valve moves that is shaken at random."""
    spectrum = numpy.fft.rfft(numpy.random.default_rng(3).standard_normal(int(seconds * RATE)))
    ratio = numpy.fft.rfftfreq(int(seconds * RATE), 1 / RATE) / 600
    theta = numpy.fft.irfft(spectrum / (1 - ratio**2 + 1j * ratio))
    return level * theta / theta.std()


@pytest.mark.parametrize("arguments", [[], ["paper"], ["-mode", "robust", "-analysis", 0]])
def test_noise_does_not_play_a_sine_does_and_a_shaken_valve_deceives_the_papers_mode_alone(arguments):
    analysis = 0 not in arguments
    noise = 0.03 * numpy.random.default_rng(2).standard_normal(2 * RATE)
    assert f_p_of(noise, *arguments, analysis=analysis)[-300:].max() < 0.1
    tone = f_p_of(sine(0.03 * math.sqrt(2), 220, 2), *arguments, analysis=analysis)
    # The envelope of attack 5 and release 80 ms lies between the rectified mean and the peak.
    envelope = 0.03 * math.sqrt(2) * numpy.array([2 / math.pi, 1])
    low, high = envelope / (envelope + 0.03)
    assert low < tone[-1] < high
    shaken = f_p_of(shaken_valve(2, 0.03), *arguments, analysis=analysis)
    assert shaken[-1] > 0.3 if arguments == ["paper"] else shaken[-300:].max() < 0.1


def gradient(patch, y, z, *flags, record=True):
    reed = patch.obj("greed_gradient~", *TRUMPET, *flags)
    patch.at(0, reed, y)
    patch.obj("sig~", z) >> reed[1]
    patch.log("f_p", reed[1])
    patch.log("gradient", reed[2])
    patch.log("info", reed[3])
    patch.log("force", reed[4])
    if record:
        patch.record("sound", reed[0])
    return reed


def test_the_gradient_of_one_object_is_that_of_five_reeds():
    """The paper's patch, drawn out: five greed~, five playability~, central differences."""
    delta, y, z = 0.01, 0.6, 0.42
    patch = Patch()
    gradient(patch, y, z)
    points = [(y, z), (y + delta, z), (y - delta, z), (y, z + delta), (y, z - delta)]
    for index, (at_y, at_z) in enumerate(points):
        reed = patch.obj("greed~", "-preset", "trumpet")
        patch.obj("sig~", 8000 * at_y) >> reed
        patch.obj("sig~", 80 * (900 / 80) ** at_z) >> reed[1]
        estimator = reed[1] >> patch.obj("playability~", "paper", "-analysis", 0)
        patch.log(f"f{index}", estimator[0])
    result = patch.render(2)
    f = [numpy.array(numbers(result.logs[f"f{i}"])[750:])[:, 0].mean() for i in range(5)]
    both = numpy.array(numbers(result.logs["gradient"])[750:]).mean(axis=0)
    one = numpy.array(numbers(result.logs["f_p"])[750:]).mean()
    assert abs(one - f[0]) < 2e-4
    # Means over 1 s; a difference of 2e-4 in f_p over 2 delta is 0.01.
    assert abs(both[0] - (f[1] - f[2]) / (2 * delta)) < 0.02
    assert abs(both[1] - (f[3] - f[4]) / (2 * delta)) < 0.02
    assert both[1] > 0
    assert 0.01 < abs(result["sound"]).max() <= 1


def test_growth_mode_leads_from_silence():
    patch = Patch()
    gradient(patch, 0.05, 0.45, "-mode", "growth", "-background", 0)
    result = patch.render(1.5)
    assert last(result, "f_p")[0] < 1e-3
    assert last(result, "gradient")[0] > 0.5


def test_guide_mode_pulls_to_a_note_by_its_map_and_goes_on_by_the_old_one_while_there_is_audio():
    patch = Patch()
    reed = gradient(patch, 0.05, 0.45, "-mode", "guide", "-background", 0)
    patch.at(1000, reed, "ceiling 0.7")
    patch.at(1200, reed, "ceiling 2, range 0 4000 80 900")
    patch.at(2200, patch.obj("s", "pd"), "dsp 0")
    result = patch.render(2.5)
    forces = numpy.array(numbers(result.logs["force"]))
    times, size = numpy.array([ms for ms, _ in result.logs["force"]]), numpy.hypot(*forces.T)
    news = [(ms, atoms[1]) for ms, atoms in result.logs["info"] if atoms[0] == "map"]
    shares = [share for ms, share in news if ms < 1200]
    assert shares == sorted(shares) and shares[-1] == 1 and len(shares) > 5
    done, anew = (ms for ms, share in news if share == 1)
    assert 500 < done < 650 and anew > 1500  # 1681 nodes, 3000 a second
    assert not size[times < done].any()
    settled = (times > done + 200) & (times < 1000)
    assert abs(size[settled] - 2).max() < 0.05 and (forces[settled, 0] > 1).all()
    limited = numpy.flatnonzero(times < 1200)[-1]
    slope = [atoms for ms, atoms in result.logs["gradient"] if ms < 1200][-1]
    assert abs(size[limited] - 0.7) < 0.02 and forces[limited] == pytest.approx(0.7 * numpy.array(slope), abs=0.01)
    assert size[(times > 1400) & (times < 2200)].min() > 1.5
    assert 2290 < times[-1] < 2310 and not forces[-1].any() and size[-2] > 1.5


def test_a_map_made_in_a_thread_arrives_while_the_patch_plays():
    """Pd renders faster than it lives: it plays until the thread is done, and half a second more."""
    patch = Patch()
    reed = gradient(patch, 0.05, 0.45, "-mode", "guide", record=False)
    done = reed[3] >> patch.obj("route", "map") >> patch.obj("select", 1)
    done >> patch.obj("delay", 500) >> patch.obj("s", "harness-end")
    result = patch.render(7200, timeout=300)
    assert last(result, "info") == [1]
    assert abs(math.hypot(*last(result, "force")) - 2) < 0.05


def test_a_slope_s_force_is_the_patch_s_law():
    patch = Patch()
    reed = gradient(patch, 0.5, 0.42, "-ceiling", 1)
    law = [patch.obj("reed_force"), patch.obj("reed_force")]
    split = reed[2] >> patch.obj("unpack", "f", "f")
    for axis in (0, 1):
        split[axis] >> law[axis]
        patch.log(f"law{axis}", law[axis])
    result = patch.render(1.5, path=[REED])
    forces = numpy.array(numbers(result.logs["force"]))
    for axis in (0, 1):
        by_patch = numpy.array(numbers(result.logs[f"law{axis}"]))[:, 0]
        # The patch smooths once a block, the object every 32 samples.
        assert abs(forces[300:, axis] - by_patch[300:]).max() < 0.02
        assert abs(by_patch[300:]).max() > 0.05


def test_a_bore_frequency_that_is_no_number_leaves_the_last_good_one():
    def played(*strange):
        patch = Patch()
        reed = gradient(patch, 0.6, 0.42)
        patch.at(10, reed[2], 233)
        for ms, value in strange:
            patch.at(ms, reed[2], value)
        return patch.render(0.6)["sound"]
    steady = played()
    assert numpy.array_equal(steady, played((200, math.nan), (300, math.inf), (400, -math.inf)))
    assert not numpy.array_equal(steady, played((200, 0)))


def map_box(patch, *flags):
    box = patch.obj("playability_map", *TRUMPET, "-columns", 11, "-rows", 11, "-background", 0,
                    *flags)
    for outlet, name in enumerate(("value", "gradient", "cells", "progress")):
        patch.log(name, box[outlet])
    return box


def cells(result):
    grid = numpy.full((11, 11), numpy.nan)
    for _, atoms in result.logs["cells"]:
        if atoms[0] == "cell":
            assert all(0 <= c <= 255 for c in atoms[4:7])
            grid[int(atoms[2]), int(atoms[1])] = atoms[3]
    return grid


def test_a_map_is_drawn_looked_up_and_found_again(tmp_path):
    kept = tmp_path / "maps.txt"
    patch = Patch()
    box = map_box(patch)
    patch.at(10, box, "compute")
    patch.at(900, box[1], 0.4)
    patch.at(901, box, 0.6)
    patch.at(920, box, f"write {kept}")
    first = patch.render(1)
    grid = cells(first)
    assert numpy.isfinite(grid).all()
    assert last(first, "progress") == [1]
    assert abs(last(first, "value")[0] - grid[4, 6]) < 1e-5
    slope = last(first, "gradient")
    assert abs(slope[0] - (grid[4, 7] - grid[4, 5]) * 5) < 1e-4
    assert abs(slope[1] - (grid[5, 6] - grid[3, 6]) * 5) < 1e-4

    (tmp_path / "no.txt").write_text("something else\n")
    patch = Patch()
    box = map_box(patch)
    patch.at(4, box, f"read {tmp_path}/no.txt")
    patch.at(5, box, f"read {kept}")
    patch.at(10, box, "compute")
    assert (cells(patch.render(0.5, expect_errors=["is not a file of playability maps"])) == grid).all()


def test_a_map_by_theory_has_the_sign_of_what_sounds():
    patch = Patch()
    box = map_box(patch, "-quantity", "growth")
    patch.at(10, box, "compute")
    grid = cells(patch.render(0.5))
    assert grid[4, 6] > 0 and grid[10, 2] < 0


@pytest.mark.parametrize("rate", [44100, pytest.param(96000, marks=pytest.mark.slow)])
def test_the_help_of_greed_gradient_leads_a_hand_from_silence_to_a_note(rate):
    def heard(*more):
        patch = Patch(opens=stage_folder() / "greed_gradient~-help.pd", own="own")
        patch.send(100, "help-play", "bang")
        for ms, receiver, value in more:
            patch.send(ms, receiver, value)
        patch.record("sound", patch.dac(1))
        return level(patch.render(3.5, rate, dsp=False)["sound"][2 * rate:3 * rate])
    assert -40 < heard() < -20
    assert heard((200, "own-force", 0)) < -80
