#pragma once
#include "fem/design/lattice.hpp"
#include "fem/modes/body.hpp"
#include "fem/radiation/mode_radiation.hpp"

#include <string>

namespace tactus::fem {

/// Metadata of a table, written as JSON.
struct TableMetadata {
  std::string body_name = "body";
  std::string support = "free";
  std::string created; ///< ISO 8601; left out if empty, so that equal bodies give equal files
  std::vector<double> relative_error; ///< estimated error of each frequency; empty if unknown
  double air_density = 1.184, air_speed = 346.1;
  std::vector<std::string> command; ///< command line of modal_fem; left out if empty
};

/// Derivatives of the frequencies by the control points of a lattice around the body.
struct ShapeDerivatives {
  std::vector<Vec3> control_points; ///< m
  std::vector<ParameterRange> parameters;
  std::vector<double> by_parameter; ///< [parameter][mode] d(omega^2)/dp, rad^2/s^2 per m
  double trust = 0; ///< m, the largest displacement for which the derivatives may be used
  std::vector<double> displacement; ///< present displacements of the parameters, m; empty for 0
};

/// The contents of a modal table file.
struct ModalTable {
  const Mesh& mesh;
  std::span<const Material> materials;
  const Modes& modes;
  MassProperties body;
  std::vector<double> loss;          ///< loss factor of each mode
  std::vector<double> poisson_slope; ///< may be empty
  TableMetadata metadata;
  ModeRadiation radiation;     ///< may be empty
  std::vector<float> residual; ///< m/N at each vertex of the skin; may be empty
  ShapeDerivatives shape{};    ///< may be empty
};

/// Writes NAME.modal.npz, in SI units, little-endian. It contains meta (JSON), freq, phi [K,V,3] at
/// the skin's vertices, xyz, tri, mult, eta, mass, com, inertia and, for one isotropic material,
/// dlnf_dnu. With radiation it also has mp_* and alpha_rad. With shape derivatives it has
/// control_points, parameters, trust and domega2_dp, and for `modal_fem serve` the mesh (bytes) and
/// the command in meta. A moved shape adds displacement. docs/formats/modal_table.md lists the
/// arrays.
void write_table(const std::string& path, const ModalTable&);

/// The file of write_table() in memory, without the mesh.
[[nodiscard]] std::string table_bytes(const ModalTable&);

/// Writes one line per mode: number, frequency, multiplicity, loss factor, T60, error estimate,
/// residual.
void write_csv(const std::string& path, const ModalTable&);

/// Writes the mesh with the first `count` mode shapes as point vectors, for ParaView.
void write_vtu(const std::string& path, const Mesh&, const Modes&, std::size_t count);

/// Decay time to -60 dB, s.
[[nodiscard]] double decay_time(double frequency_hz, double loss_factor) noexcept;

} // namespace tactus::fem
