"""Unmodified Pd in real time with [phantom hid] on a double of a SpaceNavigator."""
import os
import pathlib
import shlex
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "live"))
from live_pd import Live, Patch  # noqa: E402


def opened(folder, *messages):
    """The device, opened after these messages."""
    live = Live(folder, Patch("hid"), [*shlex.split(os.environ["HID_DOUBLE"]), "--stdin", "navigator"])
    live.wait_for_patch()
    for message in (*messages, "open"):
        live.tell_phantom(message)
    live.wait_for("status open hid")
    return live


def test_settings_of_the_driver_reach_it_and_its_refusals_are_printed(tmp_path):
    (tmp_path / "axes.txt").write_text("x -X\n")
    with opened(tmp_path, "driver table axes.txt", "driver deadzone 99") as live:
        live.wait_for("deadzone 99: expected 0..90 % of full deflection")
        live.tell_double("report 01 5e01 0000 0000")
        live.wait_for("^x: 0$")
        live.tell_double("report 03 0100")
        live.wait_for("^info: button 0 1$")


def test_strokes_onto_a_body_are_hits_and_no_stiffness_is_warned_of(tmp_path):
    """Reports 10 ms apart and 2 mm each: 0.2 m/s, more or less on a busy machine, where it strokes again."""
    with opened(tmp_path, "driver deadzone 0", "scene add floor plane 0 1 0 0") as live:

        def hits_after_a_stroke():
            for mm in (*range(31, -13, -2), *range(-13, 31, 6)):
                counts = -7 * mm & 0xffff  # of 350 at 50 mm, and HID's Z points down
                live.tell_double(f"report 01 0000 0000 {counts & 255:02x}{counts >> 8:02x}")
                time.sleep(0.01)
            return "info: hit " in live.read()
        live.wait_until(hits_after_a_stroke, 60)
        t, body, *numbers = live.wait_for(r"^info: hit (.*)$").split()
        x, y, z, nx, ny, nz, speed, along = map(float, numbers)
        assert body == "floor" and abs(y) < 1e-6 and abs(ny - 1) < 1e-6 and 0.02 < speed < 2, numbers
        assert "N/m" not in live.text
