"""Motors that grow warm lower the force limit, and the patch is told so once. The double states
3.4 N at the peak and 0.9 N for ever; a hand holds it."""

import os
import re

import pytest

from live_pd import Live, Patch

pytestmark = pytest.mark.slow  # core/haptic holds how a limit falls and rises


def forces(live, tag="info"):
    return [float(x) for x in re.findall(rf"^{tag}: force (\S+) \S+ \S+$", live.read(), re.M)]


def opened(live, receiver=""):
    for message in ("outrate 50", "repeat 1", "report force 1", "open", "motors 1"):
        live.tell_phantom(f"{receiver} {message}".strip())


def test_warm_motors_lower_the_limit_are_told_once_and_cool_by_no_other_object(tmp_path):
    patch = Patch("openhaptics")
    other = patch.obj("phantom openhaptics")
    patch.cord(patch.obj("r second"), 0, other, 0)
    patch.cord(other, 3, patch.obj("print second"), 0)
    patch.forward("second")
    environment = {"PHANTOM_LIBHD": os.environ["FAKE_HD"], "FAKE_HD": "held"}
    with Live(tmp_path, patch, environment=environment) as live:
        live.wait_for_patch()
        opened(live)
        live.wait_for(r"^info: status sched driver")

        def warm():
            """A stall of the machine looks like a failed device: then the motors are asked for again."""
            live.tell_phantom("list 3.4 0 0")
            if "motors stay off until motors 1" in live.read():
                live.tell_phantom("motors 1")
            return "status warm 1" in live.read()
        live.wait_until(warm)
        assert max(forces(live)) > 3  # the beginning had all of it
        live.wait_until(lambda: forces(live)[-1] < 1.2)
        live.wait_for("phantom: openhaptics: the motors are warm: force is limited to about 0.9 N "
                      "until they cool")
        assert live.read().count("the motors are warm") == live.text.count("info: status warm 1") == 1
        live.tell_phantom("close")
        live.wait_for(r"^info: status closed")
        opened(live, "second")
        live.wait_for(r"^second: status warm 1")
        live.tell_phantom("second list 3.4 0 0")
        live.wait_for(r"^second: force (0\.[5-9]|1)")
        assert max(forces(live, "second")) < 2.5  # a cold motor would get 3.4 N
        live.tell_phantom("second list 0 0 0")
        live.wait_for(r"^second: status warm 0")
