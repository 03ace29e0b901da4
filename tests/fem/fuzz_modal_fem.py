#!/usr/bin/python3
"""Damaged files against modal_fem: bit flips, truncations, numbers blown up, lines or pieces deleted and doubled.

    fuzz_modal_fem.py PROGRAM [--mutants N] [--formats msh2,step,...] [--seed S] [--h MM] [--keep FOLDER]

Seeds are fixed: the same call tries the same files. Each mutant is read, meshed and exported (no modes), with
--time-limit 10 (60 with --sanitized; 300 for the undamaged file) and 3 GB of address space. A table is printed: how
many were read, refused in one sentence, or ended in the child process (crash, memory, silence: also one sentence); and
the faults: the program died by a signal, went on for 50 s beyond the limit, took more than 2 GB, or did not say one
sentence. The status is 1 when there is a fault.
Needs numpy; STEP and BREP bodies come from Debian's gmsh-doc and
occt-misc, and are left out where those are not installed.
"""
import argparse
import collections
import concurrent.futures
import gzip
import os
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

BYTES, ADDRESS_SPACE = 2e9, 3 << 30
GRACE = 50  # s that the program may take beyond its --time-limit
FORMATS = ["msh2", "msh2b", "msh4", "msh4b", "step", "brep", "stl", "stlb", "obj", "inp", "parts", "npz"]
ENDINGS = {"msh2": "msh", "msh2b": "msh", "msh4": "msh", "msh4b": "msh", "stlb": "stl", "parts": "inp", "npz": "modal.npz"}
STEP = "/usr/share/doc/gmsh-doc/doc/gmsh/tutorial/t20_data.step.gz"
BREP = "/usr/share/opencascade/data/occ/solid.brep"
HUGE_NUMBERS = ["-1", "0", "2147483647", "-2147483648", "4294967296", "18446744073709551615", "1e30", "-1e300", "nan", "inf",
                "1e-320", "999999999", "0.000001", "1000000"]


def cube(n=3):
    """Corners and outward triangles of a cube of 20 mm, n squares a side."""
    triangles = []
    for axis in range(3):
        for side in (0, 1):
            for i in range(n):
                for j in range(n):
                    corners = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0, 0, 0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = 20 * side, 20 * u / n, 20 * v / n
                        corners.append(tuple(p))
                    a, b, c, d = corners if side else corners[::-1]
                    triangles += [(a, b, c), (a, c, d)]
    return triangles


def stl_text():
    lines = ["solid cube"]
    for t in cube():
        lines += ["facet normal 0 0 0", "outer loop", *("vertex %g %g %g" % p for p in t), "endloop", "endfacet"]
    return ("\n".join(lines + ["endsolid cube"]) + "\n").encode()


def stl_binary():
    t = cube()
    return b"\0" * 80 + struct.pack("<I", len(t)) + b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(c), 0) for c in t)


def obj():
    points = sorted({p for t in cube() for p in t})
    lines = ["v %g %g %g" % p for p in points]
    lines += ["f " + " ".join(str(points.index(p) + 1) for p in t) for t in cube()]
    return ("\n".join(lines) + "\n").encode()


