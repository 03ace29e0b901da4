"""Bodies from files as other programs write them, through modal_fem: what is repaired is said, what is
refused names file, place and remedy. What is repaired how, files_test.cpp and simplify_test.cpp hold."""
import re
from functools import partial
from pathlib import Path

import numpy as np
import program
import pytest
from program import MODAL_FEM, box, table, write_step, write_stl

run, refusal = partial(program.run, MODAL_FEM), partial(program.refusal, MODAL_FEM)


def modes(name, *words, folder):
    return table(name, "--modes", 1, "--h", 8, "--tolerance", 0, *words, folder=folder)


def mass(*sizes):
    """Of boxes of aluminium, their sides in mm."""
    return 2700e-9 * sum(np.prod(s) for s in sizes)


STEEL = 7850 / 2700  # of the mass of aluminium


def open_lid(gone):
    """36 x 36 x 6 mm, its top in squares of 3 mm, of which some are gone."""
    def square(x, y):
        p = [np.array((x + a, y + b, 6)) for a, b in ((0, 0), (3, 0), (3, 3), (0, 3))]
        return [[p[0], p[1], p[2]], [p[0], p[2], p[3]]]
    kept = [(i, j) for i in range(12) for j in range(12) if not gone(i, j)]
    return [t for t in box(size=(36, 36, 6)) if not all(p[2] == 6 for p in t)] + \
           [t for i, j in kept for t in square(3 * i, 3 * j)]


def test_a_small_hole_is_closed_and_told_a_large_one_is_refused_with_the_remedy(tmp_path):
    write_stl(tmp_path / "small.stl", open_lid(lambda i, j: (i, j) == (4, 7)))
    lid, said = modes("small.stl", folder=tmp_path)
    assert lid["mass"] == pytest.approx(mass((36, 36, 6)), rel=1e-6)
    assert "hole of 4 edges, 3 mm wide" in said and "(13.5, 22.5, 6) mm was closed" in said
    large = open_lid(lambda i, j: 2 < i < 9 and 2 < j < 9)
    bent = [[p + np.array((0, 0, 3 * (p[2] == 6 and 8 < p[0] < 28 and 8 < p[1] < 10))) for p in t] for t in large]
    write_stl(tmp_path / "bent.stl", bent)
    words = refusal("bent.stl", folder=tmp_path)
    assert words.startswith("modal_fem: bent.stl: ") and "open at triangle" in words
    assert "24 edges" in words and "mm" in words and "--shrink-wrap" in words


@pytest.mark.slow
def test_a_large_hole_is_wrapped_over(tmp_path):
    write_stl(tmp_path / "large.stl", open_lid(lambda i, j: 2 < i < 9 and 2 < j < 9))
    lid, said = modes("large.stl", "--shrink-wrap", 26, folder=tmp_path)
    assert "wrapped" in said  # the ball of 26 mm dips into the opening of 18 mm
    assert .85 * mass((36, 36, 6)) < lid["mass"] < 1.02 * mass((36, 36, 6))


def test_a_missing_bottom_is_closed_and_a_sheet_is_refused(tmp_path):
    def bottomless(size, times):
        triangles = [t for t in box(size=size) if not all(p[2] == 0 for p in t)]
        for _ in range(times):  # each in four
            corners = [[s[i], (s[i] + s[(i + 1) % 3]) / 2, (s[i] + s[(i + 2) % 3]) / 2] for s in triangles for i in range(3)]
            triangles = corners + \
                        [[(s[0] + s[1]) / 2, (s[1] + s[2]) / 2, (s[2] + s[0]) / 2] for s in triangles]
        return triangles
    write_stl(tmp_path / "box.stl", bottomless((40, 40, 12), 0))  # drawn by hand: it may be a box
    assert "open at triangle" in refusal("box.stl", folder=tmp_path)
    write_stl(tmp_path / "open.stl", bottomless((40, 40, 12), 2))
    block, said = modes("open.stl", folder=tmp_path)
    assert block["mass"] == pytest.approx(mass((40, 40, 12)), rel=1e-6)
    assert "open flat side of 16 edges" in said and "(20, 20, 0) mm" in said
    write_stl(tmp_path / "sheet.stl", bottomless((400, 400, .5), 2))
    words = refusal("sheet.stl", folder=tmp_path)
    assert "sheet" in words and "(200, 200, 0) mm" in words and "--shrink-wrap" in words


