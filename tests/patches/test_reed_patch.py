"""patches/reed played headless: its arithmetic on known playabilities, its direction, and the tune of
./play reed; the lips and the syrinx of ./play fanfare."""
import math

import _birds
import _brass
import _reed_patch
import listening
import numpy
import pytest
import score

from harness import Patch, stage_folder
from harness.run import ROOT
from harness.sound import RATE

slow = pytest.mark.slow
REED = ROOT / "patches" / "reed"


# ---- arithmetic on known numbers -----------------------------------------------------------

@pytest.mark.parametrize("q, distance", [(0.5, 0.02), (0.01, 0.02), (0, 0.01), (1, 0.01), (0.997, 0.013)])
def test_the_slope_of_known_playabilities_is_exact_also_at_the_edges(q, distance):
    """f_p(q + D) and f_p(q - D) at q; the upper one arrives last."""
    patch = Patch()
    box = patch.obj("reed_difference")
    for ms, inlet, value in ((10, 2, q), (20, 1, 0.3125), (30, 0, 0.4375)):
        patch.at(ms, box[inlet], value)
    patch.log("slope", box)
    slope = patch.render(0.05, path=[REED]).logs["slope"][-1][1][0]
    # q and D are single-precision numbers: at an edge the distance 1 - q + D has their error, 6e-8.
    assert slope == pytest.approx(0.125 / distance, rel=1.2e-7 / distance)


STUBS = {
    # theta becomes the playability itself, a known function of what sigma gave.
    "greed~.pd": """#N canvas 0 0 500 300 12;
#X obj 10 10 inlet~;
#X obj 110 10 inlet~;
#X obj 210 10 inlet~;
#X obj 10 60 expr~ 1-pow($v1/8000-0.6 \\, 2)-pow(ln($v2/80)/ln(11.25)-0.3 \\, 2);
#X obj 10 110 outlet~;
#X obj 110 110 outlet~;
#X connect 0 0 3 0;
#X connect 1 0 3 1;
#X connect 3 0 5 0;
""",
    "playability~.pd": """#N canvas 0 0 300 300 12;
#X obj 10 10 inlet~;
#X obj 110 10 bang~;
#X obj 10 60 snapshot~;
#X obj 10 110 outlet;
#X connect 0 0 2 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
""",
}


def held_at(y, z):
    """The hand that holds the handle at y, z mm."""
    return f"hand rigid, path line 0 {y:.6g} {z:.6g} 0 {y:.6g} {z:.6g} 1000"


def whole_patch(messages, seconds, stubs=None, names=("reed-gradient-y", "reed-gradient-z")):
    patch = Patch(opens=REED / "reed_haptic.pd")
    for receiver, message in messages:
        patch.send(0, receiver, message)
    for name in names:
        patch.record(name, patch.obj("r", name) >> patch.obj("sig~"))
    patch.record("sound", patch.dac(1))
    return patch.render(seconds, RATE, path=[stubs] if stubs else [])


def test_the_whole_patch_finds_the_slope_of_a_known_playability(tmp_path):
    for name, text in STUBS.items():
        (tmp_path / name).write_text(text)
    result = whole_patch([("reed-hand", held_at(0, 0))], 0.2, tmp_path)
    # f = 1 - (y - 0.6)^2 - (z - 0.3)^2: slopes 0.2 and -0.4 at (0.5, 0.5). Two playabilities near 0.95
    # differ by a float32's 6e-8 at least: 1e-5 of slope from each rounding on the way.
    assert abs(result["reed-gradient-y"][-1] - 0.2) < 1e-4
    assert abs(result["reed-gradient-z"][-1] + 0.4) < 1e-4


