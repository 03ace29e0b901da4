"""A system that gives no more threads costs one sentence: the objects that want one stay sane, and
work again when there are some."""

import os
import re

import pytest

from live_pd import Live, Patch
from test_hang_live import vendors_world


class World:
    def __init__(self, folder):
        self.file = folder / "no_threads.txt"
        self.environment = dict(vendors_world(folder), LD_PRELOAD=os.environ["NO_THREADS_LIBRARY"],
                                NO_THREADS=str(self.file))

    def without(self):
        self.file.write_text("")

    def again(self):
        self.file.unlink()


def errors(live):
    return re.findall(r"^error: (.*)$", live.read(), re.M)


def test_a_simulated_device_on_the_wall_s_clock(tmp_path):
    world = World(tmp_path)
    with Live(tmp_path, Patch("sim"), environment=world.environment) as live:
        live.wait_for_patch()
        world.without()
        live.tell_phantom("clock wall")
        live.wait_for(r"^info: status closed sim")
        (error,) = errors(live)
        assert "clock wall: cannot start the servo's thread (Resource temporarily" in error
        world.again()
        live.tell_phantom("open")
        live.wait_for(r"^info: status sched")

        world.without()  # a parameter, which has nobody to answer to, restarts the thread
        live.tell_phantom("rate 500")
        live.wait_for(r"^info: status closed sim", 2)
        assert len(errors(live)) == 2
        world.again()
        live.tell_phantom("clock logical")
        live.tell_phantom("open")
        live.tell_phantom("path circle 0 0 0 20 500")
        seen = len(live.positions())
        live.wait_until(lambda: len(live.positions()) > seen + 20)


@pytest.mark.parametrize("driver", ["dhd", "openhaptics"])
def test_a_real_device_is_opened_and_listed_again_when_there_are_threads(tmp_path, driver):
    world = World(tmp_path)
    with Live(tmp_path, Patch(driver), environment=world.environment) as live:
        live.wait_for_patch()
        world.without()
        live.tell_phantom("open")
        live.wait_for(rf"^info: status closed {driver}")
        live.tell_phantom("devices")
        live.wait_for(r"^error: .*devices: cannot start the thread for devices")
        world.again()
        live.tell_phantom("open")
        live.wait_for(r"^info: status sched")
        live.tell_phantom("close")
        live.wait_for(rf"^info: status closed {driver}", 2)
        live.tell_phantom("devices")
        live.wait_for(rf"^info: device {driver} 0 .*(ready|unknown)")
        assert len(errors(live)) == 2
        if driver == "dhd":  # the worker has a thread now, and the servo gets none
            world.without()
            live.tell_phantom("open")
            live.wait_for(r"^info: status closed dhd", 3)
            assert "cannot start the servo's thread" in errors(live)[-1]
            world.again()


def test_a_map_is_computed_in_the_host_s_time(tmp_path):
    world = World(tmp_path)
    patch = Patch("sim")
    receiver = patch.obj("r map")
    box = patch.obj("playability_map -quantity growth")
    patch.cord(receiver, 0, box, 0)
    for outlet in range(4):
        patch.cord(box, outlet, patch.obj("print map"), 0)
    patch.forward("map")
    with Live(tmp_path, patch, environment=world.environment) as live:
        live.wait_for_patch()
        world.without()
        live.tell_phantom("map compute")
        live.wait_for(r"^error: playability_map: compute: cannot start a thread for the map")
        live.wait_for(r"^map: cells")
        live.wait_for(r"^map: cell ", 20)
