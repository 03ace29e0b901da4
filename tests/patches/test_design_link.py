"""patches/design/design_link.pd: a design session over TCP with the program haptic_server.

Live: Pd, the server and its simulated hand play in real time. The tests wait for events and read the
server's trace, whose rows carry their own times, so a busy machine makes them slow and nothing else."""
import csv
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import pytest

from harness import stage_folder

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "net"))
sys.dont_write_bytecode = True

if not os.environ.get("HAPTIC_SERVER"):
    pytest.skip("the program haptic_server is not built", allow_module_level=True)

from peer import Program  # noqa: E402

PATCH = pathlib.Path(__file__).resolve().parents[2] / "patches" / "design" / "design_link.pd"
WAIT_S = 120

# ms x y z buttons: the hand takes the middle control point, (0, 10, 0) mm, and lifts it by 4 mm.
PATH = """0 0 10 0 0
1500 0 10 0 0
1510 0 10 0 1
2500 0 10 0 1
5500 0 14 0 1
600000 0 14 0 1
"""


class Pd:
    """The patch, and a second one that starts it and prints what it hears."""

    def __init__(self, folder, port):
        watch = folder / "watch.pd"
        watch.write_text(f"""#N canvas 0 0 400 300 12;
#X obj 10 10 loadbang;
#X obj 10 40 delay 500;
#X msg 10 70 \\; design-link connect 127.0.0.1 {port};
#X obj 10 110 r design-heard;
#X obj 10 140 print heard;
#X obj 200 110 r design-gamma;
#X obj 200 140 print gamma;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 3 0 4 0;
#X connect 5 0 6 0;
""")
        self.process = subprocess.Popen(
            [os.environ.get("TACTUS_PD", "pd"), "-nogui", "-noaudio", "-nomidi", "-noprefs", "-stderr",
             "-path", str(stage_folder()), "-open", str(PATCH), "-open", str(watch)],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        os.set_blocking(self.process.stderr.fileno(), False)
        self.text = ""

    def read(self):
        self.text += (self.process.stderr.read() or b"").decode(errors="replace")
        return self.text

    def count(self, pattern):
        return len(re.findall(pattern, self.read(), re.M))

    def wait(self, pattern, count=1):
        """All finds, once there are so many."""
        end = time.monotonic() + WAIT_S
        while self.count(pattern) < count:
            assert time.monotonic() < end, f"{count} times {pattern!r} did not come:\n{self.text[-3000:]}"
            assert self.process.poll() is None, f"Pd ended:\n{self.text[-3000:]}"
            time.sleep(0.05)
        return re.findall(pattern, self.text, re.M)

    def wait_for_height(self, mm, since):
        """Until the server has moved the control point up to that height."""
        end = time.monotonic() + WAIT_S
        while True:
            found = re.findall(r"^heard: cp move 1 \S+ (\S+) \S+$", self.read()[since:], re.M)
            if found and float(found[-1]) >= mm:
                return
            assert time.monotonic() < end, f"the point did not rise to {mm} mm:\n{self.text[-3000:]}"
            time.sleep(0.05)

    def close(self):
        self.process.kill()
        self.process.wait()


def rows_of(trace):
    """(ms, force) of a trace; the last row of a killed server may be cut off."""
    rows = []
    for row in csv.DictReader(trace.read_text().splitlines()):
        try:
            rows.append((float(row["ms"]), [float(row[f"f{axis}_n"]) for axis in "xyz"]))
        except (TypeError, ValueError):
            break
    return rows


def largest_change(rows):
    """Largest change of the force, N for each nominal tick of 1 ms: a late tick may change more."""
    return max(max(abs(a - b) for a, b in zip(now, before)) / max(1.0, ms - ms_before)
               for (ms_before, before), (ms, now) in zip(rows, rows[1:]))


def serve(folder, port=0):
    folder.mkdir()
    path = folder / "path.txt"
    path.write_text(PATH)
    return Program(folder, "--hand", "rigid", "--path", str(path), "--port", str(port), force_limit=8.0)


def test_points_are_dragged_and_stress_is_felt_and_a_killed_server_is_found_again(tmp_path):
    first = serve(tmp_path / "first")
    pd = Pd(tmp_path, first.port)
    servers = [first]
    try:
        pd.wait(r"^heard: welcome 1 simulated")
        pd.wait(r"^heard: status started spring design$")
        pd.wait(r"^heard: grab 1 1$")
        pd.wait_for_height(13.9, 0)
        # The beam is higher: less stress, and the server was told.
        gammas = [float(g) for g in pd.wait(r"^gamma: (\S+)$")]
        assert 0 < gammas[-1] < 0.95 * max(gammas)
        assert pd.count(r"^design: error") == 0
        time.sleep(0.5)
        first.signal(signal.SIGKILL)
        first.process.wait()
        since = len(pd.read())
        second = serve(tmp_path / "second", first.port)
        servers.append(second)
        pd.wait(r"^heard: welcome 1 simulated", 2)
        pd.wait(r"^heard: status started spring design$", 2)
        pd.wait(r"^heard: grab 1 1$", 2)
        # The session knows where the point was left, 4 mm up, so 4 mm more are 8.
        pd.wait_for_height(17.9, since)
        time.sleep(0.5)
        second.signal(signal.SIGKILL)
        second.process.wait()
        for server in servers:
            rows = rows_of(server.trace)
            assert len(rows) > 100
            assert max(max(map(abs, force)) for _, force in rows) > 0.2
            assert largest_change(rows) < 0.05
    finally:
        pd.close()
        for server in servers:
            server.process.kill()
            server.process.wait()
