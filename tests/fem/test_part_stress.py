"""part_stress as its user runs it: the beam's theory, what it writes, draws and refuses. The solver itself is
tested in statics_test.cpp, design_test.cpp and, beside CalculiX, calculix_test.cpp."""
import json
import re
import struct
from functools import partial

import numpy as np
import program
import pytest
from program import PART_STRESS, QUIT, READY, REFUSED, SOLVE, STRESS, meta

run = partial(program.run, PART_STRESS)
BAR = ["bar", "--length", 200, "--width", 20, "--thickness", 20, "--young", 2.1e11]
LOADED = [*BAR, "--h", 10, "--fix", "x=-100", "--force", "x=100:0,0,-100"]


def refusal(*words, folder):
    return program.refusal(PART_STRESS, *words, "--quiet", folder=folder)


def read_vtu(path):
    """Arrays by name, those that elements and nodes both have as (name, where); the coordinates are `points`."""
    text = path.read_text()
    arrays = {}
    for tag, body in re.findall(r"<DataArray ([^>]*)>([^<]*)</DataArray>", text):
        name = re.search(r'Name="([^"]*)"', tag)
        components = int((re.search(r'NumberOfComponents="(\d+)"', tag) or ["", "1"])[1])
        values = np.array(body.split(), float).reshape(-1, components).squeeze()
        arrays.setdefault(name[1] if name else "points", []).append(values)
    points, cells = map(int, re.search(r'NumberOfPoints="(\d+)" NumberOfCells="(\d+)"', text).groups())
    out = {}
    for name, found in arrays.items():
        for values in found:
            out[name if len(found) == 1 else (name, "nodes" if len(values) == points else "elements")] = values
    out["cells"] = np.split(out["connectivity"].astype(int), out["offsets"].astype(int)[:-1])
    assert len(out["points"]) == points and len(out["cells"]) == cells
    return out


def supports_take(said):
    return np.array(re.search(r"support reaction \(([^)]*)\)", said)[1].split(", "), float)


# ---- the part as it is

def test_a_clamped_cantilever_is_stiffer_by_the_contraction_that_the_clamp_prevents(tmp_path):
    run(*LOADED, "--poisson", 0.3, "--vtu", "bar.vtu", folder=tmp_path)
    vtu = read_vtu(tmp_path / "bar.vtu")
    length, side, young, force = 0.2, 0.02, 2.1e11, 100
    inertia, shear = side**4 / 12, young / 2.6
    timoshenko = force * length**3 / (3 * young * inertia) + force * length / (5 / 6 * shear * side**2)
    tip = np.abs(vtu["points"][:, 0] - 0.1) < 1e-9
    assert tip.sum() > 8
    assert -vtu["displacement m"][tip, 2].mean() / timoshenko - 1 == pytest.approx(-0.0075, abs=0.0025)
    # Von Mises of M z / I in the outer elements, away from both ends.
    middles = np.array([vtu["points"][nodes[:8]].mean(axis=0) for nodes in vtu["cells"]])
    inside = (np.abs(middles[:, 0]) < 0.06) & (np.abs(middles[:, 2]) > 0.004)
    bending = force * (0.1 - middles[:, 0]) * np.abs(middles[:, 2]) / inertia
    assert inside.sum() > 20
    assert np.allclose(vtu["von Mises Pa", "elements"][inside], bending[inside], rtol=0.05)


def test_supports_take_what_the_loads_bring_and_a_bedding_moves_by_force_over_stiffness(tmp_path):
    said = run(*BAR, "--h", 10, "--fix", "x=-100", "--force", "x=100:3,4,5", "--point", "100,10,10:1,0,0", "--gravity",
               "0,-9.81,0", "--pressure", "z=10:1e4", "--traction", "y=10:0,0,200", folder=tmp_path).stdout
    top = 0.2 * 0.02
    mass = float(re.search(r"mass (\S+) kg", said)[1])
    assert supports_take(said) == pytest.approx([-4, -4 + 9.81 * mass, -5 + 1e4 * top - 200 * top], rel=1e-4)
    run(*BAR, "--h", 10, "--spring", "x=-100:1e6", "--force", "x=100:10,0,0", "--vtu", "b.vtu", folder=tmp_path)
    vtu = read_vtu(tmp_path / "b.vtu")
    held = np.abs(vtu["points"][:, 0] + 0.1) < 1e-9
    assert vtu["displacement m"][held, 0].mean() == pytest.approx(1e-5, rel=1e-4)


