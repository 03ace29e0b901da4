"""Unmodified Pd in real time with [phantom openhaptics] on the stand-in library of six motors."""
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "live"))
from live_pd import Live, Patch  # noqa: E402


def opened(folder, mode):
    live = Live(folder, Patch("openhaptics"),
                environment={"PHANTOM_LIBHD": os.environ["FAKE_HD"], "FAKE_HD": mode})
    live.wait_for_patch()
    live.tell_phantom("report torque 1")
    live.tell_phantom("open")
    live.wait_for(r"status sched driver")
    live.tell_phantom("motors 1")
    return live


def test_torque_is_refused_until_it_is_on_then_felt_and_gone_when_it_is_off(tmp_path):
    with opened(tmp_path, "6dof") as live:
        live.tell_phantom("torque 0 0 0.1")
        live.wait_for(r"phantom: torque: torque and grip are off: send torques 1 first")
        live.tell_phantom("torques 1")
        live.tell_phantom("torque 0 0 0.1")
        live.wait_for(r"^info: torque 0 0 0\.1$")
        live.tell_phantom("torque 0 0 1e30")
        live.wait_for(r"phantom: torque: ", 2)
        live.tell_phantom("torques 0")
        live.wait_for(r"^info: torque 0 0 0\.1\n(?:.*\n)*info: torque 0 0 0$")


def test_a_device_without_such_motors_says_so(tmp_path):
    with opened(tmp_path, "") as live:
        live.tell_phantom("torques 1")
        live.wait_for(r"phantom: torques: this device has no motors for torque or")
