"""part_stress --engine petsc against the direct solver. Skipped where this build has no PETSc: ./test must not
need MPI, which is large, and the program is the same without it."""
import os
import re
import shutil

import numpy as np
import program
import pytest
from program import PART_STRESS
from test_part_stress import BAR, LOADED, read_vtu

built = os.path.exists(os.path.join(os.path.dirname(PART_STRESS), "petsc_solve")) and shutil.which("mpirun")
needs_petsc = pytest.mark.skipif(not built, reason="built without Debian's libpetsc-real-dev, or no openmpi-bin")
PETSC = ["--engine", "petsc"]


def refusal(*words, folder, part_stress=PART_STRESS, **extra):
    environment = {**os.environ, "TMPDIR": str(folder), **extra}
    return program.refusal(part_stress, *words, "--quiet", folder=folder, env=environment)


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
    own_says = program.run(PART_STRESS, *body, "--vtu", "own.vtu", folder=tmp_path).stdout
    done = program.run(PART_STRESS, *body, *PETSC, "--ranks", ranks, "--vtu", "petsc.vtu", folder=tmp_path,
                       env={**os.environ, "TMPDIR": str(tmp_path)})
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
@pytest.mark.parametrize("options, sentences", [
    ("-ksp_max_it 3", ["conjugate gradients ended at a residual of", "3 iterations"]),
    ("-pc_type nonsense", ["--engine petsc failed: PETSc failed"]),
    ("-ksp_rtol 1e-3", ["has a residual of"])])  # an answer that is none is found out here
def test_a_solver_that_does_not_converge_is_one_sentence_and_leaves_nothing(options, sentences, tmp_path):
    said = refusal(*LOADED, *PETSC, folder=tmp_path, PETSC_OPTIONS=options)
    assert all(words in said for words in sentences), said
    assert not list(tmp_path.iterdir())


@pytest.fixture
def copied(tmp_path):
    """The program in a folder of its own, and what makes a script of these words its solver."""
    (tmp_path / "bin").mkdir()
    def solver(script):
        (tmp_path / "bin/petsc_solve").write_text("#!/bin/sh\n" + script)
        (tmp_path / "bin/petsc_solve").chmod(0o755)
    return shutil.copy(PART_STRESS, tmp_path / "bin/part_stress"), solver


@needs_petsc
def test_a_process_that_dies_ends_the_run_in_one_sentence(copied, tmp_path):
    part_stress, solver = copied
    solver('[ "$OMPI_COMM_WORLD_RANK" = 1 ] && kill -9 $$\nexec sleep 120\n')
    said = refusal(*LOADED, *PETSC, "--ranks", 2, folder=tmp_path, part_stress=part_stress)
    assert "--engine petsc failed: " in said and ("signal 9" in said or "exit code" in said)  # as mpirun noticed
    solver("exit 0\n")  # one that ends well and writes nothing is no solution either
    assert "solution" in refusal(*LOADED, *PETSC, "--ranks", 2, folder=tmp_path, part_stress=part_stress)
    assert [p.name for p in tmp_path.iterdir()] == ["bin"]


def test_a_missing_engine_names_the_packages(copied, tmp_path):
    part_stress, solver = copied
    assert "libpetsc-real-dev" in refusal(*LOADED, *PETSC, folder=tmp_path, part_stress=part_stress)
    solver("")
    assert "openmpi-bin" in refusal(*LOADED, *PETSC, folder=tmp_path, part_stress=part_stress, PATH=str(tmp_path))


def test_what_makes_no_sense_is_refused_before_work_a_large_part_with_what_would_fit(tmp_path):
    for words, expected in [(["--ranks", 2], "--engine petsc"), (["--engine", "slepc"], "cholmod or petsc"),
                            ([*PETSC, "--ranks", 0], "1..4096"), ([*PETSC, "--ranks", 5000], "1..4096"),
                            ([*PETSC, "-o", "t.stress.npz"], "derivatives")]:
        assert expected in refusal(*LOADED, *words, folder=tmp_path)
    large = [*BAR, "--h", 1.5, "--fix", "x=-100", "--force", "x=100:0,0,-100", "--memory", "300M"]
    said = refusal(*large, folder=tmp_path)
    unknowns, need = re.search(r"with (\d+) unknowns would take ([\d.]+) GB, expected at most 300 MB", said).groups()
    assert int(unknowns) > 2e5 and float(need) > 1 and "use --h" in said and "--engine petsc" in said
    assert "--engine petsc" not in refusal(*large, "-o", "t.stress.npz", folder=tmp_path)


@needs_petsc
def test_more_processes_than_there_is_work_for_are_refused(tmp_path):
    said = refusal(*LOADED, *PETSC, "--ranks", 40, folder=tmp_path)
    assert re.search(r"--ranks 40: expected at most \d+ processes for \d+ nodes", said)
