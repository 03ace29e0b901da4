#!/usr/bin/python3
"""modal_fem beside CalculiX on the same mesh: equal frequencies, less time.

    bench/fem_calculix.py BUILD [--quick] [-o docs/results/fem_calculix.csv]

Needs Debian's calculix-ccx and gmsh. Every mesh is written once; modal_fem reads it and writes it on
as CalculiX' input, so both see the same nodes. Times are user seconds of the whole process, mesh
reading included, one thread each, one after the other in the same run.

CalculiX integrates tet10's mass with the four points of its stiffness, modal_fem with fifteen, which
are exact on straight sides. To show that nothing else differs, the coarse disk is solved a third time,
by scipy, with modal_fem's stiffness and a mass of four points.
"""
import argparse
import os
import re
import struct
import subprocess
import tempfile
from pathlib import Path

import numpy
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import eigsh

GEO = """SetFactory("OpenCASCADE");
Cylinder(1) = {{0,0,{low}, 0,0,{t}, {r}}};
Physical Volume("body") = {{1}};
Mesh.CharacteristicLengthMax = {h}; Mesh.CharacteristicLengthMin = {h};
Mesh.ElementOrder = 2; Mesh.MshFileVersion = 4.1; Mesh.RandomSeed = 1;
"""
ONE = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", CCX_NPROC_EQUATION_SOLVER="1",
           NUMBER_OF_CPUS="1")


