"""Runs scripts in the stub of Max (max/stub), and reads what it prints."""
import atexit
import json
import os
import pathlib
import subprocess

BUILD = pathlib.Path(os.environ["TACTUS_BUILD"])
EXTERNALS = pathlib.Path(os.environ.get("TACTUS_MAX_EXTERNALS", BUILD / "max" / "externals"))
SUFFIX = os.environ.get("TACTUS_MAX_SUFFIX", ".mxl")
# The host; for another system's build, an emulator and its arguments before it, with | between.
HOST = os.environ.get("TACTUS_MAX_HOST", str(BUILD / "max_host" / "max_host")).split("|")
EMULATOR = HOST[:-1]
RATE = 48000
# Watches what perform does; not under sanitizers, which replace malloc too, nor another system's build.
GUARD = BUILD / "tests" / "guard" / "librtguard.so"
GUARD = str(GUARD) if GUARD.exists() and "TACTUS_MAX_HOST" not in os.environ else ""
if EMULATOR:
    # Wine's services begin with the first host and keep its output open: that is none which a test reads to its end.
    subprocess.run(HOST, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                   timeout=300)
    # A host that waits keeps wine's server: each run then begins in a tenth of a second.
    waiting = subprocess.Popen(HOST, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    atexit.register(waiting.communicate)


def declarations():
    objects = json.loads((BUILD / "declarations.json").read_text())
    return {d["name"]: d for d in objects}


def word(value):
    """An atom as the host's scripts write it: 3 is an int, 3.0 a float."""
    if isinstance(value, float):
        text = repr(value)
        return f"#{text}" if text in ("nan", "inf") else text
    if isinstance(value, str):
        return f'"{value}"' if " " in value or not value else value
    return str(value)


class Result:
    """What one run printed, by kind, and its exit status."""

    def __init__(self, status, lines, errors):
        self.status, self.lines, self.stderr = status, lines, errors

    def of(self, kind):
        """The texts of lines "KIND: TEXT"."""
        return [line[len(kind) + 2:] for line in self.lines if line.startswith(kind + ": ")]

    def sent(self, box, outlet=None):
        """(milliseconds, outlet, words) of what left a box's outlets."""
        found = []
        for line in self.of("out"):
            ms, name, number, *words = line.split(" ")
            if name == box and outlet in (None, int(number)):
                found.append((float(ms), int(number), words))
        return found

    def values(self, box):
        """attribute -> its last value, as text."""
        return dict(line.split(" ", 2)[1:] for line in self.of("value") if line.startswith(box + " "))


def run(lines, timeout=300, clean=True, mistake="", folder=None):
    """Runs the script; with clean, a violation of Max's rules fails the caller."""
    environment = {**os.environ, "MISTAKE": mistake, **({"LD_PRELOAD": GUARD} if GUARD else {})}
    done = subprocess.run(HOST, input="\n".join(lines) + "\n", capture_output=True, text=True, errors="replace",
                          timeout=timeout, env=environment, cwd=folder)
    result = Result(done.returncode, done.stdout.splitlines(), done.stderr)
    if clean:
        assert not result.of("violation"), "\n".join(result.of("violation"))
        assert done.returncode == 0, f"status {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return result


def load(name):
    return f"load {EXTERNALS / (name + SUFFIX)}"