def test_overlapping_boxes_are_one_body_of_their_union(tmp_path):
    write_stl(tmp_path / "two.stl", box(size=(30, 10, 10)), box((22.3, 3.1, 4.2), (20, 20, 4)))
    both, said = modes("two.stl", folder=tmp_path)
    assert "crosses itself" in said and "rebuilt" in said
    assert both["mass"] == pytest.approx(mass((30, 10, 10), (20, 20, 4)) - mass((7.7, 6.9, 4)), rel=.01)


def test_parts_that_miss_each_other_by_rounding_are_one_body(tmp_path):
    """A gap of 5 micrometres, as programs write that compute each part for itself."""
    write_stl(tmp_path / "pair.stl", box(size=(30, 10, 10)), box((30.005, 0, 0), (30, 10, 10)))
    pair, said = table("pair.stl", "--h", 4, "--modes", 4, folder=tmp_path)
    whole, _ = table("bar", "--length", 60.005, "--width", 10, "--thickness", 10, "--h", 4, "--modes", 4, folder=tmp_path)
    assert "gaps below 0.012 mm" in said
    assert np.allclose(pair["freq"], whole["freq"], rtol=.01) and pair["mass"] == pytest.approx(whole["mass"], rel=.01)
    write_stl(tmp_path / "apart.stl", box(size=(30, 10, 10)), box((30.5, 0, 0), (30, 10, 10)))
    assert "2 separate parts" in refusal("apart.stl", folder=tmp_path)


def test_separate_solids_are_refused_by_name_taken_as_regions_by_multi_and_one_by_name_or_number(tmp_path):
    write_stl(tmp_path / "set.stl", ("gong", box(size=(30, 30, 5))), ("bar", box((50, 0, 0), (60, 8, 8))))
    words = refusal("set.stl", folder=tmp_path)
    assert "2 separate parts" in words and "gong" in words and "bar" in words and "--multi" in words
    assert "(80, 4, 4) mm" in words
    both, _ = modes("set.stl", "--multi", "--material", "gong=aluminium", "--material", "bar=steel", folder=tmp_path)
    assert both["mass"] == pytest.approx(mass((30, 30, 5)) + STEEL * mass((60, 8, 8)), rel=1e-6)
    assert modes("set.stl", "--only", 2, folder=tmp_path)[0]["mass"] == pytest.approx(mass((60, 8, 8)), rel=1e-6)
    words = refusal("set.stl", "--only", "horn", folder=tmp_path)
    assert words.startswith("modal_fem: set.stl: --only horn") and "1 gong" in words and "2 bar" in words
    assert "--multi" in refusal("set.stl", "--only", "bar", "--multi", folder=tmp_path)


def test_debris_is_left_out_and_told(tmp_path):
    write_stl(tmp_path / "scan.stl", ("bell", box(size=(30, 30, 10))), ("crumb", box((40, 0, 0), (3, 3, 3))),
              ("chip", box((0, 50, 0), (2, 2, 2))))
    bell, said = modes("scan.stl", folder=tmp_path)
    assert bell["mass"] == pytest.approx(mass((30, 30, 10)), rel=1e-6)
    assert "2 small pieces" in said and "crumb (3 mm) near (41.5, 1.5, 1.5) mm" in said and "0.39 %" in said


