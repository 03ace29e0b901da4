"""A device's library that does not return holds up nothing but its own thread: Pd goes on, says so,
and ends. Within a second, promised; here all that counts is that it does, on a busy machine, too."""
import os
import signal
import time

import pytest

from live_pd import Live, Patch, falcon_patch, falcon_world, pd_of, some


def vendors_world(folder):
    return {"PHANTOM_LIBHD": os.environ["HANGING_HD"], "TACTUS_LIBDHD": os.environ["HANGING_DHD"],
            "HANG": str(folder / "hang.txt")}


def hang(folder, *calls):
    """From now on these calls do not return."""
    fresh = folder / "hang.new"
    fresh.write_text(" ".join(calls))
    fresh.rename(folder / "hang.txt")


def ends(live, how="quit", folder=None):
    begun = time.monotonic()
    if how == "quit":
        live.tell_phantom("quit")
    else:
        for pid in pd_of(folder):
            os.kill(pid, how)
    live.process.wait(60)
    print(f"{how}: {time.monotonic() - begun:.2f} s")


def opened(folder, driver):
    """Pd with a device that runs."""
    live = Live(folder, Patch(driver), environment=vendors_world(folder))
    live.wait_for_patch()
    live.tell_phantom("open")
    live.wait_for(r"^info: status sched")
    live.wait_until(lambda: len(live.positions()) > 5 or live.tell_phantom("motors 1") or
                    live.tell_phantom("list 0.5 0 0"))
    return live


@pytest.mark.parametrize("driver, call, how", some(
    [("dhd", "dhdSetForce", "quit"), ("openhaptics", "hdStopScheduler", signal.SIGTERM)],
    ("dhd", "dhdGetPosition", "quit"), ("dhd", "dhdClose", signal.SIGTERM),
    ("openhaptics", "hdEndFrame", signal.SIGTERM), ("openhaptics", "hdDisableDevice", "quit")))
def test_pd_ends_beside_a_call_that_hangs(tmp_path, driver, call, how):
    with opened(tmp_path, driver) as live:
        hang(tmp_path, call)
        time.sleep(0.1)
        ends(live, how, tmp_path)
        if how == "quit":
            assert "has not returned; the program ends without it" in live.read()


@pytest.mark.parametrize("driver, call", some(
    [("dhd", "dhdOpenID")], ("openhaptics", "hdInitDevice"), ("openhaptics", "hdStartScheduler")))
def test_pd_ends_beside_an_opening_that_hangs(tmp_path, driver, call):
    hang(tmp_path, call)
    with Live(tmp_path, Patch(driver), environment=vendors_world(tmp_path)) as live:
        live.wait_for_patch()
        live.tell_phantom("open")
        live.wait_for(rf"^info: status opening {driver}")
        time.sleep(0.3)
        ends(live)


@pytest.mark.parametrize("message", some(["close"], ["backend sim"]))
def test_an_opening_that_hangs_and_is_not_wanted_any_more_is_told(tmp_path, message):
    hang(tmp_path, "dhdOpenID")
    with Live(tmp_path, Patch("dhd"), environment=vendors_world(tmp_path)) as live:
        live.wait_for_patch()
        live.tell_phantom("open")
        live.wait_for(r"^info: status opening dhd")
        live.tell_phantom(message)
        live.wait_for(r"^info: status closed dhd")
        live.wait_for(r"^error: .*dhd: opening the device has not returned for 1 s; its thread is")
        hang(tmp_path)  # it opens after all, for nobody, and is closed
        live.tell_phantom("backend dhd")
        live.wait_until(lambda: live.tell_phantom("open") or "info: status open dhd" in live.read())


def test_pd_ends_while_a_deaf_falcon_is_opened(tmp_path):
    with Live(tmp_path, falcon_patch(tmp_path), falcon_world(tmp_path, "--do", "deaf 1000")) as live:
        live.wait_for(r"^info: status opening falcon")
        time.sleep(1)
        ends(live)


@pytest.mark.parametrize("driver, call, message", some(
    [("dhd", "dhdGetPosition", "backend sim"), ("openhaptics", "hdStopScheduler", "open")],
    ("dhd", "dhdClose", "close"), ("dhd", "dhdClose", "backend hid"), ("dhd", "dhdGetPosition", "open")))
def test_leaving_a_device_that_hangs_takes_no_time_and_is_told(tmp_path, driver, call, message):
    with opened(tmp_path, driver) as live:
        hang(tmp_path, call)
        time.sleep(0.1)
        live.tell_phantom(message)
        live.wait_for(rf"^info: status (closed|lost) {driver}")
        live.wait_for(r"^error: .*closing the device has not returned for 1 s; its thread is abandoned")
        if message == "backend sim":  # the object goes on
            live.wait_for(r"^info: status open sim")
            seen = len(live.positions())
            live.tell_phantom("hand rigid")
            live.tell_phantom("path circle 0 0 0 20 500")
            live.wait_until(lambda: len(live.positions()) > seen + 20)
        if message == "open":  # refused, since the driver still hangs
            live.wait_for(r"^error: .*an earlier call of this driver has not returned")
        hang(tmp_path)  # the call returns after all: the device is closed and can be opened again
        live.tell_phantom(f"backend {driver}")
        live.wait_until(lambda: live.tell_phantom("open") or
                        live.read().count(f"info: status open {driver}") > 1)


def test_listing_that_hangs_holds_up_nobody(tmp_path):
    hang(tmp_path, "dhdGetDeviceCount")
    with Live(tmp_path, Patch("sim"), environment=vendors_world(tmp_path)) as live:
        live.wait_for_patch()
        live.tell_phantom("devices")
        live.wait_for(r"^info: device sim")
        live.wait_until(lambda: live.tell_phantom("devices") or
                        "devices: dhd: listing devices has not returned yet" in live.read())
        ends(live)
