"""part_stress as its user runs it: beams and CalculiX for the truth, what it writes, draws and refuses."""
import json
import os
import re
import shutil
import struct
import subprocess

import numpy as np
import pytest
import serve_client
from serve_client import QUIT, READY, REFUSED, SOLVE, STRESS

PROGRAM = os.environ["PART_STRESS"]
QUICK = bool(os.environ.get("TACTUS_QUICK"))
# Under sanitizers what brings bytes from outside is run: orders, files, streams. What measures the physics is not.
slow = pytest.mark.skipif(QUICK, reason="slow")
BAR = ["bar", "--length", "200", "--width", "20", "--thickness", "20", "--young", "2.1e11"]
LOADED = [*BAR, "--h", "10", "--fix", "x=-100", "--force", "x=100:0,0,-100"]


def run(*words, folder, expect=0, **extra):
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=300, **extra)
    assert done.returncode == expect, done.stderr
    return done


def refusal(*words, folder):
    said = run(*words, "--quiet", folder=folder, expect=1).stderr.strip().splitlines()
    assert len(said) == 1 and said[0].startswith("part_stress: "), said
    return said[0]


def read_vtu(path):
    """Arrays by name; the coordinates are `points`."""
    text = path.read_text()
    arrays = {}
    for tag, body in re.findall(r"<DataArray ([^>]*)>([^<]*)</DataArray>", text):
        name = re.search(r'Name="([^"]*)"', tag)
        values = np.array(body.split(), float)
        components = int((re.search(r'NumberOfComponents="(\d+)"', tag) or ["", "1"])[1])
        arrays.setdefault(name[1] if name else "points", []).append(values.reshape(-1, components).squeeze())
    points, cells = map(int, re.search(r'NumberOfPoints="(\d+)" NumberOfCells="(\d+)"', text).groups())
    out = {}
    for name, found in arrays.items():  # a name may stand in elements and at nodes
        for values in found:
            out[name if len(found) == 1 else (name, "nodes" if len(values) == points else "elements")] = values
    out["offsets"] = out["offsets"].astype(int)
    cell_nodes = np.split(out["connectivity"].astype(int), out["offsets"][:-1])
    assert len(out["points"]) == points and len(cell_nodes) == cells
    out["cells"] = cell_nodes
    return out


# ---- beams

def tip_deflection(folder, poisson, size):
    run(*BAR, "--poisson", poisson, "--h", size, "--fix", "x=-100", "--force", "x=100:0,0,-100", "--vtu", "bar.vtu",
        folder=folder)
    vtu = read_vtu(folder / "bar.vtu")
    tip = np.abs(vtu["points"][:, 0] - 0.1) < 1e-9
    assert tip.sum() > 8
    return -vtu["displacement m"][tip, 2].mean(), vtu


def timoshenko(poisson):
    length, side, young, force = 0.2, 0.02, 2.1e11, 100
    inertia, shear = side**4 / 12, young / (2 * (1 + poisson))
    return force * length**3 / (3 * young * inertia) + force * length / (5 / 6 * shear * side**2)


@slow
def test_a_cantilever_without_lateral_contraction_bends_as_timoshenko_says(tmp_path):
    # Loaded evenly instead of by the parabola of St Venant, the tip differs by the work of the shear's
    # redistribution near the end, 1e-4 of the whole.
    deflection, vtu = tip_deflection(tmp_path, 0, 7)
    assert deflection == pytest.approx(timoshenko(0), rel=5e-4)
    # Von Mises of M z / I and the mean shear F / A (its parabola's middle is not an element's).
    middles = np.array([vtu["points"][nodes[:8]].mean(axis=0) for nodes in vtu["cells"]])
    inside = (np.abs(middles[:, 0]) < 0.06) & (np.abs(middles[:, 2]) > 0.006)
    bending = 100 * (0.1 - middles[:, 0]) * np.abs(middles[:, 2]) / (0.02**4 / 12)
    assert inside.sum() > 20
    assert np.allclose(vtu["von Mises Pa", "elements"][inside], bending[inside], rtol=0.03)


