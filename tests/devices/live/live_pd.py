"""Unmodified Pd in real time, with [phantom] on doubles of devices that it takes for real."""
import os
import pathlib
import re
import shlex
import socket
import subprocess
import time

import pytest

from pd_process import PD, Pd, write_patch


class Patch:
    """One [phantom] with a print on each outlet and messages at given times."""

    def __init__(self, arguments):
        self.lines = []
        self.cords = []
        self.receivers = []
        self.box = self.obj(f"phantom {arguments}")
        self.start = self.obj("loadbang")
        for outlet, name in enumerate(("x", "y", "z", "info")):
            self.cord(self.box, outlet, self.obj(f"print {name}"), 0)

    def obj(self, text, kind="obj"):
        self.lines.append(f"#X {kind} 10 10 {text};")
        return len(self.lines) - 1

    def cord(self, source, outlet, sink, inlet):
        self.cords.append(f"#X connect {source} {outlet} {sink} {inlet};")

    def at(self, ms, message):
        delay, box = self.obj(f"delay {ms}"), self.obj(message, "msg")
        self.cord(self.start, 0, delay, 0)
        self.cord(delay, 0, box, 0)
        self.cord(box, 0, self.box, 0)

    def listen(self, port):
        """Messages from outside: `quit` ends Pd, all else goes to [phantom]."""
        door = self.obj(f"netreceive -u {port}")
        route, leave = self.obj("route quit"), self.obj(r"\; pd quit", "msg")
        self.cord(door, 0, route, 0)
        self.cord(route, 0, leave, 0)
        if self.receivers:
            named = self.obj(f"route {' '.join(self.receivers)}")
            self.cord(route, 1, named, 0)
            for outlet, name in enumerate(self.receivers):
                self.cord(named, outlet, self.obj(f"s {name}"), 0)
            self.cord(named, len(self.receivers), self.box, 0)
        else:
            self.cord(route, 1, self.box, 0)

    def at_once(self, name, messages):
        """`name bang` from outside sends all of these to [phantom] at one instant."""
        self.forward(name)
        receiver, box = self.obj(f"r {name}"), self.obj(r" \, ".join(messages), "msg")
        self.cord(receiver, 0, box, 0)
        self.cord(box, 0, self.box, 0)

    def forward(self, *names):
        """Messages from outside that begin with one of these go to the receiver of that name."""
        self.receivers += names

    def save(self, folder):
        return write_patch(folder, self.lines + self.cords)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as door:
        door.bind(("127.0.0.1", 0))
        return door.getsockname()[1]


class Live(Pd):
    """Pd running in a double's world."""

    def __init__(self, folder, patch, wrapper=(), environment=None):
        self.report, self.port = folder / "double.txt", free_port()
        patch.listen(self.port)
        super().__init__(folder, *patch.lines, *patch.cords, before=wrapper, environment=environment,
                         stdin=subprocess.PIPE)

    def __exit__(self, kind, *_):
        """Where all went well Pd quits, with no force left in the double's motors."""
        try:
            if kind is None and self.process.poll() is None:
                assert motors(self.end()) == [0, 0, 0]
        finally:
            self.close()

    def wait_for_patch(self):
        """Until Pd hears what is said to it."""
        def heard():
            self.tell_phantom("get slew")
            return "info: slew" in self.read()

        self.wait_until(heard)

    def tell_double(self, line):
        self.process.stdin.write(f"{line}\n".encode())
        self.process.stdin.flush()

    def unplug(self):
        self.wait_for_answer(lambda: self.tell_double("unplug"), r"^info: status lost falcon")

    def plug(self):
        self.wait_for_answer(lambda: self.tell_double("plug"), r"^info: status open falcon")

    def tell_phantom(self, message):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as door:
            door.sendto(f"{message};\n".encode(), ("127.0.0.1", self.port))

    def push(self, force, receiver=""):
        """Until the double's motors feel it. A machine that stalls for 20 ms looks like a device
        that has failed, after which the motors have to be asked for again. receiver: of [phantom],
        where it has one of its own."""
        def felt():
            return any(abs(m) > 100 for m in motors(self.state()))

        for _ in range(20):
            self.tell_phantom(f"{receiver} list {force}".strip())
            end = time.monotonic() + 2
            while time.monotonic() < end:
                if felt():
                    return
                time.sleep(0.05)
            self.tell_phantom(f"{receiver} motors 1".strip())
        raise AssertionError(f"no force came; Pd said:\n{self.read()[-3000:]}")

    def state(self):
        try:
            lines = self.report.read_text().split()
        except FileNotFoundError:
            return {}
        return {name: int(value) for name, value in (line.split("=") for line in lines)}

    def errors_without_stalls(self):
        """Pd's errors, but for the one about a double that a stalling machine kept from answering."""
        errors = re.findall(r"^error: (.*)$", self.read(), re.M)
        return [error for error in errors if "the device no longer answers" not in error]

    def end(self):
        """What the double saw last, after Pd was told to quit."""
        self.tell_phantom("quit")
        self.process.wait(60)
        self.read()
        return self.state()

    def positions(self):
        return [float(x) for x in re.findall(r"^x: (\S+)$", self.read(), re.M)]


def world(name, *options):
    """The words in front of Pd that make the world of a double."""
    double = os.environ.get(name)
    if not double:
        pytest.skip("umockdev is missing: apt-get install umockdev libumockdev-dev")
    return [*shlex.split(double), *options]


def falcon_world(folder, *options):
    return world("FALCON_DOUBLE", "--stdin", "--report", str(folder / "double.txt"), *options)


def falcon_patch(folder):
    """Its Falcon is opened at once."""
    (folder / "firmware.bin").write_bytes(bytes(i * i * 7 % 251 for i in range(500)))
    patch = Patch("falcon")
    patch.at(50, "firmware firmware.bin")
    patch.at(100, "open")
    return patch


def motors(state):
    return [state.get(f"motor{i}", 0) for i in range(3)]


def pd_of(folder):
    """Process numbers of the Pd that plays the folder's patch."""
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if words[0] == PD[0].encode() and bytes(folder / "patch.pd") in words:
            yield int(entry.name)


def some(quick, *slow):
    """Parameters of a test, of which the first stand for all in the quick tier."""
    return [*quick, *(pytest.param(*one, marks=pytest.mark.slow) for one in slow)]
