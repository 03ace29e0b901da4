"""Two devices at once in one patch, each with its own servo: a Falcon and a SpaceMouse."""

import os
import re
import shlex
import time

import pytest

from live_pd import Live, Patch, motors


@pytest.fixture(name="live")
def two_devices(tmp_path):
    double = os.environ.get("TWO_DOUBLES")
    if not double:
        pytest.skip("umockdev is missing: apt-get install umockdev libumockdev-dev")
    patch = Patch("falcon -name hand")
    receiver, mouse = patch.obj("r mouse"), patch.obj("phantom hid -name mouse")
    patch.cord(receiver, 0, mouse, 0)
    for outlet, name in enumerate(("mx", "my", "mz", "minfo")):
        patch.cord(mouse, outlet, patch.obj(f"print {name}"), 0)
    patch.forward("mouse")
    world = [*shlex.split(double), "--report", str(tmp_path / "double.txt")]
    with Live(tmp_path, patch, world) as running:
        running.wait_for_patch()
        running.tell_phantom("open")
        running.tell_phantom("mouse open")
        running.wait_for(r"^info: status open falcon")
        running.wait_for(r"^minfo: status open hid")
        running.wait_for(r"^info: status homed 1")
        yield running


def ticks(live, tag):
    """Of one servo, as its statistics tell; they come every 128."""
    live.tell_phantom("stats" if tag == "info" else "mouse stats")
    time.sleep(0.1)
    found = re.findall(rf"^{tag}: stats ticks (\d+)", live.read(), re.M)
    return int(found[-1]) if found else 0


def push(live):
    """The Falcon's motors feel it; a machine that stalls looks like a device that has failed."""
    live.push("0 0 2")


def test_each_moves_its_own_outlets_and_has_its_own_servo(live):
    live.tell_double("mouse report 015e0100000000")  # 350 counts along X
    live.wait_for(r"^mx: 1$")
    live.wait_until(lambda: len(set(live.positions())) > 50)
    push(live)
    hand, mouse = ticks(live, "info"), ticks(live, "minfo")
    live.wait_until(lambda: ticks(live, "info") > hand + 100 and ticks(live, "minfo") > mouse + 100)
    live.tell_double("mouse report 01a2fe00000000")
    live.wait_for(r"^mx: 0$")
    assert motors(live.end()) == [0, 0, 0]


def test_losing_one_does_not_touch_the_other(live):
    push(live)
    live.tell_double("mouse unplug")
    live.wait_for(r"^minfo: status lost hid")
    frames = live.state()["frames"]
    live.wait_until(lambda: live.state()["frames"] > frames + 200)
    push(live)  # still, or again
    live.tell_double("mouse plug")
    live.wait_for(r"^minfo: status open hid", 2)

    live.tell_double("falcon unplug")
    live.wait_for(r"^info: status lost falcon")
    live.tell_double("mouse report 015e0100000000")
    live.wait_for(r"^mx: 1$")
    live.tell_double("falcon plug")
    live.wait_for(r"^info: status open falcon", 2)
    live.tell_phantom("motors 1")
    push(live)
    assert motors(live.end()) == [0, 0, 0]


def test_an_estop_of_one_is_its_own(live):
    push(live)
    live.tell_phantom("mouse estop")
    live.wait_for(r"^minfo: status estop 1")
    frames = live.state()["frames"]
    live.wait_until(lambda: live.state()["frames"] > frames + 200)
    push(live)
    assert "\ninfo: status estop 1" not in live.read()
    live.tell_phantom("estop")
    live.wait_until(lambda: motors(live.state()) == [0, 0, 0])
    live.tell_phantom("mouse motors 1")
    live.wait_for(r"^minfo: status estop 0")
    frames = live.state()["frames"]
    while live.state()["frames"] < frames + 700:
        live.tell_phantom("list 0 0 2")
        assert motors(live.state()) == [0, 0, 0]
        time.sleep(0.05)
    live.end()


def test_a_list_beside_both_shows_both_open(live):
    live.tell_phantom("devices")
    live.wait_for(r"^info: device falcon 0 Novint Falcon DOUBLE01 open", 2)  # at opening, and now
    live.wait_for(r"^info: device hid 0 .* open")
    assert motors(live.end()) == [0, 0, 0]
