"""modal_fem --engine slepc. Skipped where this build has no SLEPc: ./test must not need MPI, which is
large, and the program is the same without it."""
import os
import shutil
from functools import partial

import numpy as np
import program
import pytest
from program import MODAL_FEM, errors, table

run, refusal = partial(program.run, MODAL_FEM), partial(program.refusal, MODAL_FEM)
DISK = ["disk", "--diameter", 100, "--thickness", 12]
built = os.path.exists(os.path.join(os.path.dirname(MODAL_FEM), "slepc_solve")) and shutil.which("mpirun")
needs_slepc = pytest.mark.skipif(not built, reason="built without Debian's libslepc-real-dev, or no openmpi-bin")
BODIES = {
    "free disk": [*DISK, "--h", 20, "--modes", 12],
    "clamped disk": [*DISK, "--h", 25, "--modes", 6, "--fix", "0,0,-6,12"],
    "hinged plate": ["plate", "--length", 60, "--width", 40, "--thickness", 4, "--h", 20, "--modes", 6, "--fix", "x=-30:xz"],
    "ball of fivefold modes": ["sphere", "--diameter", 100, "--h", 25, "--modes", 11],
}


@needs_slepc
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_slepc_gives_the_same_modes(body, ranks, tmp_path):
    own, _ = table(*body, folder=tmp_path)
    other, said = table(*body, "--engine", "slepc", "--ranks", ranks, folder=tmp_path,
                        env={**os.environ, "TMPDIR": str(tmp_path)})
    assert len(own["freq"]) == len(other["freq"]) == body[body.index("--modes") + 1]
    assert np.allclose(own["freq"], other["freq"], rtol=1e-8)
    assert np.array_equal(own["mult"], other["mult"]) and np.allclose(own["eta"], other["eta"])
    # Turned shapes of groups agree too, but for signs and turns that a group's rounding decides.
    single = own["mult"] == 1
    for a, b in zip(own["phi"][single], other["phi"][single]):
        assert min(np.abs(a - b).max(), np.abs(a + b).max()) < 1e-4 * np.abs(a).max()
    assert len(errors(other)) == len(own["freq"]) and np.allclose(errors(own), errors(other), rtol=.02)
    assert f"{ranks} processes, at most" in said and "SLEPc: finding modes" in said
    assert [p.name for p in tmp_path.iterdir()] == ["body.modal.npz"]


@needs_slepc
def test_errors_are_not_estimated_where_the_factor_has_no_room_and_that_is_said(tmp_path):
    body = ["plate", "--length", 60, "--width", 60, "--thickness", 60, "--h", 6, "--modes", 4, "--memory", "110M"]
    assert "the factorisation would take" in refusal(*body, folder=tmp_path)
    found, said = table(*body, "--engine", "slepc", "--ranks", 1, folder=tmp_path)
    assert "warning: the errors are not estimated: they need a factorisation in this process, which would take" in said
    assert len(errors(found)) == 0


@needs_slepc
def test_a_failing_solver_is_one_sentence_and_leaves_nothing(tmp_path):
    said = refusal(*BODIES["free disk"], "--engine", "slepc", "-o", "t.modal.npz", folder=tmp_path,
                   env={**os.environ, "TMPDIR": str(tmp_path), "PETSC_OPTIONS": "-eps_max_it 1 -eps_ncv 30 -eps_tol 1e-30"})
    assert said.startswith("modal_fem: --engine slepc failed: ")
    assert not list(tmp_path.iterdir())


def test_a_missing_engine_names_the_packages_and_its_options_are_checked(tmp_path):
    (tmp_path / "bin").mkdir()
    program_alone = shutil.copy(MODAL_FEM, tmp_path / "bin/modal_fem")
    words = [program_alone, *DISK, "--h", 1, "--engine", "slepc"]
    assert "libslepc-real-dev" in program.refusal(*words, folder=tmp_path)
    (tmp_path / "bin/slepc_solve").write_text("#!/bin/sh\n")
    (tmp_path / "bin/slepc_solve").chmod(0o755)
    said = program.run(*words, folder=tmp_path, expect=1, env={**os.environ, "PATH": str(tmp_path)}).stderr
    assert "openmpi-bin" in said and "meshing" not in said
    for words, expected in [(["--ranks", 2], "--engine slepc"), (["--engine", "petsc"], "cholmod or slepc"),
                            (["--engine", "slepc", "--ranks", 0], "1..4096")]:
        assert expected in refusal(*DISK, *words, folder=tmp_path)
