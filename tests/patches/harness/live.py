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


def played(folder, events, boxes, cords, opens=()):
    """What a Pd says, DSP on, of boxes (the first is number 4) and patches under (ms before it, receiver, words)."""
    (folder / "events.txt").write_text("".join(f"{ms} {receiver} {words};\n" for ms, receiver, words in events))
    text = patch_text(["obj 10 10 loadbang", r"msg 10 10 read events.txt \, bang", r"msg 10 10 \; pd dsp 1",
                       "obj 10 10 qlist", *(f"{box.split()[0]} 10 10 {box.split(' ', 1)[1]}" for box in boxes),
                       "obj 10 10 print list"],
                      ["0 0 2 0", "0 0 1 0", "1 0 3 0", f"3 1 {4 + len(boxes)} 0", *cords])
    (folder / "live.pd").write_text(text)
    with LivePd(*opens, folder / "live.pd") as pd:
        pd.wait_for("^list: bang")
        return pd.read()


def took_ms(folder, messages, opens, wait_ms):
    """For how many ms each of (receiver, words) holds up Pd's audio thread, without what the machine did besides: the
    least of two runs. 3 s for what is read in the background, then so long before each."""
    events = []
    for receiver, words in messages:
        events += [(wait_ms if events else 3000, "before", "bang"), (0, receiver, words), (0, "after", "bang")]
    runs = [re.findall(r"^took: (\S+)$", played(folder, [*events, (500, "after", "bang")],
                                                ["obj r before", "obj r after", "obj realtime", "obj print took"],
                                                ["4 0 6 0", "5 0 6 1", "6 0 7 0"], opens), re.M) for _ in range(2)]
    assert [len(run) for run in runs] == 2 * [len(messages) + 1]
    return [min(float(ms) for ms in pair) for pair in zip(*runs)][:-1]
