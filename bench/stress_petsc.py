#!/usr/bin/python3
"""part_stress by its own factor beside PETSc on 1, 2 ... processes of mpirun, in one run: memory, CPU time, difference.

    bench/stress_petsc.py BUILD [--ranks 1,2] [--quick] [-o docs/results/stress_petsc.csv]

Needs a build with Debian's libpetsc-real-dev, and openmpi-bin. The beam of docs/results/reanalysis.md in hex20, loaded at
its end, one static solution. Memory of PETSc is that of the largest process; part_stress itself keeps the mesh and
K meanwhile, in the column before. CPU seconds are of all processes together.
"""
import argparse
import csv
import os
import re
import subprocess
import tempfile
from pathlib import Path

BAR = ["bar", "--length", "200", "--width", "20", "--thickness", "20", "--fix", "x=-100", "--force", "x=100:0,0,-100"]
BYTES = {"MB": 1, "GB": 1000}


def solved(program, words, folder):
    """What it says on stdout and stderr, its own peak in MB, CPU seconds of it and its children."""
    with open(folder / "out", "w+") as out, open(folder / "said", "w+") as said:
        child = subprocess.Popen([program, *words], cwd=folder, stdout=out, stderr=said)
        _, status, usage = os.wait4(child.pid, 0)
        texts = []
        for file in (out, said):
            file.seek(0)
            texts.append(file.read())
    if status:
        raise SystemExit(texts[1])
    return *texts, usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime


def deflection(text):
    return float(re.search(r"largest displacement ([\d.e-]+) mm", text)[1])


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("build", type=Path)
    options.add_argument("--ranks", default="1,2")
    options.add_argument("--quick", action="store_true", help="the smallest mesh only")
    options.add_argument("-o", "--output", type=Path)
    chosen = options.parse_args()
    program = chosen.build.resolve() / "programs/part_stress/part_stress"
    rows = [["unknowns", "factor, MB", "factor, CPU s", "processes", "part_stress, MB", "largest process, MB",
             "all, CPU s", "iterations", "difference of the largest displacement"]]
    for size in ("4.5", "2.8", "2")[:1 if chosen.quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            words = [*BAR, "--h", size]
            text, _, own, seconds = solved(program, words, folder)
            unknowns = int(re.search(r"(\d+) unknowns", text)[1])
            for ranks in chosen.ranks.split(","):
                found, said, here, all_seconds = solved(program, [*words, "--engine", "petsc", "--ranks", ranks], folder)
                peaks = [float(n) * BYTES[unit] for n, unit in re.findall(r"([\d.]+) (MB|GB) and", said)]
                iterations = re.search(r"PETSc: (\d+) iterations", said)[1]
                rows.append([unknowns, round(own), round(seconds, 1), ranks, round(here), round(max(peaks)),
                             round(all_seconds, 1), iterations, f"{abs(deflection(found) / deflection(text) - 1):.0e}"])
                print("; ".join(f"{k} {v}" for k, v in zip(rows[0], rows[-1])), flush=True)
    if chosen.output:
        with open(chosen.output, "w", newline="") as file:
            csv.writer(file).writerows(rows)


main()