def largest(said, head="before  von Mises: largest"):
    """MPa, its estimated error, and its point in mm."""
    found = re.search(re.escape(head) + r" ([\d.]+) \+- ([\d.]+) MPa .*?at \(([^)]*)\) mm", said)
    return float(found[1]), float(found[2]), np.array(found[3].split(", "), float)


def test_the_bore_of_a_tube_is_lames_within_a_percent_and_within_its_estimate(tmp_path):
    a, b, p = 50, 100, 10  # mm, MPa; free ends: plane stress
    said = run("ring", "--outer-diameter", 2 * b, "--inner-diameter", 2 * a, "--thickness", 20, "--pressure",
               f"cylinder:0,0,-10,0,0,10,{a}:{1e6 * p}", "--fix", "x=0:x", "--fix", "y=0:y", "--fix", "z=-10:z",
               folder=tmp_path).stdout
    hoop = p * (a * a + b * b) / (b * b - a * a)
    exact = np.sqrt(hoop**2 + hoop * p + p * p)
    stress, error, point = largest(said)
    assert stress == pytest.approx(exact, rel=0.01)
    assert abs(stress - exact) < error < 0.03 * exact
    assert np.hypot(*point[:2]) == pytest.approx(a, rel=1e-3)
    assert "singularity" not in said  # planes of symmetry are none


def test_a_small_hole_in_a_pulled_plate_has_three_times_its_stress(tmp_path):
    """Kirsch 1898; on a plate 20 holes wide Howland's 3.00, of the stress far away."""
    program.write_step(tmp_path, "Box(1) = {-100,-100,-2, 200,200,4}; Cylinder(2) = {0,0,-5, 0,0,10, 5}; "
                                 "BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; }")
    said = run("body.step", "--traction", "x=100:1e6,0,0", "--traction", "x=-100:-1e6,0,0", "--fix",
               "box:-.01,-200,-9,.01,200,9:x", "--fix", "5,0,-2,.001:yz", "--fix", "5,0,2,.001:y", folder=tmp_path).stdout
    stress, error, point = largest(said)
    assert stress == pytest.approx(3, rel=0.01) and abs(stress - 3) < error < 0.1
    assert point[:2] == pytest.approx([0, 5 * np.sign(point[1])], abs=0.2)


def test_a_clamp_is_a_singular_corner_and_away_from_it_a_beam_bends(tmp_path):
    said = run(*BAR, "--fix", "x=-100", "--force", "x=100:0,0,-100", folder=tmp_path).stdout
    assert "is at a singularity" in said
    stress, error, point = largest(said, "elsewhere the largest is")
    bending = 100 * (0.1 - point[0] / 1e3) * 0.01 / (0.02**4 / 12) / 1e6  # M c / I, MPa
    assert abs(stress - bending) < max(error, 0.01 * bending)
    assert abs(stress - bending) < 0.015 * bending


@pytest.mark.parametrize("coarse, fine", [(20, 12), pytest.param(12, 6, marks=pytest.mark.slow)])
def test_the_peak_at_a_concave_edge_grows_with_each_refinement_and_is_told_singular(coarse, fine, tmp_path):
    # A pressed cavity, whose edges are of 270 degrees: the stress grows as r^-0.456 (Williams 1952).
    peaks = []
    for h in (coarse, fine):
        said = run("hollow_disk", "--diameter", 100, "--thickness", 40, "--cavity-diameter", 50, "--cavity-thickness",
                   16, "--h", h, "--fix", "x=0:x", "--fix", "y=0:y", "--fix", "z=-20:z", "--pressure", "z=20:1e7",
                   folder=tmp_path).stdout
        assert "is at a singularity" in said
        peaks.append(largest(said)[0])
    assert peaks[1] > (coarse / fine)**0.2 * peaks[0]


