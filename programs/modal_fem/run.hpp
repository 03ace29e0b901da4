#pragma once
#include "fem/modes/body.hpp"
#include "fem/radiation/mode_radiation.hpp"
#include "programs/body/progress.hpp"
#include "programs/modal_fem/options.hpp"
#include "programs/modal_fem/shape.hpp"

#include <memory>

namespace tactus::fem {

/// A body with its modes.
struct Solved {
  Mesh mesh;
  std::vector<Material> materials;
  std::unique_ptr<Matrices> matrices;
  Modes modes;
  std::string support_text = "free";
  std::vector<double> relative_error;
  ModeRadiation radiation;
  ShapeDerivatives shape;
  std::vector<float> residual; ///< m/N at the skin's vertices
  bool solved = false;         ///< false if the body was only exported
};

/// The supports of the command line, on the mesh's nodes. Refuses a region that contains no node.
[[nodiscard]] std::vector<Support> supports_of(const ModalOptions&, const Mesh&);

/// The table of a solved body. `created`: ISO 8601, or empty.
[[nodiscard]] ModalTable table_of(const ModalOptions&, const Solved&, const std::string& created);

/// The modes of a reshaped body and their derivatives: the requested number, or all that exist. The
/// mesh has been moved by `displacement` of the space's parameters (m). The supports are those of
/// the original mesh.
[[nodiscard]] Solved solve_moved(const ModalOptions&, Mesh moved, std::span<const Material>,
                                 std::span<const Support>, const DesignSpace&,
                                 std::vector<double> displacement);

/// Checks names, predicts memory and time, meshes, assembles and solves according to the options.
[[nodiscard]] Solved solve(const ModalOptions&, ProgressLine&);

} // namespace tactus::fem