def msh(version, binary):
    """A bar of 3 x 2 x 2 bricks in two volumes, a surface and a node group, as gmsh orders them."""
    size, numbers = (4, 3, 3), {}
    for k in range(size[2]):
        for j in range(size[1]):
            for i in range(size[0]):
                numbers[i, j, k] = len(numbers) + 1
    bricks = [[numbers[i + a, j + b, k + c] for a, b, c in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1),
                                                           (1, 1, 1), (0, 1, 1))]
              for i in range(3) for j in range(2) for k in range(2)]
    faces = [[numbers[0, j, k], numbers[0, j, k + 1], numbers[0, j + 1, k + 1], numbers[0, j + 1, k]]
             for j in range(2) for k in range(2)]
    head = b"$MeshFormat\n%s %d 8\n" % (version.encode(), binary)
    head += (struct.pack("<i", 1) + b"\n" if binary else b"") + b"$EndMeshFormat\n"
    head += b'$PhysicalNames\n3\n2 1 "clamped"\n3 2 "left"\n3 3 "right"\n$EndPhysicalNames\n'
    whole = lambda *v: struct.pack("<%di" % len(v), *v) if binary else (" ".join(map(str, v)) + "\n").encode()
    count = lambda *v: struct.pack("<%dQ" % len(v), *v) if binary else (" ".join(map(str, v)) + "\n").encode()
    real = lambda *v: struct.pack("<%dd" % len(v), *v) if binary else (" ".join("%.16g" % x for x in v) + "\n").encode()
    end = b"\n" if binary else b""
    if version == "2.2":
        out = head + b"$Nodes\n%d\n" % len(numbers)
        out += b"".join(whole(n).strip(b"\n" if not binary else b"") + (b"" if binary else b" ") + real(*p) for p, n in numbers.items())
        out += end + b"$EndNodes\n$Elements\n%d\n" % (len(bricks) + len(faces))
        for number, (kind, group, entity, nodes) in enumerate([(3, 1, 7, f) for f in faces]
                                                              + [(5, 2 + i // 8, 1 + i // 8, b) for i, b in enumerate(bricks)], 1):
            out += whole(kind, 1, 2, number, group, entity, *nodes) if binary else whole(number, kind, 2, group, entity, *nodes)
        return out + end + b"$EndElements\n"
    box = (0., 0., 0., 3., 2., 2.)
    out = head + b"$Entities\n" + count(0, 0, 1, 2)
    for tag, group in ((7, 1), (1, 2), (2, 3)):
        entity = whole(tag) + real(*box) + count(1) + whole(group) + count(0)
        out += entity if binary else entity.replace(b"\n", b" ") + b"\n"
    out += end + b"$EndEntities\n$Nodes\n" + count(1, len(numbers), 1, len(numbers)) + whole(3, 1, 0) + count(len(numbers))
    out += b"".join(count(n) for n in numbers.values()) + b"".join(real(*p) for p in numbers)
    out += end + b"$EndNodes\n$Elements\n" + count(3, len(bricks) + len(faces), 1, len(bricks) + len(faces))
    tag = 0
    for dimension, entity, kind, block in ((2, 7, 3, faces), (3, 1, 5, bricks[:8]), (3, 2, 5, bricks[8:])):
        out += whole(dimension, entity, kind) + count(len(block))
        for nodes in block:
            tag += 1
            out += count(tag, *nodes)
    return out + end + b"$EndElements\n"


def whole_files(program, folder):
    """The undamaged file of each format."""
    quiet = {"cwd": folder, "check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.run([program, "disk", "--diameter", "100", "--thickness", "12", "--h", "30", "--modes", "4", "--export-inp",
                    "disk.inp", "-o", "disk.modal.npz"], **quiet)
    files = {"stl": stl_text(), "stlb": stl_binary(), "obj": obj(), "inp": open(f"{folder}/disk.inp", "rb").read(),
             "npz": open(f"{folder}/disk.modal.npz", "rb").read()}
    part, material, rest = files["inp"].partition(b"*MATERIAL")
    section, step = rest.split(b"*SOLID SECTION")[1].split(b"*STEP")
    files["parts"] = (b"*PART,NAME=P\n" + part + b"*SOLID SECTION" + section + b"*END PART\n*ASSEMBLY,NAME=A\n"
                      b"*INSTANCE,NAME=I,PART=P\n0,0,0.1\n*END INSTANCE\n*INSTANCE,NAME=J,PART=P\n0,0,0\n"
                      b"1,0,0,1,1,0,90\n*END INSTANCE\n*NSET,NSET=B,INSTANCE=I\nNALL\n*END ASSEMBLY\n" + material +
                      rest.split(b"*SOLID SECTION")[0] + b"*STEP" + step)
    for version in ("2.2", "4.1"):
        for binary in (0, 1):
            files["msh" + version[0] + "b" * binary] = msh(version, binary)
    if os.path.isfile(STEP):
        files["step"] = gzip.open(STEP).read()
    if os.path.isfile(BREP):
        files["brep"] = open(BREP, "rb").read()
    return files


def damaged(data, binary, chance):
    """One mutant."""
    kind = chance.choice(["flip", "flip", "cut", "number", "number", "number", "delete", "double", "swap"])
    if kind == "flip":
        out = bytearray(data)
        for _ in range(chance.choice([1, 1, 2, 8, 40])):
            out[chance.randrange(len(out))] ^= 1 << chance.randrange(8)
        return bytes(out)
    if kind == "cut":
        return data[:chance.randrange(len(data))]
    if binary:
        size = chance.choice([1, 2, 4, 8, 16, 50])
        at = chance.randrange(max(1, len(data) - size))
        if kind == "number":
            value = chance.choice([b"\xff", b"\x00", b"\x7f", b"\x80", b"\x01"])
            return data[:at] + (value * size)[:size] + data[at + size:]
        if kind == "delete":
            return data[:at] + data[at + size:]
        if kind == "double":
            return data[:at] + data[at:at + size] + data[at:]
        other = chance.randrange(max(1, len(data) - size))
        return data[:at] + data[other:other + size] + data[at + size:]
    if kind == "number":
        numbers = list(re.finditer(rb"(?<![A-Za-z0-9_.])-?\d+\.?\d*(?:[eE][+-]?\d+)?", data))
        for _ in range(chance.choice([1, 1, 3])):
            spot = chance.choice(numbers)
            if len(data) >= spot.end():
                data = data[:spot.start()] + chance.choice(HUGE_NUMBERS).encode() + data[spot.end():]
        return data
    lines = data.splitlines(keepends=True)
    at = chance.randrange(len(lines))
    if kind == "delete":
        del lines[at:at + chance.choice([1, 1, 5])]
    elif kind == "double":
        lines[at:at] = lines[at:at + 1] * chance.choice([1, 1, 100])
    else:
        other = chance.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    return b"".join(lines)


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def outcome(words, folder, bounded, longest):
    """What becomes of one run within `longest` seconds, and what it said last; `folder` is its own."""
    with open(f"{folder}/said", "wb") as said:
        child = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=said,
                                 preexec_fn=limits if bounded else None, start_new_session=True)
    began, status = time.monotonic(), 0
    while (done := os.wait4(child.pid, os.WNOHANG))[0] == 0:
        if time.monotonic() - began > longest:
            os.killpg(child.pid, signal.SIGKILL)
            os.wait4(child.pid, 0)
            return "time", ""
        time.sleep(0.01)
    _, status, usage = done
    lines = open(f"{folder}/said", errors="replace").read().strip().splitlines()
    last = lines[-1] if lines else ""
    if os.WIFSIGNALED(status):
        return "crash", f"signal {os.WTERMSIG(status)}"
    if bounded and usage.ru_maxrss * 1024 > BYTES:
        return "memory", last
    if os.WEXITSTATUS(status) == 0:
        return "read", last
    if os.WEXITSTATUS(status) != 1 or not last.startswith("modal_fem: ") or "Sanitizer" in " ".join(lines):
        return "crash", last
    if re.search("reader crashed|ended without an answer|sent an invalid answer|the system stopped", last):
        return "contained crash", last
    if "meshing need more than" in last or "out of memory" in last:
        return "contained memory", last
    return ("contained time" if "no progress in" in last else "refused"), last


COLUMNS = ["read", "refused", "contained crash", "contained memory", "contained time", "crash", "time", "memory"]
FAULTS = COLUMNS[5:]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program")
    options.add_argument("--mutants", type=int, default=100)
    options.add_argument("--formats", default=",".join(FORMATS))
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--h", help="element size, mm: large ones are fast")
    options.add_argument("--keep", help="a folder for the files of faults")
    options.add_argument("--sanitized", action="store_true", help="no limit of address space: the sanitizer's shadow")
    options.add_argument("--jobs", type=int, default=2)
    options.add_argument("--verbose", action="store_true")
    chosen = options.parse_args()
    program = os.path.abspath(chosen.program)
    faults = 0
    print("| format | mutants | " + " | ".join(COLUMNS) + " | longest, s |\n" + "|---" * (len(COLUMNS) + 3) + "|")
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(chosen.jobs) as pool:
        files = whole_files(program, folder)
        for form in chosen.formats.split(","):
            if form not in files:
                print(f"{form}: left out, its file is not installed", file=sys.stderr)
                continue
            ending = ENDINGS.get(form, form)
            chance = random.Random(f"{form} {chosen.seed}")
            text = form not in ("msh2b", "msh4b", "stlb", "npz")
            mutants = [files[form]] + [damaged(files[form], not text, chance) for _ in range(chosen.mutants)]

            def attempt(number):
                own = f"{folder}/{form}{number}"
                os.mkdir(own)
                name = f"mutant.{ending}"
                with open(f"{own}/{name}", "wb") as file:
                    file.write(mutants[number])
                # The limit is of wall time: an undamaged file must be read on a busy machine too, and sanitizers are slow.
                limit = 300 if number == 0 else 60 if chosen.sanitized else 10
                words = [program, name, "--multi", "--quiet", "--export-inp", "out.inp", "--time-limit", str(limit)]
                words += ["--h", chosen.h] if chosen.h else []
                if form == "npz":
                    words = [program, "raw", name, "--hit", "0,0,6", "--seconds", "0.002", "-o", "out.modal.npz"]
                began = time.monotonic()
                result, said = outcome(words, own, not chosen.sanitized, limit + GRACE)
                if result in FAULTS and chosen.keep:
                    os.makedirs(chosen.keep, exist_ok=True)
                    shutil.copy(f"{own}/{name}", f"{chosen.keep}/{form}_{number}.{ending}")
                shutil.rmtree(own)
                if chosen.verbose:
                    print(form, number, result, said, file=sys.stderr)
                return result, time.monotonic() - began

            results = list(pool.map(attempt, range(len(mutants))))
            if results[0][0] != "read":
                print(f"{form}: the undamaged file was not read ({results[0][0]})", file=sys.stderr)
                faults += 1
            counts = collections.Counter(result for result, _ in results[1:])
            faults += sum(counts[column] for column in FAULTS)
            print(f"| {form} | {chosen.mutants} | " + " | ".join(str(counts[c]) for c in COLUMNS)
                  + f" | {max(seconds for _, seconds in results):.1f} |", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
