#!/usr/bin/python3
"""How far the default meshes of modal_fem are off, what they say of it, and what they cost.

    bench/fem_error.py BUILD [--only NAME] [-o docs/results/fem_error.csv]

Each case is run as a user runs it, 20 modes. The truth is the axisymmetric solution (disks) or a mesh
of another layout that is much finer: even intervals of a box or a section given with --h and --layers,
or the swept shape for a STEP file; modes are matched by shape, on the skin. The mesh chosen by hand is
the coarsest of a row of even meshes (--h, --layers) whose true error is at most 0.2 %. Times are user
seconds of the whole process, one thread, one after the other; both estimate their errors.
"""
import argparse
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

AXISYMMETRIC_12 = [5890.390] * 2 + [9992.755] + [12864.666] * 2 + [20574.586] * 2 + [21111.257] * 2 + \
    [23364.669] * 2 + [27421.217] * 2 + [30197.524] * 2 + [32156.676] * 2 + [34887.145] + [35445.5] + [35892.833] * 2
AXISYMMETRIC_HOLLOW = [7308.224, 8825.272] + [9835.904] * 2 + [11982.289] * 2 + [14620.028] * 2 + \
    [19075.348] * 2 + [19177.265] * 2 + [20271.910] * 2 + [22083.937] * 2 + [23152.617] * 2 + [25304.991, 25856.110]
BAR = ["bar", "--length", 400, "--width", 30, "--thickness", 10]
PLATE = ["plate", "--length", 300, "--width", 200, "--thickness", 6]
BOARD = ["board", "--length", 500, "--width", 200, "--thickness", 3]
WASHER = ["ring", "--outer-diameter", 60, "--inner-diameter", 20, "--thickness", 3, "--material", "steel",
          "--fix", "0,0,-1.5,10.001"]
CANTILEVER = ["bar", "--length", 200, "--width", 20, "--thickness", 10, "--fix", "x=-100", "--material", "steel"]
BOWL = ["bowl", "--diameter", 200, "--thickness", 4, "--material", "brass"]
DISK = ["disk", "--diameter", 100, "--thickness", 12]
HOLLOW = ["hollow-disk", "--diameter", 100, "--thickness", 25, "--cavity-diameter", 80, "--cavity-thickness", 13]
STEP_BAR = 'Box(1) = {-200,-15,-5, 400,30,10};'
# name: words, truth (frequencies or --h and --layers), even meshes from coarse to fine, geometry of a STEP file
CASES = {
    "bar": (BAR, (5, 4), [(20, 2), (16, 2), (12, 2), (10, 2), (8, 2), (7, 3), (6, 3)], None),
    "plate": (PLATE, (6, 2), [(20, 1), (14, 1), (14, 2), (12, 2), (10, 2), (8, 2)], None),
    "board": (BOARD, (8, 2), [(30, 1), (20, 1), (20, 2), (15, 2), (12, 2), (10, 2)], None),
    "cantilever": (CANTILEVER, (1.6, 8), [(10, 2), (7, 2), (5, 2), (4, 3), (3, 4), (2.5, 4)], None),
    "disk": (DISK, AXISYMMETRIC_12, [(20, 1), (14, 2), (10, 2), (8, 2), (7, 3)], None),
    "hollow disk": (HOLLOW, AXISYMMETRIC_HOLLOW, [], None),
    "washer": (WASHER, (.8, 5), [], None),
    "bowl": (BOWL, (4, 2), [(16, 1), (12, 1), (8, 1), (8, 2), (6, 1), (6, 2), (5, 2)], None),
    "bar from STEP": (BAR, (5, 4), [], STEP_BAR),
}


def table(program, words, folder, modes):
    """Positions and shapes of the modes on the skin."""
    subprocess.run([program, *map(str, words), "--modes", str(modes), "-o", "modes.modal.npz", "--quiet"],
                   cwd=folder, check=True, capture_output=True)
    with np.load(folder / "modes.modal.npz") as t:
        return t["xyz"].astype(float), t["phi"].astype(float)


def partners(body, truth):
    """Of each mode of a body the number of the true mode with the same shape: the one that, taken at the
    nearest points of the skin, is most nearly parallel to it."""
    (xyz, phi), (true_xyz, true_phi) = body, truth
    near = cKDTree(true_xyz).query(xyz)[1]
    a, b = phi.reshape(len(phi), -1), true_phi[:, near].reshape(len(true_phi), -1)
    a, b = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (a, b))
    return np.abs(a @ b.T).argmax(axis=1)


def run(program, words, folder, modes=20):
    """Frequencies, estimated errors, unknowns of the last mesh, user seconds."""
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    done = subprocess.run(["/usr/bin/env", "time", "-f", "%U", program, *map(str, words), "--modes", str(modes), "--csv",
                           "modes.csv"], cwd=folder, env=environment, capture_output=True, text=True, check=True)
    rows = [row.split(",") for row in (folder / "modes.csv").read_text().splitlines()[1:]]
    unknowns = [int(line.split(" degrees")[0].split()[-1]) for line in done.stderr.splitlines() if "degrees" in line]
    return [float(r[1]) for r in rows], [float(r[5]) for r in rows], unknowns, float(done.stderr.split()[-1])


def main():
    order = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    order.add_argument("build", type=Path)
    order.add_argument("--only")
    order.add_argument("-o", "--output", type=Path)
    order = order.parse_args()
    program = order.build.resolve() / "programs/modal_fem/modal_fem"
    lines = ["case,unknowns,meshes,largest_true_percent,largest_estimated_percent,least_ratio,largest_ratio,user_s,"
             "hand_unknowns,hand_user_s,cost_ratio"]
    for name, (words, truth, row, geometry) in CASES.items():
        if order.only and name != order.only:
            continue
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            exact = truth
            if isinstance(truth, tuple):
                # The finest mesh, less the error that it still has: below 0.03 %.
                fine = [*words, "--h", truth[0], "--layers", truth[1]]
                found, left, _, _ = run(program, fine, folder, 26)
                exact = [f * (1 - e) for f, e in zip(found, left)]
                shapes = table(program, fine, folder, 26)
            if geometry:
                (folder / "body.geo").write_text(f'SetFactory("OpenCASCADE");\n{geometry}\nSave "body.step";\n')
                subprocess.run(["gmsh", "-0", "body.geo"], cwd=folder, check=True, capture_output=True)
                words = ["body.step", *words[7:]]
            found, estimated, unknowns, seconds = run(program, words, folder)
            own = exact
            if isinstance(truth, tuple):
                own = [exact[k] for k in partners(table(program, words, folder, 20), shapes)]
            true = [f / t - 1 for f, t in zip(found, own)]
            ratios = [e / t for e, t in zip(estimated, true) if t > 1e-4] or [float("nan")]
            by_hand = None
            for h, layers in row:
                try_found, _, try_unknowns, try_seconds = run(program, [*words, "--h", h, "--layers", layers], folder)
                if max(f / t - 1 for f, t in zip(try_found, exact)) <= 2e-3:
                    by_hand = (try_unknowns[-1], try_seconds)
                    break
            cost = f"{by_hand[0]},{by_hand[1]:.2f},{seconds / by_hand[1]:.2f}" if by_hand else ",,"
            lines.append(f"{name},{unknowns[-1]},{len(unknowns)},{100 * max(true):.3f},{100 * max(estimated):.3f},"
                         f"{min(ratios):.2f},{max(ratios):.2f},{seconds:.2f},{cost}")
            print(lines[-1], flush=True)
    if order.output:
        order.output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
