#pragma once
#include "fem/error/error_estimate.hpp"
#include "fem/error/refined_sizes.hpp"
#include "fem/shapes/grid.hpp"
#include "programs/modal_fem/forecast.hpp"

#include <optional>

namespace tactus::fem {

/// The meshes of one run, each finer where the last one's errors are.
///
///   1. the first follows from the highest wave number among the modes asked for
///   2. the modes' errors are estimated on it, element by element
///   3. until each is below `--tolerance`, the next mesh takes the sizes that make them so with the
///      fewest unknowns: lines of the grid for shapes, a field of sizes for CAD and surface models
///
/// A mesh that the user sizes (--h, --layers), --tolerance 0, volume meshes from files, modes from
/// elsewhere (--engine slepc, --import-modes) and orders that do not solve keep their first mesh.
class Refinement {
public:
  Refinement(const ModalOptions&, ProgressLine&, Forecast&);

  /// The next mesh. Refuses one beyond the budget.
  [[nodiscard]] Mesh mesh();
  /// Whether the mesh is the last: the tolerance is met, or cannot be within the budget. Says what
  /// is left of it. Else the next mesh is ready to be made. `held`: of Matrices.
  [[nodiscard]] bool finished(const Mesh&, std::span<const std::uint8_t> constrained,
                              const ErrorEstimate&);
  /// Says which errors stay, because the next mesh could not be made or solved.
  void give_up(const std::string& reason);

private:
  [[nodiscard]] Mesh mesh_of_shape();
  [[nodiscard]] Mesh mesh_of_file();
  [[nodiscard]] std::vector<ProfilePoint> profile() const;
  [[nodiscard]] MeshSize planned_size(const Mesh&) const;
  /// Of elements for so many modes, from the body's volume, skin and extent.
  [[nodiscard]] double first_size(double volume, double skin, double largest, double modes) const;
  void plan(const Mesh&, std::span<const std::uint8_t> constrained, const ErrorEstimate&,
            double target);

  const ModalOptions& options_;
  ProgressLine& progress_;
  Forecast& forecast_;
  bool refines_;
  int round_ = 0;
  double last_target_ = 0, target_scale_ = 1;
  std::vector<double> errors_; ///< of the last mesh's modes
  SweepGrid grid_, next_grid_;
  std::optional<SizeField> sizes_;
};

} // namespace tactus::fem
