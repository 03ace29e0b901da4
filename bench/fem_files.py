#!/usr/bin/python3
"""How many real CAD and surface files become a body, and what modal_fem says of the others.

    bench/fem_files.py MODAL_FEM FOLDER... [--list FILE] [--seconds 120] [--gigabytes 3] [--only TEXT]
                       [--mesh-only] [--modes 3] [-o TABLE.csv] [-- options for modal_fem]

Every .step, .stp, .brep, .stl and .obj below the folders, or named in --list, is given to modal_fem for its
first modes, in a process with limits on processor time (wall clock: five times as long) and memory (--mesh-only
leaves the modes out). A file is a body if modes are found, its first frequency is positive and the table's mass
is. The table printed has one line a file: body, refused (with the sentence), time, memory or crash. docs/results/modal_fem_files.md
tells where the files of our own run came from.
"""
import argparse
import csv
import os
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy

ENDINGS = {".step", ".stp", ".brep", ".brp", ".stl", ".obj"}


def attempt(program, path, seconds, gigabytes, modes, options):
    """(outcome, sentence, seconds) of one file."""
    def limit():
        size = int(gigabytes * 2**30)
        resource.setrlimit(resource.RLIMIT_AS, (size, size))
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))

    def processor_time():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    mesh_only, start = modes == 0, processor_time()
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "body.modal.npz"
        wanted = ["--export-inp", "body.inp"] if mesh_only else ["--modes", str(modes), "-o", str(table)]
        command = [os.path.abspath(program), str(path.resolve()), *wanted, *options]
        environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
        try:
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True,
                                  errors="replace", timeout=5 * seconds, preexec_fn=limit)
        except subprocess.TimeoutExpired:
            return "time", f"not ready after {5 * seconds:g} s by the clock", processor_time() - start
        spent = processor_time() - start
        if spent > seconds:
            return "time", f"not ready after {seconds:g} s", spent
        lines = [line.split("\r")[-1].strip() for line in (done.stdout + "\n" + done.stderr).splitlines()]
        lines = [line for line in lines if line]
        if done.returncode < 0 or "terminate called" in done.stderr:
            return "crash", f"signal {-done.returncode}: " + (lines[-1] if lines else ""), spent
        if done.returncode:
            memory = "memory" in done.stderr.lower() or "alloc" in done.stderr.lower()
            return "memory" if memory else "refused", lines[-1].replace(str(path.parent.resolve()) + "/", ""), spent
        result = ""
        if not mesh_only:
            found = numpy.load(table)
            frequency, mass = found["freq"][0], float(found["mass"])
            result = f"{frequency:.4g} Hz, {mass:.3g} kg; "
            if not (frequency > 0 and mass > 0):
                return "wrong", result, spent
        said = [line for line in lines if any(word in line for word in
                ("closed", "weld", "rebuilt", "removed", "meshed", "sewn", "left out", "wrapped", "above"))]
        return "body", result + "; ".join(said), spent


def main():
    words, options = sys.argv[1:], []
    if "--" in words:
        at = words.index("--")
        words, options = words[:at], words[at + 1:]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", nargs="*")
    parser.add_argument("--list", type=Path)
    parser.add_argument("--modes", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--gigabytes", type=float, default=3)
    parser.add_argument("--only", default="")
    parser.add_argument("--mesh-only", action="store_true")
    parser.add_argument("-o", "--output")
    chosen = parser.parse_args(words)
    files = sorted(p for folder in chosen.folder for p in Path(folder).rglob("*")
                   if p.suffix.lower() in ENDINGS and chosen.only in str(p))
    if chosen.list:
        files += [Path(line) for line in chosen.list.read_text().splitlines() if chosen.only in line]
    rows, count = [], Counter()
    for path in files:
        outcome, sentence, spent = attempt(chosen.program, path, chosen.seconds, chosen.gigabytes,
                                          0 if chosen.mesh_only else chosen.modes, options)
        count[outcome] += 1
        rows.append([path.parent.name, path.name, outcome, f"{spent:.1f}", sentence])
        print(f"{outcome:8s}{spent:7.1f} s  {path.parent.name}/{path.name}: {sentence}", flush=True)
    print(", ".join(f"{number} {outcome}" for outcome, number in count.most_common()), "of", len(files))
    if chosen.output:
        with open(chosen.output, "w", newline="") as file:
            csv.writer(file).writerows([["package", "file", "outcome", "seconds", "sentence"], *rows])


if __name__ == "__main__":
    main()
