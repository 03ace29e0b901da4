#!/usr/bin/python3
"""Stands for part_stress: serves a table by its protocol and fails in the way that its file name says
(fake.MODE). At parameters p the stress is s0 (1 + 10 p_0/m), its derivatives 10 s0 and 0."""
import os
import signal
import struct
import sys

from fake_solver import MODE, READY, REFUSED, STRESS, begin, forever, numbers, out, request, send

members = begin("part_stress", STRESS)
assert sys.argv[3:] == ["--tolerance", "1e-08"], sys.argv
s0 = numbers(members["s0.npy"], "f")
N, P = len(s0), len(numbers(members["parameters.npy"], "d")) // 4
send(READY, struct.pack("<QQddd", N + (MODE == "sizes"), P, 1e-4, 1e-4, 0.01 if MODE != "costs" else float("nan")))
solved = 0
while True:
    wanted = request()
    method, flags = struct.unpack_from("<II", wanted)
    assert flags & 2  # the object decides when a new factor is made
    p = list(struct.unpack_from(f"<{P}d", wanted, 8))
    solved += 1
    values = [s * (1 + 10 * p[0] + (0.1 if MODE == "another" else 0)) for s in s0]
    if solved > 1:  # the first is the object's comparison with the table
        if MODE == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if MODE == "mute":
            forever()
        if MODE == "nonsense":
            method = 9
        if MODE == "half":
            send(STRESS, bytes(100), 32 + 8 * P + 8 * N)
            sys.exit(0)
        if MODE == "short":
            send(STRESS, bytes(32 + 8 * P + 4 * N))
            forever()
        if MODE == "refuses" and solved == 2:
            send(REFUSED, b"the part is\nsingular")
            continue
        if MODE == "cut":
            p = [x / 2 for x in p]
        if MODE == "talks":
            sys.stderr.write("still here\n" * 100000)
    method = 2 if flags & 1 else method
    answer = struct.pack("<IIddd", method, 12 if method == 1 else 0, 0.01, 1, 1e-9)
    answer += struct.pack(f"<{P}d", *p) + 2 * struct.pack(f"<{N}f", *values)
    if flags & 1:
        rows = [[10 * s for s in s0]] + [[0] * N] * (P - 1)
        answer += 2 * b"".join(struct.pack(f"<{N}f", *row) for row in rows)
    send(STRESS, answer)
    if MODE == "leaves":
        sys.exit(3)
    if MODE == "floods" and solved == 2:
        out.write(b"more" * 100)
        out.flush()
