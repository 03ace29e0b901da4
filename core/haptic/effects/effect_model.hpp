#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/servo.hpp"

#include <algorithm>
#include <atomic>
#include <optional>

/// Force effects that a host switches on and off by name. docs/theory/effects.md has the equations.
namespace tactus::haptic {

/// Settings of the effects; an effect without a value is off. Stiffness N/m, damping N s/m.
struct EffectSettings {
  struct Constant {
    Vec3 force_n{};
  };
  /// F = k (c - x), its magnitude limited to max_n.
  struct Spring {
    double stiffness = 0;
    Vec3 centre{}; ///< m
    double max_n = 40;
  };
  /// F = -b v.
  struct Viscous {
    double damping = 0;
  };
  /// A mass coupled to the handle by a spring and a damper.
  struct Inertia {
    double mass_kg = 0;
    double stiffness = 300, damping = 1;
  };
  /// Coulomb friction with presliding: a spring of the given stiffness up to the force F, then
  /// slip.
  struct Friction {
    double force_n = 0;
    double stiffness = 500;
  };
  /// F = A sin(2 pi s/lambda) e, s = x . e: a grating in free space.
  struct Texture {
    double amplitude_n = 0, wavelength_m = 1e-3;
    Vec3 direction{1, 0, 0}; ///< e, of unit length
  };
  /// Grooves of depth H in every touched surface: height h(s) = H (cos(2 pi s/lambda) - 1)/2.
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

/// Computes the effects inside the servo. force() returns the sum of the passive effects: viscous,
/// inertia, friction, texture and relief. active_force() returns the sum of constant and spring.
/// These two put energy into the hand when they are switched on, and therefore count as forces of
/// the patch (Servo::attach).
///
/// Bounded work, no allocation; the force of each effect is at most kMaxEffect_n. A sampled damper
/// is passive only up to the device's damping limit; viscous and inertia use no more damping than
/// this.
class EffectModel final : public LocalModel {
public:
  static constexpr double kMaxEffect_n = 40;
  static constexpr double kDamping_n_s_per_m = 5; ///< limit of a device that does not state one

  // the host's side
  void set(const EffectSettings& settings) noexcept { settings_.write(settings); }
  /// The scene in whose surfaces `relief` cuts its grooves, and the variable that holds the scene's
  /// force of this tick, N. The scene's force() must be called before force() of this model.
  void set_scene(const SceneModel& scene, const Vec3& scene_force_n) noexcept {
    scene_ = &scene;
    scene_force_ = &scene_force_n;
  }

  /// Largest damping that the device renders stably at 1 kHz, N s/m; 0: not known. May be called at
  /// any time.
  void set_damping_limit(double n_s_per_m) noexcept {
    damping_limit_.store(n_s_per_m, std::memory_order_relaxed);
  }
  /// The largest passive damping for ticks of this period, N s/m: the limit at 1 kHz, less for
  /// longer periods.
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
  Vec3 position_{}; // position of the handle at the last tick
  bool started_ = false;
  Vec3 mass_position_{}, mass_velocity_{};
  bool has_mass_ = false;
  Vec3 friction_anchor_{}; // where friction's spring is anchored
  bool has_friction_anchor_ = false;
};

/// active_force() of an EffectModel whose force() was called in the same tick, as a local model.
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
