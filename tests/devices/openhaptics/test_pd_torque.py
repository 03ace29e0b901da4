"""Unmodified Pd in real time with [phantom openhaptics] on the stand-in library of six motors."""

import os
import re
import signal
import subprocess
import time

PATCH = """#N canvas 0 0 600 400 12;
#X obj 10 10 loadbang;
#X obj 10 40 delay 100;
#X msg 10 70 open \\, report torque 1;
#X obj 10 100 phantom openhaptics;
#X obj 250 140 print info;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
#X connect 3 3 4 0;
"""


class Live:
    def __init__(self, folder, mode, orders):
        """orders: (ms, message) pairs, sent to the object at that time."""
        text, count = PATCH, 5
        for ms, order in orders:
            text += f"#X obj 400 40 delay {ms};\n#X msg 400 70 {order};\n"
            text += f"#X connect 0 0 {count} 0;\n#X connect {count} 0 {count + 1} 0;\n"
            text += f"#X connect {count + 1} 0 3 0;\n"
            count += 2
        (folder / "patch.pd").write_text(text)
        command = [os.environ.get("TACTUS_PD", "pd"), "-nogui", "-oss", "-noaudio", "-nomidi",
                   "-noprefs", "-stderr", "-path", os.environ["TACTUS_STAGE"],
                   "-open", str(folder / "patch.pd")]
        environment = {**os.environ, "PHANTOM_LIBHD": os.environ["FAKE_HD"], "FAKE_HD": mode}
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                        start_new_session=True, env=environment)
        os.set_blocking(self.process.stderr.fileno(), False)
        self.text = ""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def printed(self, pattern):
        self.text += (self.process.stderr.read() or b"").decode()
        return re.findall(pattern, self.text, re.M)

    def wait_for(self, pattern, seconds=60):
        end = time.monotonic() + seconds
        while not self.printed(pattern):
            assert time.monotonic() < end, self.text[-3000:]
            time.sleep(0.02)


def test_torque_is_refused_until_it_is_on_then_felt_and_gone_when_it_is_off(tmp_path):
    orders = [(1500, "torque 0 0 0.1"), (2000, "torques 1 \\, torque 0 0 0.1"),
              (4000, "torque 0 0 1e30"), (5000, "torques 0")]
    with Live(tmp_path, "6dof", orders) as live:
        live.wait_for(r"status open openhaptics")
        live.wait_for(r"phantom: torque: torque and grip are off: send torques 1 first")
        live.wait_for(r"^info: torque 0 0 0\.1$")
        live.wait_for(r"phantom: torque: ")
        live.wait_for(r"^info: torque 0 0 0\.1\n(?:.*\n)*info: torque 0 0 0$")


def test_a_device_without_such_motors_says_so(tmp_path):
    with Live(tmp_path, "", [(2000, "torques 1")]) as live:
        live.wait_for(r"phantom: torques: this device has motors neither for torque nor")
