"""The bodies of fem_error.py: what a user orders, where the truth comes from, and meshes by hand."""
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq
from scipy.special import spherical_jn

# Free aluminium disks, diameter 100 mm: Fourier in the angle, spectral quadrilaterals in (r, z), 1e-5.
DISK_12 = [5890.390] * 2 + [9992.755] + [12864.666] * 2 + [20574.586] * 2 + [21111.257] * 2 + \
    [23364.669] * 2 + [27421.217] * 2 + [30197.524] * 2 + [32156.676] * 2 + [34887.145, 35445.5] + [35892.833] * 2
DISK_HOLLOW = [7308.224, 8825.272] + [9835.904] * 2 + [11982.289] * 2 + [14620.028] * 2 + \
    [19075.348] * 2 + [19177.265] * 2 + [20271.910] * 2 + [22083.937] * 2 + [23152.617] * 2 + [25304.991, 25856.110]


def free_ball(diameter_m, count, young=70.3e9, poisson=.33, density=2700):
    """Frequencies of a free elastic ball (Lamb 1882; Eringen & Suhubi 1975, section 8.14), ascending,
    each 2 l + 1 times. x = omega a / c_T, y = omega a / c_L."""
    shear = np.sqrt(young / (2 * (1 + poisson)) / density)
    ratio = np.sqrt((1 - 2 * poisson) / (2 - 2 * poisson))

    def torsional(l, x):
        return (l - 1) * spherical_jn(l, x) - x * spherical_jn(l + 1, x)

    def spheroidal(l, x):
        y = ratio * x
        radial = (l * l - l - x * x / 2) * spherical_jn(l, y) + 2 * y * spherical_jn(l + 1, y)
        if l == 0:
            return radial
        across = (l * l - 1 - x * x / 2) * spherical_jn(l, x) + x * spherical_jn(l + 1, x)
        return radial * across - l * (l + 1) * torsional(l, x) * torsional(l, y)

    at = np.linspace(.3, 14, 2000)
    found = []
    for law, lowest in ((torsional, 1), (spheroidal, 0)):
        for l in range(lowest, 12):
            values = np.array([law(l, x) / x ** (2 * l) for x in at])
            for i in np.flatnonzero(values[:-1] * values[1:] < 0):
                found += [brentq(lambda x: law(l, x), at[i], at[i + 1]) * shear / (np.pi * diameter_m)] * (2 * l + 1)
    return sorted(found)[:count]


@dataclass
class Case:
    words: list                                   # the order; "FILE" stands for the body's file
    truth: list                                   # frequencies, or the words of a much finer mesh; "MESH" is `mesh`
    by_hand: list = field(default_factory=list)   # (h, layers) or h, from coarse to fine
    geometry: str = ""                            # a body for Open CASCADE, written as STEP or STL
    ending: str = "step"
    mesh: str = ""                                # a structured mesh by gmsh
    modes: int = 20


BAR = ["bar", "--length", 400, "--width", 30, "--thickness", 10]
PLATE = ["plate", "--length", 300, "--width", 200, "--thickness", 6]
THIN = ["plate", "--length", 300, "--width", 200, "--thickness", 1]
BOARD = ["board", "--length", 500, "--width", 200, "--thickness", 3]
WASHER = ["ring", "--outer-diameter", 60, "--inner-diameter", 20, "--thickness", 3, "--material", "steel",
          "--fix", "0,0,0,10.1121"]
CANTILEVER = ["bar", "--length", 200, "--width", 20, "--thickness", 10, "--fix", "x=-100", "--material", "steel"]
BOWL = ["bowl", "--diameter", 200, "--thickness", 4, "--material", "brass"]
CYLINDER = ["bar", "--length", 120, "--diameter", 40]
HOLLOW = ["hollow-disk", "--diameter", 100, "--thickness", 25, "--cavity-diameter", 80, "--cavity-thickness", 13]


def fine(words, h, layers):
    return [*words, "--h", h, "--layers", layers]


L_BODY = "Box(1) = {0,0,0, 60,20,10}; Box(2) = {0,0,10, 10,20,30}; BooleanUnion(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};"


