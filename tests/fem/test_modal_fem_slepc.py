"""modal_fem --engine slepc. Skipped where this build has no SLEPc: ./test must not need MPI, which is
large, and the program is the same without it."""
import json
import os
import shutil
import subprocess

import numpy as np
import pytest

PROGRAM = os.environ["MODAL_FEM"]
SOLVER = os.path.join(os.path.dirname(PROGRAM), "slepc_solve")
built = os.path.exists(SOLVER) and shutil.which("mpirun")
needs_slepc = pytest.mark.skipif(not built, reason="built without Debian's libslepc-real-dev, or no openmpi-bin")


def run(*words, folder, expect=0, **extra):
    environment = {**os.environ, "TMPDIR": str(folder), **extra}
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=280,
                          env=environment)
    assert done.returncode == expect, done.stderr
    return done


BODIES = {
    "free disk": ["disk", "--diameter", 100, "--thickness", 12, "--h", 20, "--modes", 12],
    "clamped disk": ["disk", "--diameter", 100, "--thickness", 12, "--h", 25, "--modes", 6, "--fix", "0,0,-6,12"],
    "hinged plate": ["plate", "--length", 60, "--width", 40, "--thickness", 4, "--h", 20, "--modes", 6, "--fix", "x=-30:xz"],
    "ball of fivefold modes": ["sphere", "--diameter", 100, "--h", 25, "--modes", 11],
}


@needs_slepc
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_slepc_gives_the_same_modes(body, ranks, tmp_path):
    run(*body, "-o", "own.modal.npz", folder=tmp_path)
    said = run(*body, "--engine", "slepc", "--ranks", ranks, "-o", "slepc.modal.npz", folder=tmp_path).stderr
    own, other = (np.load(tmp_path / f"{name}.modal.npz") for name in ("own", "slepc"))
    assert len(own["freq"]) == len(other["freq"]) == body[body.index("--modes") + 1]
    assert np.allclose(own["freq"], other["freq"], rtol=1e-8)
    assert np.array_equal(own["mult"], other["mult"]) and np.allclose(own["eta"], other["eta"])
    # Turned shapes of groups agree too, but for signs and turns that a group's rounding decides.
    single = own["mult"] == 1
    for a, b in zip(own["phi"][single], other["phi"][single]):
        assert min(np.abs(a - b).max(), np.abs(a + b).max()) < 1e-4 * np.abs(a).max()
    # The estimate is of the mesh and its modes, whoever found them.
    estimates = [json.loads(bytes(t["meta"]))["accuracy"]["est_rel_error"] for t in (own, other)]
    assert len(estimates[1]) == len(own["freq"]) and np.allclose(*estimates, rtol=.02)
    assert f"{ranks} processes, at most" in said and "SLEPc: finding modes" in said
    assert sorted(p.name for p in tmp_path.iterdir()) == ["own.modal.npz", "slepc.modal.npz"]


@needs_slepc
def test_errors_are_not_estimated_where_the_factor_has_no_room_and_that_is_said(tmp_path):
    body = ["plate", "--length", 60, "--width", 60, "--thickness", 60, "--h", 6, "--modes", 4, "-o", "t.modal.npz"]
    assert "the factor would take" in run(*body, "--memory", "110M", folder=tmp_path, expect=1).stderr
    said = run(*body, "--memory", "110M", "--engine", "slepc", "--ranks", 1, folder=tmp_path).stderr
    assert "warning: the errors are not estimated: they need the factor here, which would take" in said
    assert json.loads(bytes(np.load(tmp_path / "t.modal.npz")["meta"]))["accuracy"]["est_rel_error"] == []


@needs_slepc
def test_a_failing_solver_is_one_sentence_and_leaves_nothing(tmp_path):
    done = run(*BODIES["free disk"], "--engine", "slepc", "-o", "t.modal.npz", folder=tmp_path, expect=1,
               PETSC_OPTIONS="-eps_max_it 1 -eps_ncv 30 -eps_tol 1e-30")
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("modal_fem: --engine slepc failed: ") and "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_missing_engine_names_the_packages(tmp_path):
    alone = tmp_path / "bin"
    alone.mkdir()
    program = shutil.copy(PROGRAM, alone / "modal_fem")
    done = subprocess.run([program, "disk", "--diameter", "100", "--thickness", "12", "--h", "1", "--engine", "slepc"],
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "libslepc-real-dev" in done.stderr and "meshing" not in done.stderr
    (alone / "slepc_solve").write_text("#!/bin/sh\n")
    (alone / "slepc_solve").chmod(0o755)
    done = subprocess.run([program, "disk", "--diameter", "100", "--thickness", "12", "--h", "1", "--engine", "slepc"],
                          capture_output=True, text=True, timeout=60, env={**os.environ, "PATH": str(tmp_path)})
    assert done.returncode == 1 and "openmpi-bin" in done.stderr and "meshing" not in done.stderr


def test_ranks_without_the_engine_and_other_engines_are_refused(tmp_path):
    for words, expected in [(["--ranks", 2], "--engine slepc"), (["--engine", "petsc"], "cholmod or slepc"),
                            (["--engine", "slepc", "--ranks", 0], "1 to 4096")]:
        done = run(*BODIES["free disk"], *words, folder=tmp_path, expect=1)
        assert expected in done.stderr
