#pragma once

#include "core/stress/stress_table.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace tactus::stress {

enum class Method : std::uint8_t { kTaylor, kPcg, kFull };

/// A solver of the part at another shape. It works outside of the caller's thread, as a child
/// process does: the methods return at once. One solve at a time.
class Reanalysis {
public:
  /// Measured when the part is loaded.
  struct Costs {
    double product_s = 0; ///< stiffness matrix times vector
    double solve_s = 0;   ///< forward and back substitution with the factor
    double factor_s = 0;  ///< assembly and factorisation
  };
  struct Result {
    std::string refusal; ///< why there is no new base, else empty
    std::shared_ptr<const StressBase> base;
    Method method = Method::kPcg;
    unsigned iterations = 0;
    double seconds = 0;
    bool stale_sensitivities = false; ///< those in the base belong to an earlier shape
    bool lost = false;                ///< the solver has ended: it must not be asked again
  };

  virtual ~Reanalysis() = default;
  /// Begins to load the part if that has not begun. Whether it is loaded: only then count costs()
  /// and may start() be called.
  [[nodiscard]] virtual bool prepare() { return true; }
  [[nodiscard]] virtual Costs costs() const noexcept = 0;
  /// Begins a solve at these displacements of the parameters, m; with new sensitivities if they are
  /// wanted, which takes a new factor whatever the method. Returns why it cannot, else an empty
  /// sentence.
  [[nodiscard]] virtual std::string start(std::span<const double> displacement_m, Method method,
                                          bool sensitivities) = 0;
  /// The result of the last start, once; or, once, why the solver is lost.
  [[nodiscard]] virtual std::optional<Result> poll() = 0;
};

} // namespace tactus::stress
