#!/usr/bin/python3
"""Stands for modal_fem: serves a table by its protocol and fails in the way that its file name says (fake.MODE).
At parameters p the table is the file's own with frequencies times 1 + 10 p_0/m; modes keep their numbers."""
import io
import os
import signal
import struct
import sys
import zipfile

from fake_solver import MODE, MODES, READY, REFUSED, begin, forever, numbers, request, send


def npy(values, shape):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * (-(len(header) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + struct.pack(f"<{len(values)}d", *values)


members = begin("modal_fem", MODES)
assert len(sys.argv) == 3, sys.argv
frequencies = numbers(members["freq.npy"], "d")
K, P, V = len(frequencies), len(numbers(members["parameters.npy"], "d")) // 4, len(numbers(members["xyz.npy"], "f")) // 3
send(READY, struct.pack("<QQQ", K, V + (MODE == "sizes"), P))
while True:
    both = struct.unpack(f"<{2 * P}d", request())
    p, matched = both[:P], both[P:]
    if MODE == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if MODE == "mute":
        open(sys.argv[2] + ".asked", "w").close()
        forever()
    if MODE == "refuses":
        send(REFUSED, b"the body is\nsingular")
        continue
    fraction = 0.5 if MODE == "cut" else 1.0
    p = [fraction * x for x in p]
    members["freq.npy"] = npy([f * (1 + 10 * p[0]) for f in frequencies], (K,))
    members["displacement.npy"] = npy(p, (P,))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    shares = b"".join(struct.pack("<IId", k, k, 7 if MODE == "shares" else 1) for k in range(K))
    payload = struct.pack("<ddQ", matched[0], fraction, K) + shares + file.getvalue()
    if MODE == "half":
        send(MODES, payload[:100], len(payload))
        sys.exit(0)
    if MODE == "damaged":
        payload = payload[:-200] + bytes(200)
    send(MODES, payload)