@pytest.mark.parametrize("gradient, gain, limit", [(0.4, 0.3, 1), (-0.4, 0.3, 1), (-40, 0.3, 1), (2, 0.6, 0.5)])
def test_the_force_is_the_limited_gradient_rises_slowly_and_ends_with_it(gradient, gain, limit):
    """Of a gradient that comes every 2 ms for a second."""
    patch = Patch()
    box = patch.obj("reed_force", "reed")
    metro = patch.obj("metro", 2)
    metro >> patch.obj("f", gradient) >> box
    for name, value in (("reed-gain", gain), ("reed-force-max", limit)):
        patch.send(0, name, value)
    patch.at(10, metro, 1)
    patch.at(1010, metro, 0)
    patch.log("force", box)
    times, forces = numpy.array([(t, a[0]) for t, a in patch.render(1.4, path=[REED]).logs["force"]]).T
    steady = forces[times <= 1010]
    assert steady[-1] == pytest.approx(limit * math.tanh(gain * gradient / limit), abs=1e-4)
    assert abs(numpy.diff(steady)).max() <= 20 * 0.002 + 1e-5  # 20 N/s
    assert forces[-1] == 0 and times[-1] <= 1010 + 101


# ---- direction -----------------------------------------------------------------------------

@pytest.mark.parametrize("z, sign", [(-8, 1), pytest.param(7, -1, marks=slow), pytest.param(0, 1, marks=slow)])
def test_on_the_trumpet_the_slope_points_to_the_next_register(z, sign):
    result = whole_patch([("reed-hand", held_at(10, z))], 4)
    steady = result["reed-gradient-z"][-RATE:]
    assert sign * steady.mean() > 0.3, steady.mean()


# ---- the tune ------------------------------------------------------------------------------

@pytest.fixture(scope="module", params=[4, pytest.param(None, marks=slow)])  # s of it, or all
def tune(request):
    played = _reed_patch.gesture(*[request.param] * bool(request.param))
    sound = _reed_patch.render(played)["sound"]
    return played, sound, listening.measure_notes(sound, RATE, played.notes, score.frequency)


def test_every_note_of_the_tune_is_in_tune_at_the_level_that_the_score_asks_and_speaks_at_once(tune):
    played, sound, measured = tune
    off = {f"{n.onset:.2f} s {score.name(n.pitch)}": j["cents"]
           for n, j in zip(played.notes, measured) if j["sustained"]}
    assert len(off) > len(played.notes) / 2
    assert not {note: cents for note, cents in off.items() if not abs(cents) <= 10}
    uneven = numpy.array([j["level_db"] - asked for j, asked in zip(measured, played.intended_db)])
    assert abs(uneven - numpy.median(uneven)).max() < 2
    assert all(abs(j["cents"]) < 30 and j["fundamental_db"] > -30 for j in measured)
    late = [j["speaks_ms"] for j in measured if j["speaks_ms"] is not None]  # those that are tongued
    assert late and max(late) < 60
    assert listening.clicks(sound, RATE) == []
    assert 0.1 < abs(sound).max() < 0.5  # where [greed~]'s soft clip is still linear


def test_a_click_put_into_the_tune_would_be_heard(tune):
    played, sound, _ = tune
    note = max(played.notes, key=lambda n: n.duration)
    spoilt = sound.copy()
    spoilt[int((note.onset + 0.5 * note.duration) * RATE)] += 0.1  # a third of the tune's peak
    assert len(listening.clicks(spoilt, RATE)) == 1


# ---- lips and syrinx -----------------------------------------------------------------------

@slow
def test_the_fanfare_loses_no_note_is_in_tune_and_without_clicks_and_has_the_dynamics_of_the_score():
    for preset, channel, _, _, played, sound in _brass.perform():
        voice, notes, sound = f"{preset} {channel}", played.notes, sound.astype(float)
        measured = listening.measure_notes(sound, RATE, notes, score.frequency)
        assert abs(sound).max() < 0.5, voice  # where [greed~]'s soft clip is still linear
        for note, j in zip(notes, measured):
            where = f"{voice} {note.onset:.2f} s {score.name(note.pitch)}"
            assert abs(j["cents"]) < 10 and j["fundamental_db"] > -30 and j["level_db"] > -50, where
        steps = abs(numpy.diff(sound))
        held = max(steps[slice(*(int(s * RATE) for s in listening.steady(n)))].max() for n in notes)
        assert steps.max() < 2 * held, voice
        softest, loudest = (choice(n.velocity for n in notes) for choice in (min, max))
        levels = [numpy.mean([j["level_db"] for n, j in zip(notes, measured) if n.velocity == v])
                  for v in (softest, loudest)]
        assert levels[1] - levels[0] >= 20 * math.log10(loudest / softest), voice


