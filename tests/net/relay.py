"""A TCP relay that does to a connection what bad networks do; bytes stay in order, as in TCP."""
import random
import selectors
import socket
import threading
import time


class Relay:
    """Between clients of its own port and 127.0.0.1:target. Settings may change at any time.

    delay_s, jitter_s: of every piece, the jitter uniform up to jitter_s or, with `exponential`, of
    that mean; loss: share of pieces that come late by retry_s, as a
    retransmission does; stalled: nothing passes and nobody is told (a half-open peer); cut(): both
    ends are closed.
    """

    def __init__(self, target, seed=1):
        self.target, self.chance = target, random.Random(seed)
        self.delay_s = self.jitter_s = self.loss = 0.0
        self.retry_s, self.stalled, self.exponential = 0.2, False, False
        self.door = socket.create_server(("127.0.0.1", 0))
        self.port = self.door.getsockname()[1]
        self.pairs, self.ended = [], False
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while not self.ended:
            try:
                client, _ = self.door.accept()
            except OSError:
                return
            try:
                server = socket.create_connection(("127.0.0.1", self.target), timeout=5)
            except OSError:
                client.close()
                continue
            for one in (client, server):
                one.settimeout(None)
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.pairs.append((client, server))
            for source, sink in ((client, server), (server, client)):
                threading.Thread(target=self.pump, args=(source, sink), daemon=True).start()

    def pump(self, source, sink):
        waiting, due_last = [], 0.0  # (time, bytes) in order
        poll = selectors.DefaultSelector()
        poll.register(source, selectors.EVENT_READ)
        try:
            while not self.ended:
                now = time.monotonic()
                pause = max(0.0, min(waiting[0][0] - now, 0.01)) if waiting else 0.01
                if poll.select(pause):
                    data = source.recv(65536)
                    if not data:
                        break
                    drawn = self.chance.expovariate(1) if self.exponential else self.chance.random()
                    late = self.delay_s + self.jitter_s * drawn
                    if self.chance.random() < self.loss:
                        late += self.retry_s
                    due_last = max(due_last, time.monotonic() + late)
                    waiting.append((due_last, data))
                while waiting and waiting[0][0] <= time.monotonic() and not self.stalled:
                    sink.sendall(waiting.pop(0)[1])
        except OSError:
            pass
        shut(source, sink)

    def cut(self):
        pairs, self.pairs = self.pairs, []
        for pair in pairs:
            shut(*pair)

    def close(self):
        self.ended = True
        self.door.close()
        self.cut()


def shut(*sockets):
    for one in sockets:
        try:
            one.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
