#pragma once

#include "core/modal/table/modal_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace tactus::modal {

/// The sound at a listener from recorded or computed velocities of surface elements (the method of
/// the AudioHaptics paper):
///   phi(t) = sum over points of v(t - d/c) dS / (2 pi d),   p(t) = rho (phi(t) - phi(t - D))/D,
/// with D = 1/44100 s and d the distance from point to listener. The table gives points and areas.
/// A sample costs two interpolated reads for each point.
class RawListener {
public:
  /// Allocates.
  void set(const RawTable& table, const Vec3& listener, double air_density, double sound_speed) {
    density_ = air_density;
    delay_s_.resize(table.points);
    area_weight_m_.resize(table.points);
    for (std::size_t i = 0; i < table.points; ++i) {
      const double distance = std::max(norm(listener - table.position_m[i]), 1e-4);
      delay_s_[i] = distance / sound_speed;
      area_weight_m_[i] = table.area_m2[i] / (2 * std::numbers::pi * distance);
    }
  }
  /// Pressure in Pa at a time after a strike of 1 m/s at one of the table's points.
  [[nodiscard]] double pressure(const RawTable& table, std::size_t hit,
                                double time_s) const noexcept {
    constexpr double kStep = 1 / 44100.0;
    return density_ * (potential(table, hit, time_s) - potential(table, hit, time_s - kStep)) /
           kStep;
  }
  /// Time from the strike to the end of the sound, s.
  [[nodiscard]] double end_s(const RawTable& table) const noexcept {
    const auto longest = std::max_element(delay_s_.begin(), delay_s_.end());
    return static_cast<double>(table.samples) / table.sample_rate_hz + 1e-3 +
           (longest == delay_s_.end() ? 0 : *longest);
  }

private:
  [[nodiscard]] double potential(const RawTable& table, std::size_t hit,
                                 double time_s) const noexcept {
    double sum = 0;
    const float* point = table.velocity_m_per_s.data() + hit * table.points * table.samples;
    for (std::size_t i = 0; i < delay_s_.size(); ++i, point += table.samples) {
      const double at = (time_s - delay_s_[i]) * table.sample_rate_hz;
      if (!(at >= 0) || at >= static_cast<double>(table.samples - 1))
        continue;
      const auto whole = static_cast<std::size_t>(at);
      const double part = at - static_cast<double>(whole);
      const auto a = static_cast<double>(point[whole]), b = static_cast<double>(point[whole + 1]);
      sum += area_weight_m_[i] * (a + part * (b - a));
    }
    return sum;
  }

  double density_ = 1.184;
  std::vector<double> delay_s_, area_weight_m_;
};

} // namespace tactus::modal