@pytest.mark.parametrize("bird", _birds.BIRDS)
def test_every_syllable_of_a_bird_sounds_and_its_pitch_follows_the_valve(bird):
    sound, pressure, reed = _birds.sing(bird)
    heard, asked = [], []
    for begin, length, points, _ in _birds.SONGS[bird]():
        middle = slice(int((begin + 0.3 * length) * RATE), int((begin + 0.8 * length) * RATE))
        part = sound[middle].astype(float)
        assert numpy.sqrt((part ** 2).mean()) > 10 ** (-60 / 20), begin
        valve = reed[middle].mean()
        # 0.75..1.1: the windpipe holds the pitch down where the valve is tuned above its resonance.
        heard.append(listening.pitch_near(part, RATE, 0.93 * valve, 300) / valve)
        asked.append(valve)
    assert numpy.isfinite(heard).all(), heard
    assert 0.75 < min(heard) and max(heard) < 1.15, (min(heard), max(heard))


# ---- guidance: chosen by one name, and worth it for hands that do not know where to go ----------

PLAYS = 0.3        # of f_p
CEILING = 2        # N
SIGNALS = ("reed-fp", "reed-y", "reed-z", "reed-force-y", "reed-force-z")
CLARINET = (("reed-all", "preset clarinet"), ("reed-range", [0, 5000, 1000, 3500]),
            ("reed-note", 53))


def played(messages, seconds, *settings):
    patch = Patch(opens=REED / "reed_haptic.pd")
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


@pytest.mark.parametrize("hand, instrument, seeds, seconds", [("hand free", (), range(1, 3), 5)] + [
    pytest.param(hand, instrument, range(1, 5), 15, marks=slow)  # the table of docs/results/guidance.md
    for hand in ("hand free", PERSON) for instrument in ((), CLARINET)])
def test_with_guidance_a_hand_is_out_of_the_playable_region_half_as_long_at_most(hand, instrument, seeds, seconds):
    out, speeds = {}, {}
    for name, force in (("off", OFF), ("guide", GUIDE)):
        trials = [explored(hand, instrument, force, seed, seconds) for seed in seeds]
        out[name] = [float((t["reed-fp"] < PLAYS).mean()) for t in trials]
        speeds[name] = numpy.mean([speed(t) for t in trials])
    print(f"out of the region, off {numpy.mean(out['off']):.3f}, guide {numpy.mean(out['guide']):.3f};"
          f" mm/s, off {100 * speeds['off']:.0f}, guide {100 * speeds['guide']:.0f}")
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


# ---- the front of reed_haptic --------------------------------------------------------------

def test_the_sliders_lead_the_hand_as_the_map_does():
    patch = Patch(opens=stage_folder() / "reed_haptic.pd", own="own")
    patch.send(50, "own-force-on", 0)
    patch.send(100, "own-goal-y", 0.8)
    patch.send(200, "own-goal-z", 0.3)
    patch.send(1200, "own-drag", "0.2 0.6")
    for axis in "yz":
        patch.log(axis, patch.obj("r", f"own-{axis}"))
    logs = patch.render(2.4, RATE, dsp=False).logs

    def hand(ms):
        return [[value for at, (value,) in logs[axis] if at < ms][-1] for axis in "yz"]
    assert hand(1200) == pytest.approx([0.8, 0.3], abs=0.01)
    assert hand(2400) == pytest.approx([0.2, 0.6], abs=0.01)
