#pragma once

#include "programs/haptic_check/options.hpp"
#include "programs/haptic_check/session.hpp"

#include <string>
#include <vector>

namespace tactus::haptic_check {

/// The result of a station, for the report.
struct Finding {
  std::string name;
  std::vector<std::string> lines; ///< the measurements, or the reason for skipping
  std::string answer;             ///< the user's answer
  Intervals intervals{};
  haptic::ServoStatistics statistics{};
  std::string scheduling;
  bool ran = false;
};

/// The four stations, one after the other, on an open device.
class Stations {
public:
  Stations(Session& session, const Options& options);
  /// Empty unless the device failed so that nothing more can be done.
  [[nodiscard]] std::string run();
  [[nodiscard]] const std::vector<Finding>& findings() const noexcept { return findings_; }
  [[nodiscard]] double force_limit_n() const noexcept { return force_limit_n_; }

private:
  [[nodiscard]] std::string look();
  [[nodiscard]] std::string wall();
  [[nodiscard]] std::string sphere();
  [[nodiscard]] std::string sines();
  [[nodiscard]] std::string finish(Finding finding, const Recording& recording, bool has_force);
  /// The plan of every station with force: the force rises, then the requested time follows.
  [[nodiscard]] Session::Plan with_motors() const;
  /// A body with a stiffness that this device renders stably.
  [[nodiscard]] haptic::Body body(const haptic::Shape& shape, const haptic::Pose& pose);
  [[nodiscard]] Vec3 current_position(std::string& error);
  void move_simulated_hand(const Vec3& from, const Vec3& to, double period_s);
  void skip(const std::string& name, const std::string& reason);

  Session& session_;
  const Options& options_;
  haptic::Caps caps_;
  double period_s_, force_limit_n_, stiffness_n_per_m_;
  std::vector<Finding> findings_;
  std::uint64_t bodies_ = 0; // number of bodies made so far, so that no two share a key
};

} // namespace tactus::haptic_check
