"""Guidance in patches/reed/reed_haptic.pd: chosen by one name, and worth it for hands that do not know
where to go."""
import numpy
import pytest

from harness import Patch
from harness.run import ROOT
from harness.sound import RATE

PLAYS = 0.3        # of f_p
CEILING = 2        # N
SIGNALS = ("reed-fp", "reed-y", "reed-z", "reed-force-y", "reed-force-z")
CLARINET = (("reed-all", "preset clarinet"), ("reed-range", [0, 5000, 1000, 3500]),
            ("reed-note", 53))


def played(messages, seconds, *settings):
    patch = Patch(opens=ROOT / "patches" / "reed" / "reed_haptic.pd")
    patch.send(0, "reed-guide-set", "background 0")  # so that it repeats
    patch.send(0, "reed-guide-set", f"ceiling {CEILING}")
    for name, value in settings:
        patch.send(0, name, value)
    for ms, message in messages:
        patch.send(ms, "reed-hand", message)
    for name in SIGNALS:
        patch.record(name, patch.obj("r", name) >> patch.obj("sig~"))
    patch.log("map", patch.obj("r", "reed-guide-map"))
    return patch.render(seconds)


def held_at(y, z):
    return f"hand rigid, path line 0 {y:.6g} {z:.6g} 0 {y:.6g} {z:.6g} 1000"


def explored(hand, instrument, force, seed, seconds):
    """A hand that is brought to a place drawn evenly from the plane and then left to itself."""
    y, z = numpy.random.default_rng(seed).uniform(-50, 50, 2)
    return played([(0, f"seed {seed}"), (0, held_at(y, z)), (20, hand)], seconds, *instrument, *force)


def force_size(result):
    return numpy.hypot(result["reed-force-y"], result["reed-force-z"])


def speed(result):
    """Mean of the handle, sides of the plane a second, over steps of 10 ms."""
    y, z = (numpy.asarray(result[name][::480], dtype=float) for name in ("reed-y", "reed-z"))
    return numpy.hypot(numpy.diff(y), numpy.diff(z)).mean() * RATE / 480


OFF = (("reed-force-on", 0),)
GUIDE = (("reed-force-on", 1), ("reed-guide", 1))


PERSON = "hand person 200 2 0.1 15 1000"  # without a goal


@pytest.mark.parametrize("hand, instrument, seeds, seconds", [
    ("hand free", (), range(1, 3), 5), pytest.param(PERSON, CLARINET, range(1, 5), 15, marks=pytest.mark.slow)])
def test_with_guidance_a_hand_is_out_of_the_playable_region_half_as_long_at_most(hand, instrument, seeds, seconds):
    out, speeds = {}, {}
    for name, force in (("off", OFF), ("guide", GUIDE)):
        trials = [explored(hand, instrument, force, seed, seconds) for seed in seeds]
        out[name] = [float((t["reed-fp"] < PLAYS).mean()) for t in trials]
        speeds[name] = numpy.mean([speed(t) for t in trials])
    assert sum(out["off"]) > 0.3 * len(seeds)  # there is something to help with
    assert sum(out["guide"]) <= 0.5 * sum(out["off"])
    # It leads, once, by no more than the plane is wide, and does not shake.
    assert speeds["guide"] * seconds <= 1.5 * speeds["off"] * seconds + 0.75


def test_one_name_chooses_the_force():
    hand = [(0, held_at(-45, 0))]  # hardly blown: the slope of five silent reeds is nothing
    slope, guide, back, off = (
        played(hand, 1.2, ("reed-guide", 0)), played(hand, 1.2, ("reed-guide", 1)),
        played(hand, 1.2, ("reed-guide", 1), ("reed-guide", 0)),
        played(hand, 1.2, ("reed-guide", 1), ("reed-force-on", 0)))
    end = slice(int(1.1 * RATE), None)
    assert force_size(slope)[end].max() < 0.05
    assert force_size(guide)[end].min() > 0.95 * CEILING
    assert guide["reed-force-y"][-1] > 0  # towards more pressure
    assert force_size(off).max() == 0
    for name in SIGNALS:
        assert numpy.array_equal(slope[name], back[name]), name
    # It costs nothing where it is not chosen: not even its map is made.
    assert slope.logs["map"] == []
    assert guide.logs["map"][-1][1] == [1]


def test_guidance_follows_the_patch_s_plane_also_after_a_preset():
    """A preset has a range of its own, the patch another: the patch's holds."""
    hand = [(0, held_at(-20, 0))]
    by_order = [played(hand, 1.5, *order, ("reed-guide", 1)) for order in (
        (("reed-all", "preset clarinet"), ("reed-range", [0, 9000, 1000, 3500])),
        (("reed-range", [0, 9000, 1000, 3500]), ("reed-all", "preset clarinet")))]
    assert numpy.array_equal(*(force_size(r) for r in by_order))
