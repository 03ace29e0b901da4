"""Two devices at once in one patch, each with its own servo: a Falcon, and an omega of the vendor's library."""
import os
import re
import time

import pytest

from live_pd import Live, Patch, falcon_world, motors


@pytest.fixture(name="live")
def two_devices(tmp_path):
    patch = Patch("falcon -name hand")
    receiver, other = patch.obj("r other"), patch.obj("phantom dhd -name other")
    patch.cord(receiver, 0, other, 0)
    for outlet, name in enumerate(("ox", "oy", "oz", "oinfo")):
        patch.cord(other, outlet, patch.obj(f"print {name}"), 0)
    patch.forward("other")
    with Live(tmp_path, patch, falcon_world(tmp_path, "--loaded"),
              {"TACTUS_LIBDHD": os.environ["HANGING_DHD"]}) as running:
        running.wait_for_patch()
        running.tell_phantom("open")
        running.tell_phantom("other open")
        running.wait_for(r"^oinfo: status sched")
        running.wait_for(r"^info: status homed 1")
        yield running


def moved(live):
    """The other one moves its outlet, under its own force."""
    seen = len(re.findall(r"^ox: ", live.read(), re.M))
    live.wait_until(lambda: live.tell_phantom("other motors 1") or live.tell_phantom("other list 0.2 0 0") or
                    len(re.findall(r"^ox: ", live.read(), re.M)) > seen + 5)
    live.tell_phantom("other list 0 0 0")


def test_each_moves_its_own_outlets_is_listed_and_lost_alone(live):
    live.wait_until(lambda: len(set(live.positions())) > 50)
    live.push("0 0 2")
    moved(live)
    live.tell_phantom("devices")
    live.wait_for(r"^info: device falcon 0 Novint Falcon DOUBLE01 open", 2)  # at opening, and now
    live.wait_for(r"^info: device dhd 0 .* open")
    live.tell_phantom("other close")
    live.wait_for(r"^oinfo: status closed dhd")
    live.push("0 0 2")  # still, or again
    live.tell_phantom("other open")
    live.wait_for(r"^oinfo: status sched", 2)
    live.unplug()
    moved(live)
    live.plug()
    live.tell_phantom("motors 1")
    live.push("0 0 2")


def test_an_estop_of_one_is_its_own(live):
    live.push("0 0 2")
    live.tell_phantom("other estop")
    live.wait_for(r"^oinfo: status estop 1")
    live.push("0 0 2")
    assert "\ninfo: status estop 1" not in live.read()
    live.tell_phantom("estop")
    live.wait_until(lambda: motors(live.state()) == [0, 0, 0])
    live.tell_phantom("other motors 1")
    live.wait_for(r"^oinfo: status estop 0")
    frames = live.state()["frames"]
    while live.state()["frames"] < frames + 700:
        live.tell_phantom("list 0 0 2")
        assert motors(live.state()) == [0, 0, 0]
        time.sleep(0.05)
