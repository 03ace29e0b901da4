#pragma once

#include "core/stress/stress_table.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace tactus::stress {

/// How a stress was found: by Taylor's series, by preconditioned conjugate gradients on the factor
/// of an earlier shape, or by a new factor.
enum class Method : std::uint8_t { kTaylor, kPcg, kFull };

/// Interface of a solver that computes the stress of a part at a new shape. Solves run outside the
/// caller's thread (in a child process): every function returns at once. One solve at a time.
class Reanalysis {
public:
  /// Times measured when the part was loaded.
  struct Costs {
    double product_s = 0; ///< stiffness matrix times vector
    double solve_s = 0;   ///< forward and back substitution with the factor
    double factor_s = 0;  ///< assembly and factorisation
  };
  struct Result {
    std::string refusal; ///< reason why there is no new base; empty: success
    std::shared_ptr<const StressBase> base;
    Method method = Method::kPcg;
    unsigned iterations = 0;
    double seconds = 0;
    bool stale_sensitivities = false; ///< the base's sensitivities belong to an earlier shape
    bool lost = false;                ///< the solver has ended and must not be used again
  };

  virtual ~Reanalysis() = default;
  /// Starts loading the part if necessary. Returns true once it is loaded; only then costs() is
  /// valid and start() may be called.
  [[nodiscard]] virtual bool prepare() { return true; }
  [[nodiscard]] virtual Costs costs() const noexcept = 0;
  /// Starts a solve at these displacements of the parameters, m. `sensitivities`: compute new ones,
  /// which needs a new factor whatever the method. Returns an empty string, or the reason why it
  /// cannot start.
  [[nodiscard]] virtual std::string start(std::span<const double> displacement_m, Method method,
                                          bool sensitivities) = 0;
  /// The result of the last start(), or the reason why the solver is lost; each is returned once.
  [[nodiscard]] virtual std::optional<Result> poll() = 0;
};

} // namespace tactus::stress
