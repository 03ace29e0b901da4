"""What the tests of modal_fem and part_stress share: the programs as their users run them, and bodies in other
programs' formats."""
import json
import os
import re
import resource
import shutil
import struct
import subprocess

import numpy as np
import pytest

MODAL_FEM, PART_STRESS = (os.environ[name] for name in ("MODAL_FEM", "PART_STRESS"))
CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2),
         (1, 3, 7), (1, 7, 5)]


def run(program, *words, folder, expect=0, **extra):
    done = subprocess.run([program, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=600, **extra)
    assert done.returncode == expect, done.stdout + done.stderr
    return done


def refusal(program, *words, folder, **extra):
    """The sentence that is said last."""
    said = run(program, *words, folder=folder, expect=1, **extra).stderr.strip().splitlines()[-1]
    assert said.startswith(os.path.basename(program) + ": ")
    return said


def table(*words, folder, **extra):
    """What modal_fem writes and says. (A table that was loaded before stays: the program replaces the file.)"""
    done = run(MODAL_FEM, *words, "-o", "body.modal.npz", folder=folder, **extra)
    return np.load(folder / "body.modal.npz"), done.stdout + done.stderr


def meta(table):
    return json.loads(bytes(table["meta"]))


def errors(table):
    """The relative error estimated of each mode."""
    return np.array(meta(table)["accuracy"]["est_rel_error"])


def processor_seconds():
    """Of all programs that have ended: no business of what else the machine does."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def box(low=(0, 0, 0), size=(10, 10, 10)):
    """Twelve outward triangles."""
    corners = np.array(CORNERS) * np.array(size) + np.array(low)
    return [[corners[i] for i in face] for face in FACES]


def write_stl(path, *solids, head="solid", line="\n"):
    """Text; a solid is its triangles, or a name with them."""
    with open(path, "w", newline="") as file:
        for solid in solids:
            name, triangles = solid if isinstance(solid, tuple) else ("part", solid)
            file.write(f"{head} {name}{line}")
            for t in triangles:
                corners = "".join("vertex " + " ".join(f"{x:.17g}" for x in p) + line for p in t)
                file.write(f"facet normal 0 0 0{line}outer loop{line}{corners}endloop{line}endfacet{line}")
            file.write(f"end{head.strip()} {name}{line}")


def write_obj(path, size):
    lines = [f"v {x * size} {y * size} {z * size}\n" for x, y, z in CORNERS]
    path.write_text("".join(lines + [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES]))


def write_step(folder, geometry, rename=()):
    """body.step by gmsh's own kernel, in millimetres; products renamed in their order."""
    if not shutil.which("gmsh"):
        pytest.skip("gmsh's program is not installed")
    (folder / "body.geo").write_text(f'SetFactory("OpenCASCADE");\n{geometry}\nSave "body.step";\n')
    subprocess.run(["gmsh", "-0", "body.geo"], cwd=folder, check=True, capture_output=True)
    text = (folder / "body.step").read_text()
    for k, name in enumerate(rename, 1):
        text, count = re.subn(rf"'Open CASCADE STEP translator [0-9.]+ 1\.{k}'", f"'{name}'", text)
        assert count
    (folder / "body.step").write_text(text)
    return text


MAGIC, SOLVE, QUIT, READY, STRESS, REFUSED, MODES = 0x31525354, 1, 2, 16, 17, 18, 19


class Server:
    """`part_stress serve` or `modal_fem serve` as a child: messages to its stdin and from its stdout."""

    def __init__(self, program, folder, table, *words):
        self.process = subprocess.Popen([program, "serve", table, *words], cwd=folder, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def send(self, kind, payload=b"", magic=MAGIC, size=None):
        self.process.stdin.write(struct.pack("<IIQ", magic, kind, len(payload) if size is None else size) + payload)
        self.process.stdin.flush()

    def read(self):
        header = self.process.stdout.read(16)
        assert len(header) == 16, self.process.stderr.read()
        magic, kind, size = struct.unpack("<IIQ", header)
        assert magic == MAGIC
        payload = self.process.stdout.read(size)
        assert len(payload) == size
        return kind, payload

    def refuses(self, kind, payload=b"", **head):
        self.send(kind, payload, **head)
        answer, sentence = self.read()
        assert answer == REFUSED
        return sentence.decode()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            try:
                pipe.close()
            except BrokenPipeError:
                pass
