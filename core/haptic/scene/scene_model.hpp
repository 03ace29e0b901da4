#pragma once

#include "core/dsp/ring.hpp"
#include "core/haptic/scene/proxy.hpp"
#include "core/haptic/scene/scene.hpp"
#include "core/haptic/servo/servo.hpp"

#include <array>
#include <atomic>
#include <limits>
#include <memory>

namespace tactus::haptic {

/// Renders the contact of a spherical tool with a scene inside the servo. docs/theory/scene.md has
/// the model.
///   F = sum_i (k_i d_i + b_i max(0, -v . n_i)) n_i + k t
/// over the faces i that hold the proxy. n_i, k_i, b_i: normal, stiffness and damping of a face. v:
/// velocity of the handle relative to the body. k: mean of the k_i weighted by d_i. The vector from
/// handle to proxy is sum_i d_i n_i + t. d_i >= 0 is the depth along n_i, and t the tangential
/// remainder, which friction holds: k |t| <= sum_i mu_i k_i d_i.
///
/// The host publishes whole scenes. The servo takes the newest at the start of a tick and returns
/// the old one, so that it neither allocates nor frees memory. A body that keeps its key keeps its
/// contact. A body that appears around the handle pushes it out by the nearest face, with a force
/// that rises at kOverlapForceRise_n_per_s to at most kMaxOverlapForce_n or the device's continuous
/// force.
///
/// A tick computes no more than its work limit; the rest is done in the next ticks. Until then the
/// proxy stays at the end of its last complete motion, outside of every body and held by the faces
/// found so far. A body whose motion against the proxy is not yet computed stays in its pose.
class SceneModel final : public LocalModel {
public:
  static constexpr double kOverlapForceRise_n_per_s = 100, kMaxOverlapForce_n = 1;
  static constexpr double kMinHit_m_per_s = 5e-3;
  static constexpr double kRearm_m = 2e-4,
                          kRearm_s = 0.01; ///< distance and time before the next hit
  static constexpr double kContactEvery_s = 4e-3;
  static constexpr std::int64_t kWorkPerTick = 16000; ///< about 0.1 ms; see docs/theory/scene.md

  explicit SceneModel(std::int64_t work_per_tick = kWorkPerTick) noexcept
      : work_per_tick_(work_per_tick) {}
  ~SceneModel() override;
  SceneModel(const SceneModel&) = delete;
  SceneModel& operator=(const SceneModel&) = delete;

  // the host's side
  /// Replaces the scene at the servo's next tick; a scene that the servo has not taken yet is
  /// dropped.
  void publish(std::unique_ptr<const Scene> scene);
  /// Frees the scenes that the servo has returned.
  void collect() noexcept;
  [[nodiscard]] Ring<SceneEvent, 1024>& events() noexcept { return events_; }
  /// Continuous force of the device, N; 0: not known. At any time.
  void set_continuous_force(double newton) noexcept {
    continuous_force_n_.store(newton, std::memory_order_relaxed);
  }

  // the servo's side
  void begin() noexcept override;
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override;
  [[nodiscard]] const Vec3& proxy() const noexcept { return proxy_; }
  [[nodiscard]] std::span<const Touch> touches() const noexcept { return touches_.all(); }
  /// True if the proxy of the last tick is final, because the work limit sufficed.
  [[nodiscard]] bool complete() const noexcept { return complete_; }

private:
  static constexpr double kUnlimitedMotion = std::numeric_limits<double>::infinity();

  struct Slot {
    const Body* body = nullptr;
    std::uint64_t key = 0;
    Pose pose{}, before{};
    Pose goal{}, start{};
    double glide_ticks = 1, glide_elapsed_ticks = 1;
    bool is_new = true, touching = false;
    bool armed = true;     ///< the next contact may be a hit
    bool separated = true; ///< the tool has been kRearm_m away since the last contact
    double released_s = -1e9, reported_s = -1e9;
    double overlap_start_s = -1;      ///< time at which the body appeared around the handle;
                                      ///< negative: it did not
    double overlap_start_force_n = 0; ///< force of the body just before that time, if the tool has
                                      ///< grown
    double force_n = 0;               ///< its force in the last tick

    [[nodiscard]] bool moved() const noexcept { return !(pose == before); }
  };

  void take_scene(const Tick& tick) noexcept;
  void glide(Slot& slot) noexcept;
  void resolve_overlaps(const Tick& tick, WorkLimit& work) noexcept;
  void find_near_bodies(const Vec3& goal) noexcept;
  [[nodiscard]] std::size_t holding_body() const noexcept;
  void move_bodies(WorkLimit& work) noexcept;
  [[nodiscard]] bool move_body(std::size_t index, bool holds, WorkLimit& work) noexcept;
  [[nodiscard]] Touches moved_touches() const noexcept;
  void follow(const Vec3& goal, WorkLimit& work) noexcept;
  void keep_incomplete(const Proxy::Result& result, const Vec3& goal, double attempted_m) noexcept;
  [[nodiscard]] Vec3 render(const Tick& tick, const Vec3& goal, const Vec3& velocity) noexcept;
  [[nodiscard]] Vec3 limit_overlap_force(const Tick& tick) noexcept;
  void push_events(const Tick& tick) noexcept;
  void rearm(Slot& slot, const Tick& tick, WorkLimit& work) noexcept;
  [[nodiscard]] Vec3 velocity_of(const Slot& slot, const Vec3& point,
                                 double period_s) const noexcept;
  [[nodiscard]] std::span<const Obstacle> near_bodies() const noexcept {
    return {near_bodies_.data(), near_body_count_};
  }
  [[nodiscard]] std::span<const Slot> slots() const noexcept { return {slots_.data(), count_}; }

  std::atomic<const Scene*> pending_{nullptr};
  Ring<const Scene*, 64> retired_;
  Ring<SceneEvent, 1024> events_;

  std::atomic<double> continuous_force_n_{0};
  const std::int64_t work_per_tick_;

  const Scene* scene_ = nullptr;
  double tool_radius_m_ = 0;
  std::array<Slot, Scene::kMaxBodies> slots_{};
  std::size_t count_ = 0;
  std::array<Obstacle, Scene::kMaxBodies> near_bodies_{};
  std::array<std::size_t, Scene::kMaxBodies>
      near_body_index_{}; ///< index of each slot; kNoSlot: not near
  std::size_t near_body_count_ = 0;
  std::size_t first_moving_ = 0;                     ///< body whose motion was postponed
  std::size_t first_overlapping_ = 0;                ///< body whose exit was postponed
  std::array<Vec3, Scene::kMaxBodies> body_force_{}; ///< each body's part of the force, N

  Vec3 proxy_{}, previous_velocity_{};
  Touches touches_{};
  double max_motion_m_ = kUnlimitedMotion; ///< the longest motion that is tried in one tick
  bool started_ = false, complete_ = true;
};

} // namespace tactus::haptic
