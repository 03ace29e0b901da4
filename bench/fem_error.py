#!/usr/bin/python3
"""How far the default meshes of modal_fem are off, what they say of it, and what they cost.

    bench/fem_error.py BUILD [--only NAME] [--repeat 3] [--no-hand] [-o docs/results/fem_error.csv]

Each body of fem_error_bodies.py is run as a user runs it. The truth is closed form (balls), the
axisymmetric solution (disks) or a much finer mesh of another layout: even intervals of a box or a
section, or gmsh's structured hexahedra; modes are matched by shape, on the skin. Pairs may be turned:
a mode belongs to the true group of equal frequencies whose shapes hold most of it. The mesh chosen by
hand is the coarsest of a row of even meshes (--h, --layers) whose true error is at most 0.2 %. Times are
user seconds of the whole process with the children it waits for, one thread, the smallest of the
repetitions, default and by hand in turn; both estimate their errors.
"""
import argparse
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from fem_error_bodies import CASES
from scipy.spatial import cKDTree

ONE_THREAD = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")


def gmsh(text, file, folder, *words):
    (folder / "body.geo").write_text(f'SetFactory("OpenCASCADE");\n{text}\n')
    subprocess.run(["gmsh", *words, "body.geo", "-o", file], cwd=folder, check=True, capture_output=True)


def write_files(case, folder):
    """The words of the order and of the truth, their files written."""
    files = {}
    if case.geometry:
        files["FILE"] = "body." + case.ending
        if case.ending == "stl":
            gmsh(case.geometry + "MeshSize{:} = 1000;", files["FILE"], folder, "-2")
        else:
            gmsh(f'{case.geometry}\nSave "{files["FILE"]}";', "unused.msh", folder, "-0")
    if case.mesh:
        files["MESH"] = "truth.msh"
        gmsh(case.mesh, files["MESH"], folder, "-3", "-order", "2", "-setnumber", "Mesh.SecondOrderIncomplete", "1",
             "-format", "msh41")
    return [[files.get(w, w) for w in words] for words in (case.words, case.truth)]


def run(program, words, folder, modes):
    """Frequencies, estimated errors, unknowns of the meshes, user seconds, positions and shapes on the skin."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([program, *map(str, words), "--modes", str(modes), "--csv", "modes.csv", "-o", "modes.modal.npz"],
                          cwd=folder, env=ONE_THREAD, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{words}: {done.stderr}")
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    rows = [row.split(",") for row in (folder / "modes.csv").read_text().splitlines()[1:]]
    unknowns = [int(line.split(" degrees")[0].split()[-1]) for line in done.stderr.splitlines() if "degrees" in line]
    with np.load(folder / "modes.modal.npz") as t:
        skin = t["xyz"].astype(float), t["phi"].astype(float)
    return np.array([float(r[1]) for r in rows]), np.array([float(r[5]) for r in rows]), unknowns, seconds, skin


def true_frequencies(found, skin, exact, exact_skin):
    """Of each mode of a body that of the true mode with the same shape. Modes of the truth within 0.1 % are a
    group; a mode is of the group that holds most of its motion at the nearest points of the skin, and the
    k-th of its kind there."""
    (xyz, phi), (true_xyz, true_phi) = skin, exact_skin
    near = cKDTree(true_xyz).query(xyz)[1]
    a, b = phi.reshape(len(phi), -1), true_phi[:, near].reshape(len(true_phi), -1)
    a = a / np.linalg.norm(a, axis=1, keepdims=True)
    ends = [*np.flatnonzero(np.diff(exact) > 1e-3 * exact[:-1]) + 1, len(exact)]
    groups = [np.arange(first, end) for first, end in zip([0, *ends], ends)]
    held = np.array([np.linalg.norm(np.linalg.qr(b[g].T)[0].T @ a.T, axis=0) for g in groups])
    own = held.argmax(axis=0)
    out = np.empty(len(found))
    for g in set(own):
        members = np.flatnonzero(own == g)
        if len(members) > len(groups[g]) and ends[g] < len(exact):
            raise SystemExit(f"modes {members + 1} resemble the true group {groups[g] + 1}")
        for k, m in enumerate(members):
            out[m] = exact[groups[g][min(k, len(groups[g]) - 1)]]
    return out


def errors_of(result, exact, exact_skin):
    found, _, _, _, skin = result
    own = exact[:len(found)] if exact_skin is None else true_frequencies(found, skin, exact, exact_skin)
    return found / own - 1


def measure(program, case, folder, repeat, with_hand):
    words, truth = write_files(case, folder)
    if isinstance(truth[0], float):
        exact, exact_skin = np.array(truth), None
    else:
        # The finest mesh, less the error that it still has by its own estimate.
        found, left, _, _, exact_skin = run(program, truth, folder, case.modes + 6)
        print(f"  truth: {100 * left[:case.modes].max():.4f} % left", flush=True)
        exact = found * (1 - left)
    result = run(program, words, folder, case.modes)
    error, estimate, unknowns, seconds = errors_of(result, exact, exact_skin), result[1], result[2], result[3]
    ratio = estimate[error > 1e-4] / error[error > 1e-4]
    row = [unknowns[-1], len(unknowns), f"{100 * error.max():.3f}", f"{100 * estimate.max():.3f}",
           f"{ratio.min():.2f}" if len(ratio) else "", f"{ratio.max():.2f}" if len(ratio) else ""]
    hand, hand_seconds = None, None
    for size in case.by_hand if with_hand else []:
        h, layers = size if isinstance(size, tuple) else (size, 0)
        tried = [*words, "--h", h, *(["--layers", layers] if layers else [])]
        other = run(program, tried, folder, case.modes)
        if errors_of(other, exact, exact_skin).max() <= 2e-3:
            hand, hand_seconds = other[2][-1], other[3]
            break
    for _ in range(repeat - 1):
        time.sleep(.1)
        seconds = min(seconds, run(program, words, folder, case.modes)[3])
        if hand:
            hand_seconds = min(hand_seconds, run(program, tried, folder, case.modes)[3])
    row += [f"{seconds:.2f}"] + ([hand, f"{hand_seconds:.2f}", f"{seconds / hand_seconds:.2f}"] if hand else ["", "", ""])
    return row


def main():
    order = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    order.add_argument("build", type=Path, help="build folder, or the program itself")
    order.add_argument("--only", nargs="*", default=[])
    order.add_argument("--repeat", type=int, default=1)
    order.add_argument("--no-hand", action="store_true")
    order.add_argument("-o", "--output", type=Path)
    order = order.parse_args()
    program = order.build.resolve()
    if program.is_dir():
        program = program / "programs/modal_fem/modal_fem"
    lines = ["case,unknowns,meshes,largest_true_percent,largest_estimated_percent,least_ratio,largest_ratio,user_s,"
             "hand_unknowns,hand_user_s,cost_ratio"]
    print(lines[0], flush=True)
    for name, case in CASES.items():
        if order.only and name not in order.only:
            continue
        with tempfile.TemporaryDirectory() as folder:
            row = measure(program, case, Path(folder), order.repeat, not order.no_hand)
        lines.append(",".join(map(str, [name.replace(",", ""), *row])))
        print(lines[-1], flush=True)
    if order.output:
        order.output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
