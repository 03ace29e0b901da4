#!/usr/bin/python3
"""Stands for modal_fem: serves a table by its protocol and fails in the way that its file name says (fake.MODE).
At parameters p the table is the file's own with frequencies times 1 + 10 p_0/m; modes keep their numbers."""
import io
import os
import signal
import struct
import sys
import time
import zipfile

MODE = os.path.basename(sys.argv[0]).split(".")[1]
READY, REFUSED, MODES = 16, 18, 19


def npy(values, shape):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * (-(len(header) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + struct.pack(f"<{len(values)}d", *values)


def doubles(stored):
    raw = stored[10 + struct.unpack_from("<H", stored, 8)[0]:]
    return struct.unpack(f"<{len(raw) // 8}d", raw)


def send(kind, payload, size=None):
    out.write(struct.pack("<IIQ", 0x31525354, kind, len(payload) if size is None else size) + payload)
    out.flush()


def forever():
    while True:
        time.sleep(3600)


out = sys.stdout.buffer
assert sys.argv[1] == "serve" and len(sys.argv) == 3, sys.argv
if MODE == "dies":
    sys.exit("modal_fem: a\x07 reason")
if MODE == "hangs":
    forever()
if MODE == "garbage":
    out.write(os.urandom(5000))
    out.flush()
    forever()
if MODE == "huge":
    send(MODES, b"", 1 << 60)
    forever()
with zipfile.ZipFile(sys.argv[2]) as file:
    members = {name: file.read(name) for name in file.namelist() if name != "mesh.npy"}
frequencies = doubles(members["freq.npy"])
K, P = len(frequencies), len(doubles(members["parameters.npy"])) // 4
V = (len(members["xyz.npy"]) - 10 - struct.unpack_from("<H", members["xyz.npy"], 8)[0]) // 12
send(READY, struct.pack("<QQQ", K, V + (MODE == "sizes"), P))
while True:
    header = sys.stdin.buffer.read(16)
    if len(header) < 16:
        sys.exit(0)  # the object has gone
    request = sys.stdin.buffer.read(struct.unpack("<IIQ", header)[2])
    both = struct.unpack(f"<{2 * P}d", request)
    p, matched = both[:P], both[P:]
    if MODE == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if MODE == "mute":
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
