#pragma once
#include "fem/modes/body.hpp"
#include "fem/radiation/mode_radiation.hpp"
#include "programs/body/progress.hpp"
#include "programs/modal_fem/order.hpp"
#include "programs/modal_fem/shape.hpp"

#include <memory>

namespace tactus::fem {

/// A body with its modes.
struct Solved {
  Mesh mesh;
  std::vector<Material> materials;
  std::unique_ptr<Matrices> matrices;
  Modes modes;
  std::string support_words = "free";
  std::vector<double> relative_error;
  ModeRadiation radiation;
  ShapeDerivatives shape;
  std::vector<float> residual; ///< m/N at the skin's vertices
  bool solved = false;         ///< false: only exported
};

/// Checks names, foretells, meshes, assembles and solves as ordered.
[[nodiscard]] Solved solve(const Order&, ProgressLine&);

} // namespace tactus::fem
