"""Unmodified Pd in real time: [phantom] drives doubles of devices that it takes for real.

No test asserts how fast anything is; they wait for what must happen."""

import os
import pathlib
import re
import signal
import subprocess

import pytest

from live_pd import PD, Live, Patch, falcon_patch, falcon_world, motors, pd_of, world


def test_a_falcon_moves_the_outlets_and_quitting_leaves_it_without_force(tmp_path):
    with Live(tmp_path, falcon_patch(tmp_path), falcon_world(tmp_path)) as live:
        live.wait_for(r"^info: status opening falcon")
        live.wait_for(r"^info: status open falcon")
        live.wait_for(r"^info: status homed 1")
        live.wait_until(lambda: len(set(live.positions())) > 50)
        live.push("0.5 1 2")
        last = live.end()
    assert last["frames"] > 100
    assert motors(last) == [0, 0, 0]
    assert all(0 <= x <= 1 for x in live.positions())
    assert live.errors_without_stalls() == []


def test_signals_that_end_pd_are_for_its_own_thread(tmp_path):
    """A handler that ran in the servo's thread would wait for that thread, and force would stay."""
    with Live(tmp_path, falcon_patch(tmp_path), falcon_world(tmp_path, "--loaded")) as live:
        live.wait_for(r"^info: status homed 1")
        (pid,) = pd_of(tmp_path)
        held = {}
        for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
            status = (task / "status").read_text()
            held[int(task.name)] = int(re.search(r"SigBlk:\s*(\w+)", status).group(1), 16)
        others = [mask for thread, mask in held.items() if thread != pid]
        assert len(others) >= 3  # worker, servo, and the Falcon's
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            bit = 1 << (number - 1)
            assert not held[pid] & bit
            assert all(mask & bit for mask in others)


@pytest.mark.parametrize("how", [
    signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_a_terminated_pd_leaves_no_force_either(tmp_path, how):
    with Live(tmp_path, falcon_patch(tmp_path), falcon_world(tmp_path, "--loaded")) as live:
        live.wait_for(r"^info: status homed 1")
        live.push("0 0 2")
        for pid in pd_of(tmp_path):
            os.kill(pid, how)
        live.process.wait(60)
        assert motors(live.state()) == [0, 0, 0]


def test_a_space_mouse_pushed_to_the_right_is_an_x_of_one(tmp_path):
    patch = Patch("hid")
    patch.at(100, "open")
    patch.at(150, "list 1 2 3")
    with Live(tmp_path, patch, world("HID_DOUBLE", "--stdin", "navigator")) as live:
        live.wait_for(r"^info: status open hid")
        live.wait_for(r"^info: status noforce hid")
        live.wait_for(r"^x: 0.5$")
        live.tell_double("report 015e0100000000")  # 350 counts along X
        live.wait_for(r"^x: 1$")
        live.tell_phantom("driver mapping rate")
        live.tell_phantom("driver mapping sideways")
        live.wait_for(r"^error: phantom: .*mapping")
        live.tell_double("unplug")
        live.wait_for(r"^info: status lost hid")
        live.tell_double("plug")
        live.wait_for(r"^info: status open hid", 2)


def test_devices_are_listed_with_what_keeps_a_driver_from_working(tmp_path):
    patch = Patch("")
    patch.at(50, "devices")
    with Live(tmp_path, patch, falcon_world(tmp_path),
              {"PHANTOM_LIBHD": "/nowhere/libHD.so"}) as live:
        live.wait_for(r"^info: device sim 0 tactus simulated - open")
        live.wait_for(r"^info: device falcon 0 \S+ .*ready")
        live.wait_for(r"^info: obstacle openhaptics .*/nowhere/libHD.so")


def test_closing_and_opening_again_works_as_often_as_one_likes(tmp_path):
    with Live(tmp_path, falcon_patch(tmp_path), falcon_world(tmp_path, "--loaded")) as live:
        for times in range(1, 5):
            live.wait_for(r"^info: status open falcon", times)
            live.tell_phantom("list 0 0 1")
            live.tell_phantom("close")
            live.wait_for(r"^info: status closed falcon", times)
            if times < 4:
                live.tell_phantom("open")
        live.tell_phantom("backend sim")
        live.wait_for(r"^info: status open sim")


def test_a_device_is_refused_in_batch_unless_the_wall_clock_is_asked_for(tmp_path):
    patch = Patch("falcon")
    patch.at(10, "open")
    patch.at(20, "hand rigid")
    patch.at(30, "clock logical")
    patch.at(40, "open")
    end, leave = patch.obj("delay 100"), patch.obj(r"\; pd quit", "msg")
    patch.cord(patch.start, 0, end, 0)
    patch.cord(end, 0, leave, 0)
    done = subprocess.run([PD[0], "-batch", *PD[1:], "-open", str(patch.save(tmp_path))],
                          capture_output=True, text=True, timeout=60, check=False)
    errors = re.findall(r"^error: (.*)$", done.stderr, re.M)
    assert errors == [
        "phantom: open: a batch render does not run in real time; send clock wall first to use a "
        "real device all the same",
        "phantom: hand: only for the simulated device, not for falcon; send backend sim first",
        "phantom: open: a real device cannot be stepped by the patch's time; send clock auto or "
        "clock wall first"]
