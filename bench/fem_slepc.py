#!/usr/bin/python3
"""Memory of modal_fem's own engine beside SLEPc's on 1, 2 ... processes, and their largest difference.

    bench/fem_slepc.py BUILD [--ranks 1,2] [--quick] [-o docs/results/fem_slepc.csv]

Needs a build with Debian's libslepc-real-dev, and openmpi-bin. Peaks are those of the largest process:
the factor is spread over the ranks; modal_fem itself keeps the mesh, K and M meanwhile.
"""
import argparse
import csv
import os
import re
import subprocess
import tempfile
from pathlib import Path

BODIES = {
    "disk h 5 mm": ["disk", "--diameter", "100", "--thickness", "12", "--h", "5"],
    "plate h 7 mm": ["plate", "--length", "300", "--width", "200", "--thickness", "5", "--h", "7"],
    "ball h 8 mm": ["sphere", "--diameter", "100", "--h", "8"],
}
BYTES = {"MB": 1, "GB": 1000}


def solved(program, words, folder):
    """MB of the program, MB of SLEPc's largest process (or 0), unknowns, frequencies."""
    with open(folder / "said", "w+") as said:
        child = subprocess.Popen([program, *words, "--modes", "20", "--csv", "modes.csv"], cwd=folder,
                                 stdout=subprocess.DEVNULL, stderr=said)
        _, status, usage = os.wait4(child.pid, 0)
        said.seek(0)
        text = said.read()
    if status:
        raise SystemExit(text)
    rank = re.search(r"processes, at most ([\d.]+) (MB|GB) each", text)
    with open(folder / "modes.csv") as file:
        frequencies = [float(row["frequency_hz"]) for row in csv.DictReader(file)]
    return usage.ru_maxrss / 1024, float(rank[1]) * BYTES[rank[2]] if rank else 0, int(re.search(r"(\d+) degrees", text)[1]), frequencies




def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("build", type=Path)
    options.add_argument("--ranks", default="1,2")
    options.add_argument("--quick", action="store_true", help="the first body only")
    options.add_argument("-o", "--output", type=Path)
    chosen = options.parse_args()
    program = chosen.build.resolve() / "programs/modal_fem/modal_fem"
    rows = [["body", "unknowns", "own engine, MB", "ranks", "SLEPc's largest rank, MB", "largest difference"]]
    for name, words in list(BODIES.items())[:1 if chosen.quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            own, _, unknowns, truth = solved(program, words, folder)
            for ranks in chosen.ranks.split(","):
                _, rank, _, found = solved(program, [*words, "--engine", "slepc", "--ranks", ranks], folder)
                worst = max(abs(a / b - 1) for a, b in zip(found, truth))
                rows.append([name, unknowns, round(own), ranks, round(rank), f"{worst:.1e}"])
                print("; ".join(f"{k} {v}" for k, v in zip(rows[0], rows[-1])), flush=True)
    if chosen.output:
        with open(chosen.output, "w", newline="") as file:
            csv.writer(file).writerows(rows)


main()
