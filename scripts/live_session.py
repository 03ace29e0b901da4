"""Live Pds on the computers of an emulated network, with time stamps of their events.

    with EmulatedNetwork(["hand", "sound"]) as network, Session(network, folder) as session:
        patch = LivePatch()
        patch.tell(patch.obj("r lab.hit"), 0, "hit")
        session.play("hand", patch)
        session.send("hand", "lab.phantom", "motors 1")
        session.wait("hand", "ready")
        session.of("hand", "hit")          # times in s
"""
import os
import pathlib
import re
import secrets
import socket
import struct
import subprocess
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
STAGE = pathlib.Path(os.environ.get("TACTUS_STAGE", ROOT / "build" / "tactus")).resolve()
SO_TIMESTAMPNS = 35
FIRST_PORT = 7801  # ports of the session's own messages, on each computer's 127.0.0.1


class LivePatch:
    """Boxes and connections of a patch; `tell` sends words to the session, Session.send reaches receivers.
    number: distinguishes the Pds of one computer."""

    def __init__(self, number=0):
        self.boxes, self.cords = [], []
        self.event_port, self.order_port = FIRST_PORT + 2 * number, FIRST_PORT + 2 * number + 1
        self._event_sender()
        self._order_receiver()
        self.loaded = self.obj("loadbang")
        self.tell(self.chain(self.loaded, "delay 100"), 0, "loaded")  # when all others have loaded

    def obj(self, text, kind="obj"):
        self.boxes.append(f"#X {kind} 10 10 {text};")
        return len(self.boxes) - 1

    def msg(self, text):
        return self.obj(text, "msg")

    def cord(self, source, outlet, sink, inlet=0):
        self.cords.append(f"#X connect {source} {outlet} {sink} {inlet};")

    def chain(self, source, *boxes, outlet=0):
        """Boxes one below the other, from that outlet on; returns the last."""
        for text in boxes:
            sink = self.obj(text)
            self.cord(source, outlet, sink)
            source, outlet = sink, 0
        return source

    def tell(self, source, outlet, word):
        """Reports any output of that outlet as the event `word`."""
        bang, message = self.obj("t b"), self.msg(word)
        self.cord(source, outlet, bang)
        self.cord(bang, 0, message)
        self.cord(message, 0, self.obj("s session-event"))

    def _event_sender(self):
        load, door = self.obj("loadbang"), self.msg(f"connect 127.0.0.1 {self.event_port}")
        send = self.chain(self.obj("r session-event"), "list", "list prepend send", "list trim",
                          "netsend -u")
        self.cord(load, 0, door)
        self.cord(door, 0, send)

    def _order_receiver(self):
        fork = self.chain(self.obj(f"netreceive -u {self.order_port} 127.0.0.1"), "list", "t l l")
        name = self.chain(fork, "list split 1", "makefilename %s", outlet=1)
        words = self.chain(self.chain(fork, "list split 1"), "list trim", outlet=1)
        send = self.obj("s")
        self.cord(name, 0, send, 1)
        self.cord(words, 0, send)

    def net(self, receiver, words):
        """Adds an ioa_net that is controlled through that receiver and reports when it is connected."""
        join = self.obj(f"ioa_net {words}")
        self.cord(self.obj(f"r {receiver}"), 0, join)
        self.tell(self.chain(join, "route connected", "sel 1"), 0, f"{receiver}-connected")

    def see(self, bus, *topics):
        """Stores messages on these topics of a bus; `session-write FILE` writes them, one row per message."""
        rows = self.chain(self.obj(f"ioa_bus {bus} {' '.join(topics)}"), "list", "text insert session-seen 1e+06")
        table = self.obj("text define session-seen")
        self.cord(self.chain(self.obj("r session-write"), "symbol"), 0, write := self.msg("write -c \\$1"))
        self.cord(write, 0, table)
        return rows

    def text(self):
        return "\n".join(["#N canvas 0 0 800 600 12;", *self.boxes, *self.cords]) + "\n"


