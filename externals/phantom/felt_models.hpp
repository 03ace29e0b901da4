#pragma once

#include "externals/phantom/named_network.hpp"
#include "externals/phantom/named_scene.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/servo_rig.hpp"

#include <optional>
#include <string>

namespace tactus::phantom {

/// What a device renders stably; above it, it may hum.
struct StabilityLimits {
  double stiffness_n_per_m, damping_n_s_per_m;
};

/// Warnings of more stiffness or damping than the device renders stably: once for each new
/// maximum.
class StabilityWarnings {
public:
  explicit StabilityWarnings(const Reports& reports) : reports_(reports) {}
  /// `share`: factor on the limit for a model whose force comes late.
  void stiffness(const std::string& what, double n_per_m, const StabilityLimits& limits, Host& host,
                 double share = 1);
  void damping(const std::string& what, double n_s_per_m, const StabilityLimits& limits,
               Host& host);

private:
  const Reports& reports_;
  double warned_n_per_m_ = 0, warned_n_s_per_m_ = 0;
};

/// What the patch makes felt inside the servo, by the messages `scene`, `effect` and `network`.
/// Each returns a sentence when it is refused. `limits`: of the device; none: it renders no force,
/// or is not known yet.
class FeltModels {
public:
  using Words = std::span<const Atom>;
  using Limits = std::optional<StabilityLimits>;

  explicit FeltModels(const Reports& reports) : warnings_(reports) {}
  [[nodiscard]] std::string scene(Words words, ServoRig& rig, const Limits& limits, Host& host);
  [[nodiscard]] std::string effect(Words words, ServoRig& rig, const Limits& limits, Host& host);
  [[nodiscard]] std::string network(Words words, ServoRig& rig, double period_s,
                                    const Limits& limits, Host& host);
  /// Gives all of it to a servo.
  void publish(ServoRig& rig) const;
  /// Warns of what a device that has been opened does not hold quiet.
  void warn(const Limits& limits, Host& host);
  /// A new period of the ticks may need more steps than a tick can have.
  void check_network(double period_s, Host& host) const;
  /// The name of a body of the scene.
  [[nodiscard]] Atom name_of(std::uint64_t key) const noexcept { return scene_.name_of(key); }
  void dump(double period_s, Host& host) const;

private:
  [[nodiscard]] std::string act(Words words, ServoRig& rig);
  void warn_of_scene(const Limits& limits, Host& host);
  void warn_of_effect(const std::string& name, const Limits& limits, Host& host);

  NamedScene scene_;
  NamedNetwork network_;
  haptic::EffectSettings effects_;
  StabilityWarnings warnings_;
};

} // namespace tactus::phantom
