#pragma once
#include "fem/modes/modes.hpp"
#include "programs/body/budget.hpp"
#include "programs/body/progress.hpp"
#include "programs/modal_fem/options.hpp"

namespace tactus::fem {

/// Predicts memory, time and disk space before the work is done, and warns of odd sizes or refuses.
class Forecast {
public:
  using Notify = std::function<void(const std::string& sentence)>;

  Forecast(const ModalOptions&, ProgressLine&);

  /// Call before gmsh meshes or a shape is built. Refuses a mesh beyond the budget; warns once if
  /// the body's size makes its modes inaudible. `with_element_size`: the mesh's size for another h,
  /// if it has one; `with_modes`: for fewer modes, if they size it. `notify` replaces the progress
  /// line in a child process.
  void mesh(const MeshSize&, const std::function<MeshSize(double h)>& with_element_size,
            const std::function<MeshSize(double modes)>& with_modes, const Notify& notify = {});
  /// For an existing mesh, before it is assembled.
  void made(const Mesh&, double seconds_spent = 0);
  /// After the symbolic factorisation: the same with its exact count, and the time ahead.
  void factor(const FactorCost&);

  /// From now on so many bytes of another mesh's results stay in memory.
  void keep(double bytes) noexcept { retained_bytes_ = bytes; }
  /// Why a mesh is beyond the budget; empty: it is not.
  [[nodiscard]] std::string over_budget(const MeshSize&) const;

  /// Why a factor of modes that were found elsewhere, and the estimate of their errors with it, are
  /// beyond the budget; empty: they are not.
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