class Session:
    """Pds by name (by default their computer's), and the time of each event in s of CLOCK_MONOTONIC. The kernel takes
    this time when Pd sends the event."""

    def __init__(self, network, folder):
        self.network, self.folder = network, pathlib.Path(folder)
        self.pds, self.doors, self.computers, self.order_ports = {}, {}, {}, {}
        self.events, self.threads = [], []
        self.closing = False
        self.realtime_ahead_s = time.time() - time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def play(self, computer, patch, audio_rate=48000, opens=(), name=None):
        """Starts Pd with the patch and further ones; it runs in real time, computing sound without
        playing it."""
        name = name or computer
        self.computers[name], self.order_ports[name] = computer, patch.order_port
        file = self.folder / f"{name}.pd"
        file.write_text(patch.text())
        door = self.network.socket(computer)
        door.bind(("127.0.0.1", patch.event_port))
        door.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        door.settimeout(0.2)
        self.doors[name] = door
        self.threads.append(threading.Thread(target=self._listen, args=(name, door)))
        self.threads[-1].start()
        opened = [word for other in opens for word in ("-open", other)]
        with open(self.folder / f"{name}.log", "w") as log:
            self.pds[name] = self.network.start(
                computer, ["pd", "-nogui", "-nosound", "-nomidi", "-noprefs", "-stderr", "-r", audio_rate,
                           "-path", STAGE, *opened, "-open", file],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log, cwd=self.folder)
        self.wait(name, "loaded")

    def _listen(self, name, door):
        while not self.closing:
            try:
                data, ancillary, _, _ = door.recvmsg(2048, 64)
            except TimeoutError:
                continue
            seconds, nanoseconds = next(struct.unpack("qq", value) for level, kind, value in ancillary
                                        if kind == SO_TIMESTAMPNS)
            at_s = seconds + 1e-9 * nanoseconds - self.realtime_ahead_s
            for line in data.decode().replace("\n", "").split(";")[:-1]:
                self.events.append((at_s, name, line.strip()))

    def said(self, name):
        """Everything that this Pd has printed."""
        return (self.folder / f"{name}.log").read_text()

    def of(self, name, word):
        """Times of that event, s, in order."""
        return [at_s for at_s, where, what in list(self.events) if (where, what) == (name, word)]

    def wait(self, name, word, count=1, seconds=60):
        end = time.monotonic() + seconds
        while len(self.of(name, word)) < count:
            if self.pds[name].poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"no {word} from the Pd {name}; its log:\n"
                                   + self.said(name)[-2000:])
            time.sleep(0.01)

    def send(self, name, receiver, words):
        """Sends words to a receiver of that Pd."""
        self.doors[name].sendto(f"{receiver} {words};\n".encode(),
                                ("127.0.0.1", self.order_ports[name]))

    def cpu_s(self, name):
        """Processor time that this Pd has used."""
        fields = pathlib.Path(f"/proc/{self.pds[name].pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def join(self, caller, listener, port, calling, listening):
        """Connects the ioa_net objects of two Pds, with a token if they are on two computers. calling,
        listening:
        receivers of these objects. Returns when both sides have reported `RECEIVER-connected`
        (LivePatch.net)."""
        here, there = self.computers[caller], self.computers[listener]
        if here == there:
            listen, connect = f"listen {port}", f"connect {port}"
        else:
            address = self.network.address(there)
            listen, connect = f"listen {port} {address}", f"connect {address} {port}"
            for name, receiver in ((caller, calling), (listener, listening)):
                self.send(name, receiver, f"token {self._token_file()}")
        self.send(listener, listening, listen)
        self.send(caller, calling, connect)
        self.wait(caller, f"{calling}-connected")
        self.wait(listener, f"{listening}-connected")

    def _token_file(self):
        """The token file shared by all computers of this session."""
        file = self.folder.resolve() / "token"
        if not file.exists():
            file.touch(mode=0o600)
            file.write_text(f"{secrets.token_hex(16)}\n")
        return file

    def tcp_traffic(self, computer, port):
        """(bytes, segments) carried by the TCP connection from that computer to that port, in both
        directions, counted by the client's kernel without headers."""
        text = subprocess.run([*self.network.inside(computer), "ss", "-tinH", "state", "established",
                               "dport", f"= :{port}"], capture_output=True, text=True, check=True).stdout
        found = {name: int(value) for name, value in
                 re.findall(r"(bytes_sent|bytes_received|segs_out|segs_in):(\d+)", text)}
        return (found.get("bytes_sent", 0) + found.get("bytes_received", 0),
                found.get("segs_out", 0) + found.get("segs_in", 0))

    def close(self):
        for process in self.pds.values():
            process.kill()
            process.wait()
        self.closing = True
        for thread in self.threads:
            thread.join()
        for door in self.doors.values():
            door.close()