@pytest.mark.parametrize("newton, told", [(1.9e4, False), (2.2e4, True)])
def test_displacements_that_are_not_small_are_told(newton, told, tmp_path):
    """F L^3/(3 E I) and 1 % by shear are 10 % of 200 mm at 20.8 kN, for a square of 20 mm and E = 210 GPa."""
    said = run(*BAR, "--h", 10, "--fix", "x=-100", "--force", f"x=100:0,0,-{newton:g}", folder=tmp_path).stdout
    assert ("of the part's length: the linear equations are valid up to" in said) == told


@pytest.mark.slow
def test_the_arm_bends_as_a_curved_beam_and_its_supports_take_the_pins_forces(tmp_path):
    said = run("lift_arm", "--vtu", "arm.vtu", folder=tmp_path).stdout
    assert supports_take(said) == pytest.approx([1000, 6000, 0], abs=1)
    vtu = read_vtu(tmp_path / "arm.vtu")
    eye = np.hypot(vtu["points"][:, 0] - 0.38, vtu["points"][:, 1]) < 0.0131
    drop = vtu["displacement m"][eye, 1].mean()
    # A straight cantilever of the plate's section at mid-length without holes is stiffer, one of half its depth
    # weaker: order of magnitude and sign.
    stiff = -(12000 * 0.38**3 / 3 - 6000 * 0.17**2 * (3 * 0.38 - 0.17) / 6) / (2.0e11 * 0.022 * 0.108**3 / 12)
    assert 8 * stiff < drop < stiff


