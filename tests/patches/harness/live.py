"""A Pd that plays in real time, without a screen or sound card: for sockets, children and the wall clock."""
import os
import re
import socket
import subprocess
import time

from .run import stage_folder

WAIT_S = 120  # of a machine that is busy; everything here waits for what is said, not for a time


def patch_text(lines, cords=()):
    """A patch of boxes ("obj 10 10 bang") and cords ("0 0 1 0")."""
    return "\n".join(["#N canvas 0 0 600 400 12;", *(f"#X {line};" for line in lines),
                      *(f"#X connect {cord};" for cord in cords)]) + "\n"


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class LivePd:
    """with LivePd(patch, ...) as pd: pd.wait_for("heard: x")."""

    def __init__(self, *patches, path=()):
        words = [str(w) for p in (*path, stage_folder()) for w in ("-path", p)]
        words += [str(w) for p in patches for w in ("-open", p)]
        self.process = subprocess.Popen(
            [os.environ.get("TACTUS_PD", "pd"), "-nogui", "-nosound", "-nomidi", "-noprefs", "-stderr", *words],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        os.set_blocking(self.process.stderr.fileno(), False)
        self.text, self.begun = "", time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stderr.close()

    def read(self):
        """All that Pd has said so far."""
        self.text += (self.process.stderr.read() or b"").decode(errors="replace")
        return self.text

    def find(self, pattern, since=0):
        return re.findall(pattern, self.read()[since:], re.M)

    def wait_until(self, condition, what):
        while not condition():
            assert time.monotonic() < self.begun + WAIT_S, f"{what} did not come:\n{self.read()[-3000:]}"
            assert self.process.poll() is None, f"Pd ended before {what}:\n{self.read()[-3000:]}"
            time.sleep(0.02)

    def wait_for(self, pattern, count=1, since=0):
        """All finds, once there are so many."""
        self.wait_until(lambda: len(self.find(pattern, since)) >= count, f"{count} times {pattern!r}")
        return self.find(pattern, since)


HALF_BLOCK_MS = 32 / 48


def took_ms(folder, messages, opens, wait_ms):
    """For how many ms each of (receiver, words) holds up Pd's audio thread, DSP on, without what the machine did
    besides: the least of two runs. 3 s for what is read in the background, then so long before each."""
    lines = [f"{wait_ms if n else 3000} before bang;\n0 {receiver} {words};\n0 after bang;\n"
             for n, (receiver, words) in enumerate(messages)]
    (folder / "messages.txt").write_text("".join(lines))
    (folder / "live.pd").write_text(patch_text(
        ["obj 10 10 loadbang", r"msg 10 10 read messages.txt \, bang", r"msg 10 10 \; pd dsp 1", "obj 10 10 qlist",
         "obj 10 10 r before", "obj 10 10 r after", "obj 10 10 realtime", "obj 10 10 print took"],
        ["0 0 2 0", "0 0 1 0", "1 0 3 0", "4 0 6 0", "5 0 6 1", "6 0 7 0"]))
    runs = []
    for _ in range(2):
        with LivePd(*opens, folder / "live.pd") as pd:
            runs.append(pd.wait_for(r"^took: (\S+)$", len(messages)))
    return [min(float(ms) for ms in pair) for pair in zip(*runs)]
