#pragma once
#include "fem/modes/modes.hpp"
#include "fem/statics/statics.hpp"

#include <string>

namespace tactus::fem {

/// Writes the mesh, materials and supports as a CalculiX / Abaqus frequency step.
void write_inp(const std::string& path, const Mesh&, std::span<const Material>,
               std::span<const Support>, std::size_t modes);

/// Writes a static step for CalculiX / Abaqus: mesh, materials and fixed patches, and all loads as
/// the nodal forces of load_vector(). The step outputs displacements at nodes, and stresses at
/// nodes (.frd) and integration points (.dat). Refuses springs.
void write_static_inp(const std::string& path, const Mesh&, const StaticModel&);

/// Writes K, then M unless it is empty, as PETSc binary matrices (big-endian, both triangles,
/// 32-bit indices). Constrained directions have a unit diagonal in K and none in M.
void write_petsc(const std::string& path, const Matrices&);

/// Writes vectors of `size` numbers, one after the other, as PETSc binary vectors.
void write_petsc_vectors(const std::string& path, std::span<const double> vectors,
                         std::size_t size);

/// Reads the only vector, of `size` numbers, from a file in PETSc's binary form. Refuses anything
/// else.
[[nodiscard]] std::vector<double> read_petsc_vector(const std::string& path, std::size_t size);

/// Reads the modes of a SLEPc run: eigenvalues (lambda = omega^2) and vectors as PETSc binary
/// vectors (`-eps_view_values binary:FILE -eps_view_vectors binary:FILE`). The lowest values, one
/// for each rigid motion, are dropped unless the rigid motions were deflated; the other modes are
/// normalised and rotated into canonical directions.
[[nodiscard]] Modes import_modes(const std::string& values, const std::string& vectors, const Mesh&,
                                 const Matrices&, bool rigid_among_them = true);

} // namespace tactus::fem
