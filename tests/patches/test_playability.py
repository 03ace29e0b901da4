"""[playability~], [greed_gradient~] and [playability_map] in a headless Pd."""

import math

import numpy
import pytest

from harness import Patch

RATE = 48000
TRUMPET = ["trumpet", "-range", 0, 8000, 80, 900]
HUGE = 1e30


def numbers(log):
    return [[atom for atom in atoms if not isinstance(atom, str)] for _, atoms in log]


def last(result, name):
    return numbers(result.logs[name])[-1]


def sine(amplitude, frequency, seconds):
    return amplitude * numpy.sin(2 * numpy.pi * frequency * numpy.arange(int(seconds * RATE)) / RATE)


@pytest.mark.parametrize("block", [1, 64, 4096])
def test_a_sine_has_its_closed_form_envelope_rate_and_pitch(block):
    patch = Patch(block=block)
    judge = patch.signal(sine(0.03, 220, 4)) >> patch.obj(
        "playability~", "-attack", 100, "-release", 100)
    for outlet, name in enumerate(("f_p", "envelope", "rate", "variation", "analysis", "regime")):
        patch.log(name, judge[outlet])
    result = patch.render(seconds=1.9, rate=RATE)
    envelope = last(result, "envelope")[0]
    assert abs(envelope / (0.06 / math.pi) - 1) < 0.01
    assert abs(last(result, "f_p")[0] - envelope / (envelope + 0.03)) < 1e-5
    assert abs(last(result, "rate")[0] - 220) <= 20
    assert last(result, "variation")[0] < 1e-3
    pitch, periodicity, harmonicity, centroid = last(result, "analysis")
    assert abs(pitch - 220) < 0.1 and abs(centroid - 220) < 5
    assert periodicity > 0.999 and harmonicity > 30
    assert last(result, "regime") == [1]


def test_the_judge_without_analysis_keeps_two_outlets_silent():
    patch = Patch()
    judge = patch.signal(sine(0.03, 220, 0.5)) >> patch.obj("playability~", "-analysis", 0)
    patch.log("f_p", judge[0])
    patch.log("analysis", judge[4])
    patch.log("regime", judge[5])
    result = patch.render(seconds=0.4, rate=RATE)
    assert len(result.logs["f_p"]) > 100
    assert result.logs["analysis"] == [] and result.logs["regime"] == []


def test_the_judge_refuses_what_is_out_of_range():
    patch = Patch()
    judge = patch.obj("playability~")
    patch.at(10, judge, "ref -1")
    patch.at(20, judge, "mode nice")
    patch.render(0.1, expect_errors=["playability~: ref -1 rad: expected", "playability~: mode nice"])


def gradient(patch, y, z, *flags):
    reed = patch.obj("greed_gradient~", *TRUMPET, *flags)
    patch.at(0, reed, y)
    patch.obj("sig~", z) >> reed[1]
    patch.log("f_p", reed[1])
    patch.log("gradient", reed[2])
    patch.record("sound", reed[0])
    return reed


def test_the_gradient_of_one_object_is_that_of_five_reeds():
    """The paper's patch, drawn out: five greed~, five playability~, central differences."""
    delta, y, z = 0.01, 0.6, 0.42
    patch = Patch()
    gradient(patch, y, z)
    places = [(y, z), (y + delta, z), (y - delta, z), (y, z + delta), (y, z - delta)]
    for index, (at_y, at_z) in enumerate(places):
        reed = patch.obj("greed~", "-preset", "trumpet")
        patch.obj("sig~", 8000 * at_y) >> reed
        patch.obj("sig~", 80 * (900 / 80) ** at_z) >> reed[1]
        judge = reed[1] >> patch.obj("playability~", "-analysis", 0)
        patch.log(f"f{index}", judge[0])
    result = patch.render(seconds=2, rate=RATE)
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
    gradient(patch, 0.05, 0.45, "-mode", "growth")
    result = patch.render(seconds=1.5, rate=RATE)
    assert last(result, "f_p")[0] < 1e-3
    assert last(result, "gradient")[0] > 0.5


def test_a_rebuilt_graph_plays_on():
    patch = Patch()
    gradient(patch, 0.6, 0.42)
    for ms in range(1000, 1500, 10):
        patch.rebuild_dsp(ms)
    result = patch.render(seconds=2, rate=RATE)
    f = numpy.array(numbers(result.logs["f_p"]))[:, 0]
    assert f[-100:].min() > 0.9 * f[700:740].mean()


@pytest.mark.parametrize("strange", [math.nan, math.inf, -math.inf, HUGE, -HUGE])
def test_a_strange_hand_is_survived(strange):
    patch = Patch()
    reed = gradient(patch, 0.6, 0.42)
    for inlet in range(3):
        patch.at(300 + 100 * inlet, reed[inlet], strange)
    patch.at(700, reed, 0.6)
    patch.at(700, reed[1], 0.42)
    patch.at(700, reed[2], 0)
    result = patch.render(seconds=2.5, rate=RATE)
    assert numpy.isfinite(numpy.array(numbers(result.logs["gradient"]))).all()
    assert abs(result["sound"]).max() <= 1
    assert last(result, "f_p")[0] > 0.3


def test_the_gradient_refuses_a_plane_without_extent():
    patch = Patch()
    reed = patch.obj("greed_gradient~", "trumpet")
    patch.at(10, reed, "range 5 5 80 900")
    patch.at(20, reed, "preset kazoo")
    patch.at(30, reed, "delta 0")
    patch.render(0.1, expect_errors=["greed_gradient~: range: expected p_lo < p_hi",
                                     "greed_gradient~: preset kazoo: expected clarinet",
                                     "greed_gradient~: delta 0: expected"])


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
    first = patch.render(1, rate=RATE)
    grid = cells(first)
    assert numpy.isfinite(grid).all()
    assert last(first, "progress") == [1]
    assert abs(last(first, "value")[0] - grid[4, 6]) < 1e-5
    slope = last(first, "gradient")
    assert abs(slope[0] - (grid[4, 7] - grid[4, 5]) * 5) < 1e-4
    assert abs(slope[1] - (grid[5, 6] - grid[3, 6]) * 5) < 1e-4

    patch = Patch()
    box = map_box(patch)
    patch.at(5, box, f"read {kept}")
    patch.at(10, box, "compute")
    second = patch.render(0.5, rate=RATE)
    assert (cells(second) == grid).all()


def test_a_map_by_theory_has_the_sign_of_what_sounds():
    patch = Patch()
    box = map_box(patch, "-quantity", "growth")
    patch.at(10, box, "compute")
    grid = cells(patch.render(0.5, rate=RATE))
    assert grid[4, 6] > 0 and grid[10, 2] < 0


def test_a_damaged_file_of_maps_is_refused(tmp_path):
    (tmp_path / "no.txt").write_text("something else\n")
    patch = Patch()
    box = map_box(patch)
    patch.at(10, box, f"read {tmp_path}/no.txt")
    patch.at(20, box, "draw")
    patch.at(30, box, "read nowhere.txt")
    patch.render(0.2, expect_errors=["holds no playability maps", "no map yet",
                                     "cannot find nowhere.txt"])
