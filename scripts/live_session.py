"""Live Pds on the computers of an emulated network, and a clock for what they say.

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
import socket
import struct
import subprocess
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
STAGE = pathlib.Path(os.environ.get("TACTUS_STAGE", ROOT / "build" / "tactus")).resolve()
SO_TIMESTAMPNS = 35
EVENT_PORT, ORDER_PORT = 7801, 7802


class LivePatch:
    """Boxes and cords of a patch; `tell` sends words to the session, Session.send comes to receivers."""

    def __init__(self):
        self.boxes, self.cords = [], []
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
        """Whatever leaves that outlet is the event `word`."""
        bang, message = self.obj("t b"), self.msg(word)
        self.cord(source, outlet, bang)
        self.cord(bang, 0, message)
        self.cord(message, 0, self.obj("s session-event"))

    def _event_sender(self):
        load, door = self.obj("loadbang"), self.msg(f"connect 127.0.0.1 {EVENT_PORT}")
        send = self.chain(self.obj("r session-event"), "list", "list prepend send", "list trim",
                          "netsend -u")
        self.cord(load, 0, door)
        self.cord(door, 0, send)

    def _order_receiver(self):
        fork = self.chain(self.obj(f"netreceive -u {ORDER_PORT} 127.0.0.1"), "list", "t l l")
        name = self.chain(fork, "list split 1", "makefilename %s", outlet=1)
        words = self.chain(self.chain(fork, "list split 1"), "list trim", outlet=1)
        send = self.obj("s")
        self.cord(name, 0, send, 1)
        self.cord(words, 0, send)

    def net(self, receiver, words):
        """An ioa_net that takes orders by that receiver, and tells that it is connected."""
        join = self.obj(f"ioa_net {words}")
        self.cord(self.obj(f"r {receiver}"), 0, join)
        self.tell(self.chain(join, "route connected", "sel 1"), 0, f"{receiver}-connected")

    def see(self, bus, *topics):
        """Keeps what comes on these topics of a bus; `session-write FILE` writes it, a row a message."""
        rows = self.chain(self.obj(f"ioa_bus {bus} {' '.join(topics)}"), "list", "text insert session-seen 1e+06")
        table = self.obj("text define session-seen")
        self.cord(self.chain(self.obj("r session-write"), "symbol"), 0, write := self.msg("write -c \\$1"))
        self.cord(write, 0, table)
        return rows

    def text(self):
        return "\n".join(["#N canvas 0 0 800 600 12;", *self.boxes, *self.cords]) + "\n"


class Session:
    """Pds by the name of their computer, one each, and the time of each event, s of CLOCK_MONOTONIC,
    taken by the kernel as Pd sends it."""

    def __init__(self, network, folder):
        self.network, self.folder = network, pathlib.Path(folder)
        self.pds, self.doors, self.events, self.threads = {}, {}, [], []
        self.closing = False
        self.realtime_ahead_s = time.time() - time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def play(self, computer, patch, audio_rate=48000, opens=()):
        """Starts Pd with the patch, and with others beside it; it runs by the clock, with sound
        computed and not played."""
        file = self.folder / f"{computer}.pd"
        file.write_text(patch.text())
        door = self.network.socket(computer)
        door.bind(("127.0.0.1", EVENT_PORT))
        door.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        door.settimeout(0.2)
        self.doors[computer] = door
        self.threads.append(threading.Thread(target=self._listen, args=(computer, door)))
        self.threads[-1].start()
        log = open(self.folder / f"{computer}.log", "w")
        opened = [word for other in opens for word in ("-open", other)]
        self.pds[computer] = self.network.start(
            computer, ["pd", "-nogui", "-nosound", "-nomidi", "-noprefs", "-stderr", "-r", audio_rate,
                       "-path", STAGE, *opened, "-open", file],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log, cwd=self.folder)
        self.wait(computer, "loaded")

    def _listen(self, computer, door):
        while not self.closing:
            try:
                data, ancillary, _, _ = door.recvmsg(2048, 64)
            except TimeoutError:
                continue
            seconds, nanoseconds = next(struct.unpack("qq", value) for level, kind, value in ancillary
                                        if kind == SO_TIMESTAMPNS)
            at_s = seconds + 1e-9 * nanoseconds - self.realtime_ahead_s
            for line in data.decode().replace("\n", "").split(";")[:-1]:
                self.events.append((at_s, computer, line))

    def said(self, computer):
        """All that Pd has printed."""
        return (self.folder / f"{computer}.log").read_text()

    def of(self, computer, word):
        """Times of that event, s, in order."""
        return [at_s for at_s, where, what in list(self.events) if (where, what) == (computer, word)]

    def wait(self, computer, word, count=1, seconds=60):
        end = time.monotonic() + seconds
        while len(self.of(computer, word)) < count:
            if self.pds[computer].poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"no {word} from the Pd on {computer}, which said:\n"
                                   + self.said(computer)[-2000:])
            time.sleep(0.01)

    def send(self, computer, receiver, words):
        """To a receiver of that Pd."""
        self.doors[computer].sendto(f"{receiver} {words};\n".encode(), ("127.0.0.1", ORDER_PORT))

    def cpu_s(self, computer):
        """Processor time that this Pd has used."""
        fields = pathlib.Path(f"/proc/{self.pds[computer].pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def join(self, caller, listener, port, calling, listening):
        """The bus's ioa_net of two Pds over 127.0.0.1, through a tunnel where they are two computers.
        calling, listening: receivers that lead to them. Both sides tell `RECEIVER-connected`
        (LivePatch.net)."""
        self.send(listener, listening, f"listen {port}")
        self.network.tunnel(caller, listener, port)
        end = time.monotonic() + 30
        while not self.of(caller, f"{calling}-connected") and time.monotonic() < end:
            self.send(caller, calling, f"connect {port}")
            time.sleep(0.3)
        self.wait(caller, f"{calling}-connected")
        self.wait(listener, f"{listening}-connected")

    def line_bytes(self, computer, interface="line"):
        """{"rx_bytes", "rx_packets", "tx_bytes", "tx_packets"} of a network interface so far."""
        lines = subprocess.run([*self.network.inside(computer), "cat", "/proc/net/dev"],
                               capture_output=True, text=True, check=True).stdout
        numbers = next(line.split(":")[1].split() for line in lines.splitlines()
                       if line.strip().startswith(interface + ":"))
        return dict(zip(("rx_bytes", "rx_packets", "tx_bytes", "tx_packets"),
                        (int(numbers[i]) for i in (0, 1, 8, 9))))

    def close(self):
        for process in self.pds.values():
            process.kill()
            process.wait()
        self.closing = True
        for thread in self.threads:
            thread.join()
        for door in self.doors.values():
            door.close()
