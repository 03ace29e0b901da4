"""[tactus_pads] and foot_pad.pd: a recorded take of velocity-sensitive pads becomes forces under two feet, and
[footstep~] finds every heel and ball in them."""
import numpy
import pytest

from harness import Patch
from harness.run import ROOT
from harness.sound import RATE

LIVE = ROOT / "patches" / "live"
START_MS = 100
PADS = {36: ("left", "heel"), 38: ("left", "ball"), 40: ("right", "heel"), 41: ("right", "ball")}


def take():
    """[(ms, message)] of the recorded take."""
    now, events = START_MS, []
    for line in (LIVE / "foot_demo.txt").read_text().splitlines():
        wait, message = line.rstrip(";").split(" ", 1)
        now += float(wait)
        events.append((now, message))
    return events


def render(events, seconds):
    patch = Patch()
    pads = patch.obj("tactus_pads 0")
    feet = patch.obj("footstep~ wood -feet 2 -source sensors")
    for i in range(4):
        pads[i] >> feet[i]
        patch.record(f"force {i}", pads[i])
    pads[4] >> feet
    patch.log("messages", pads[4])
    patch.log("info", feet[8])
    for ms, message in events:
        patch.at(ms, pads, message)
    patch.record("left", feet[0])
    patch.record("right", feet[4])
    return patch.render(seconds, path=[LIVE])


@pytest.fixture(scope="module")
def walked():
    return render(take(), take()[-1][0] / 1000 + 1)


def landings(result, until=5000):
    return [(ms, atoms[1], atoms[2], atoms[3]) for ms, atoms in result.logs["info"]
            if len(atoms) == 4 and ms < until]


def test_every_pad_is_a_landing_of_its_foot(walked):
    played = [(ms, int(m.split()[1]), int(m.split()[2])) for ms, m in take()
              if m.startswith("note") and m.split()[2] != "0" and int(m.split()[1]) in PADS]
    found = landings(walked)
    assert len(found) == len(played) == 16
    for (ms, key, _), (at, foot, part, _) in zip(played, found):
        assert (foot, part) == PADS[key] and 0 < at - ms < 12


def test_a_harder_pad_lands_harder_with_more_force(walked):
    heels = [speed for _, _, part, speed in landings(walked) if part == "heel"]
    assert heels == sorted(heels) and heels[-1] > 2 * heels[0]
    for i, keys in enumerate(PADS):
        last = max(int(m.split()[2]) for _, m in take() if m.startswith(f"note {keys} "))
        assert walked[f"force {i}"].max() == pytest.approx(700 * (0.25 + last / 127), rel=1e-3)


def test_the_force_rises_holds_and_falls_to_nothing():
    force = render([(100, "weight 1000"), (200, "note 36 127"), (900, "note 36 0"), (1500, "note 36 64"),
                    (1501, "note 36 0")], 2)["force 0"]
    at = lambda ms: force[int(ms * RATE / 1000)]  # noqa: E731
    assert numpy.abs(force[:int(0.2 * RATE)]).max() == 0
    assert force.max() == pytest.approx(1250, rel=1e-3)
    assert at(500) == pytest.approx(1000, rel=1e-3) and at(890) == at(500)
    assert at(980) == 0
    # A pad that ends its note at once still makes a stance of 0.16 s and more.
    assert at(1640) > 500 and at(1740) == 0


def test_a_jump_takes_off_and_lands(walked):
    after = [(ms, atoms) for ms, atoms in walked.logs["info"] if ms > 5000]
    lands = [ms for ms, atoms in after if atoms[2] == "ball" and atoms[3] > 1]
    off = [ms for ms, atoms in after if atoms[2] == "toe_off"]
    assert len(lands) == len(off) == 2
    flight = (lands[0] - off[0]) / 1000
    assert flight == pytest.approx(2 * (2 * 0.42 / 9.81) ** 0.5, rel=0.05)  # velocity 100: 0.42 m


def test_programs_choose_the_ground_and_it_ends_in_silence(walked):
    assert [atoms for _, atoms in walked.logs["messages"] if atoms[0] == "surface"] == [
        ["surface", "gravel"], ["surface", "snow"], ["surface", "concrete"]]
    for side in ("left", "right"):
        assert numpy.abs(walked[side]).max() <= 1
        assert numpy.abs(walked[side][-RATE // 4:]).max() < 1e-4 * numpy.abs(walked[side]).max()
    assert not any(walked[f"force {i}"][-1] for i in range(4))


def test_the_patch_sounds_by_one_click_and_not_before():
    patch = Patch(opens=LIVE / "foot_pad.pd")
    patch.send(1000, "help-play", "bang")
    patch.record("sound", patch.dac(1))
    sound = patch.render(4, path=[LIVE])["sound"]
    assert numpy.abs(sound[:RATE]).max() == 0
    assert 0.05 < numpy.abs(sound).max() <= 1


def test_unknown_keys_and_programs_do_nothing():
    result = render([(100, "note 12 90"), (150, "program 15"), (200, "program -1"), (250, "note 99 1")], 0.5)
    assert not result.logs["info"] and not result.logs["messages"]


@pytest.mark.parametrize("message", ["silence", "control 120 0", "control 123 0"])
def test_what_ends_all_notes_lifts_the_pads(message):
    result = render([(START_MS, "note 36 127"), (START_MS, "note 41 127"), (400, message)], 0.7)
    heel, ball = result["force 0"], result["force 3"]
    assert min(heel[int(0.39 * RATE)], ball[int(0.39 * RATE)]) > 500
    assert not heel[int(0.65 * RATE):].any() and not ball[int(0.65 * RATE):].any()