@slow
def test_a_clamped_cantilever_is_stiffer_by_the_contraction_that_the_clamp_prevents(tmp_path):
    deflection, _ = tip_deflection(tmp_path, 0.3, 10)
    assert deflection / timoshenko(0.3) - 1 == pytest.approx(-0.0075, abs=0.0025)


def test_supports_take_what_the_loads_bring(tmp_path):
    said = run(*BAR, "--h", 10, "--fix", "x=-100", "--force", "x=100:3,4,5", "--point", "100,10,10:1,0,0", "--gravity",
               "0,-9.81,0", "--pressure", "z=10:1e4", "--traction", "y=10:0,0,200", folder=tmp_path).stdout
    found = np.array(re.search(r"supports take \(([^)]*)\)", said)[1].split(", "), float)
    top = 0.2 * 0.02
    mass = float(re.search(r"mass (\S+) kg", said)[1])
    assert found == pytest.approx([-4, -4 + 9.81 * mass, -5 + 1e4 * top - 200 * top], rel=1e-4)


@slow
def test_an_elastic_bedding_moves_by_force_over_stiffness(tmp_path):
    run(*BAR, "--h", 10, "--spring", "x=-100:1e6", "--force", "x=100:10,0,0", "--vtu", "b.vtu", folder=tmp_path)
    vtu = read_vtu(tmp_path / "b.vtu")
    held = np.abs(vtu["points"][:, 0] + 0.1) < 1e-9
    assert vtu["displacement m"][held, 0].mean() == pytest.approx(1e-5, rel=1e-4)


# ---- the table

@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bar")
    done = run(*LOADED, "-o", "bar.stress.npz", "--range", "8", folder=folder)
    return folder, done, np.load(folder / "bar.stress.npz")


