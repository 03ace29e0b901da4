#!/usr/bin/env python3
"""Writes the stress table of a cantilever whose upper edge is reshaped, from beam theory.

    make_beam.py beam.stress.npz

        p0        p1        p2          three control points on the upper edge move up and down
       ==o=========o=========o
      /|                     | | F      length L, width b, height h(x) = h0 + sum N_c(x) d_c with
      /|                     | v        N_c Bernstein's polynomials of degree 2, force F at the tip
      /=======================

Bending and shear of a slender beam (Timoshenko & Gere, Mechanics of Materials, sections 5.5 and 5.8),
eta = -1..1 across the height:
  sigma = 6 F (L - x) eta / (b h^2),   tau = 3 F (1 - eta^2) / (2 b h)
  von Mises sqrt(sigma^2 + 3 tau^2),   maximum shear sqrt(sigma^2 / 4 + tau^2)
and their derivatives with respect to h times N_c, at the middles of the elements. The beam is of steel, 80 x 20 x 10
mm, in the x-y plane, centred, under 1 kN.
"""
import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import table_file  # noqa: E402

L, H, B = 0.08, 0.02, 0.01    # m
FORCE = 1000.0                # N
COLUMNS, ROWS = 40, 8         # elements along and across
LOW, HIGH = -0.008, 0.012     # m, bounds of a control point's displacement
TRUST = 0.1 * H               # a tenth of the height, within which Taylor's error of the mean stays below 1 %


def bernstein(t):
    return [(1 - t) ** 2, 2 * t * (1 - t), t ** 2]


def stresses(x, eta, h):
    """von Mises and maximum shear stress, and their derivatives with respect to h."""
    sigma = 6 * FORCE * (L - x) * eta / (B * h ** 2)
    tau = 3 * FORCE * (1 - eta ** 2) / (2 * B * h)
    dsigma, dtau = -2 * sigma / h, -tau / h
    mises = math.sqrt(sigma ** 2 + 3 * tau ** 2)
    shear = math.sqrt(sigma ** 2 / 4 + tau ** 2)
    return (mises, shear, (sigma * dsigma + 3 * tau * dtau) / mises,
            (sigma * dsigma / 4 + tau * dtau) / shear)


def main(path):
    middles = [(L * (i + 0.5) / COLUMNS, 2 * (k + 0.5) / ROWS - 1)
               for k in range(ROWS) for i in range(COLUMNS)]
    rows = [stresses(x, eta, H) for x, eta in middles]
    shares = [bernstein(x / L) for x, _ in middles]
    count = len(rows)
    nodes = [(L * (i / COLUMNS - 0.5), H * (k / ROWS - 0.5), B / 2)
             for k in range(ROWS + 1) for i in range(COLUMNS + 1)]
    element = [min(k, ROWS - 1) * COLUMNS + min(i, COLUMNS - 1)
               for k in range(ROWS + 1) for i in range(COLUMNS + 1)]
    triangles = []
    for k in range(ROWS):
        for i in range(COLUMNS):
            p = k * (COLUMNS + 1) + i
            q = p + COLUMNS + 1
            triangles += [p, p + 1, q + 1, p, q + 1, q]
    table_file.write(path, {
        "meta": table_file.description({
            "format": "stress-table", "version": "1.0", "generator": "make_beam.py",
            "name": "beam", "units": {"stress": "Pa", "length": "m"}, "material": "steel",
            "loads": "1 kN down at the tip, clamped at the left", "license": "CC0-1.0"}),
        "s0": table_file.array("<f8", (count,), [r[0] for r in rows]),
        "shear0": table_file.array("<f8", (count,), [r[1] for r in rows]),
        "S": table_file.array("<f8", (3, count),
                              [r[2] * s[c] for c in range(3) for r, s in zip(rows, shares)]),
        "S_shear": table_file.array("<f8", (3, count),
                                    [r[3] * s[c] for c in range(3) for r, s in zip(rows, shares)]),
        "weights": table_file.array("<f8", (count,), [L * H * B / count] * count),
        "parameters": table_file.array("<f8", (3, 4),
                                       [v for c in range(3) for v in (c, 1, LOW, HIGH)]),
        "control_points": table_file.array("<f8", (3, 3),
                                           [v for c in range(3) for v in (L * (c / 2 - 0.5), H / 2, 0)]),
        "trust": table_file.array("<f8", (), [TRUST]),
        "surface_nodes": table_file.array("<f4", (len(nodes), 3), [c for n in nodes for c in n]),
        "surface_triangles": table_file.array("<i4", (len(triangles) // 3, 3), triangles),
        "surface_weights": table_file.array("<f4", (len(nodes), 3),
                                            [(y / H + 0.5) * share for x, y, _ in nodes
                                             for share in bernstein(x / L + 0.5)]),
        "surface_node_element": table_file.array("<i4", (len(nodes),), element),
    })


if __name__ == "__main__":
    main(sys.argv[1])
