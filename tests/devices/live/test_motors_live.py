"""`motors` and `estop` on a Falcon's double: the newest wish holds, whatever else was said before
it, and a stop holds until the user ends it."""

import time

import pytest

from live_pd import Live, Patch, falcon_world, motors


def loaded(folder):
    """A patch with a closed Falcon, and the world where it is plugged in and knows its firmware."""
    patch = Patch("falcon")
    return patch, falcon_world(folder, "--loaded")


def no_force(live, seconds=0.7):
    """Pushes, and sees the motors without force for longer than they would take to come back. The
    double's report may be from before the cable was pulled or the device closed."""
    live.wait_until(lambda: motors(live.state()) == [0, 0, 0])
    frames, end = live.state()["frames"], time.monotonic() + seconds
    seen = set()
    while time.monotonic() < end or live.state()["frames"] < frames + 500:
        assert time.monotonic() < end + 30, "the double stands still"
        live.tell_phantom("list 0 0 2")
        seen |= set(motors(live.state()))
        time.sleep(0.05)
    return seen == {0}


def force_comes(live):
    """It does at once; a machine that stalls looks like a device that fails, which takes another
    `motors 1`."""
    end = time.monotonic() + 40
    while not any(abs(m) > 100 for m in motors(live.state())):
        assert time.monotonic() < end, f"no force came; Pd said:\n{live.read()[-3000:]}"
        live.tell_phantom("motors 1")
        live.tell_phantom("list 0 0 2")
        time.sleep(0.05)


def test_motors_off_before_opening_counts_however_often_they_were_on(tmp_path):
    patch, world = loaded(tmp_path)
    patch.at_once("many", ["motors 1"] * 70 + ["motors 0", "open"])
    with Live(tmp_path, patch, world) as live:
        live.wait_for_patch()
        live.tell_phantom("many bang")
        live.wait_for(r"^info: status homed 1")
        assert no_force(live)
        live.tell_phantom("get motors")
        live.wait_for(r"^info: motors 0")
        live.tell_phantom("motors 1")
        force_comes(live)
        live.end()


def test_what_is_said_while_it_is_unplugged_switches_no_motors_on(tmp_path):
    patch, world = loaded(tmp_path)
    patch.at(100, "open")
    patch.at_once("many", ["stats reset"] * 70)
    with Live(tmp_path, patch, world) as live:
        live.wait_for(r"^info: status homed 1")
        live.push("0 0 2")
        live.tell_double("unplug")
        live.wait_for(r"^info: status lost falcon")
        live.tell_phantom("many bang")
        live.tell_double("plug")
        live.wait_for(r"^info: status open falcon", 2)
        assert no_force(live)
        live.tell_phantom("motors 1")
        force_comes(live)
        live.end()


@pytest.mark.parametrize("before", ["stats reset", "motors 1"])
def test_an_estop_acts_whatever_came_at_the_same_instant(tmp_path, before):
    patch, world = loaded(tmp_path)
    patch.at(100, "open")
    patch.at_once("many", [before] * 200 + ["estop"])
    with Live(tmp_path, patch, world) as live:
        live.wait_for(r"^info: status homed 1")
        live.push("0 0 2")
        live.tell_phantom("many bang")
        live.wait_for(r"^info: status estop 1")
        live.wait_until(lambda: motors(live.state()) == [0, 0, 0])
        assert no_force(live)
        live.end()


def test_an_estop_holds_over_close_replug_and_another_phantom_of_its_device(tmp_path):
    patch, world = loaded(tmp_path)
    patch.at(100, "open")
    with Live(tmp_path, patch, world) as live:
        live.wait_for(r"^info: status homed 1")
        live.push("0 0 2")
        live.tell_phantom("estop")
        live.tell_phantom("close")
        live.wait_for(r"^info: status closed falcon")
        live.tell_phantom("rate 500")
        live.tell_phantom("clock wall")
        live.tell_phantom("open")
        live.wait_for(r"^info: status open falcon", 2)
        assert no_force(live)
        live.tell_double("unplug")
        live.wait_for(r"^info: status lost falcon")
        live.tell_double("plug")
        live.wait_for(r"^info: status open falcon", 3)
        assert no_force(live)
        live.tell_phantom("dump")
        live.wait_for(r"^info: estop 1")
        live.tell_phantom("motors 1")
        live.wait_for(r"^info: status estop 0")
        force_comes(live)
        live.end()


def test_an_estop_holds_for_a_new_phantom_with_the_same_device(tmp_path):
    """The object is deleted and made again, as when its box is edited."""
    patch = Patch("")
    patch.obj("pd made")
    world = falcon_world(tmp_path, "--loaded")

    made = [r"\; pd-made obj 10 10 r f", r"\; pd-made obj 10 50 phantom falcon",
            r"\; pd-made obj 10 90 print info", r"\; pd-made connect 0 0 1 0",
            r"\; pd-made connect 1 3 2 0"]

    def make(ms):
        for i, line in enumerate(made):
            box, delay = patch.obj(line, "msg"), patch.obj(f"delay {ms + i}")
            patch.cord(patch.start, 0, delay, 0)
            patch.cord(delay, 0, box, 0)

    make(100)
    to, again = patch.obj("r say"), patch.obj("s f")
    patch.cord(to, 0, again, 0)
    clear = patch.obj("r clear")
    remove = patch.obj(r"\; pd-made clear", "msg")
    patch.cord(clear, 0, remove, 0)
    for i, line in enumerate(made):
        delay, box = patch.obj(f"delay {10 + i}"), patch.obj(line, "msg")
        patch.cord(clear, 0, delay, 0)
        patch.cord(delay, 0, box, 0)
    patch.forward("say", "clear")
    with Live(tmp_path, patch, world) as live:
        live.wait_for_patch()
        time.sleep(0.3)
        live.tell_phantom("say open")
        live.wait_for(r"^info: status homed 1")
        live.push("0 0 2", "say")
        live.tell_phantom("say estop")
        live.wait_for(r"^info: status estop 1")
        live.tell_phantom("clear bang")
        time.sleep(0.3)
        live.tell_phantom("say open")
        live.wait_for(r"^info: status open falcon", 2)
        frames, seen = live.state()["frames"], set()
        while live.state()["frames"] < frames + 700:
            live.tell_phantom("say list 0 0 2")
            seen.update(motors(live.state()))
            time.sleep(0.05)
        assert seen == {0}
        live.wait_for(r"the estop of an earlier phantom holds for this one")
        live.tell_phantom("say motors 1")
        live.push("0 0 2", "say")
        live.end()
    assert motors(live.state()) == [0, 0, 0]


def test_an_estop_that_is_said_while_the_device_is_away_holds_for_who_opens_it_next(tmp_path):
    patch, world = loaded(tmp_path)
    patch.at(100, "open")
    second = patch.obj("phantom falcon")
    patch.cord(patch.obj("r second"), 0, second, 0)
    patch.cord(second, 3, patch.obj("print second"), 0)
    patch.forward("second")
    with Live(tmp_path, patch, world) as live:
        live.wait_for(r"^info: status homed 1")
        live.tell_double("unplug")
        live.wait_for(r"^info: status lost falcon")
        live.tell_phantom("estop")
        live.tell_phantom("close")
        live.wait_for(r"^info: status closed falcon")
        live.tell_double("plug")
        live.tell_phantom("second open")
        live.wait_for(r"^second: status (open|closed) falcon")
        live.wait_for(r"^second: status estop 1", seconds=10)
        live.end()
