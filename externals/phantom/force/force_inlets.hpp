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

  bool in_shares_of_limit = false; ///< 1 is forcemax, else 1 N

  /// For the next apply().
  void set(std::size_t inlet, double value) noexcept;
  /// Gives the force to the servo.
  void apply(double limit_n, Host& host);

private:
  ServoSession& session_;
  const Reports& reports_;
  Vec3 values_{};
  bool refused_ = false, changed_ = false;
  double last_error_ms_ = -1e9;
};

} // namespace tactus::phantom
