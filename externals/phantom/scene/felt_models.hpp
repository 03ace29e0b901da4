#pragma once

#include "externals/phantom/force/servo_setup.hpp"
#include "externals/phantom/network/named_network.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/scene/named_scene.hpp"
#include "externals/phantom/words.hpp"

#include <string>
#include <string_view>

namespace tactus::phantom {

/// The models in the servo that the messages `scene`, `effect` and `network` build.
class FeltModels {
public:
  FeltModels(const ServoSession& session, const DeviceLink& link, const ServoSetup& setup,
             const Reports& reports)
      : session_(session), link_(link), setup_(setup), reports_(reports) {}
  void scene(Words words, Host& host);
  void effect(Words words, Host& host);
  void network(Words words, Host& host);
  /// Passes all models to the servo.
  void publish() const;
  /// Warns of stiffness and damping that a newly opened device does not render stably.
  void warn(Host& host);
  /// Call it after a new tick period, which may need more steps than a tick can have.
  void check_network(Host& host) const;
  /// The name of a body of the scene.
  [[nodiscard]] Atom name_of(std::uint64_t key) const noexcept { return scene_.name_of(key); }
  void dump(Host& host) const;

private:
  struct Limits {
    double stiffness_n_per_m, damping_n_s_per_m;
  };
  [[nodiscard]] Limits limits() const noexcept;
  [[nodiscard]] std::string act(Words words);
  void warn_of_scene(Host& host);
  void warn_of_effects(std::string_view name, Host& host);
  void warn(const std::string& what, double n_per_m, double n_s_per_m, Host& host,
            double share = 1);

  const ServoSession& session_;
  const DeviceLink& link_;
  const ServoSetup& setup_;
  const Reports& reports_;
  NamedScene scene_;
  NamedNetwork network_;
  haptic::EffectSettings effects_;
  double warned_n_per_m_ = 0, warned_n_s_per_m_ = 0;
};

} // namespace tactus::phantom
