"""Bodies from files as other programs write them, through modal_fem: what is repaired is said, what is
refused names file, place and remedy."""
import os
import re
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

MODAL_FEM = os.environ["MODAL_FEM"]
QUICK = bool(os.environ.get("TACTUS_QUICK"))  # under sanitizers: what is read counts, not what is solved
slow = pytest.mark.skipif(QUICK, reason="slow")


def run(*words, folder, expect=0):
    done = subprocess.run([MODAL_FEM, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == expect, done.stdout + done.stderr
    return done


def refusal(*words, folder):
    return run(*words, folder=folder, expect=1).stderr.strip().splitlines()[-1]


def box(low=(0, 0, 0), size=(10, 10, 10)):
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]) * np.array(size) + np.array(low)
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
             (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
    return [[corners[i] for i in face] for face in faces]


def write_stl(path, solids, head="solid", line="\n"):
    with open(path, "w", newline="") as file:
        for name, triangles in solids.items():
            file.write(f"{head} {name}{line}")
            for t in triangles:
                file.write(f"facet normal 0 0 0{line}outer loop{line}")
                for p in t:
                    file.write("vertex " + " ".join(f"{x:.17g}" for x in p) + line)
                file.write(f"endloop{line}endfacet{line}")
            file.write(f"end{head.strip()} {name}{line}")


def modes(name, *words, folder):
    count, h = (1, 8) if QUICK else (4, 4)
    done = run(name, "--modes", count, "--h", h, "-o", "out.modal.npz", *words, folder=folder)
    return np.load(folder / "out.modal.npz"), done.stdout + done.stderr


def mass(*sizes):
    return 2700e-9 * sum(np.prod(s) for s in sizes)


def test_zeros_that_differ_by_rounding_close_a_surface(tmp_path):
    """The corner of one triangle is 0, of the next -5.7e-17."""
    cube = [[[x if x else (-5.7e-17 if i % 2 else 3e-16) for x in p] for p in t] for i, t in enumerate(box())]
    write_stl(tmp_path / "cube.stl", {"cube": cube})
    table, _ = modes("cube.stl", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((10, 10, 10)), rel=1e-6)


def test_capitals_blanks_marks_and_line_ends_do_not_matter(tmp_path):
    write_stl(tmp_path / "loud.stl", {"PART": box()}, head="  SOLID", line="\r\n")
    text = (tmp_path / "loud.stl").read_text().upper()
    (tmp_path / "loud.stl").write_bytes(b"\xef\xbb\xbf" + text.encode())
    table, _ = modes("loud.stl", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((10, 10, 10)), rel=1e-6)


def test_a_binary_file_may_begin_with_solid_and_end_with_more(tmp_path):
    with open(tmp_path / "b.stl", "wb") as file:
        file.write(b"solid facet".ljust(80) + struct.pack("<I", 12))
        for t in box():
            file.write(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), 0))
        file.write(b"and the rest")
    table, _ = modes("b.stl", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((10, 10, 10)), rel=1e-6)


def test_a_small_hole_is_closed_and_told_a_large_one_is_refused_with_the_remedy(tmp_path):
    n = 12
    grid = [[(i, j) for j in range(n)] for i in range(n)]
    size = 36 / n
    triangles = [t for t in box(size=(36, 36, 6)) if not all(p[2] == 6 for p in t)]
    top = []
    for i, j in (c for row in grid for c in row):
        p = np.array([(i * size, j * size, 6), ((i + 1) * size, j * size, 6),
                      ((i + 1) * size, (j + 1) * size, 6), (i * size, (j + 1) * size, 6)])
        top.append(((i, j), [[p[0], p[1], p[2]], [p[0], p[2], p[3]]]))
    small = triangles + [t for cell, pair in top if cell != (4, 7) for t in pair]
    large = triangles + [t for (i, j), pair in top if not (2 < i < 9 and 2 < j < 9) for t in pair]
    write_stl(tmp_path / "small.stl", {"lid": small})
    table, said = modes("small.stl", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((36, 36, 6)), rel=1e-6)
    assert "hole of 4 edges, 3 mm wide" in said and "(13.5, 22.5, 6) mm was closed" in said
    write_stl(tmp_path / "large.stl", {"lid": large})
    bent = [[p + np.array((0, 0, 3 * (p[2] == 6 and 8 < p[0] < 28 and 8 < p[1] < 10))) for p in t] for t in large]
    write_stl(tmp_path / "bent.stl", {"lid": bent})
    words = refusal("bent.stl", folder=tmp_path)
    assert words.startswith("modal_fem: bent.stl: ") and "open at triangle" in words
    assert "24 edges" in words and "mm" in words and "--shrink-wrap" in words
    table, said = modes("large.stl", "--shrink-wrap", 26, folder=tmp_path)
    assert "wrapped" in said  # the ball of 26 mm dips into the opening of 18 mm
    assert .85 * mass((36, 36, 6)) < table["mass"] < 1.02 * mass((36, 36, 6))


