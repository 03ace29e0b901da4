#!/usr/bin/env python3
"""Writes the modal table of a thin rectangular plate whose edges rest on a frame, from the closed form.

    make_plate.py plate.modal.npz

Kirchhoff's plate, simply supported on all sides (Leissa, Vibration of Plates, 1969, section 4.1):
  f_mn = pi/2 sqrt(D / (rho h)) ((m/a)^2 + (n/b)^2),   D = E h^3 / (12 (1 - nu^2)),
  phi_mn = 2 / sqrt(rho h a b) sin(m pi x / a) sin(n pi y / b)   for a modal mass of 1 kg.
Its frequencies change with its sides by d(omega^2)/da = -4 omega^2 (m/a)^2 / (a ((m/a)^2 + (n/b)^2)) and likewise for n
and b. The control point in its upper right corner moves both edges.

The plate is of aluminium, 320 x 200 x 5 mm, and stands upright in the x-y plane, centred, facing +z.
"""
import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from table_file import array, description, write  # noqa: E402

A, B, H = 0.32, 0.20, 0.005            # m
E, NU, RHO = 70.3e9, 0.33, 2700.0      # Pa, 1, kg/m^3
LOSS = 8e-4                            # loss factor in a frame; ten times that of the bare metal
HIGHEST = 16000.0                      # Hz
RANGE = 0.25                           # maximum move of the corner, relative to each side
COLUMNS, ROWS = 48, 30                 # cells of the surface mesh


def plate_modes():
    stiffness = E * H ** 3 / (12 * (1 - NU ** 2))
    factor = math.pi / 2 * math.sqrt(stiffness / (RHO * H))
    found = []
    for m in range(1, 40):
        for n in range(1, 40):
            f = factor * ((m / A) ** 2 + (n / B) ** 2)
            if f < HIGHEST:
                found.append((f, m, n))
    return sorted(found)


def surface():
    """Vertices of front and back, and the triangles of a closed box."""
    vertices = [(A * (i / COLUMNS - 0.5), B * (k / ROWS - 0.5), side * H / 2)
              for side in (1, -1) for k in range(ROWS + 1) for i in range(COLUMNS + 1)]
    half = (COLUMNS + 1) * (ROWS + 1)

    def at(i, k, back=False):
        return k * (COLUMNS + 1) + i + (half if back else 0)

    faces = []
    for k in range(ROWS):
        for i in range(COLUMNS):
            p, q, r, s = at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)
            faces += [(p, q, r), (p, r, s)]
            faces += [(half + p, half + r, half + q), (half + p, half + s, half + r)]
    rim = ([(i, 0) for i in range(COLUMNS)] + [(COLUMNS, k) for k in range(ROWS)]
           + [(i, ROWS) for i in range(COLUMNS, 0, -1)] + [(0, k) for k in range(ROWS, 0, -1)])
    for here, there in zip(rim, rim[1:] + rim[:1]):
        p, q = at(*here), at(*there)
        faces += [(p, half + p, half + q), (p, half + q, q)]
    return vertices, faces


def main(path):
    modes = plate_modes()
    vertices, faces = surface()
    size = 2 / math.sqrt(RHO * H * A * B)
    shape = []
    for _, m, n in modes:
        for x, y, _ in vertices:
            z = (size * math.sin(m * math.pi * (x / A + 0.5)) * math.sin(n * math.pi * (y / B + 0.5)))
            shape += [0.0, 0.0, z]
    mass = RHO * H * A * B
    inertia = [mass / 12 * (B * B + H * H), mass / 12 * (A * A + H * H), mass / 12 * (A * A + B * B)]
    meta = {"format": "modal-table", "version": "1.0", "generator": "make_plate.py", "units": "SI",
            "body_name": "plate", "bc": "simply supported edges", "n_nodes": len(vertices),
            "material": {"name": "aluminium", "E": E, "nu": NU, "rho": RHO},
            "air": {"rho": 1.184, "c": 346.1}, "license": "CC0-1.0"}
    count = len(modes)
    slopes = [-4 * (2 * math.pi * f) ** 2 * (number(m, n) / side) ** 2
              / (side * ((m / A) ** 2 + (n / B) ** 2))
              for side, number in ((A, lambda m, n: m), (B, lambda m, n: n)) for f, m, n in modes]
    write(path, {
        "meta": description(meta),
        "freq": array("<f8", (count,), [f for f, _, _ in modes]),
        "eta": array("<f8", (count,), [LOSS] * count),
        "mult": array("<i4", (count,), [1] * count),
        "phi": array("<f4", (count, len(vertices), 3), shape),
        "xyz": array("<f4", (len(vertices), 3), [c for p in vertices for c in p]),
        "tri": array("<i4", (len(faces), 3), [c for f in faces for c in f]),
        "control_points": array("<f8", (1, 3), [A / 2, B / 2, 0.0]),
        "parameters": array("<f8", (2, 4), [0, 0, -RANGE * A, RANGE * A, 0, 1, -RANGE * B, RANGE * B]),
        "trust": array("<f8", (), [0.1 * B]),
        "domega2_dp": array("<f8", (2, count), slopes),
        "mass": array("<f8", (), [mass]),
        "com": array("<f8", (3,), [0.0, 0.0, 0.0]),
        "inertia": array("<f8", (3, 3), [inertia[i] if i == k else 0.0
                                         for i in range(3) for k in range(3)]),
    })


if __name__ == "__main__":
    main(sys.argv[1])
