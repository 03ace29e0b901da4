"""part_stress --engine petsc against the direct solver. Skipped where this build has no PETSc: ./test must not
need MPI, which is large, and the program is the same without it."""
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from test_part_stress import BAR, LOADED, PROGRAM, read_vtu

SOLVER = os.path.join(os.path.dirname(PROGRAM), "petsc_solve")
built = os.path.exists(SOLVER) and shutil.which("mpirun")
needs_petsc = pytest.mark.skipif(not built, reason="built without Debian's libpetsc-real-dev, or no openmpi-bin")
PETSC = ["--engine", "petsc"]


def run(*words, folder, expect=0, program=PROGRAM, **extra):
    environment = {**os.environ, "TMPDIR": str(folder), **extra}
    done = subprocess.run([program, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=280,
                          env=environment)
    assert done.returncode == expect, done.stderr
    return done


def refusal(*words, folder, **extra):
    said = run(*words, "--quiet", folder=folder, expect=1, **extra).stderr.strip().splitlines()
    assert len(said) == 1 and said[0].startswith("part_stress: "), said
    return said[0]


BODIES = {
    "beam of hex20, moved": [*LOADED, "--lattice", 3, 3, 3, "--move", 22, 0, 0, -4],
    "beam on springs": [*BAR, "--h", 10, "--fix", "x=-100:x", "--spring", "z=-10:1e6", "--force", "x=100:0,0,-100"],
    "under gravity, held in one direction at the end": [
        *BAR, "--h", 10, "--fix", "x=-100", "--fix", "x=100:y", "--gravity", "0,5,-9.81"],
}


@needs_petsc
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_petsc_gives_the_displacement_and_stress_of_the_factor(body, ranks, tmp_path):
    own_says = run(*body, "--vtu", "own.vtu", folder=tmp_path).stdout
    done = run(*body, *PETSC, "--ranks", ranks, "--vtu", "petsc.vtu", folder=tmp_path)
    own, other = (read_vtu(tmp_path / f"{name}.vtu") for name in ("own", "petsc"))
    # The file has seven digits: the last one of the largest value may round the other way.
    assert np.array_equal(own["points"], other["points"])
    for name in own:
        if "displacement" in str(name) or "Pa" in str(name):
            assert np.abs(own[name] - other[name]).max() < 1.1e-6 * np.abs(own[name]).max(), name
    moves = 2 if "--move" in body else 1
    reports = re.findall(r"PETSc: (\d+) iterations to (\S+); (\d+) process(?:es)?: (.*)", done.stderr)
    assert len(reports) == moves and ("after" in done.stdout) == (moves == 2)
    for iterations, residual, count, processes in reports:
        assert 2 < int(iterations) < 300 and float(residual) <= 1e-8 and int(count) == ranks
        each = re.findall(r"([\d.]+) MB and (\S+) s", processes)
        assert len(each) == ranks and all(10 < float(mb) < 2000 and float(s) > 0 for mb, s in each)
    assert "PETSc: conjugate gradients" in done.stderr
    for line in ("before", "after")[:moves]:
        peaks = [re.search(line + r" +von Mises: largest (\S+) MPa", text)[1] for text in (own_says, done.stdout)]
        assert peaks[0] == peaks[1]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["own.vtu", "petsc.vtu"]


@needs_petsc
def test_a_solver_that_does_not_converge_is_one_sentence_and_leaves_nothing(tmp_path):
    said = refusal(*LOADED, *PETSC, folder=tmp_path, PETSC_OPTIONS="-ksp_max_it 3")
    assert "conjugate gradients ended at a residual of" in said and "3 iterations" in said
    said = refusal(*LOADED, *PETSC, folder=tmp_path, PETSC_OPTIONS="-pc_type nonsense")
    assert "--engine petsc failed: PETSc failed" in said
    # An answer that is none is found out here.
    said = refusal(*LOADED, *PETSC, folder=tmp_path, PETSC_OPTIONS="-ksp_rtol 1e-3")
    assert "leaves a residual of" in said
    assert not list(tmp_path.iterdir())


@needs_petsc
def test_a_process_that_dies_ends_the_run_in_one_sentence(tmp_path):
    folder = tmp_path / "bin"
    folder.mkdir()
    program = shutil.copy(PROGRAM, folder / "part_stress")
    (folder / "petsc_solve").write_text('#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK" = 1 ] && kill -9 $$\nexec sleep 120\n')
    (folder / "petsc_solve").chmod(0o755)
    said = refusal(*LOADED, *PETSC, "--ranks", 2, folder=tmp_path, program=program)
    assert "--engine petsc failed: " in said and ("signal 9" in said or "exit code" in said)  # as mpirun noticed
    # One that ends well and writes nothing is no solution either.
    (folder / "petsc_solve").write_text("#!/bin/sh\nexit 0\n")
    assert "solution" in refusal(*LOADED, *PETSC, "--ranks", 2, folder=tmp_path, program=program)
    assert [p.name for p in tmp_path.iterdir()] == ["bin"]


def test_a_missing_engine_names_the_packages(tmp_path):
    folder = tmp_path / "bin"
    folder.mkdir()
    program = shutil.copy(PROGRAM, folder / "part_stress")
    assert "libpetsc-real-dev" in refusal(*LOADED, *PETSC, folder=tmp_path, program=program)
    (folder / "petsc_solve").write_text("#!/bin/sh\n")
    (folder / "petsc_solve").chmod(0o755)
    assert "openmpi-bin" in refusal(*LOADED, *PETSC, folder=tmp_path, program=program, PATH=str(tmp_path))


def test_what_makes_no_sense_is_refused_before_work(tmp_path):
    for words, expected in [(["--ranks", 2], "--engine petsc"), (["--engine", "slepc"], "cholmod or petsc"),
                            ([*PETSC, "--ranks", 0], "1 to 4096"), ([*PETSC, "--ranks", 5000], "1 to 4096"),
                            ([*PETSC, "-o", "t.stress.npz"], "derivatives")]:
        assert expected in refusal(*LOADED, *words, folder=tmp_path)


def test_a_large_part_is_refused_before_meshing_with_what_would_fit(tmp_path):
    large = [*BAR, "--h", 1.5, "--fix", "x=-100", "--force", "x=100:0,0,-100", "--memory", "300M"]
    said = refusal(*large, folder=tmp_path)
    unknowns, need = re.search(r"with (\d+) unknowns would take ([\d.]+) GB, expected at most 300 MB", said).groups()
    assert int(unknowns) > 2e5 and float(need) > 1 and "take --h" in said and "--engine petsc" in said
    assert "--engine petsc" not in refusal(*large, "-o", "t.stress.npz", folder=tmp_path)


@needs_petsc
def test_more_processes_than_there_is_work_for_are_refused(tmp_path):
    said = refusal(*LOADED, *PETSC, "--ranks", 40, folder=tmp_path)
    assert re.search(r"--ranks 40: expected at most \d+ processes for \d+ nodes", said)
