#pragma once

#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/mailbox.hpp"
#include "core/haptic/servo/servo.hpp"

#include <algorithm>
#include <atomic>
#include <optional>

/// Force effects that a host switches on and off by name. docs/effects.md has the equations.
namespace tactus::haptic {

/// What is felt now; an effect without a value is off. Stiffnesses N/m, damping N s/m.
struct EffectSettings {
  struct Constant {
    Vec3 force_n{};
  };
  /// F = k (c - x), no longer than max_n.
  struct Spring {
    double stiffness = 0;
    Vec3 centre{}; ///< m
    double max_n = 40;
  };
  /// F = -b v.
  struct Viscous {
    double damping = 0;
  };
  /// A mass that hangs on the handle by a spring and a damper.
  struct Inertia {
    double mass_kg = 0;
    double stiffness = 300, damping = 1;
  };
  /// Coulomb's friction F, which a spring of that stiffness builds up before it slips.
  struct Friction {
    double force_n = 0;
    double stiffness = 500;
  };
  /// F = A sin(2 pi s/lambda) e, s the position along e: a grating in free space.
  struct Texture {
    double amplitude_n = 0, wavelength_m = 1e-3;
    Vec3 direction{1, 0, 0}; ///< e, of unit length
  };
  /// Grooves h(s) = H (cos(2 pi s/lambda) - 1)/2 in every surface of the scene that is touched.
  struct Relief {
    double depth_m = 0, wavelength_m = 1e-3;
    Vec3 direction{1, 0, 0};
  };

  std::optional<Constant> constant{};
  std::optional<Spring> spring{};
  std::optional<Viscous> viscous{};
  std::optional<Inertia> inertia{};
  std::optional<Friction> friction{};
  std::optional<Texture> texture{};
  std::optional<Relief> relief{};
};

/// The effects inside the servo. force() is the sum of those that are passive by themselves:
/// viscous, inertia, friction, texture and relief. driven() is that of constant and spring, which
/// put energy into the hand when they are switched on, and so count as the patch's own wish.
///
/// Bounded work, no allocation; each effect is at most kMaxEffect_n long. A damper that is sampled
/// is passive only up to what the device can damp: viscous and inertia use no more than that.
class EffectModel final : public LocalModel {
public:
  static constexpr double kMaxEffect_n = 40;
  static constexpr double kDamping_n_s_per_m = 5; ///< of a device that does not say its limit

  // the host's side
  void set(const EffectSettings& settings) noexcept { settings_.write(settings); }
  /// The scene that relief is carved into, and where its force of this tick is found. Both must be
  /// asked for their force before this is.
  void set_scene(const SceneModel& scene, const Vec3& scene_force_n) noexcept {
    scene_ = &scene;
    scene_force_ = &scene_force_n;
  }

  /// What the device damps quietly at 1 kHz, N s/m; 0 when it does not say. At any time.
  void set_damping_limit(double n_s_per_m) noexcept {
    damping_limit_.store(n_s_per_m, std::memory_order_relaxed);
  }
  /// The same in ticks of that length: slower ones hold less.
  [[nodiscard]] static double max_passive_damping(double limit_n_s_per_m,
                                                  double period_s) noexcept {
    return (limit_n_s_per_m > 0 ? limit_n_s_per_m : kDamping_n_s_per_m) *
           std::min(1.0, 1e-3 / period_s);
  }

  // the servo's side
  void begin() noexcept override;
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override;
  [[nodiscard]] const Vec3& active_force() const noexcept { return active_force_; }

private:
  [[nodiscard]] Vec3 inertia(const EffectSettings::Inertia&, double max_damping, const Tick&,
                             const Vec3& position) noexcept;
  [[nodiscard]] Vec3 friction(const EffectSettings::Friction&, const Vec3& position) noexcept;
  [[nodiscard]] Vec3 relief(const EffectSettings::Relief&, const Vec3& position) const noexcept;

  Mailbox<EffectSettings> settings_;
  std::atomic<double> damping_limit_{0};
  const SceneModel* scene_ = nullptr;
  const Vec3* scene_force_ = nullptr;

  Vec3 active_force_{};
  Vec3 position_{}; // of the handle at the last tick
  bool started_ = false;
  Vec3 mass_position_{}, mass_velocity_{};
  bool has_mass_ = false;
  Vec3 friction_anchor_{}; // where friction's spring is anchored
  bool has_friction_anchor_ = false;
};

/// driven() of an EffectModel that has been asked in the same tick.
class ActiveEffects final : public LocalModel {
public:
  explicit ActiveEffects(const EffectModel& effects) noexcept : effects_(effects) {}
  [[nodiscard]] Vec3 force(const Tick&, const State&) noexcept override {
    return effects_.active_force();
  }

private:
  const EffectModel& effects_;
};

} // namespace tactus::haptic
