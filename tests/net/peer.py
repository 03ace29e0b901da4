"""What tests need to talk to a haptic server from outside: an encoder of its own, and the program."""
import csv
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


def with_length(packet):
    return struct.pack(">i", len(packet)) + packet


def fudi(address, *values):
    words = [str(value) for value in values if value != ""]
    return (" ".join(["hap", *address.split("/"), *words]) + ";\n").encode()


class Peer:
    """One connection. Messages are lists: an address, then its values."""

    def __init__(self, port, framing="length", host="127.0.0.1", timeout=20):
        self.framing, self.rest, self.waiting = framing, b"", []
        self.socket = socket.create_connection((host, port), timeout=timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, address, *values):
        if self.framing == "fudi":
            data = fudi(address, *values)
        else:
            data = {"slip": slip, "length": with_length}[self.framing](osc(address, *values))
        self.socket.sendall(data)

    def hello(self, role="control", token=""):
        self.send("hello", 1, "peer", role, token)
        return self.wait("welcome")

    def cut(self):
        """Takes complete messages off what has come."""
        while True:
            if self.framing == "fudi":
                end = self.rest.find(b";")
                if end < 0:
                    return
                words = self.rest[:end].decode().replace("\\ ", "\0").split()
                self.rest = self.rest[end + 1:]
                words = [word.replace("\0", " ") for word in words[1:]]
                if words[0] == "cp":
                    words = ["/".join(words[:2]), *words[2:]]
                self.waiting.append(words[:1] + [number(word) for word in words[1:]])
            elif self.framing == "slip":
                frame, end, rest = self.rest.lstrip(b"\xc0").partition(b"\xc0")
                if not end:
                    return
                self.rest = rest
                self.waiting.append(parse(frame.replace(b"\xdb\xdc", b"\xc0").replace(b"\xdb\xdd", b"\xdb")))
            else:
                if len(self.rest) < 4:
                    return
                size, = struct.unpack_from(">i", self.rest)
                if len(self.rest) < 4 + size:
                    return
                self.waiting.append(parse(self.rest[4:4 + size]))
                self.rest = self.rest[4 + size:]

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

    def hold(self, seconds, *message, every=0.02):
        """Sends the message again and again for that long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.send(*message)
            time.sleep(every)

    def close(self):
        self.socket.close()


def number(word):
    try:
        return float(word)
    except ValueError:
        return word


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

    def peer(self, framing="length"):
        return Peer(self.port, framing)

    def signal(self, number):
        self.process.send_signal(number)

    def force(self):
        """The force, in N, that the trace holds last; it comes some 50 ms late."""
        with open(self.trace, "rb") as file:
            file.seek(max(0, self.trace.stat().st_size - 4096))
            lines = file.read().decode().split("\n")[:-1]
        words = lines[-1].split(",") if lines else []
        return size([float(word) for word in words[8:11]]) if len(words) == 13 else 0.0

    def wait_for_force(self, at_least, seconds=60):
        """Until the trace holds a force of at least so many N."""
        end = time.monotonic() + seconds
        while self.force() < at_least:
            assert time.monotonic() < end, f"no force of {at_least} N came"
            time.sleep(0.02)

    def end(self):
        """Ends it and returns the ticks: (s, force in N as a triple)."""
        self.signal(signal.SIGTERM)
        output, errors = self.process.communicate(timeout=60)
        assert self.process.returncode == 0, output + errors
        self.output = output
        with open(self.trace) as file:
            rows = [(float(row["ms"]) / 1e3, tuple(float(row[f"f{axis}_n"]) for axis in "xyz"))
                    for row in csv.DictReader(file)]
        assert rows
        assert max(size(force) for _, force in rows) <= self.force_limit * (1 + 1e-6)
        assert size(rows[-1][1]) == 0
        return rows


def size(force):
    return sum(component * component for component in force) ** 0.5


def last_force(rows, after=0.0):
    """The time of the last tick with a force; None when there is none."""
    times = [time_s for time_s, force in rows if size(force) > 0 and time_s > after]
    return times[-1] if times else None


def largest(rows, begin, end):
    """The largest force, in N, between two times."""
    return max(size(force) for time_s, force in rows if begin <= time_s <= end)


def near(rows, time_s):
    """The force at the first tick from that time on."""
    return next(force for tick_s, force in rows if tick_s >= time_s)