@pytest.mark.parametrize("n", [50, pytest.param(160, marks=pytest.mark.slow)])
def test_a_surface_of_many_triangles_is_meshed_in_few(n, tmp_path):
    """As a scanner writes a block: n x n squares on each face, 307 200 triangles at the most, binary."""
    faces, (u, v) = [], np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    for axis in range(3):
        for level in (0, 1):
            def at(du, dv):
                p = np.zeros((n * n, 3))
                p[:, axis], p[:, (axis + 1) % 3], p[:, (axis + 2) % 3] = level, (u + du).ravel() / n, (v + dv).ravel() / n
                return p * (60, 40, 20)
            a, b, c, d = at(0, 0), at(1, 0), at(1, 1), at(0, 1)
            faces += [np.stack(t if level else t[::-1], axis=1) for t in ((a, b, c), (a, c, d))]
    record = np.zeros(12 * n * n, dtype=[("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("rest", "<u2")])
    record["corner"] = np.concatenate(faces)
    head = b"solid scan".ljust(80) + np.uint32(len(record)).tobytes()
    (tmp_path / "fine.stl").write_bytes(head + record.tobytes() + b"and the rest")
    done = run("fine.stl", "--modes", 3, "--export-inp", "fine.inp", folder=tmp_path)
    assert 100 < int(re.search(r"([0-9]+) elements", done.stdout + done.stderr)[1]) < n * n


def test_touching_parts_of_a_step_file_are_one_body_with_named_regions_and_overlaps_count_once(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {30,0,0, 20,10,10};", ("handle", "blade"))
    knife, _ = modes("body.step", "--material", "handle=aluminium", "--material", "blade=steel", folder=tmp_path)
    assert knife["mass"] == pytest.approx(mass((30, 10, 10)) + STEEL * mass((20, 10, 10)), rel=1e-6)
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {20,2,3, 30,5,5};")
    assert modes("body.step", folder=tmp_path)[0]["mass"] == pytest.approx(mass((30, 10, 10), (20, 5, 5)), rel=1e-6)


def test_parts_of_a_step_file_with_a_small_gap_are_one_body(tmp_path):
    """0.03 mm on 50 mm; a tenth of a millimetre and more is a gap that was meant."""
    geometry = "Box(1) = {{0,0,0, 30,10,10}}; Box(2) = {{{x},0,0, 20,10,10}}; Line(99) = {{1, 7}};"
    write_step(tmp_path, geometry.format(x=30.03), ("handle", "blade"))
    knife, said = modes("body.step", "--material", "handle=aluminium", "--material", "blade=steel", folder=tmp_path)
    assert knife["mass"] == pytest.approx(mass((30, 10, 10)) + STEEL * mass((20, 10, 10)), rel=2e-3)
    assert "gaps below 0.05 mm" in said
    write_step(tmp_path, geometry.format(x=30.3), ("handle", "blade"))
    assert "2 separate parts" in refusal("body.step", folder=tmp_path)


def test_separate_parts_of_a_step_file_are_named_before_meshing_debris_is_left_out(tmp_path):
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {60,0,0, 20,10,10};", ("gong", "bar"))
    words = refusal("body.step", folder=tmp_path)
    assert "2 separate parts" in words and "gong (30 mm) near (15, 5, 5) mm" in words and "--multi" in words
    both, _ = modes("body.step", "--multi", "--material", "gong=aluminium", "--material", "bar=steel", folder=tmp_path)
    assert both["mass"] == pytest.approx(mass((30, 10, 10)) + STEEL * mass((20, 10, 10)), rel=1e-6)
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Box(2) = {60,0,0, 2,2,2};", ("gong", "screw"))
    gong, said = modes("body.step", folder=tmp_path)
    assert gong["mass"] == pytest.approx(mass((30, 10, 10)), rel=1e-6)
    assert "1 small pieces" in said and "screw (2 mm) near (61, 1, 1) mm" in said
    screw, _ = modes("body.step", "--only", "screw", "--h", 2, folder=tmp_path)
    assert screw["mass"] == pytest.approx(mass((2, 2, 2)), rel=1e-6)


def test_a_closed_shell_becomes_a_solid_what_is_none_is_refused_as_that(tmp_path):
    (tmp_path / "no.brep").write_text("DBRep_DrawableShape\n\nCASCADE Topology V1, (c) Matra-Datavision\nLocations 5\n")
    words = refusal("no.brep", folder=tmp_path)
    assert "no.brep" in words and ("cannot be read" in words or "no solid" in words)
    write_step(tmp_path, "Box(1) = {0,0,0, 30,10,10}; Delete { Volume{1}; }")
    bar, said = modes("body.step", folder=tmp_path)
    assert "sewn" in said and bar["mass"] == pytest.approx(mass((30, 10, 10)), rel=1e-6)
    write_step(tmp_path, "Rectangle(1) = {0,0,0, 30,10};")
    words = refusal("body.step", folder=tmp_path)
    assert "1 faces that enclose no volume" in words and "mm" in words and "--shrink-wrap" in words


@pytest.mark.slow
def test_a_body_whose_curved_elements_cannot_be_mended_gets_straight_ones(tmp_path):
    """gmsh throws while it optimises the curved sides of this part of Open CASCADE's own examples."""
    part = Path("/usr/share/opencascade/data/occ/MODERN_Exhaust_1.brep")
    if not part.exists():
        pytest.skip("Open CASCADE's example data (occt-misc) is not installed")
    # 2 % refines it once, straight.
    assert table(part, "--modes", 3, "--tolerance", 2, folder=tmp_path)[0]["freq"][0] > 100


@pytest.mark.slow
def test_small_fillets_do_not_take_minutes(tmp_path):
    """Fillets a fifth of an element turn curved sides inside out, which gmsh's own repair takes minutes for."""
    write_step(tmp_path, "Box(1) = {0,0,0, 60,40,8}; f[] = Fillet{1}{1:12}{0.4};")
    done = run("body.step", "--modes", 5, "--export-inp", "out.inp", folder=tmp_path)
    assert int(re.search(r"([0-9]+) elements", done.stdout + done.stderr)[1]) < 30000
