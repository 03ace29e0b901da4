#pragma once
#include "fem/modes/modes.hpp"
#include "programs/body/budget.hpp"
#include "programs/body/progress.hpp"
#include "programs/modal_fem/options.hpp"

namespace tactus::fem {

/// Predicts memory, time and disk space before the work is done, and warns of unusual sizes or
/// refuses the work.
class Forecast {
public:
  using Notify = std::function<void(const std::string& sentence)>;

  Forecast(const ModalOptions&, ProgressLine&);

  /// Call before gmsh meshes or a shape is built. Refuses a mesh beyond the budget; warns once if
  /// the body's size makes its modes inaudible. `with_element_size` gives the mesh's size for
  /// another h, if the mesh has an h. `with_modes` gives it for fewer modes, if their number
  /// determines the mesh. `notify` replaces the progress line in a child process.
  void mesh(const MeshSize&, const std::function<MeshSize(double h)>& with_element_size,
            const std::function<MeshSize(double modes)>& with_modes, const Notify& notify = {});
  /// Call it for an existing mesh, before assembly.
  void made(const Mesh&, double seconds_spent = 0);
  /// Call it after the symbolic factorisation, to check the budget with its exact count and to
  /// predict the time ahead.
  void factor(const FactorCost&);

  /// Sets the number of bytes of another mesh's results that stay in memory from now on.
  void keep(double bytes) noexcept { retained_bytes_ = bytes; }
  /// The reason why a mesh is beyond the budget; empty if it is not.
  [[nodiscard]] std::string over_budget(const MeshSize&) const;

  /// The reason why estimating the errors of modes found elsewhere, which needs a factorisation
  /// here, is beyond the budget; empty if it is not.
  [[nodiscard]] std::string over_budget_in_process(const FactorCost&) const;

  [[nodiscard]] double meshing_seconds() const noexcept { return meshing_s_; }
  [[nodiscard]] double factor_seconds() const noexcept { return factor_s_; }
  [[nodiscard]] const Budget& budget() const noexcept { return budget_; }

private:
  [[nodiscard]] Workload workload(const MeshSize&) const;
  void check_budget(const std::optional<FactorCost>&);
  void warn_of_unusual_size(const Notify& notify);

  const ModalOptions& options_;
  ProgressLine& progress_;
  Budget budget_;
  MeshSize size_;
  std::function<MeshSize(double)> with_element_size_, with_modes_;
  bool size_warned_ = false;
  double flops_, meshing_s_ = 0, factor_s_ = 0, retained_bytes_ = 0;
};

/// One sentence if none of the modes is audible, with the unit that would make them audible; else
/// empty. `largest` in m, frequencies in Hz; `unit`: the unit assumed for the lengths, m, or 0 if
/// the file contains it.
[[nodiscard]] std::string inaudible_text(double lowest_hz, double highest_hz, double largest,
                                         double unit, bool estimated);

} // namespace tactus::fem
