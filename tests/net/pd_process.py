"""Unmodified Pd with a patch, live, and what it prints."""
import os
import re
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


class Pd:
    """A patch from its lines; what it prints. before: words in front of Pd's own."""

    def __init__(self, folder, *lines, name="patch", before=()):
        file = folder / f"{name}.pd"
        file.write_text("#N canvas 0 0 600 400 12;\n" + "\n".join(lines) + "\n")
        self.process = subprocess.Popen([*before, *PD, "-open", str(file)], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        os.set_blocking(self.process.stderr.fileno(), False)
        self.text, self.bytes = "", b""

    def read(self):
        self.bytes += self.process.stderr.read() or b""
        whole, end, self.bytes = self.bytes.rpartition(b"\n")
        self.text += (whole + end).decode()
        return self.text

    def wait_for(self, pattern, seconds=60):
        end = time.monotonic() + seconds
        while True:
            found = re.findall(pattern, self.read(), re.M)
            if found:
                return found[-1]
            assert time.monotonic() < end, f"no {pattern!r} in:\n{self.text[-3000:]}"
            assert self.process.poll() is None, f"Pd ended:\n{self.text[-3000:]}"
            time.sleep(0.02)

    def close(self):
        self.process.kill()
        self.process.wait()