def test_overlapping_boxes_are_one_body_of_their_union(tmp_path):
    write_stl(tmp_path / "two.stl", {"a": box(size=(30, 10, 10)), "b": box((22.3, 3.1, 4.2), (20, 20, 4))})
    table, said = modes("two.stl", folder=tmp_path)
    assert "crosses itself" in said and "taken anew" in said
    assert table["mass"] == pytest.approx(mass((30, 10, 10), (20, 20, 4)) - mass((7.7, 6.9, 4)), rel=.01)


@slow
def test_touching_boxes_are_one_body_and_ring_as_such(tmp_path):
    write_stl(tmp_path / "glued.stl", {"a": box(size=(30, 10, 10)), "b": box((30, 0, 0), (30, 10, 10))})
    write_stl(tmp_path / "whole.stl", {"a": box(size=(60, 10, 10))})
    glued, _ = modes("glued.stl", folder=tmp_path)
    whole, _ = modes("whole.stl", folder=tmp_path)
    assert glued["mass"] == pytest.approx(whole["mass"], rel=2e-3)
    assert np.allclose(glued["freq"], whole["freq"], rtol=.01)


def test_separate_solids_are_refused_by_name_and_taken_as_regions_by_multi(tmp_path):
    write_stl(tmp_path / "set.stl", {"gong": box(size=(30, 30, 5)), "bar": box((50, 0, 0), (60, 8, 8))})
    words = refusal("set.stl", folder=tmp_path)
    assert "2 separate parts" in words and "gong" in words and "bar" in words and "--multi" in words
    assert "(80, 4, 4) mm" in words
    table, _ = modes("set.stl", "--multi", "--material", "bar=steel", folder=tmp_path)
    steel = 7850 / 2700
    assert table["mass"] == pytest.approx(mass((30, 30, 5)) + steel * mass((60, 8, 8)), rel=1e-6)


def test_one_of_several_solids_is_taken_by_name_or_number(tmp_path):
    write_stl(tmp_path / "set.stl", {"gong": box(size=(30, 30, 5)), "bar": box((50, 0, 0), (60, 8, 8))})
    for part in ("bar", 2):
        table, _ = modes("set.stl", "--only", part, folder=tmp_path)
        assert table["mass"] == pytest.approx(mass((60, 8, 8)), rel=1e-6)
    words = refusal("set.stl", "--only", "horn", folder=tmp_path)
    assert words.startswith("modal_fem: set.stl: --only horn") and "1 gong" in words and "2 bar" in words
    assert "--multi" in refusal("set.stl", "--only", "bar", "--multi", folder=tmp_path)


def test_debris_is_left_out_and_told(tmp_path):
    scan = {"bell": box(size=(30, 30, 10)), "crumb": box((40, 0, 0), (3, 3, 3)), "chip": box((0, 50, 0), (2, 2, 2))}
    write_stl(tmp_path / "scan.stl", scan)
    table, said = modes("scan.stl", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 30, 10)), rel=1e-6)
    assert "2 small pieces" in said and "crumb (3 mm) near (41.5, 1.5, 1.5) mm" in said
    assert "0.39 %" in said


