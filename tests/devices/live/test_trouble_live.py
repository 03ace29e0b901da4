"""What is wrong with a device reaches the patch: `trouble DRIVER SENTENCE` on the info outlet, one
error line for a failure, and a list that leaves a device that runs alone."""

import re
import time

from live_pd import Live, Patch, falcon_patch, falcon_world
from test_hang_live import hang, vendors_world


def lines(live, pattern):
    return re.findall(pattern, live.read().replace("\\", ""), re.M)


def test_a_device_that_does_not_open_says_why_once_or_as_an_error_alone(tmp_path):
    with Live(tmp_path, Patch("openhaptics"), environment={"PHANTOM_LIBHD": "/nowhere/HD"}) as live:
        live.wait_for_patch()
        for reports in (1, 0):
            live.tell_phantom(f"report error {reports}")
            live.tell_phantom("open")
            live.wait_for(r"^info: status closed openhaptics", 2 - reports)
        (said,) = lines(live, r"^info: trouble openhaptics (.*)$")
        assert lines(live, r"^error: phantom: (.*)$") == [said, said] and "/nowhere/HD" in said


def test_a_backend_takes_a_device_by_a_name_of_several_words(tmp_path):
    world = dict(vendors_world(tmp_path), FAKE_HD="named")  # its one device is Left Device
    with Live(tmp_path, Patch("sim"), environment=world) as live:
        live.wait_for_patch()
        for chosen, state in (("openhaptics Right Device", "closed"), ("openhaptics Left Device", "open")):
            live.tell_phantom(f"backend {chosen}")
            live.tell_phantom("open")
            live.wait_for(rf"^info: status {state} openhaptics")
        (error,) = lines(live, r"^error: (.*)$")
        assert "the name Right Device:" in error and "Default Device" not in error


def test_what_a_device_wants_of_its_user_is_told_once(tmp_path):
    world = dict(vendors_world(tmp_path), FAKE_HD="inkwell")
    with Live(tmp_path, Patch("openhaptics"), environment=world) as live:
        live.wait_for_patch()
        live.tell_phantom("open")
        live.wait_for(r"^info: status homed 0")
        live.wait_for(r"^info: trouble openhaptics .*inkwell")
        time.sleep(1)  # twenty times as long as between two looks
        assert len(lines(live, r"^info: trouble .*inkwell")) == 1
        assert len(lines(live, r"phantom: openhaptics: the device is not calibrated")) == 1
        assert not lines(live, r"^error")


def test_a_device_that_homes_while_the_host_stands_still_is_reported_homed(tmp_path):
    patch = Patch("falcon")
    patch.at(100, "open")
    # Pd counts for longer than the double takes to home, beginning when its servo has begun
    boxes = ("route status", "route open", "t b", "delay 0", "t b b b", "until", "f", "realtime",
             "print stood_ms")
    route, opened, bang, begun, order, until, number, clock, stood = (patch.obj(box) for box in boxes)
    count = patch.obj("80000000", "msg")
    for cord in ((patch.box, 3, route, 0), (route, 0, opened, 0), (opened, 0, bang, 0),
                 (bang, 0, begun, 0), (begun, 0, order, 0), (order, 2, clock, 0), (order, 1, count, 0), (count, 0, until, 0),
                 (until, 0, number, 0), (order, 0, clock, 1), (clock, 0, stood, 0)):
        patch.cord(*cord)
    with Live(tmp_path, patch, falcon_world(tmp_path, "--loaded")) as live:
        stood_ms = float(live.wait_for(r"^stood_ms: (.*)$"))
        live.wait_for(r"^info: status homed 1", seconds=20)
        assert stood_ms > 150 and not lines(live, r"^info: status homed 0")


def test_hot_motors_and_a_failure_are_told_while_the_device_is_open(tmp_path):
    world = vendors_world(tmp_path)
    with Live(tmp_path, Patch("openhaptics"), environment=world) as live:
        live.wait_for_patch()
        live.tell_phantom("open")
        live.wait_for(r"^info: status sched driver")
        hang(tmp_path, "warm")
        live.wait_for(r"^info: status hot 1")
        live.wait_for(r"^info: trouble openhaptics .*motors\\? are\\? warm")
        assert not lines(live, r"^error")  # it still works
        hang(tmp_path)
        live.wait_for(r"^info: status hot 0")
        live.wait_for(r"^info: trouble openhaptics -$")

        hang(tmp_path, "fast")
        live.wait_for(r"^info: status fault 1")
        live.wait_for(r"^info: status estop 1")
        (error,) = lines(live, r"^error: phantom: (.*)$")
        assert error == ("the device has failed and its motors stay off until motors 1: openhaptics: "
                         "the handle moved too fast and the device switched the force off: hold "
                         "it, then send motors 1")
        assert len(lines(live, r"^info: trouble openhaptics .*moved too fast")) == 1
        live.tell_phantom("motors 1")
        live.wait_for(r"^info: status estop 0")


def test_a_lost_device_says_why_and_what_keeps_it_away(tmp_path):
    with Live(tmp_path, falcon_patch(tmp_path), falcon_world(tmp_path, "--loaded")) as live:
        live.wait_for(r"^info: status homed 1")
        live.unplug()
        live.wait_for(r"^info: trouble falcon .*(was\\? unplugged|does\\? not\\? answer)")
        live.wait_for(r"^info: trouble falcon no\\? Falcon")  # once, though it is tried again
        live.plug()
        live.wait_for(r"^info: trouble falcon -$")
        assert len(lines(live, r"^info: trouble falcon no Falcon")) == 1
        assert len(lines(live, r"^error: .*no longer answers.*\(the Falcon")) >= 1


def test_a_list_leaves_a_device_that_runs_alone(tmp_path):
    """The double's count of devices would hang: nobody may ask for it."""
    with Live(tmp_path, Patch("dhd"), environment=vendors_world(tmp_path)) as live:
        live.wait_for_patch()
        live.tell_phantom("devices")
        live.wait_for(r"^info: device dhd 0 Force\S* \S+ - ready|^info: device dhd 0 .* ready")
        live.tell_phantom("open")
        live.wait_for(r"^info: status sched")
        hang(tmp_path, "dhdGetDeviceCount")
        live.tell_phantom("devices")
        live.wait_for(r"^info: device dhd 0 .* open", 2)  # when it opened, and now
        live.wait_for(r"^info: device sim", 2)
        live.tell_phantom("close")
        live.wait_for(r"^info: status closed dhd")
        hang(tmp_path)
        live.tell_phantom("devices")
        live.wait_for(r"^info: device dhd 0 .* ready", 2)


def test_a_servo_that_stands_still_is_told_until_it_goes_on(tmp_path):
    with Live(tmp_path, Patch("openhaptics"), environment=vendors_world(tmp_path)) as live:
        live.wait_for_patch()
        live.tell_phantom("open")
        live.wait_for(r"^info: status sched driver")
        hang(tmp_path, "hdEndFrame")
        live.wait_for(r"^info: trouble openhaptics .*servo\\? has\\? stopped")
        hang(tmp_path)
        live.wait_for(r"^info: trouble openhaptics -$")
