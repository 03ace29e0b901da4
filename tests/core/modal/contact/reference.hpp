#pragma once

#include "core/contact/impact.hpp"
#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tactus::test {

/// Bodies and strikers that touch, integrated by the classical Runge-Kutta method in fine steps: it
/// shares nothing with the solver. Coordinates are mass-normalised,
///   y'' = 2 Re(s) y' - |s|^2 y + a + sum b F,   F = k d^e (1 + mu d') >= 0,   d = d0 - sum b y;
/// a rigid motion has s = 0, and a striker of mass m is one of gain -1/sqrt(m) at its contact.
class FineIntegration {
public:
  struct Contact {
    contact::ImpactLaw law;
    double depth_m = 0;       ///< d0
    std::vector<double> gain; ///< b
    double impulse_ns = 0;
  };
  /// Adds a coordinate that no contact moves yet.
  std::size_t add(Complex rate, double position, double velocity, double acceleration = 0) {
    rate_.push_back(rate);
    acceleration_.push_back(acceleration);
    state_.insert(state_.end(), {position, velocity});
    for (Contact& c : contacts)
      c.gain.push_back(0);
    return rate_.size() - 1;
  }
  void step(double seconds, int parts) {
    const double h = seconds / parts;
    for (int s = 0; s < parts; ++s) {
      for (Contact& c : contacts)
        c.impulse_ns += h * force(c, state_);
      const State a = slope(state_), b = slope(ahead(a, h / 2)), c = slope(ahead(b, h / 2)),
                  d = slope(ahead(c, h));
      for (std::size_t k = 0; k < state_.size(); ++k)
        state_[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
    }
  }
  [[nodiscard]] double position(std::size_t k) const { return state_[2 * k]; }
  [[nodiscard]] double velocity(std::size_t k) const { return state_[2 * k + 1]; }
  std::vector<Contact> contacts;

private:
  using State = std::vector<double>;
  [[nodiscard]] State ahead(const State& slope, double h) const {
    State y = state_;
    for (std::size_t k = 0; k < y.size(); ++k)
      y[k] += h * slope[k];
    return y;
  }
  [[nodiscard]] double force(const Contact& c, const State& y) const {
    double depth = c.depth_m, closing = 0;
    for (std::size_t k = 0; k < rate_.size(); ++k) {
      depth -= c.gain[k] * y[2 * k];
      closing -= c.gain[k] * y[2 * k + 1];
    }
    return depth > 0 ? std::max(c.law.stiffness * std::pow(depth, c.law.exponent) *
                                    (1 + c.law.dissipation_s_per_m * closing),
                                0.0)
                     : 0;
  }
  [[nodiscard]] State slope(const State& y) const {
    State dy(y.size());
    for (std::size_t k = 0; k < rate_.size(); ++k) {
      dy[2 * k] = y[2 * k + 1];
      dy[2 * k + 1] =
          2 * rate_[k].real() * y[2 * k + 1] - norm(rate_[k]) * y[2 * k] + acceleration_[k];
    }
    for (const Contact& c : contacts) {
      const double f = force(c, y);
      for (std::size_t k = 0; k < rate_.size(); ++k)
        dy[2 * k + 1] += c.gain[k] * f;
    }
    return dy;
  }

  std::vector<Complex> rate_;
  std::vector<double> acceleration_;
  State state_;
};

} // namespace tactus::test
