"""What fake_modal_fem.py and fake_part_stress.py share: frames of core/serve, and a program's failures before it has
answered anything. The mode is in the name by which the program is called (fake.MODE)."""
import os
import struct
import sys
import time
import zipfile

MODE = os.path.basename(sys.argv[0]).split(".")[1]
READY, STRESS, REFUSED, MODES = 16, 17, 18, 19
out = sys.stdout.buffer


def send(kind, payload, size=None):
    out.write(struct.pack("<IIQ", 0x31525354, kind, len(payload) if size is None else size) + payload)
    out.flush()


def forever():
    while True:
        time.sleep(3600)


def begin(program, kind):
    """Fails, if that is the mode; else the table's members by name."""
    assert sys.argv[1] == "serve", sys.argv
    if MODE == "dies":
        sys.exit(f"{program}: a\x07 reason")
    if MODE == "garbage":
        out.write(struct.pack("<IIQ", 0x31525355, READY, 40) + bytes(40))  # right but for its first word
        out.flush()
    if MODE == "huge":
        send(kind, b"", 1 << 60)
    if MODE in ("hangs", "garbage", "huge"):
        forever()
    with zipfile.ZipFile(sys.argv[2]) as file:
        return {name: file.read(name) for name in file.namelist()}


def request():
    header = sys.stdin.buffer.read(16)
    if len(header) < 16:
        sys.exit(0)  # the object has gone
    return sys.stdin.buffer.read(struct.unpack("<IIQ", header)[2])


def numbers(stored, code):
    """Of a stored .npy member."""
    raw = stored[10 + struct.unpack_from("<H", stored, 8)[0]:]
    return struct.unpack(f"<{len(raw) // struct.calcsize(code)}{code}", raw)