def l_mesh():
    """An L of 60 x 40 x 20 mm, walls 10 mm, in five structured blocks, graded by 1.5 a step into the inner edge."""
    xs, zs, blocks = [0, 10, 20, 60], [0, 10, 20, 40], [(0, 0), (1, 0), (2, 0), (0, 1), (0, 2)]
    cuts = {0: "15 Using Progression 1/1.5", 1: "15 Using Progression 1.5"}
    text, lines = "", {}
    corners = sorted({(i + a, j + b) for i, j in blocks for a in (0, 1) for b in (0, 1)})
    for n, (i, j) in enumerate(corners):
        text += f"Point({n + 1}) = {{{xs[i]}, 0, {zs[j]}}};\n"
    for i, j in blocks:
        across, up = cuts.get(i, "13"), cuts.get(j, "7")
        for ends, cut in ((((i, j), (i + 1, j)), across), (((i, j + 1), (i + 1, j + 1)), across),
                          (((i, j), (i, j + 1)), up), (((i + 1, j), (i + 1, j + 1)), up)):
            if ends not in lines:
                number = lines[ends] = len(lines) + 1
                first, last = (corners.index(end) + 1 for end in ends)
                text += f"Line({number}) = {{{first}, {last}}}; Transfinite Curve{{{number}}} = {cut};\n"
    for n, (i, j) in enumerate(blocks, 1):
        a, b, c, d = (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
        text += f"Curve Loop({n}) = {{{lines[a, b]},{lines[b, c]},{-lines[d, c]},{-lines[a, d]}}}; Plane Surface({n}) = {{{n}}};\n"
    return text + """Transfinite Surface{:}; Recombine Surface{:};
Extrude {0,20,0} { Surface{1:5}; Layers{{1,1,1,1,1,1},{.04,.2,.5,.8,.96,1}}; Recombine; }
Physical Volume("body") = {1:5};
"""


# Two discs of different size cut out of a plate; its mesh swept with quadrilaterals.
HOLES = ("Rectangle(1) = {0,0,0, 160,100}; Disk(2) = {50,50,0, 20}; Disk(3) = {115,60,0, 12}; Disk(4) = {120,20,0, 6}; "
         "BooleanDifference(5) = {Surface{1}; Delete;}{Surface{2,3,4}; Delete;}; ")
# A truncated pyramid on a slanted block: planar faces only, so that the STL is the body itself.
ROOF_POINTS = [(0, 0, 0), (70, 0, 0), (70, 40, 0), (0, 40, 0), (0, 0, 20), (70, 0, 30), (70, 40, 30), (0, 40, 20)]
ROOF = "".join(f"Point({i + 1}) = {{{x},{y},{z}}};" for i, (x, y, z) in enumerate(ROOF_POINTS)) + \
    "Line(1)={1,2};Line(2)={2,3};Line(3)={3,4};Line(4)={4,1};Line(5)={5,6};Line(6)={6,7};Line(7)={7,8};Line(8)={8,5};" + \
    "Line(9)={1,5};Line(10)={2,6};Line(11)={3,7};Line(12)={4,8};" + \
    "".join(f"Curve Loop({i})={{{loop}}};Plane Surface({i})={{{i}}};" for i, loop in enumerate(
        ["1,2,3,4", "5,6,7,8", "1,10,-5,-9", "2,11,-6,-10", "3,12,-7,-11", "4,9,-8,-12"], 1)) + \
    "Surface Loop(1)={1,2,3,4,5,6};Volume(1)={1};"
ROOF_MESH = ROOF + "Transfinite Curve{1,3,5,7}=25; Transfinite Curve{2,4,6,8}=15; Transfinite Curve{9,10,11,12}=10;" \
    "Transfinite Surface{:}; Recombine Surface{:}; Transfinite Volume{1}; Physical Volume(\"body\")={1};"

CASES = {
    "bar": Case(BAR, fine(BAR, 5, 4), [(20, 2), (16, 2), (12, 2), (10, 2), (8, 2), (7, 3), (6, 3)]),
    "bar, 40 modes": Case(BAR, fine(BAR, 4, 4), [(10, 2), (8, 2), (7, 3), (6, 3), (5, 3)], modes=40),
    "bar, 60 modes": Case(BAR, fine(BAR, 3.2, 4), [(8, 2), (7, 3), (6, 3), (5, 3), (4, 3)], modes=60),
    "bar, 1 mode": Case(BAR, fine(BAR, 6, 4), [(50, 1), (30, 1), (20, 1), (20, 2)], modes=1),
    "plate": Case(PLATE, fine(PLATE, 6, 2), [(20, 1), (14, 1), (14, 2), (12, 2), (10, 2), (8, 2)]),
    "thin plate": Case(THIN, fine(THIN, 2.5, 1), [(10, 1), (8, 1), (7, 1), (6, 1), (5, 1), (4, 1)]),
    "board": Case(BOARD, fine(BOARD, 5, 2), [(30, 1), (20, 1), (15, 1), (12, 1), (10, 1), (12, 2), (10, 2), (9, 1)]),
    "disk": Case(["disk", "--diameter", 100, "--thickness", 12], DISK_12, [(20, 1), (14, 2), (10, 2), (8, 2), (7, 3)]),
    "hollow disk": Case(HOLLOW, DISK_HOLLOW, [(12, 1), (10, 1), (8, 1), (6, 1), (6, 2)]),
    "washer, clamped": Case(WASHER, fine(WASHER, .8, 5), [(6, 1), (4, 1), (3, 1), (2.5, 2), (2, 2)]),
    "cantilever": Case(CANTILEVER, fine(CANTILEVER, 1.6, 8),
                       [(20, 1), (16, 1), (12, 1), (10, 1), (10, 2), (7, 2), (5, 2), (4, 3), (3, 4), (2.5, 4)]),
    "bowl": Case(BOWL, fine(BOWL, 4, 2), [(16, 1), (12, 1), (8, 1), (8, 2), (6, 1), (6, 2), (5, 2)]),
    "cylinder": Case(CYLINDER, fine(CYLINDER, 4, 30), [(20, 3), (15, 4), (12, 6), (10, 8), (8, 10), (7, 12)]),
    "sphere": Case(["sphere", "--diameter", 100], free_ball(.1, 20), [(30, 0), (25, 0), (20, 0), (16, 0), (14, 0), (12, 0)]),
    "sphere, 2 modes": Case(["sphere", "--diameter", 100], free_ball(.1, 2), [(50, 0), (30, 0), (25, 0)], modes=2),
    "L block": Case(["FILE"], ["MESH", "--unit", "mm"], [20, 10, 7, 5, 4, 3], L_BODY, mesh=l_mesh()),
    "bar from STEP": Case(["FILE"], fine(BAR, 5, 4), [16, 10, 8, 6, 5], "Box(1) = {-200,-15,-5, 400,30,10};"),
    "board from STEP": Case(["FILE", "--material", "spruce"], fine(BOARD, 5, 2), [12, 8, 6, 5, 4],
                            "Box(1) = {-250,-100,-1.5, 500,200,3};"),
    "bowl from STEP": Case(["FILE", "--material", "brass"], fine(BOWL, 4, 2), [12, 8, 6, 5, 4],
                           "Sphere(1) = {0,0,0, 100, -Pi/2, 0}; Sphere(2) = {0,0,0, 96, -Pi/2, 0}; "
                           "BooleanDifference(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};"),
    "disk from STEP": Case(["FILE"], DISK_12, [20, 14, 10, 8, 6], "Cylinder(1) = {0,0,-6, 0,0,12, 50};"),
    "plate with holes, STEP": Case(["FILE"], ["MESH", "--unit", "mm"], [12, 8, 6, 5, 4],
                                   HOLES + "Extrude {0,0,5} { Surface{5}; }",
                                   mesh=HOLES + "MeshSize{:} = 3.5; Mesh.MeshSizeFromCurvature = 20; Recombine Surface{5}; "
                                   "Extrude {0,0,5} { Surface{5}; Layers{2}; Recombine; } Physical Volume(\"body\") = {1};"),
    "unnamed STL": Case(["FILE"], ["MESH", "--unit", "mm"], [15, 10, 8, 6, 5], ROOF, "stl", ROOF_MESH),
}