def test_the_table_holds_every_array_in_its_type_and_shape(bar):
    table = bar[2]
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
    meta = json.loads(bytes(table["meta"]))
    assert meta["format"] == "stress-table" and meta["version"] == "1.0"
    assert meta["units"] == {"stress": "Pa", "length": "m"} and meta["material"]["name"] == "steel"
    assert "force x=100:0,0,-100" in meta["loads"] and meta["supports"] == ["fix x=-100"]
    a, b, c = (table["surface_nodes"][table["surface_triangles"][:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(8e-5)  # outward and closed


def moved(folder, *moves):
    words = [w for id_, *d in moves for w in ("--move", id_, *d)]
    run(*LOADED, *words, "--vtu", "moved.vtu", folder=folder)
    return read_vtu(folder / "moved.vtu")["von Mises Pa", "elements"]


@slow
def test_the_tables_derivatives_are_those_of_the_part_solved_again(bar):
    folder, _, table = bar
    elements = len(table["s0"])
    for control, axis in ((22, 2), (12, 0)):  # of the top's middle, of the held end
        row = int(np.flatnonzero((table["parameters"][:, 0] == control) & (table["parameters"][:, 1] == axis))[0])
        step = 0.2  # mm; the difference's own error goes as its square, 1e-5
        there, back = ([0, 0, 0] for _ in range(2))
        there[axis], back[axis] = step, -step
        difference = (moved(folder, (control, *there)) - moved(folder, (control, *back))) / (2e-3 * step)
        error = np.linalg.norm(table["S"][row] - difference) / np.linalg.norm(difference)
        assert len(difference) == elements and error < 1e-3, (control, axis, error)


@slow
def test_taylors_error_falls_with_the_square_of_the_move(bar):
    folder, _, table = bar
    row = int(np.flatnonzero((table["parameters"][:, 0] == 22) & (table["parameters"][:, 1] == 2))[0])
    errors = []
    for move in (-4, -2, -1):
        solved = moved(folder, (22, 0, 0, move))
        taylor = table["s0"] + table["S"][row] * move * 1e-3
        errors.append(np.linalg.norm(taylor - solved) / np.linalg.norm(solved))
    assert 3.3 < errors[0] / errors[1] < 4.7 and 3.3 < errors[1] / errors[2] < 4.7, errors


def test_a_box_within_the_part_leaves_the_faces_that_it_crosses_where_they_are(tmp_path):
    run(*LOADED, "--box", "-30,-12,-12,30,12,12", "-o", "b.stress.npz", "--move", "22", "0", "0", "2", "--vtu", "b.vtu",
        folder=tmp_path)
    table = np.load(tmp_path / "b.stress.npz")
    # Of 3 x 3 x 3 points those with x in the middle: the body passes through both ends.
    assert set(table["parameters"][:, 0]) == {1 + 3 * j + 9 * k for j in range(3) for k in range(3)}
    points = read_vtu(tmp_path / "b.vtu")["points"]
    outside = np.abs(points[:, 0]) > 0.0301
    assert np.abs(points[outside][:, 2]).max() == pytest.approx(0.01, abs=1e-9)
    # Bernstein's weights at the middle of the top: 1/2 along x and y, (22/24)^2 along z; of 2 mm.
    assert points[~outside][:, 2].max() == pytest.approx(0.01 + 0.25 * (22 / 24) ** 2 * 2e-3, abs=1e-8)
    few = run(*LOADED, "--box", "-30,-12,-12,30,12,12", "--controls", "4,13", "--directions", "z", "-o", "f.stress.npz",
              folder=tmp_path)
    rows = np.load(tmp_path / "f.stress.npz")["parameters"]
    assert rows[:, :2].tolist() == [[4, 2], [13, 2]] and "2 parameters" in few.stdout


@slow
def test_bounds_end_where_the_mesh_would_turn_inside_out(tmp_path):
    run(*LOADED, "--range", "1000", "--controls", "12,14", "--directions", "x", "-o", "b.stress.npz", folder=tmp_path)
    rows = np.load(tmp_path / "b.stress.npz")["parameters"]
    assert np.all(rows[:, 2] < -0.02) and np.all(rows[:, 3] > 0.02) and np.abs(rows[:, 2:]).min() < 0.9
    said = run(*LOADED, "--move", "14", "-1000", "0", "0", folder=tmp_path).stdout
    assert re.search(r"the move stops at \d+\.\d %: element \d+", said)


@slow
def test_equal_orders_write_equal_tables(tmp_path):
    env = dict(os.environ, SOURCE_DATE_EPOCH="0")
    for name in ("a", "b"):
        run(*LOADED, "--controls", "13", "-o", f"{name}.stress.npz", folder=tmp_path, env=env)
    a, b = (np.load(tmp_path / f"{name}.stress.npz") for name in "ab")
    assert all(np.array_equal(a[k], b[k]) for k in a.files if k != "meta")


# ---- the lift arm, CAD files and CalculiX

@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arm")
    done = run("lift_arm", "--export-inp", "arm.inp", "--vtu", "arm.vtu", folder=folder)
    return folder, done, read_vtu(folder / "arm.vtu")


@slow
@pytest.mark.skipif(not shutil.which("ccx"), reason="CalculiX (ccx) is not installed")
def test_the_arm_agrees_with_calculix_in_displacement_and_stress(arm):
    folder, _, vtu = arm
    subprocess.run(["ccx", "arm"], cwd=folder, check=True, capture_output=True, timeout=280,
                   env=dict(os.environ, OMP_NUM_THREADS="1"))
    text = (folder / "arm.dat").read_text()
    tables = {}
    for title, body in re.findall(r"^ *(\S[^\n]*?) for set[^\n]*\n\n((?:[^\n]*\d[^\n]*\n)+)", text, re.M):
        tables[title.split()[0]] = np.array([line.split() for line in body.splitlines()], float)
    theirs = np.zeros_like(vtu["points"])
    theirs[tables["displacements"][:, 0].astype(int) - 1] = tables["displacements"][:, 1:4]
    ours = vtu["displacement m"]
    assert np.abs(ours - theirs).max() < 0.005 * np.abs(theirs).max()
    # The mean of a tet10's four integration points is the stress in its middle where its sides are straight.
    rows = tables["stresses"]
    element = rows[:, 0].astype(int) - 1
    mean = np.array([np.bincount(element, rows[:, 2 + k], len(vtu["cells"])) for k in range(6)])
    mean /= np.bincount(element, minlength=len(vtu["cells"]))
    xx, yy, zz, xy, xz, yz = mean
    mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + xz**2 + yz**2))
    middles = np.array([vtu["points"][nodes[:4]].mean(axis=0) for nodes in vtu["cells"]])
    # Ten points along the plate's upper and lower edge, away from bosses, holes and their fillets.
    points = [(x, y) for x in (0.08, 0.12, 0.22, 0.26, 0.30) for y in ("top", "bottom")]
    stress = vtu["von Mises Pa", "elements"]
    compared = []
    for x, side in points:
        near = (np.abs(middles[:, 0] - x) < 0.012) & (np.abs(middles[:, 2]) < 0.011)
        rank = middles[:, 1] if side == "top" else -middles[:, 1]
        at = np.flatnonzero(near)[np.argmax(rank[near])]
        compared.append((stress[at], mises[at]))
        assert stress[at] == pytest.approx(mises[at], rel=0.02), (x, side)
    assert min(a for a, _ in compared) > 1e7  # they carry the load


@slow
def test_the_arm_bends_as_a_curved_beam_and_its_supports_take_the_pins_forces(arm):
    _, done, vtu = arm
    found = np.array(re.search(r"supports take \(([^)]*)\)", done.stdout)[1].split(", "), float)
    assert found == pytest.approx([1000, 6000, 0], abs=1)
    eye = np.hypot(vtu["points"][:, 0] - 0.38, vtu["points"][:, 1]) < 0.0131
    drop = vtu["displacement m"][eye, 1].mean()
    # A straight cantilever of the plate's section at mid-length without holes is stiffer, one of half its depth
    # weaker: order of magnitude and sign.
    inertia = 0.022 * 0.108**3 / 12
    stiff = -(12000 * 0.38**3 / 3 - 6000 * 0.17**2 * (3 * 0.38 - 0.17) / 6) / (2.0e11 * inertia)
    assert 8 * stiff < drop < stiff


def test_a_step_file_of_the_arm_lists_its_faces_and_takes_them_by_number(tmp_path):
    run("lift_arm", "--step", "arm.step", folder=tmp_path)
    faces = run("arm.step", "--list-faces", "--h", 40, "--no-grade", "--quiet", folder=tmp_path).stdout.splitlines()
    holes = {}
    for line in faces:
        if found := re.match(r"face (\d+): cylinder of radius ([\d.]+) mm, area ([\d.e+]+)", line):
            number, radius, area = found.groups()
            holes.setdefault(float(radius), []).append((int(number), float(area)))
    for radius, width in ((30, 62), (15, 54), (13, 50)):
        (number, area), = holes[radius]
        assert area == pytest.approx(2 * np.pi * radius * width, rel=1e-3)
    said = run("arm.step", "--h", 40, "--no-grade", "--fix", f"face:{holes[30][0][0]}", "--bolt",
               f"face:{holes[13][0][0]}:0,-100,0", folder=tmp_path).stdout
    found = np.array(re.search(r"supports take \(([^)]*)\)", said)[1].split(", "), float)
    assert found == pytest.approx([0, 100, 0], abs=0.2)  # the facets find the hole's axis within 1e-3
    assert "face 99" in refusal("arm.step", "--h", 40, "--fix", "face:99", "--gravity", "0,-9,0", folder=tmp_path)


# ---- pictures

@slow
def test_the_sheet_shows_the_part_before_and_after_and_leaves_nothing_else(tmp_path):
    pytest.importorskip("matplotlib")
    import matplotlib.image
    words = [*LOADED, "--sheet", "bar.png"]
    run(*words, folder=tmp_path)
    one = matplotlib.image.imread(tmp_path / "bar.png")
    run(*words, "--move", 22, 0, 0, -4, folder=tmp_path)
    two = matplotlib.image.imread(tmp_path / "bar.png")
    assert two.shape[0] > 1.4 * one.shape[0]
    for picture in (one, two):
        colours = np.unique((picture[::2, ::2, :3] * 15).astype(int).reshape(-1, 3), axis=0)
        assert len(colours) > 100  # the stress's colours, not an empty page
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bar.png"]


@pytest.mark.parametrize("newton, told", [(1.9e4, False), (2.2e4, True)])
def test_displacements_that_are_not_small_are_told(newton, told, tmp_path):
    """F L^3/(3 E I) and 1 % by shear are 10 % of 200 mm at 20.8 kN, for a square of 20 mm and E = 210 GPa."""
    said = run(*BAR, "--h", 10, "--fix", "x=-100", "--force", f"x=100:0,0,-{newton:g}", folder=tmp_path).stdout
    assert ("of the part's length: the stress is that of small displacements" in said) == told


# ---- refusals

@pytest.mark.parametrize("words, expected", [
    ([*BAR, "--force", "x=100:0,0,1"], "nothing holds it"),
    ([*BAR, "--fix", "x=-100"], "carries no load"),
    ([*BAR, "--fix", "x=-100:x", "--force", "x=100:0,0,1"], "3 of its 6 rigid motions are free"),
    ([*BAR, "--fix", "x=-101", "--force", "x=100:0,0,1"], "--fix x=-101"),
    ([*LOADED, "--force", "x=100:1,2"], "2 numbers, expected 3"),
    ([*LOADED, "--force", "x=100:1,2,nan"], "nan is no number"),
    ([*LOADED, "--force", "x=100:1,2,1e300"], "1e300: expected a number within -1e15..1e15"),
    ([*LOADED, "--force", "x=100:1,2,inf"], "inf is no number"),
    ([*LOADED, "--force", "ball:1,2,3"], "expected x=LEVEL"),
    ([*LOADED, "--force", "box:1,2,3:1,2,3"], "expected 6"),
    ([*LOADED, "--force", "box:1,2,3,0,0,0:1,2,3"], "box ends before it begins"),
    ([*LOADED, "--pressure", "x=100"], "expected a pressure in Pa"),
    ([*LOADED, "--bolt", "x=100:0,0,1"], "wall of a round hole"),
    ([*LOADED, "--point", "1,2,3"], "expected X,Y,Z:FX,FY,FZ"),
    ([*LOADED, "--spring", "x=100:-5"], "0 or more N/m"),
    ([*LOADED, "--spring", "x=100:0"], "above 0"),
    ([*LOADED, "--lattice", "1", "3", "3"], "--lattice 1"),
    ([*LOADED, "--lattice", "3", "3"], "expected three whole numbers"),
    ([*LOADED, "--degree", "3", "2", "2"], "expected 1 to 2"),
    ([*LOADED, "--box", "300,0,0,310,9,9"], "no node of the mesh"),
    ([*LOADED, "--box", "-10,-12,-12,10,12,12", "--lattice", "2", "2", "2"], "no control point may move"),
    ([*LOADED, "--controls", "40"], "expected 0 to 26"),
    ([*LOADED, "--move", "99", "0", "0", "1"], "--move 99"),
    ([*LOADED, "--move", "5", "0", "0"], "--move --quiet: expected a number"),
    ([*LOADED, "--memory", "1M"], "expected at most 1 MB"),
    ([*LOADED, "--material", "wax"], "wax"),
    ([*LOADED, "-o", "/nowhere/x.npz"], "no folder /nowhere"),
    ([*LOADED, "--vtu", "a", "-o", "a"], "same file"),
    ([*LOADED, "--step", "a.step"], "--step"),
    ([*LOADED, "--modes", "3"], "unknown option --modes"),
    (["lift_arm", "--rod-width", "20"], "rod_eye width is 20 mm"),
    (["none.step", "--fix", "x=0", "--gravity", "0,0,-9"], "cannot read none.step: no such file"),
    (["none.step"], "cannot read none.step: no such file"),
])
def test_what_cannot_be_done_is_refused_in_one_sentence(words, expected, tmp_path):
    assert expected in refusal(*words, folder=tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_mesh_with_an_element_inside_out_is_refused_by_its_number(tmp_path):
    nodes = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    edges = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    points = nodes + [tuple((a + b) / 2 for a, b in zip(nodes[i], nodes[j])) for i, j in edges]
    order = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]  # two corners changed: a negative volume
    (tmp_path / "bad.inp").write_text(
        "*NODE\n" + "".join(f"{i + 1},{x},{y},{z}\n" for i, (x, y, z) in enumerate(points)) +
        "*ELEMENT,TYPE=C3D10\n1," + ",".join(str(n + 1) for n in order) + "\n")
    said = refusal("bad.inp", "--fix", "z=0", "--gravity", "0,0,-9", "--unit", "m", folder=tmp_path)
    assert "element 1" in said


# ---- the skin that is drawn

def skin_volume(table, nodes):
    a, b, c = (nodes[table["surface_triangles"][:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_the_lattice_carries_the_skin(bar):
    """B-splines on Greville abscissae reproduce every point of the box (The NURBS Book, 2.3), so the skin lies at
    the weighted control points; moved by an affine map they move it by the same map."""
    table = bar[2]
    weights, points = table["surface_weights"].astype(float), table["control_points"]
    assert np.allclose(weights @ points, table["surface_nodes"], atol=1e-8)
    stretched = points * [1.1, 0.9, 1] + [0.01, 0, 0]
    assert np.allclose(weights @ stretched, table["surface_nodes"] * [1.1, 0.9, 1] + [0.01, 0, 0], atol=1e-8)


@slow
def test_a_coarser_skin_is_closed_and_of_the_same_body(tmp_path):
    run("lift_arm", "-o", "fine.stress.npz", folder=tmp_path)
    run("lift_arm", "--skin", "20", "-o", "coarse.stress.npz", folder=tmp_path)
    fine, coarse = (np.load(tmp_path / f"{name}.stress.npz") for name in ("fine", "coarse"))
    assert len(coarse["surface_triangles"]) < 0.2 * len(fine["surface_triangles"])
    edges = np.concatenate([coarse["surface_triangles"][:, pair] for pair in ((0, 1), (1, 2), (2, 0))])
    assert set(map(tuple, edges)) == set(map(tuple, edges[:, ::-1])) and len(set(map(tuple, edges))) == len(edges)
    # No vertex is further than 0.15 of 20 mm from the new skin.
    assert skin_volume(coarse, coarse["surface_nodes"]) == pytest.approx(skin_volume(fine, fine["surface_nodes"]), rel=0.02)
    at = {tuple(node): (element, tuple(weights)) for node, element, weights in
          zip(fine["surface_nodes"], fine["surface_node_element"], fine["surface_weights"])}
    for node, element, weights in zip(coarse["surface_nodes"], coarse["surface_node_element"], coarse["surface_weights"]):
        assert at[tuple(node)] == (element, tuple(weights))
    assert np.array_equal(fine["S"], coarse["S"])
    assert "--skin" in run("lift_arm", "--skin", "-3", folder=tmp_path, expect=1).stderr


# ---- serve

class Server(serve_client.Server):
    def __init__(self, folder, table, *words):
        super().__init__(PROGRAM, folder, table, *words)

    def solve(self, parameters, method=0, derivatives=0):
        self.send(SOLVE, struct.pack("<II", method, derivatives) + np.asarray(parameters, "<f8").tobytes())
        return self.read()


def unpack(payload, elements, parameters):
    method, iterations, seconds, fraction, residual = struct.unpack_from("<IIddd", payload)
    values = np.frombuffer(payload, "<f4", offset=32 + 8 * parameters)
    return {"method": method, "iterations": iterations, "fraction": fraction, "residual": residual,
            "p": np.frombuffer(payload, "<f8", parameters, 32), "s": values[:elements],
            "shear": values[elements:2 * elements],
            "S": values[2 * elements:].reshape(-1, elements) if len(values) > 2 * elements else None}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serve")
    run(*LOADED, "--controls", "13,22", "-o", "bar.stress.npz", folder=folder)
    return folder, np.load(folder / "bar.stress.npz")


def test_a_server_solves_the_part_at_other_shapes_and_ends_with_its_stdin(served):
    folder, table = served
    elements, parameters = len(table["s0"]), len(table["parameters"])
    with Server(folder, "bar.stress.npz") as server:
        kind, ready = server.read()
        assert kind == READY and struct.unpack("<QQ", ready[:16]) == (elements, parameters)
        assert all(t > 0 for t in struct.unpack("<ddd", ready[16:]))
        kind, payload = server.solve(np.zeros(parameters))
        start = unpack(payload, elements, parameters)
        assert kind == STRESS and np.allclose(start["s"], table["s0"], rtol=1e-5, atol=1)
        p = np.zeros(parameters)
        p[5] = -4e-3  # control point 22 along z
        expected = moved(folder, (22, 0, 0, -4))
        for method in (1, 2):
            got = unpack(server.solve(p, method)[1], elements, parameters)
            assert got["method"] == method and np.array_equal(got["p"], p) and got["fraction"] == 1
            assert np.allclose(got["s"], expected, rtol=2e-5, atol=2e-5 * expected.max())
        assert got["S"] is None
        based = unpack(server.solve(p, 0, 1)[1], elements, parameters)
        assert based["S"].shape == (2 * parameters, elements)
        assert np.allclose(based["s"], expected, rtol=1e-4, atol=1e-4 * expected.max())
        assert not np.allclose(based["S"][5], table["S"][5], rtol=1e-3, atol=1e-3 * np.abs(table["S"][5]).max())
        # Bad requests are refused, and the next good one is answered.
        for payload, words in ((b"", "expected"), (struct.pack("<II", 9, 0) + p.tobytes(), "method 9"),
                               (struct.pack("<II", 0, 0) + (p * np.nan).tobytes(), "")):
            server.send(SOLVE, payload)
            kind, sentence = server.read()
            assert kind == REFUSED and words in sentence.decode()
        server.send(77)
        assert "kind 77" in server.read()[1].decode()
        kind, payload = server.solve(p, 1)
        assert kind == STRESS and np.allclose(unpack(payload, elements, parameters)["s"], expected, rtol=2e-5, atol=2e-5 * expected.max())
        server.process.stdin.close()
        assert server.process.wait(60) == 0


@slow
def test_a_server_keeps_its_factor_and_solves_as_closely_as_it_is_told(served):
    folder, table = served
    elements, parameters = len(table["s0"]), len(table["parameters"])
    p = np.zeros(parameters)
    p[[2, 5]] = -5e-3  # both points along z, a quarter of the height
    found = {}
    for tolerance in ("1e-3", "1e-10"):
        with Server(folder, "bar.stress.npz", "--tolerance", tolerance) as server:
            assert server.read()[0] == READY
            found[tolerance] = unpack(server.solve(p, 1, 2)[1], elements, parameters)
            assert found[tolerance]["method"] == 1 and found[tolerance]["residual"] <= float(tolerance)
            back = unpack(server.solve(0 * p, 1, 2)[1], elements, parameters)  # the factor's own shape
            assert back["iterations"] <= 3
    assert found["1e-10"]["iterations"] > 15 > found["1e-3"]["iterations"]
    with Server(folder, "bar.stress.npz", "--tolerance", "1e-10") as server:
        server.read()
        server.solve(p, 1)  # many iterations: a new factor, unless the client keeps the old one
        assert unpack(server.solve(-p, 1, 2)[1], elements, parameters)["iterations"] > 5
        assert unpack(server.solve(p, 1, 2)[1], elements, parameters)["iterations"] < 10  # seen before
        server.send(SOLVE, struct.pack("<II", 1, 4) + p.tobytes())
        kind, sentence = server.read()
        assert kind == REFUSED and "flags 4" in sentence.decode()
    for words in (["--tolerance"], ["--tolerance", "2"], ["--tolerance", "nan"], ["--tolerant", "1e-3"]):
        assert "tolerance" in refusal_of_serve(folder, words)


def refusal_of_serve(folder, words):
    said = run("serve", "bar.stress.npz", *words, folder=folder, expect=1).stderr.strip().splitlines()
    assert len(said) == 1
    return said[0]


@pytest.mark.parametrize("damage, words", [("magic", "begins with"), ("size", "expected at most"),
                                           ("header", "16 bytes"), ("payload", "the stream ends")])
def test_a_server_whose_stream_is_broken_says_so_and_ends(served, damage, words):
    folder, _ = served
    with Server(folder, "bar.stress.npz") as server:
        assert server.read()[0] == READY
        if damage == "magic":
            server.send(SOLVE, b"12345678", magic=5)
        elif damage == "size":
            server.send(SOLVE, size=1 << 40)
        elif damage == "header":
            server.process.stdin.write(b"TSR1abc")
        else:
            server.send(SOLVE, b"1234", size=100)
        server.process.stdin.close()
        kind, sentence = server.read()
        assert kind == REFUSED and words in sentence.decode()
        assert server.process.wait(60) == 1 and words in server.process.stderr.read().decode()


def test_a_server_ends_when_it_is_told_to_and_when_nobody_reads(served):
    folder, table = served
    with Server(folder, "bar.stress.npz") as server:
        server.read()
        server.send(QUIT)
        assert server.process.wait(60) == 0
    with Server(folder, "bar.stress.npz") as server:
        server.read()
        server.process.stdout.close()
        server.send(SOLVE, struct.pack("<II", 0, 0) + np.zeros(len(table["parameters"])).tobytes())
        assert server.process.wait(60) != 0


def test_files_that_a_server_cannot_use_are_refused(served, tmp_path):
    folder, table = served
    whole = (folder / "bar.stress.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[:len(whole) // 2])
    np.savez(tmp_path / "other.npz", meta=np.frombuffer(b'{"format": "modal-table"}', np.uint8))
    arrays = {name: table[name] for name in table.files}
    arrays["mesh"] = arrays["mesh"][:-9]
    np.savez(tmp_path / "mesh.npz", **arrays)
    meta = json.loads(bytes(table["meta"]))
    del meta["command"]
    np.savez(tmp_path / "silent.npz", **{**arrays, "meta": np.frombuffer(json.dumps(meta).encode(), np.uint8)})
    for name, words in (("cut", "cut off"), ("other", "no stress table"), ("mesh", "mesh.npz"), ("silent", "command")):
        done = run("serve", f"{name}.npz", folder=tmp_path, expect=1)
        assert words in done.stderr and len(done.stderr.splitlines()) == 1 and not done.stdout


def test_help_lists_shapes_and_options():
    done = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True)
    for word in ("lift_arm", "--bolt", "--lattice", "--move", "--sheet", "cylinder:", "serve"):
        assert word in done.stdout