def test_parts_that_miss_each_other_by_rounding_are_one_body(tmp_path):
    """A gap of 5 micrometres, as programs write that compute each part for itself."""
    write_stl(tmp_path / "pair.stl", {"a": box(size=(30, 10, 10)), "b": box((30.005, 0, 0), (30, 10, 10))})
    write_stl(tmp_path / "whole.stl", {"a": box(size=(60.005, 10, 10))})
    pair, said = modes("pair.stl", folder=tmp_path)
    whole, _ = modes("whole.stl", folder=tmp_path)
    assert "gaps below 0.012 mm" in said
    assert np.allclose(pair["freq"], whole["freq"], rtol=.01)
    assert pair["mass"] == pytest.approx(whole["mass"], rel=.01)
    write_stl(tmp_path / "apart.stl", {"a": box(size=(30, 10, 10)), "b": box((30.5, 0, 0), (30, 10, 10))})
    assert "2 separate parts" in refusal("apart.stl", folder=tmp_path)


def in_four(triangles):
    return [[s[i], (s[i] + s[(i + 1) % 3]) / 2, (s[i] + s[(i + 2) % 3]) / 2] for s in triangles for i in range(3)] + \
           [[(s[0] + s[1]) / 2, (s[1] + s[2]) / 2, (s[2] + s[0]) / 2] for s in triangles]


def test_a_missing_bottom_is_closed_and_a_sheet_is_refused(tmp_path):
    coarse = [t for t in box(size=(40, 40, 12)) if not all(p[2] == 0 for p in t)]
    write_stl(tmp_path / "box.stl", {"block": coarse})  # drawn by hand: it may be a box
    assert "open at triangle" in refusal("box.stl", folder=tmp_path)
    bottomless = in_four(in_four(coarse))
    write_stl(tmp_path / "open.stl", {"block": bottomless})
    table, said = modes("open.stl", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((40, 40, 12)), rel=1e-6)
    assert "open flat side of 16 edges" in said and "(20, 20, 0) mm" in said
    lid = [t for t in box(size=(400, 400, .5)) if not all(p[2] == 0 for p in t)]
    write_stl(tmp_path / "sheet.stl", {"lid": in_four(in_four(lid))})
    words = refusal("sheet.stl", folder=tmp_path)
    assert "sheet" in words and "(200, 200, 0) mm" in words and "--shrink-wrap" in words


@slow
def test_a_surface_of_300_000_triangles_is_meshed_in_few(tmp_path):
    """As a scanner writes a block: 160 x 160 squares on each face, binary."""
    n, faces = 160, []
    for axis in range(3):
        for level in (0, 1):
            u, v = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
            def at(du, dv):
                p = np.zeros((n * n, 3))
                p[:, axis], p[:, (axis + 1) % 3], p[:, (axis + 2) % 3] = level, (u + du).ravel() / n, (v + dv).ravel() / n
                return p * (60, 40, 20)
            a, b, c, d = at(0, 0), at(1, 0), at(1, 1), at(0, 1)
            for t in ((a, b, c), (a, c, d)):
                faces.append(np.stack(t if level else t[::-1], axis=1))
    corners = np.concatenate(faces)
    record = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("rest", "<u2")])
    record["corner"] = corners
    (tmp_path / "fine.stl").write_bytes(b"scan".ljust(80) + struct.pack("<I", len(record)) + record.tobytes())
    assert len(record) == 307200
    done = run("fine.stl", "--modes", 3, "--export-inp", "fine.inp", folder=tmp_path)
    elements = int(re.search(r"([0-9]+) elements", done.stdout + done.stderr)[1])
    assert 100 < elements < 20000


def test_a_body_in_the_cavity_of_another_is_a_body(tmp_path):
    rattle = box((-20, -20, -20), (40, 40, 40)) + box((-15, -15, -15), (30, 30, 30)) + box((-5, -5, -5))
    write_stl(tmp_path / "rattle.stl", {"rattle": rattle})
    assert "2 separate parts" in refusal("rattle.stl", folder=tmp_path)
    table, _ = modes("rattle.stl", "--multi", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((40, 40, 40), (10, 10, 10)) - mass((30, 30, 30)), rel=1e-6)