def enclosed(table):
    """Volume within the skin: positive where its triangles look outwards."""
    a, b, c = (table["surface_nodes"][table["surface_triangles"][:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_a_step_file_of_the_arm_lists_its_faces_and_takes_them_by_number(tmp_path):
    run("lift_arm", "--h", 60, "--no-grade", "--step", "arm.step", folder=tmp_path)
    faces = run("arm.step", "--list-faces", "--h", 60, "--no-grade", "--quiet", folder=tmp_path).stdout
    holes = {}
    for number, radius, area in re.findall(r"face (\d+): cylinder of radius ([\d.]+) mm, area ([\d.e+]+)", faces):
        holes.setdefault(float(radius), []).append((number, float(area)))
    for radius, width in ((30, 62), (15, 54), (13, 50)):
        (_, area), = holes[radius]
        assert area == pytest.approx(2 * np.pi * radius * width, rel=1e-3)
    said = run("arm.step", "--h", 60, "--no-grade", "--fix", f"face:{holes[30][0][0]}", "--bolt",
               f"face:{holes[13][0][0]}:0,-100,0", folder=tmp_path).stdout
    assert supports_take(said) == pytest.approx([0, 100, 0], abs=0.5)  # the facets find the hole's axis within 5e-3
    assert "face 99" in refusal("arm.step", "--h", 60, "--no-grade", "--fix", "face:99", "--gravity", "0,-9,0", folder=tmp_path)


# ---- the table

@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bar")
    run(*LOADED, "-o", "bar.stress.npz", "--range", 8, folder=folder)
    return folder, np.load(folder / "bar.stress.npz")


def test_the_table_holds_every_array_in_its_type_and_shape(bar):
    table = bar[1]
    elements, vertices, parameters = len(table["s0"]), len(table["surface_nodes"]), len(table["parameters"])
    expected = {"s0": ("<f4", (elements,)), "shear0": ("<f4", (elements,)), "weights": ("<f4", (elements,)),
                "S": ("<f4", (parameters, elements)), "S_shear": ("<f4", (parameters, elements)),
                "parameters": ("<f8", (parameters, 4)), "control_points": ("<f8", (27, 3)), "trust": ("<f8", ()),
                "surface_nodes": ("<f8", (vertices, 3)), "surface_node_element": ("<i4", (vertices,)),
                "surface_weights": ("<f4", (vertices, 27))}
    for name, (kind, shape) in expected.items():
        assert table[name].dtype == np.dtype(kind) and table[name].shape == shape, name
    assert table["surface_triangles"].dtype == np.int32 and table["surface_triangles"].max() == vertices - 1
    assert table["surface_node_element"].min() >= 0 and table["surface_node_element"].max() < elements
    assert table["weights"].sum() == pytest.approx(0.2 * 0.02 * 0.02, rel=1e-6)
    rows = table["parameters"]
    assert parameters == 81 and set(rows[:, 0]) == set(range(27)) and set(rows[:, 1]) == {0, 1, 2}
    assert np.all(rows[:, 2] < 0) and np.all(rows[:, 3] > 0) and np.all(np.abs(rows[:, 2:]) <= 0.008 + 1e-12)
    assert table["trust"] == pytest.approx(0.002)
    about = meta(table)
    assert about["format"] == "stress-table" and about["version"] == "1.0"
    assert about["units"] == {"stress": "Pa", "length": "m"} and about["material"]["name"] == "steel"
    assert "force x=100:0,0,-100" in about["loads"] and about["supports"] == ["fix x=-100"]
    assert enclosed(table) == pytest.approx(8e-5)


def moved(folder, *moves):
    words = [w for id_, *d in moves for w in ("--move", id_, *d)]
    run(*LOADED, *words, "--vtu", "moved.vtu", folder=folder)
    return read_vtu(folder / "moved.vtu")["von Mises Pa", "elements"]


# Of the top's middle, of the held end.
@pytest.mark.parametrize("control, axis", [(22, 2), pytest.param(12, 0, marks=pytest.mark.slow)])
def test_taylors_error_falls_with_the_square_of_the_move(control, axis, bar):
    folder, table = bar
    row = int(np.flatnonzero((table["parameters"][:, 0] == control) & (table["parameters"][:, 1] == axis))[0])
    errors = []
    for move in (-2, -1, -0.5):
        solved = moved(folder, (control, *(move if k == axis else 0 for k in range(3))))
        taylor = table["s0"] + table["S"][row] * move * 1e-3
        errors.append(np.linalg.norm(taylor - solved) / np.linalg.norm(solved))
    assert 3.3 < errors[0] / errors[1] < 5 and 3.3 < errors[1] / errors[2] < 4.7, errors


def test_the_lattice_carries_the_skin(bar):
    """B-splines on Greville abscissae reproduce every point of the box (The NURBS Book, 2.3), so the skin lies at
    the weighted control points; moved by an affine map they move it by the same map."""
    table = bar[1]
    weights, points = table["surface_weights"].astype(float), table["control_points"]
    assert np.allclose(weights @ points, table["surface_nodes"], atol=1e-8)
    stretched = points * [1.1, 0.9, 1] + [0.01, 0, 0]
    assert np.allclose(weights @ stretched, table["surface_nodes"] * [1.1, 0.9, 1] + [0.01, 0, 0], atol=1e-8)


def test_a_coarser_skin_is_closed_and_of_the_same_body(bar, tmp_path):
    fine = bar[1]
    run(*LOADED, "-o", "coarse.stress.npz", "--range", 8, "--skin", 20, folder=tmp_path)
    coarse = np.load(tmp_path / "coarse.stress.npz")
    assert len(coarse["surface_triangles"]) < 0.5 * len(fine["surface_triangles"])
    edges = [(t[k], t[(k + 1) % 3]) for t in coarse["surface_triangles"] for k in range(3)]
    assert len(set(edges)) == len(edges) and set(edges) == {(j, i) for i, j in edges}
    assert enclosed(coarse) == pytest.approx(8e-5)
    vertices = lambda t: {tuple(node): (element, tuple(weights)) for node, element, weights in
                          zip(t["surface_nodes"], t["surface_node_element"], t["surface_weights"])}
    assert vertices(coarse).items() <= vertices(fine).items()
    assert np.array_equal(fine["S"], coarse["S"])
    assert "--skin" in refusal("lift_arm", "--skin", -3, folder=tmp_path)


def test_a_box_within_the_part_leaves_the_faces_that_it_crosses_where_they_are(tmp_path):
    words = [*LOADED, "--box", "-30,-12,-12,30,12,12"]
    run(*words, "-o", "b.stress.npz", "--move", 22, 0, 0, 2, "--vtu", "b.vtu", folder=tmp_path)
    table = np.load(tmp_path / "b.stress.npz")
    # Of 3 x 3 x 3 points those with x in the middle: the body passes through both ends.
    assert set(table["parameters"][:, 0]) == {1 + 3 * j + 9 * k for j in range(3) for k in range(3)}
    points = read_vtu(tmp_path / "b.vtu")["points"]
    outside = np.abs(points[:, 0]) > 0.0301
    assert np.abs(points[outside][:, 2]).max() == pytest.approx(0.01, abs=1e-9)
    # Bernstein's weights at the middle of the top: 1/2 along x and y, (22/24)^2 along z; of 2 mm.
    assert points[~outside][:, 2].max() == pytest.approx(0.01 + 0.25 * (22 / 24) ** 2 * 2e-3, abs=1e-8)
    few = run(*words, "--controls", "4,13", "--directions", "z", "-o", "f.stress.npz", folder=tmp_path)
    rows = np.load(tmp_path / "f.stress.npz")["parameters"]
    assert rows[:, :2].tolist() == [[4, 2], [13, 2]] and "2 parameters" in few.stdout


@pytest.mark.slow
def test_bounds_end_where_the_mesh_would_turn_inside_out(tmp_path):
    run(*LOADED, "--range", 1000, "--controls", "12,14", "--directions", "x", "-o", "b.stress.npz", folder=tmp_path)
    rows = np.load(tmp_path / "b.stress.npz")["parameters"]
    assert np.all(rows[:, 2] < -0.02) and np.all(rows[:, 3] > 0.02) and np.abs(rows[:, 2:]).min() < 0.9
    said = run(*LOADED, "--move", 14, -1000, 0, 0, folder=tmp_path).stdout
    assert re.search(r"the move stops at \d+\.\d %: element \d+", said)


@pytest.mark.slow
def test_the_sheet_shows_the_part_before_and_after_and_leaves_nothing_else(tmp_path):
    pytest.importorskip("matplotlib")
    import matplotlib.image
    pictures = []
    for move in ([], ["--move", 22, 0, 0, -4]):
        run(*LOADED, "--sheet", "bar.png", *move, folder=tmp_path)
        pictures.append(matplotlib.image.imread(tmp_path / "bar.png"))
        colours = np.unique((pictures[-1][::2, ::2, :3] * 15).astype(int).reshape(-1, 3), axis=0)
        assert len(colours) > 100  # the stress's colours, not an empty page
    assert pictures[1].shape[0] > 1.4 * pictures[0].shape[0]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bar.png"]


# ---- refusals

@pytest.mark.parametrize("words, expected", [
    ([*BAR, "--force", "x=100:0,0,1"], "no supports"),
    ([*BAR, "--fix", "x=-100"], "no loads"),
    ([*BAR, "--fix", "x=-100:x", "--force", "x=100:0,0,1"], "3 of its 6 rigid motions are free"),
    ([*BAR, "--fix", "x=-101", "--force", "x=100:0,0,1"], "--fix x=-101"),
    ([*LOADED, "--force", "x=-100:0,0,1"], "--force x=-100:0,0,1 acts only on fixed nodes"),
    ([*LOADED, "--force", "x=100:1,2"], "2 numbers, expected 3"),
    ([*LOADED, "--force", "x=100:1,2,nan"], "nan: not a finite number"),
    ([*LOADED, "--force", "x=100:1,2,1e300"], "1e300: expected a number in -1e15..1e15"),
    ([*LOADED, "--force", "ball:1,2,3"], "expected x=LEVEL"),
    ([*LOADED, "--force", "box:1,2,3:1,2,3"], "expected 6"),
    ([*LOADED, "--force", "box:1,2,3,0,0,0:1,2,3"], "box has low above high"),
    ([*LOADED, "--pressure", "x=100"], "expected a pressure in Pa"),
    ([*LOADED, "--bolt", "x=100:0,0,1"], "wall of a round hole"),
    ([*LOADED, "--point", "1,2,3"], "expected X,Y,Z:FX,FY,FZ"),
    ([*LOADED, "--spring", "x=100:-5"], "0 N/m or more"),
    ([*LOADED, "--spring", "x=100:0"], "above 0"),
    ([*LOADED, "--lattice", 1, 3, 3], "--lattice 1"),
    ([*LOADED, "--lattice", 3, 3], "expected three integers"),
    ([*LOADED, "--degree", 3, 2, 2], "expected 1 to 2"),
    ([*LOADED, "--box", "300,0,0,310,9,9"], "no node of the mesh"),
    ([*LOADED, "--box", "-10,-12,-12,10,12,12", "--lattice", 2, 2, 2], "no control point may move"),
    ([*LOADED, "--controls", 40], "expected 0..26"),
    ([*LOADED, "--move", 99, 0, 0, 1], "--move 99"),
    ([*LOADED, "--move", 5, 0, 0], "--move --quiet: expected a number"),
    ([*LOADED, "--memory", "1M"], "expected at most 1 MB"),
    ([*LOADED, "--material", "wax"], "wax"),
    ([*LOADED, "-o", "/nowhere/x.npz"], "no folder /nowhere"),
    ([*LOADED, "--vtu", "a", "-o", "a"], "same file"),
    ([*LOADED, "--step", "a.step"], "--step"),
    ([*LOADED, "--modes", 3], "unknown option --modes"),
    (["lift_arm", "--rod-width", 20], "rod_eye width 20 mm"),
    (["none.step", "--fix", "x=0", "--gravity", "0,0,-9"], "cannot read none.step: no such file"),
])
def test_what_cannot_be_done_is_refused_in_one_sentence(words, expected, tmp_path):
    assert expected in refusal(*words, folder=tmp_path)
    assert not list(tmp_path.iterdir())


# ---- serve

class Server(program.Server):
    def __init__(self, folder, *words):
        super().__init__(PART_STRESS, folder, "bar.stress.npz", *words)
        kind, self.ready = self.read()
        assert kind == READY
        self.elements, self.parameters = struct.unpack_from("<QQ", self.ready)

    def solve(self, parameters, method=0, flags=0):
        self.send(SOLVE, struct.pack("<II", method, flags) + np.asarray(parameters, "<f8").tobytes())
        kind, payload = self.read()
        assert kind == STRESS, payload
        method, iterations, _, fraction, residual = struct.unpack_from("<IIddd", payload)
        p = np.frombuffer(payload, "<f8", self.parameters, 32)
        rows = np.frombuffer(payload, "<f4", offset=32 + 8 * self.parameters).reshape(-1, self.elements)
        return {"method": method, "iterations": iterations, "fraction": fraction, "residual": residual, "p": p,
                "s": rows[0], "shear": rows[1], "S": rows[2:]}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serve")
    run(*LOADED, "--controls", "13,22", "-o", "bar.stress.npz", folder=folder)
    return folder, np.load(folder / "bar.stress.npz")


def test_a_server_solves_the_part_at_other_shapes_and_ends_with_its_stdin(served):
    folder, table = served
    with Server(folder) as server:
        assert (server.elements, server.parameters) == (len(table["s0"]), len(table["parameters"]))
        assert all(t > 0 for t in struct.unpack("<ddd", server.ready[16:]))
        assert np.allclose(server.solve(np.zeros(6))["s"], table["s0"], rtol=1e-5, atol=1)
        p = np.zeros(6)
        p[5] = -4e-3  # control point 22 along z
        expected = moved(folder, (22, 0, 0, -4))
        close = partial(np.allclose, rtol=2e-5, atol=2e-5 * expected.max())
        for method in (1, 2):
            got = server.solve(p, method)
            assert got["method"] == method and np.array_equal(got["p"], p) and got["fraction"] == 1
            assert close(got["s"], expected) and len(got["S"]) == 0
        based = server.solve(p, 0, 1)
        assert len(based["S"]) == 12 and np.allclose(based["s"], expected, rtol=1e-4, atol=1e-4 * expected.max())
        assert not np.allclose(based["S"][5], table["S"][5], rtol=1e-3, atol=1e-3 * np.abs(table["S"][5]).max())
        # Bad requests are refused, and the next good one is answered.
        for payload, words in ((b"", "expected"), (struct.pack("<II", 9, 0) + p.tobytes(), "method 9"),
                               (struct.pack("<II", 1, 4) + p.tobytes(), "flags 4"),
                               (struct.pack("<II", 1, 0) + (p + 0.021).tobytes(), "control point 13 along y 21 mm: expected -5..5 mm"),
                               (struct.pack("<II", 0, 0) + (p * np.nan).tobytes(), "")):
            assert words in server.refuses(SOLVE, payload)
        assert "kind 77" in server.refuses(77)
        assert close(server.solve(p, 1)["s"], expected)
        server.process.stdin.close()
        assert server.process.wait(60) == 0


def test_a_server_keeps_its_factor_and_solves_as_closely_as_it_is_told(served):
    folder = served[0]
    p = np.zeros(6)
    p[[2, 5]] = -5e-3  # both points along z, a quarter of the height
    found = {}
    for tolerance in ("1e-3", "1e-10"):
        with Server(folder, "--tolerance", tolerance) as server:
            found[tolerance] = server.solve(p, 1, 2)
            assert found[tolerance]["method"] == 1 and found[tolerance]["residual"] <= float(tolerance)
            assert server.solve(0 * p, 1, 2)["iterations"] <= 3  # the factor's own shape
            if tolerance == "1e-10":
                server.solve(p, 1)  # many iterations: a new factor, unless the client keeps the old one
                assert server.solve(-p, 1, 2)["iterations"] > 5
                assert server.solve(p, 1, 2)["iterations"] < 10  # seen before
    assert found["1e-10"]["iterations"] > 15 > found["1e-3"]["iterations"]
    for words in (["--tolerance"], ["--tolerance", 2], ["--tolerance", "nan"], ["--tolerant", "1e-3"]):
        said = run("serve", "bar.stress.npz", *words, folder=folder, expect=1).stderr.strip().splitlines()
        assert len(said) == 1 and "tolerance" in said[0]


@pytest.mark.parametrize("damage, words", [("magic", "begins with"), ("size", "expected at most"),
                                           ("header", "16 bytes"), ("payload", "the stream ends")])
def test_a_server_whose_stream_is_broken_says_so_and_ends(served, damage, words):
    with Server(served[0]) as server:
        if damage == "header":
            server.process.stdin.write(b"TSR1abc")
        else:
            wrong = {"magic": {"magic": 5}, "size": {"size": 1 << 40}, "payload": {"size": 100}}[damage]
            server.send(SOLVE, b"12345678", **wrong)
        server.process.stdin.close()
        kind, sentence = server.read()
        assert kind == REFUSED and words in sentence.decode()
        assert server.process.wait(60) == 1 and words in server.process.stderr.read().decode()


def test_a_server_ends_when_it_is_told_to_and_when_nobody_reads(served):
    with Server(served[0]) as server:
        server.send(QUIT)
        assert server.process.wait(60) == 0
    with Server(served[0]) as server:
        server.process.stdout.close()
        server.send(SOLVE, struct.pack("<II", 0, 0) + np.zeros(6).tobytes())
        assert server.process.wait(60) != 0


def test_files_that_a_server_cannot_use_are_refused(served, tmp_path):
    folder, table = served
    whole = (folder / "bar.stress.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[:len(whole) // 2])
    text = lambda value: np.frombuffer(json.dumps(value).encode(), np.uint8)
    np.savez(tmp_path / "other.npz", meta=text({"format": "modal-table"}))
    np.savez(tmp_path / "mesh.npz", **{**table, "mesh": table["mesh"][:-9]})
    silent = {name: value for name, value in meta(table).items() if name != "command"}
    np.savez(tmp_path / "silent.npz", **{**table, "meta": text(silent)})
    for name, words in (("cut", "damaged"), ("other", "not a stress table"), ("mesh", "mesh.npz"), ("silent", "command")):
        done = run("serve", f"{name}.npz", folder=tmp_path, expect=1)
        assert words in done.stderr and len(done.stderr.splitlines()) == 1 and not done.stdout


def test_help_lists_shapes_and_options(tmp_path):
    said = run("--help", folder=tmp_path).stdout
    for word in ("lift_arm", "--bolt", "--lattice", "--move", "--sheet", "cylinder:", "serve"):
        assert word in said
