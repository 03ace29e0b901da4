"""Motors that grow warm lower the force limit, and the patch is told so once. The double states
3.4 N at the peak and 0.9 N for ever; a hand holds it."""

import os
import re

from live_pd import Live, Patch


def forces(live):
    return [float(x) for x in re.findall(r"^info: force (\S+) \S+ \S+$", live.read(), re.M)]


def held_device():
    return {"PHANTOM_LIBHD": os.environ["FAKE_HD"], "FAKE_HD": "held"}


def opened(live):
    live.wait_for_patch()
    live.tell_phantom("outrate 50")
    live.tell_phantom("repeat 1")
    live.tell_phantom("report force 1")
    live.tell_phantom("open")
    live.wait_for(r"^info: status open openhaptics")
    live.wait_for(r"^info: status sched driver")


def push_until_warm(live):
    """A stall of the machine looks like a failed device: then the motors are asked for again."""
    def warm():
        live.tell_phantom("list 3.4 0 0")
        if "motors are off until motors 1" in live.read():
            live.tell_phantom("motors 1")
        return "status warm 1" in live.read()

    live.wait_until(warm)


def test_warm_motors_lower_the_limit_and_are_told_once(tmp_path):
    with Live(tmp_path, Patch("openhaptics"), environment=held_device()) as live:
        opened(live)
        push_until_warm(live)
        live.wait_until(lambda: forces(live)[-1] < 1.5)
        live.wait_for("phantom: openhaptics: the motors are warm: force is limited to about 0.9 N "
                      "until they cool")
        assert live.read().count("the motors are warm") == 1
        assert max(forces(live)) > 3  # the beginning had all of it
        live.tell_phantom("list 0 0 0")
        live.wait_for(r"^info: status warm 0", seconds=60)
        assert len(re.findall(r"^info: status warm 1", live.read(), re.M)) == 1
        live.end()


def test_closing_or_another_object_does_not_cool_the_motors(tmp_path):
    patch = Patch("openhaptics")
    other = patch.obj("phantom openhaptics")
    patch.cord(patch.obj("r second"), 0, other, 0)
    patch.cord(other, 3, patch.obj("print second"), 0)
    patch.forward("second")
    with Live(tmp_path, patch, environment=held_device()) as live:
        opened(live)
        push_until_warm(live)
        live.wait_until(lambda: forces(live)[-1] < 1.2)
        live.tell_phantom("close")
        live.wait_for(r"^info: status closed")
        live.tell_phantom("second outrate 50")
        live.tell_phantom("second repeat 1")
        live.tell_phantom("second report force 1")
        live.tell_phantom("second open")
        live.wait_for(r"^second: status open")
        live.wait_for(r"^second: status warm 1", seconds=10)
        live.tell_phantom("second list 3.4 0 0")
        live.wait_for(r"^second: force (0\.[5-9]|1)", seconds=10)
        felt = [float(x) for x in re.findall(r"^second: force (\S+)", live.read(), re.M)]
        assert max(felt) < 2.5  # a cold motor would get 3.4 N
        live.end()