def test_concave_polygons_and_object_names_of_an_obj(tmp_path):
    outline = [(0, 0), (30, 0), (30, 20), (20, 20), (20, 8), (10, 8), (10, 20), (0, 20)]  # a U
    n = len(outline)
    with open(tmp_path / "u.obj", "w") as file:
        for z in (0, 6):
            file.writelines(f"v {x} {y} {z}\n" for x, y in outline)
        file.write("o fork\nf " + " ".join(str(n - i) for i in range(n)) + "\n")
        file.write("f " + " ".join(str(i - n) for i in range(n)) + "\n")
        for i in range(n):
            j = (i + 1) % n
            file.write(f"f {i + 1}/1 {j + 1}/2 {j + 1 + n}//3 {i + 1 + n}\n")
    table, _ = modes("u.obj", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 20, 6)) - mass((10, 12, 6)), rel=1e-6)


def test_free_form_and_lines_are_refused_by_name(tmp_path):
    (tmp_path / "lines.obj").write_text("v 0 0 0\nv 1 0 0\nl 1 2\n")
    assert "1 lines" in refusal("lines.obj", folder=tmp_path)
    (tmp_path / "form.obj").write_text("v 0 0 0\nv 1 0 0\ncstype bezier\nsurf 0 1 0 1 1 2\n")
    assert "line 3" in refusal("form.obj", folder=tmp_path) and "cstype" in refusal("form.obj", folder=tmp_path)


def test_a_scan_full_of_cracks_is_wrapped(tmp_path):
    random = np.random.default_rng(3)
    rings, triangles = 24, []
    def at(i, j):
        a, b = np.pi * i / rings, np.pi * j / rings
        return 25 * np.array((np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)))
    for i in range(rings):
        for j in range(2 * rings):
            for t in ([at(i, j), at(i + 1, j), at(i, j + 1)], [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]):
                triangles.append([p + d for p, d in zip(t, [random.uniform(-.03, .03, 3)] * 3)])
    write_stl(tmp_path / "scan.stl", {"scan": triangles})
    assert "--shrink-wrap" in refusal("scan.stl", folder=tmp_path)
    done = run("scan.stl", "--shrink-wrap", 4, "--h", 8, "--export-inp", "scan.inp", folder=tmp_path)
    cubic_centimetres = float((done.stdout + done.stderr).split("volume ")[1].split()[0])
    assert cubic_centimetres == pytest.approx(4 / 3 * np.pi * 2.5**3, rel=.03)
    assert (tmp_path / "scan.inp").stat().st_size > 1e5


def write_step(folder, geometry, rename=()):
    """body.step by gmsh's own kernel, in millimetres; products renamed in their order."""
    if not shutil.which("gmsh"):
        pytest.skip("gmsh's program is not installed")
    (folder / "body.geo").write_text(f'SetFactory("OpenCASCADE");\n{geometry}\nSave "body.step";\n')
    subprocess.run(["gmsh", "-0", "body.geo"], cwd=folder, check=True, capture_output=True)
    text = (folder / "body.step").read_text()
    for k, name in enumerate(rename, 1):
        text, count = re.subn(rf"'Open CASCADE STEP translator [0-9.]+ 1\.{k}'", f"'{name}'", text)
        assert count
    (folder / "body.step").write_text(text)


def test_touching_parts_of_a_step_file_are_one_body_with_named_regions(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {30,0,0, 20,10,10};", ("handle", "blade"))
    table, _ = modes("body.step", "--material", "blade=steel", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 10, 10)) + 7850 / 2700 * mass((20, 10, 10)), rel=1e-6)


def test_overlapping_parts_of_a_step_file_count_once(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {20,2,3, 30,5,5};")
    table, _ = modes("body.step", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 10, 10), (20, 5, 5)), rel=1e-6)


