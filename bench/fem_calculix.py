#!/usr/bin/python3
"""modal_fem beside CalculiX on the same mesh: equal frequencies, less time.

    bench/fem_calculix.py BUILD [--quick] [-o docs/results/fem_calculix.csv]

Needs Debian's calculix-ccx and gmsh. Every mesh is written once; modal_fem reads it and writes it on
as CalculiX' input, so both see the same nodes. Times are user seconds of the whole process, mesh
reading included, one thread each, one after the other in the same run.
"""
import argparse
import os
import re
import subprocess
import tempfile
from pathlib import Path

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


def compare(label, folder, build, make, modes):
    program = build / "programs/modal_fem/modal_fem"
    make(folder)
    subprocess.run([program, *make.words, "--modes", str(modes + 6), "--export-inp", "case.inp", "--quiet"],
                   cwd=folder, check=True, stdout=subprocess.DEVNULL)
    ours_s, ours_mb, _ = timed([program, *make.words, "--modes", modes, "--csv", "ours.csv"], folder)
    theirs_s, theirs_mb, _ = timed(["ccx", "case"], folder)
    ours = [float(row.split(",")[1]) for row in (folder / "ours.csv").read_text().splitlines()[1:]]
    theirs = [f for f in calculix_frequencies(folder / "case.dat") if f > 1][: len(ours)]
    worst = max(abs(a / b - 1) for a, b in zip(ours, theirs))
    nodes = len(re.findall(r"^\d+,[-\d.e+]+,[-\d.e+]+,[-\d.e+]+$", (folder / "case.inp").read_text(), re.M))
    row = dict(mesh=label, dofs=3 * nodes, modes=len(ours), max_difference=worst, modal_fem_user_s=ours_s,
               calculix_user_s=theirs_s, ratio=theirs_s / ours_s, modal_fem_mb=ours_mb, calculix_mb=theirs_mb)
    print(f"{label:24} {row['dofs']:7d} dofs  {len(ours):3d} modes  max difference {worst:.1e}   "
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
    if order.output:
        with open(order.output, "w") as file:
            file.write(",".join(rows[0]) + "\n")
            for row in rows:
                file.write(",".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()) + "\n")


if __name__ == "__main__":
    main()
