"""`motors` and `estop` on a Falcon's double: the newest wish holds, whatever else was said before
it, and a stop holds until the user ends it."""
import time

from live_pd import Live, Patch, falcon_world, motors


def homed(folder, patch=None):
    """Pd with a Falcon that is open, homed and pushes."""
    patch = patch or Patch("falcon")
    live = Live(folder, patch, falcon_world(folder, "--loaded"))
    live.wait_for_patch()
    live.tell_phantom("open")
    live.wait_for(r"^info: status homed 1")
    live.push("0 0 2")
    return live


def no_force(live, receiver=""):
    """Pushes, and sees the motors without force for longer than they would take to come back. The
    double's report may be from before the cable was pulled or the device closed."""
    live.wait_until(lambda: motors(live.state()) == [0, 0, 0])
    frames, end = live.state()["frames"], time.monotonic() + 0.7
    seen = set()
    while time.monotonic() < end or live.state()["frames"] < frames + 500:
        assert time.monotonic() < end + 60, "the double stands still"
        live.tell_phantom(f"{receiver} list 0 0 2".strip())
        seen |= set(motors(live.state()))
        time.sleep(0.05)
    return seen == {0}


def force_comes(live, receiver=""):
    live.tell_phantom(f"{receiver} motors 1".strip())
    live.push("0 0 2", receiver)


def test_motors_off_before_opening_counts_however_often_they_were_on(tmp_path):
    patch = Patch("falcon")
    patch.at_once("many", ["motors 1"] * 70 + ["motors 0", "open"])
    with Live(tmp_path, patch, falcon_world(tmp_path, "--loaded")) as live:
        live.wait_for_patch()
        live.tell_phantom("many bang")
        live.wait_for(r"^info: status homed 1")
        assert no_force(live)
        live.tell_phantom("get motors")
        live.wait_for(r"^info: motors 0")
        force_comes(live)


def test_what_is_said_while_it_is_unplugged_switches_no_motors_on(tmp_path):
    patch = Patch("falcon")
    patch.at_once("many", ["stats reset"] * 70)
    with homed(tmp_path, patch) as live:
        live.unplug()
        live.tell_phantom("many bang")
        live.plug()
        assert no_force(live)
        force_comes(live)


def test_an_estop_acts_at_any_instant_and_holds_over_close_and_replug(tmp_path):
    patch = Patch("falcon")
    patch.at_once("many", ["stats reset", "motors 1"] * 100 + ["estop"])
    with homed(tmp_path, patch) as live:
        live.tell_phantom("many bang")
        live.wait_for(r"^info: status estop 1")
        assert no_force(live)
        live.tell_phantom("close")
        live.wait_for(r"^info: status closed falcon")
        live.tell_phantom("rate 500")
        live.tell_phantom("clock wall")
        live.wait_for_answer(lambda: live.tell_phantom("open"), r"^info: status open falcon")
        assert no_force(live)
        live.unplug()
        live.plug()
        assert no_force(live)
        live.tell_phantom("dump")
        live.wait_for(r"^info: estop 1")
        force_comes(live)
        live.wait_for(r"^info: status estop 0")


def test_an_estop_outlives_its_object_also_while_the_device_is_away(tmp_path):
    """Another object, as when a box is edited, opens the device of a stopped one that is deleted."""
    patch = Patch("falcon")
    patch.lines.append("#N canvas 0 0 9 9 made 0;\n#X obj 0 0 r doomed;\n#X obj 0 0 phantom falcon;\n"
                       "#X obj 0 0 print doomed;\n#X connect 0 0 1 0;\n#X connect 1 3 2 0;\n"
                       "#X restore 0 0 pd made;")
    patch.cord(patch.obj("r clear"), 0, patch.obj(r"\; pd-made clear", "msg"), 0)
    patch.forward("doomed", "clear")
    with Live(tmp_path, patch, falcon_world(tmp_path, "--loaded")) as live:
        live.wait_for_patch()
        live.tell_phantom("doomed open")
        live.wait_for(r"^doomed: status homed 1")
        live.push("0 0 2", "doomed")
        live.tell_double("unplug")
        live.wait_for(r"^doomed: status lost falcon")
        live.tell_phantom("doomed estop")
        live.wait_for(r"^doomed: status estop 1")
        live.tell_phantom("clear bang")
        live.tell_double("plug")
        live.wait_until(lambda: live.tell_phantom("open") or "\ninfo: status open falcon" in live.read())
        live.wait_for(r"the estop of an earlier phantom of the same name or device is still active")
        assert no_force(live)
        force_comes(live)
