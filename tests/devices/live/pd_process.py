"""Unmodified Pd in real time, and what it prints."""
import os
import re
import signal
import subprocess
import time

PD = [os.environ.get("TACTUS_PD", "pd"), "-nogui", "-oss", "-noaudio", "-nomidi", "-noprefs",
      "-stderr", "-path", os.environ["TACTUS_STAGE"]]


def patch(boxes, cords):
    """Lines of a patch: boxes by name, as `obj ...` or `msg ...`; cords as `from out to in`."""
    number = {name: i for i, name in enumerate(boxes)}
    return [f"#X {words.split()[0]} 10 10 {words.split(' ', 1)[1]};" for words in boxes.values()] + [
        f"#X connect {number[a]} {i} {number[b]} {j};"
        for a, i, b, j in (cord.split() for cord in cords)]


def write_patch(folder, lines, name="patch"):
    """The file NAME.pd in that folder."""
    file = folder / f"{name}.pd"
    file.write_text("\n".join(["#N canvas 0 0 800 600 12;", *lines]) + "\n")
    return file


class Pd:
    """A patch from its lines, NAME.pd in that folder; what it prints, as it comes. before: words in
    front of Pd's own."""

    def __init__(self, folder, *lines, name="patch", before=(), environment=None, stdin=subprocess.DEVNULL):
        file = write_patch(folder, lines, name)
        self.process = subprocess.Popen([*before, *PD, "-open", str(file)], stdin=stdin,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                        start_new_session=True,
                                        env=dict(os.environ, **(environment or {})))
        os.set_blocking(self.process.stderr.fileno(), False)
        self.text, self.bytes = "", b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)  # and what it has started, or what started Pd
        self.process.wait()

    def read(self):
        self.bytes += self.process.stderr.read() or b""
        whole, line_end, self.bytes = self.bytes.rpartition(b"\n")
        self.text += (whole + line_end).decode()
        return self.text

    def wait_for(self, pattern, count=1, seconds=200):
        """Until the pattern has been printed so often; what was found last."""
        end = time.monotonic() + seconds
        while len(found := re.findall(pattern, self.read(), re.M)) < count:
            assert time.monotonic() < end, f"no {pattern!r} in:\n{self.text[-3000:]}"
            assert self.process.poll() is None, f"Pd ended:\n{self.text[-3000:]}"
            time.sleep(0.02)
        return found[-1] if found else None

    def wait_for_answer(self, act, pattern):
        """Does act(), until the pattern has been printed once more: a machine that stalls may have lost and opened a
        device before."""
        before = len(re.findall(pattern, self.read(), re.M))
        act()
        return self.wait_for(pattern, before + 1)

    def wait_until(self, true, seconds=200):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, f"in vain; Pd said:\n{self.read()[-3000:]}"
            time.sleep(0.05)
