#!/usr/bin/python3
"""Modes of a body too large for one machine: SLEPc on modal_fem's matrices, under MPI.

    modal_fem BODY ... --export-petsc km.bin
    mpirun -n 4 slepc_modes.py km.bin 40 SHIFT_HZ values.bin vectors.bin
    modal_fem BODY ... --import-modes values.bin vectors.bin -o body.modal.npz

Solves K u = lambda M u for the lowest modes, rigid motions included, by Krylov-Schur on
(K + s M)^-1 M, s = (2 pi SHIFT_HZ)^2, with MUMPS' distributed Cholesky factor. A tenth to a half of
the lowest elastic frequency is a good shift. Needs Debian's python3-slepc4py. Options of SLEPc
(-eps_monitor, -eps_tol ...) may follow.
"""
import glob
import math
import sys

# Debian keeps the modules beside the libraries.
sys.path += glob.glob("/usr/lib/slepcdir/*/*-real/lib/python3/dist-packages")
sys.path += glob.glob("/usr/lib/petscdir/*/*-real/lib/python3/dist-packages")
try:
    import slepc4py
except ImportError:
    sys.exit("slepc_modes.py: needs Debian's python3-slepc4py")
if len(sys.argv) < 6:
    sys.exit(__doc__)
slepc4py.init(sys.argv)
from petsc4py import PETSc  # noqa: E402
from slepc4py import SLEPc  # noqa: E402

matrices, count, shift_hz, values_path, vectors_path = sys.argv[1:6]
source = PETSc.Viewer().createBinary(matrices, "r")
stiffness = PETSc.Mat().load(source)
mass = PETSc.Mat().load(source)

solver = SLEPc.EPS().create()
solver.setOperators(stiffness, mass)
solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
solver.setDimensions(int(count) + 12)
solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
solver.setTarget(-((2 * math.pi * float(shift_hz)) ** 2))
solver.setTolerances(1e-10, 500)
spectral = solver.getST()
spectral.setType(SLEPc.ST.Type.SINVERT)
spectral.getKSP().setType(PETSc.KSP.Type.PREONLY)
factor = spectral.getKSP().getPC()
factor.setType(PETSc.PC.Type.CHOLESKY)
factor.setFactorSolverType("mumps")
solver.setFromOptions()
solver.solve()

converged = solver.getConverged()
if converged < int(count):
    sys.exit(f"slepc_modes.py: {converged} of {count} modes converged; raise -eps_max_it or change the shift")
shape = stiffness.createVecRight()
values = PETSc.Vec().createMPI(converged)
target = PETSc.Viewer().createBinary(vectors_path, "w")
first, last = values.getOwnershipRange()
for k in range(converged):
    value = solver.getEigenpair(k, shape).real
    if first <= k < last:
        values.setValue(k, value)
    shape.view(target)
target.destroy()
values.assemble()
target = PETSc.Viewer().createBinary(values_path, "w")
values.view(target)
target.destroy()
if PETSc.COMM_WORLD.rank == 0:
    print(f"{converged} modes of {stiffness.getSize()[0]} degrees of freedom, {PETSc.COMM_WORLD.size} processes")
