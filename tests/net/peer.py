"""What tests need to talk to a haptic server from outside: an encoder of its own, and the program."""
import csv
import itertools
import os
import signal
import socket
import struct
import subprocess
import time

PROGRAM = os.environ.get("HAPTIC_SERVER", "")


def padded(text):
    data = text.encode() if isinstance(text, str) else text
    return data + b"\0" * (4 - len(data) % 4)


def osc(address, *values):
    """An OSC 1.0 packet of the haptic protocol, or with a whole address of another; ints are i, floats
    f, strings s."""
    tags, body = ",", b""
    for value in values:
        if isinstance(value, str):
            tags, body = tags + "s", body + padded(value)
        elif isinstance(value, int):
            tags, body = tags + "i", body + struct.pack(">i", value)
        else:
            tags, body = tags + "f", body + struct.pack(">f", value)
    return padded(address if address.startswith("/") else "/hap/" + address) + padded(tags) + body


def parse(packet):
    def string(at):
        end = packet.index(b"\0", at)
        return packet[at:end].decode(), (end // 4 + 1) * 4
    address, at = string(0)
    tags, at = string(at)
    values = []
    for tag in tags[1:]:
        if tag == "s":
            value, at = string(at)
        else:
            value, = struct.unpack_from(">i" if tag == "i" else ">f", packet, at)
            at += 4
        values.append(value)
    return [address.removeprefix("/hap/"), *values]


def slip(packet):
    return b"\xc0" + packet.replace(b"\xdb", b"\xdb\xdd").replace(b"\xc0", b"\xdb\xdc") + b"\xc0"


class Peer:
    """One connection, in SLIP. Messages are lists: an address, then its values."""

    def __init__(self, port, host="127.0.0.1", timeout=20):
        self.rest, self.waiting = b"", []
        self.socket = socket.create_connection((host, port), timeout=timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, address, *values):
        self.socket.sendall(slip(osc(address, *values)))

    def hello(self, role="control", token=""):
        self.send("hello", 1, "peer", role, token)
        return self.wait("welcome")

    def cut(self):
        """Takes complete messages off what has come."""
        while True:
            frame, end, rest = self.rest.lstrip(b"\xc0").partition(b"\xc0")
            if not end:
                return
            self.rest = rest
            self.waiting.append(parse(frame.replace(b"\xdb\xdc", b"\xc0").replace(b"\xdb\xdd", b"\xdb")))

    def take(self, seconds):
        """More bytes, within that time; False when the connection has ended."""
        self.socket.settimeout(max(seconds, 1e-3))
        try:
            data = self.socket.recv(65536)
        except TimeoutError:
            return True
        except OSError:
            return False
        self.rest += data
        self.cut()
        return data != b""

    def wait(self, *beginning, seconds=20):
        """The next message that begins so; those before it are dropped."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            while self.waiting:
                message = self.waiting.pop(0)
                if message[:len(beginning)] == list(beginning):
                    return message
            if not self.take(end - time.monotonic()):
                break
        raise AssertionError(f"{beginning} did not come")

    def ended(self, seconds=20):
        """Whether the server ends the connection in that time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if not self.take(min(0.1, end - time.monotonic())):
                return True
        return False

    def push(self, holds, seconds=60):
        """Asks for 1 N and ever a little more until that holds, so that a trace tells when the server last
        heard of it."""
        end = time.monotonic() + seconds
        for i in itertools.count():
            self.send("force", 1 + 2e-4 * i, 0.0, 0.0)
            if holds():
                return
            assert time.monotonic() < end, "in vain"
            time.sleep(0.02)

    def close(self):
        self.socket.close()


class Program:
    """haptic_server on a free port, with its trace."""

    def __init__(self, folder, *options, force_limit=3.0, before=()):
        self.trace = folder / "trace.csv"
        self.force_limit = force_limit
        self.process = subprocess.Popen(
            [*before, PROGRAM, "--port", "0", "--force-limit", str(force_limit), "--trace",
             str(self.trace), *options],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.first = self.process.stdout.readline()
        assert ":" in self.first, self.process.communicate()
        self.port = int(self.first.split(":")[2].split()[0])

    def peer(self, **options):
        return Peer(self.port, **options)

    def in_control(self, port=None):
        """A client that is in control and whose force has come up; over the relay with its port."""
        peer = Peer(port or self.port)
        peer.hello()
        peer.send("start", "force")
        peer.push(lambda: self.force() > 0.9)
        return peer

    def signal(self, number):
        self.process.send_signal(number)

    def force(self):
        """The force, in N, that the trace holds last; it comes some 50 ms late."""
        with open(self.trace, "rb") as file:
            file.seek(max(0, self.trace.stat().st_size - 4096))
            lines = file.read().decode().split("\n")[:-1]
        words = lines[-1].split(",") if lines else []
        return size([float(word) for word in words[8:11]]) if len(words) > 12 else 0.0

    def wait_for_force(self, at_least, seconds=60):
        """Until the trace holds a force of at least so many N."""
        wait_until(lambda: self.force() >= at_least, seconds)

    def wait_for_none(self, seconds=60):
        wait_until(lambda: self.force() == 0, seconds)

    def end(self):
        """Ends it and returns the ticks: (s, force in N as a triple)."""
        self.signal(signal.SIGTERM)
        self.log, errors = self.process.communicate(timeout=60)
        assert self.process.returncode == 0, self.log + errors
        with open(self.trace) as file:
            rows = [(float(row["ms"]) / 1e3, tuple(float(row[f"f{axis}_n"]) for axis in "xyz"))
                    for row in csv.DictReader(file)]
        assert rows
        assert max(size(force) for _, force in rows) <= self.force_limit * (1 + 1e-6)
        assert size(rows[-1][1]) == 0
        return rows


def wait_until(holds, seconds=60):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "in vain"
        time.sleep(0.02)


def size(force):
    return sum(component * component for component in force) ** 0.5


def longest_hold_s(rows):
    """How long a force stayed the same, of clients that always ask for another: at most the half second
    after which silence ends it, by the server's own clock, whatever stalls."""
    longest_s, begun_s, held = 0.0, 0.0, 0.0
    for time_s, force in rows:
        if size(force) == 0 or abs(size(force) - held) > 1e-4:
            begun_s, held = time_s, size(force)
        longest_s = max(longest_s, time_s - begun_s if held else 0.0)
    return longest_s


HOLD_S = 0.5 + 2e-3  # and two ticks


def some_force(rows, begin, end=float("inf")):
    """Whether there was one between two times."""
    return any(size(force) > 0 for time_s, force in rows if begin < time_s < end)
