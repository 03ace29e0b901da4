"""Tables in numpy.savez's format, written with Python's standard library only; equal inputs give equal
bytes."""
import json
import struct
import zipfile


def array(kind, shape, numbers):
    """The bytes of an .npy member; kind is '<f8', '<f4', '<i4' or '|u1'."""
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {tuple(shape)}, }}"
    header += " " * (-(len(header) + 11) % 64) + "\n"
    letter = {"<f8": "d", "<f4": "f", "<i4": "i", "|u1": "B"}[kind]
    return (b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode()
            + struct.pack(f"<{len(numbers)}{letter}", *numbers))


def description(meta):
    """The member `meta` as bytes of JSON."""
    text = json.dumps(meta).encode()
    return array("|u1", (len(text),), list(text))


def write(path, members):
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name + ".npy", (1980, 1, 1, 0, 0, 0)), content)
