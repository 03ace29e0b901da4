#pragma once
#include "fem/error/error_estimate.hpp"
#include "fem/error/refined_sizes.hpp"
#include "fem/shapes/grid.hpp"
#include "programs/modal_fem/forecast.hpp"

#include <optional>

namespace tactus::fem {

/// The meshes of one run. Each is finer where the previous mesh has errors.
///
///   1. the first follows from the highest wave number among the requested modes
///   2. the modes' errors are estimated on it, element by element
///   3. until each is below `--tolerance`, the next mesh takes the sizes that make them so with the
///      fewest unknowns: lines of the grid for shapes, a field of sizes for CAD and surface models
///
/// Without refinement: meshes sized by the user (--h, --layers), --tolerance 0, volume meshes from
/// files, modes computed elsewhere (--engine slepc, --import-modes) and commands that do not solve.
class Refinement {
public:
  Refinement(const ModalOptions&, ProgressLine&, Forecast&);

  /// Returns the next mesh. Refuses a mesh beyond the budget.
  [[nodiscard]] Mesh mesh();
  /// Returns whether the mesh is final, because it meets the tolerance or cannot meet it within the
  /// budget; reports the remaining error. Otherwise plans the next mesh. `constrained` is that of
  /// Matrices.
  [[nodiscard]] bool finished(const Mesh&, std::span<const std::uint8_t> constrained,
                              const ErrorEstimate&);
  /// Reports the remaining errors if the next mesh could not be made or solved.
  void give_up(const std::string& reason);

private:
  [[nodiscard]] Mesh mesh_of_shape();
  [[nodiscard]] Mesh mesh_of_file();
  [[nodiscard]] std::vector<ProfilePoint> profile() const;
  [[nodiscard]] MeshSize planned_size(const Mesh&) const;
  /// Element size for that many modes, from the body's volume, skin area and extent.
  [[nodiscard]] double first_size(double volume, double skin, double largest, double modes) const;
  void plan(const Mesh&, std::span<const std::uint8_t> constrained, const ErrorEstimate&,
            double target);

  const ModalOptions& options_;
  ProgressLine& progress_;
  Forecast& forecast_;
  bool refines_;
  int round_ = 0;
  double last_target_ = 0, target_scale_ = 1;
  std::vector<double> errors_; ///< errors of the last mesh's modes
  SweepGrid grid_, next_grid_;
  std::optional<SizeField> sizes_;
};

} // namespace tactus::fem
