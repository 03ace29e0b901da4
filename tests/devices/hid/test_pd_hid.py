"""Unmodified Pd in real time with [phantom hid] on a double of a SpaceNavigator."""

import os
import re
import shlex
import signal
import subprocess
import time

PATCH = """#N canvas 0 0 600 400 12;
#X obj 10 10 loadbang;
#X obj 10 40 delay 100;
#X msg 10 70 open;
#X obj 10 100 phantom hid;
#X obj 10 140 print x;
#X obj 90 140 print y;
#X obj 170 140 print z;
#X obj 250 140 print info;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
#X connect 3 0 4 0;
#X connect 3 1 5 0;
#X connect 3 2 6 0;
#X connect 3 3 7 0;
"""


class Live:
    def __init__(self, folder, patch=PATCH):
        (folder / "patch.pd").write_text(patch)
        command = [*shlex.split(os.environ["HID_DOUBLE"]), "--stdin", "navigator",
                   os.environ.get("TACTUS_PD", "pd"), "-nogui", "-oss", "-noaudio", "-nomidi",
                   "-noprefs", "-stderr", "-path", os.environ["TACTUS_STAGE"],
                   "-open", str(folder / "patch.pd")]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, start_new_session=True)
        os.set_blocking(self.process.stderr.fileno(), False)
        self.text = ""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.killpg(self.process.pid, signal.SIGKILL)  # the double and the Pd that it started
        self.process.wait()

    def tell(self, line):
        self.process.stdin.write(f"{line}\n".encode())
        self.process.stdin.flush()

    def printed(self, pattern):
        self.text += (self.process.stderr.read() or b"").decode()
        return re.findall(pattern, self.text, re.M)

    def last(self, name):
        found = self.printed(rf"^{name}: (.*)$")
        return found[-1] if found else None

    def wait_for(self, true, seconds=30):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, self.text[-3000:]
            time.sleep(0.02)


def test_full_deflection_to_the_right_is_one_at_the_outlet_and_the_device_may_come_and_go(tmp_path):
    with Live(tmp_path) as live:
        live.wait_for(lambda: live.printed("status open hid"))
        live.tell("report 01 5e01 0000 0000")
        live.wait_for(lambda: live.last("x") == "1")
        live.tell("report 01 0000 a2fe 5e01")  # away from the user and down
        live.wait_for(lambda: (live.last("x"), live.last("y"), live.last("z")) == ("0.5", "0", "0"))
        live.tell("report 03 0100")
        live.wait_for(lambda: live.printed("^info: button 0 1$"))
        live.tell("unplug")
        live.wait_for(lambda: live.printed("status lost"))
        live.tell("plug")
        live.wait_for(lambda: len(live.printed("status open hid")) == 2)
        live.tell("report 01 5e01 0000 0000")
        live.wait_for(lambda: live.last("x") == "1")


def test_settings_of_the_driver_reach_it_and_its_refusals_are_printed(tmp_path):
    (tmp_path / "axes.txt").write_text("x -X\n")
    setting = "driver table axes.txt \\, driver deadzone 99 \\, open"
    with Live(tmp_path, PATCH.replace("msg 10 70 open", f"msg 10 70 {setting}")) as live:
        live.wait_for(lambda: live.printed("status open hid"))
        assert live.printed("deadzone 99 is not possible: expected 0 to 90 % of full deflection")
        live.tell("report 01 5e01 0000 0000")
        live.wait_for(lambda: live.last("x") == "0")


def test_strokes_onto_a_body_are_hits_and_no_stiffness_is_warned_of(tmp_path):
    """Reports 10 ms apart and 2 mm each: 0.2 m/s, more or less on a busy machine, where it strokes again."""
    messages = "driver deadzone 0 \\, scene add floor plane 0 1 0 0 \\, open"
    with Live(tmp_path, PATCH.replace("msg 10 70 open", f"msg 10 70 {messages}")) as live:
        live.wait_for(lambda: live.printed("status open hid"))

        def hits_after_a_stroke():
            for mm in (*range(31, -13, -2), *range(-13, 31, 6)):
                counts = -7 * mm & 0xffff  # of 350 at 50 mm, and HID's Z points down
                live.tell(f"report 01 0000 0000 {counts & 255:02x}{counts >> 8:02x}")
                time.sleep(0.01)
            return live.printed(r"^info: hit (.*)$")
        live.wait_for(hits_after_a_stroke, 60)
        t, body, *numbers = live.printed(r"^info: hit (.*)$")[0].split()
        x, y, z, nx, ny, nz, speed, along = map(float, numbers)
        assert body == "floor" and abs(y) < 1e-6 and abs(ny - 1) < 1e-6 and 0.02 < speed < 2, numbers
        assert not live.printed("N/m"), live.text[-2000:]
