#!/usr/bin/env python3
"""Carries TCP connections on: each one to ADDRESS PORT goes to TO_ADDRESS TO_PORT, both ways.

    scripts/tcp_forward.py 127.0.0.1 7771 10.78.0.1 7772

It stands for `ssh -L` where computers are network namespaces: both ends of a bus speak to their own
127.0.0.1 alone, and what goes between the computers is this program's.
"""
import selectors
import socket
import sys

LIMIT = 1 << 18  # bytes that wait for one side before the other is read no more


class Side:
    def __init__(self, end):
        self.end, self.waiting, self.other, self.ended = end, bytearray(), None, False
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.setblocking(False)


def forward(door, target):
    events = selectors.DefaultSelector()
    events.register(door, selectors.EVENT_READ)

    def close(side):
        for one in (side, side.other):
            if not one.ended:
                one.ended = True
                events.unregister(one.end)
                one.end.close()

    def write(side):
        try:
            while side.waiting:
                del side.waiting[:side.end.send(side.waiting)]
        except BlockingIOError:
            pass

    def watch(side):
        wanted = selectors.EVENT_READ if len(side.other.waiting) < LIMIT else 0
        wanted |= selectors.EVENT_WRITE if side.waiting else 0
        events.modify(side.end, wanted or selectors.EVENT_WRITE, side)

    while True:
        for key, mask in events.select():
            if key.data is None:
                near, _ = door.accept()
                try:
                    far = socket.create_connection(target, timeout=10)
                except OSError:
                    near.close()
                    continue
                pair = Side(near), Side(far)
                for side, other in (pair, pair[::-1]):
                    side.other = other
                    events.register(side.end, selectors.EVENT_READ, side)
                continue
            side = key.data
            if side.ended:
                continue
            try:
                if mask & selectors.EVENT_READ:
                    data = side.end.recv(65536)
                    if not data:
                        close(side)
                        continue
                    side.other.waiting += data
                    write(side.other)
                if mask & selectors.EVENT_WRITE:
                    write(side)
            except OSError:
                close(side)
                continue
            watch(side)
            watch(side.other)


def main():
    address, port, to_address, to_port = sys.argv[1:]
    door = socket.create_server((address, int(port)))
    print("ready", flush=True)
    forward(door, (to_address, int(to_port)))


if __name__ == "__main__":
    main()