def test_separate_parts_of_a_step_file_are_named_before_meshing(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {60,0,0, 20,10,10};", ("gong", "bar"))
    words = refusal("body.step", folder=tmp_path)
    assert "2 separate parts" in words and "gong (30 mm) near (15, 5, 5) mm" in words and "--multi" in words
    table, _ = modes("body.step", "--multi", "--material", "bar=steel", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 10, 10)) + 7850 / 2700 * mass((20, 10, 10)), rel=1e-6)


def test_a_closed_shell_becomes_a_solid_a_sheet_is_refused_as_one(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Delete { Volume{1}; }")
    table, said = modes("body.step", folder=tmp_path)
    assert "sewn" in said and table["mass"] == pytest.approx(mass((30, 10, 10)), rel=1e-6)
    write_step(tmp_path, "Rectangle(1) = {0,0,0, 30,10};")
    words = refusal("body.step", folder=tmp_path)
    assert "1 faces that close no body" in words and "mm" in words and "--shrink-wrap" in words


def test_a_body_whose_curved_elements_cannot_be_mended_gets_straight_ones(tmp_path):
    """gmsh throws while it optimises the curved sides of this part of Open CASCADE's own examples."""
    part = Path("/usr/share/opencascade/data/occ/MODERN_Exhaust_1.brep")
    if not part.exists():
        pytest.skip("Open CASCADE's example data (occt-misc) is not installed")
    # 2 % refines it once, straight.
    tolerance = 30 if QUICK else 2
    run(part, "--modes", 3, "--tolerance", tolerance, "-o", "out.modal.npz", folder=tmp_path)
    assert np.load(tmp_path / "out.modal.npz")["freq"][0] > 100


def test_a_file_the_cad_kernel_cannot_read_is_said_to_be_that(tmp_path):
    (tmp_path / "no.brep").write_text("DBRep_DrawableShape\n\nCASCADE Topology V1, (c) Matra-Datavision\nLocations 5\n")
    words = refusal("no.brep", folder=tmp_path)
    assert "no.brep" in words and ("cannot be read" in words or "no solid" in words)


def test_debris_of_a_step_file_is_left_out_and_one_part_can_be_taken(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {60,0,0, 2,2,2};", ("gong", "screw"))
    table, said = modes("body.step", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 10, 10)), rel=1e-6)
    assert "1 small pieces" in said and "screw (2 mm) near (61, 1, 1) mm" in said
    table, _ = modes("body.step", "--only", "screw", "--h", 2, folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((2, 2, 2)), rel=1e-6)


def test_parts_of_a_step_file_with_a_small_gap_are_one_body(tmp_path):
    """0.03 mm on 50 mm; a tenth of a millimetre and more is a gap that was meant."""
    geometry = "Box(1) = {{0,0,0, 30,10,10}}; Box(2) = {{{x},0,0, 20,10,10}}; Line(99) = {{1, 7}};"
    write_step(tmp_path, geometry.format(x=30.03), ("handle", "blade"))
    table, said = modes("body.step", "--material", "blade=steel", folder=tmp_path)
    assert table["mass"] == pytest.approx(mass((30, 10, 10)) + 7850 / 2700 * mass((20, 10, 10)), rel=2e-3)
    assert "gaps below 0.05 mm" in said
    write_step(tmp_path, geometry.format(x=30.3), ("handle", "blade"))
    assert "2 separate parts" in refusal("body.step", folder=tmp_path)


@slow
def test_small_fillets_do_not_take_minutes(tmp_path):
    """Fillets a fifth of an element turn curved sides inside out, which gmsh's own repair takes minutes for."""
    write_step(tmp_path, "Box(1) = {0,0,0, 60,40,8}; f[] = Fillet{1}{1:12}{0.4};")
    done = run("body.step", "--modes", 5, "--export-inp", "out.inp", folder=tmp_path)
    elements = int(re.search(r"([0-9]+) elements", done.stdout + done.stderr)[1])
    assert elements < 30000