def timed(command, folder):
    """User seconds and peak MB of a command."""
    done = subprocess.run(["/usr/bin/env", "time", "-f", "%U %M", *map(str, command)], cwd=folder, env=ONE,
                          capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{command[0]} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    user, peak = done.stderr.strip().splitlines()[-1].split()
    return float(user), float(peak) / 1024, done.stdout


def calculix_frequencies(dat):
    """Cycles per second of the first table of a .dat file."""
    rows = []
    for line in dat.read_text().splitlines():
        words = line.split()
        if len(words) == 5 and words[0].isdigit():
            rows.append(float(words[3]))
        elif rows and line.strip().startswith("P A R T"):
            break
    return rows


def exported_stiffness(path):
    """The first matrix of a file in PETSc's binary form."""
    raw = path.read_bytes()
    _, rows, columns, entries = struct.unpack_from(">4i", raw)
    counts = numpy.frombuffer(raw, ">i4", rows, 16)
    index = numpy.frombuffer(raw, ">i4", entries, 16 + 4 * rows).astype(int)
    values = numpy.frombuffer(raw, ">f8", entries, 16 + 4 * (rows + entries)).astype(float)
    row = numpy.repeat(numpy.arange(rows), counts)
    return csc_matrix((values, (row, index)), (rows, columns))


def four_point_mass(inp, density):
    """Mass of the tet10 in a CalculiX file, integrated with four points of degree two."""
    nodes, elements, into = [], [], None
    for line in inp.read_text().splitlines():
        if line.startswith("*"):
            into = {"*NODE": nodes, "*ELEMENT": elements}.get(line.split(",")[0])
        elif into is not None:
            into.append([float(word) for word in line.split(",")][1:])
    position, element = numpy.array(nodes), numpy.array(elements, int) - 1
    edges = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
    slope = numpy.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    small = (5 - 5 ** 0.5) / 20
    mass = numpy.zeros((len(element), 10, 10))
    for corner in range(4):
        part = numpy.full(4, small)
        part[corner] = 1 - 3 * small
        value = numpy.array([*part * (2 * part - 1), *(4 * part[a] * part[b] for a, b in edges)])
        change = numpy.array([*((4 * part - 1)[:, None] * slope),
                              *(4 * (part[a] * slope[b] + part[b] * slope[a]) for a, b in edges)])
        volume = numpy.linalg.det(numpy.einsum("ak,eai->eki", change, position[element])) / 24
        mass += density * volume[:, None, None] * numpy.outer(value, value)
    rows, columns = numpy.repeat(element, 10, axis=1).ravel(), numpy.tile(element, (1, 10)).ravel()
    scalar = coo_matrix((mass.ravel(), (rows, columns))).tocoo()
    axis = numpy.arange(3)[:, None]
    return csc_matrix((numpy.tile(scalar.data, 3), ((3 * scalar.row + axis).ravel(), (3 * scalar.col + axis).ravel())))


def with_calculix_mass(folder, build, make, modes):
    """Largest difference to CalculiX once the mass has four points: rounding of its printed digits."""
    make(folder)
    subprocess.run([build / "programs/modal_fem/modal_fem", *make.words, "--modes", str(modes), "--quiet",
                    "--export-inp", "case.inp", "--export-petsc", "km.bin"], cwd=folder, check=True)
    timed(["ccx", "case"], folder)
    theirs = numpy.array([f for f in calculix_frequencies(folder / "case.dat") if f > 1][:modes])
    below = -(numpy.pi * theirs[0]) ** 2  # half the first frequency, on the side where nothing is singular
    found = eigsh(exported_stiffness(folder / "km.bin"), modes + 8, four_point_mass(folder / "case.inp", 2700),
                  sigma=below, return_eigenvectors=False)
    ours = numpy.sort(numpy.sqrt(numpy.abs(found)))[-modes - 2:] / (2 * numpy.pi)
    worst = numpy.abs(ours[:modes] / theirs - 1).max()
    print(f"tet10 with four mass points too: max difference {worst:.1e}", flush=True)
    return worst


def compare(label, folder, build, make, modes):
    program = build / "programs/modal_fem/modal_fem"
    make(folder)
    subprocess.run([program, *make.words, "--modes", str(modes), "--export-inp", "case.inp", "--quiet"],
                   cwd=folder, check=True, stdout=subprocess.DEVNULL)
    ours_s, ours_mb, _ = timed([program, *make.words, "--modes", modes, "--csv", "ours.csv"], folder)
    theirs_s, theirs_mb, _ = timed(["ccx", "case"], folder)
    ours = [float(row.split(",")[1]) for row in (folder / "ours.csv").read_text().splitlines()[1:]]
    theirs = [f for f in calculix_frequencies(folder / "case.dat") if f > 1][: len(ours)]
    differences = [abs(a / b - 1) for a, b in zip(ours, theirs)]
    worst, first = max(differences), max(differences[:20])
    nodes = len(re.findall(r"^\d+,[-\d.e+]+,[-\d.e+]+,[-\d.e+]+$", (folder / "case.inp").read_text(), re.M))
    row = dict(mesh=label, dofs=3 * nodes, modes=len(ours), max_difference=worst, max_difference_first_20=first, modal_fem_user_s=ours_s,
               calculix_user_s=theirs_s, ratio=theirs_s / ours_s, modal_fem_mb=ours_mb, calculix_mb=theirs_mb)
    print(f"{label:24} {row['dofs']:7d} dofs  {len(ours):3d} modes  max difference {worst:.1e} (first 20: {first:.1e})   "
          f"{ours_s:6.2f} s against {theirs_s:7.2f} s: {row['ratio']:.1f} times   {ours_mb:.0f} / {theirs_mb:.0f} MB",
          flush=True)
    return row


def tetrahedra(h):
    def make(folder):
        (folder / "disk.geo").write_text(GEO.format(r=0.05, t=0.012, low=-0.006, h=h))
        subprocess.run(["gmsh", "-3", "disk.geo", "-o", "disk.msh"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    make.words = ["disk.msh"]
    return make


def hexahedra(h):
    def make(_):
        pass
    make.words = ["plate", "--length", "120", "--width", "80", "--thickness", "10", "--h", str(h)]
    return make


def swept(h):
    def make(_):
        pass
    make.words = ["disk", "--diameter", "100", "--thickness", "12", "--h", str(h)]
    return make


def main():
    order = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    order.add_argument("build", type=Path)
    order.add_argument("--quick", action="store_true", help="small meshes only")
    order.add_argument("-o", "--output", type=Path)
    order = order.parse_args()
    cases = [("tet10 disk h 8 mm", tetrahedra(0.008), 20), ("hex20 plate h 8 mm", hexahedra(8), 20),
             ("swept disk h 10 mm", swept(10), 20), ("tet10 disk h 4 mm", tetrahedra(0.004), 40)]
    if not order.quick:
        cases.append(("tet10 disk h 3 mm", tetrahedra(0.003), 40))
    rows = []
    for label, make, modes in cases:
        with tempfile.TemporaryDirectory() as folder:
            rows.append(compare(label, Path(folder), order.build.resolve(), make, modes))
    with tempfile.TemporaryDirectory() as folder:
        with_calculix_mass(Path(folder), order.build.resolve(), tetrahedra(0.008), 20)
    if order.output:
        with open(order.output, "w") as file:
            file.write(",".join(rows[0]) + "\n")
            for row in rows:
                file.write(",".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()) + "\n")


if __name__ == "__main__":
    main()
