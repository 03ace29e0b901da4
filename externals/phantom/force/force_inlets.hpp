#pragma once

#include "externals/phantom/reports.hpp"
#include "externals/phantom/servo/servo_session.hpp"

#include <cstddef>

namespace tactus::phantom {

/// The forces at the inlets. Values that arrive at several inlets in one logical instant form one
/// force.
class ForceInlets {
public:
  ForceInlets(ServoSession& session, const Reports& reports)
      : session_(session), reports_(reports) {}

  bool in_shares_of_limit = false; ///< if true, 1 at an inlet means forcemax, otherwise 1 N

  /// Sets a component for the next apply().
  void set(std::size_t inlet, double value) noexcept;
  /// Passes the force to the servo.
  void apply(double limit_n, Host& host);

private:
  ServoSession& session_;
  const Reports& reports_;
  Vec3 values_{};
  bool refused_ = false, changed_ = false;
  double last_error_ms_ = -1e9;
};

} // namespace tactus::phantom
