#pragma once

#include "core/haptic/ring.hpp"
#include "core/haptic/scene/proxy.hpp"
#include "core/haptic/scene/scene.hpp"
#include "core/haptic/servo.hpp"

#include <array>
#include <atomic>
#include <memory>

namespace tactus::haptic {

/// Contact with a scene, felt inside the servo. docs/scene.md has the model.
///   F = sum_i (k_i d_i + b_i max(0, -v . n_i)) n_i + k t
/// over the faces that hold the proxy: d_i the normals' shares of the way from handle to proxy, v
/// the handle's velocity against the body, t the rest of that way, which friction holds: no longer
/// than mu times the normal part. k is the mean of the k_i, weighted by d_i; where all are equal
/// the spring is k times the whole way.
///
/// The host publishes whole scenes; the servo takes the newest at the beginning of a tick and hands
/// the old one back, so that it neither allocates nor frees. Bodies that keep their key keep their
/// contact. A body that appears around the handle lets it out by the nearest face, its force rising
/// at kEmerging_n_per_s.
class SceneModel final : public LocalModel {
public:
  static constexpr double kEmerging_n_per_s = 100;
  static constexpr double kSlowestHit_m_per_s = 5e-3;
  static constexpr double kRearm_m = 2e-4, kRearm_s = 0.01; ///< either makes the next hit possible
  static constexpr double kContactEvery_s = 4e-3;

  SceneModel() = default;
  ~SceneModel() override;
  SceneModel(const SceneModel&) = delete;
  SceneModel& operator=(const SceneModel&) = delete;

  // the host's side
  /// The servo's next tick takes it; one that it has not taken yet is dropped.
  void publish(std::unique_ptr<const Scene> scene);
  /// Frees the scenes that the servo has done with.
  void collect() noexcept;
  [[nodiscard]] Ring<ContactEvent, 1024>& events() noexcept { return events_; }

  // the servo's side
  void begin() noexcept override;
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override;
  [[nodiscard]] const Vec3& proxy() const noexcept { return proxy_; }
  [[nodiscard]] std::span<const Touch> touches() const noexcept { return touches_.all(); }

private:
  struct Slot {
    const Body* body = nullptr;
    std::uint64_t key = 0;
    Pose pose{}, before{};
    Pose goal{}, start{};
    double glide_ticks = 1, glided = 1;
    bool fresh = true, touching = false, armed = true;
    double released_s = -1e9, reported_s = -1e9;
    double emerged_s = -1;  ///< when it appeared around the handle; negative: it did not
    Vec3 point{}, normal{}; ///< of the last contact, in the body's frame

    [[nodiscard]] bool moved() const noexcept { return !(pose == before); }
  };

  void take_scene(const Tick& tick) noexcept;
  void glide(Slot& slot) noexcept;
  void emerge(const Tick& tick) noexcept;
  void carry() noexcept;
  void look_around(const Vec3& goal) noexcept;
  [[nodiscard]] bool sticks(const Vec3& goal) noexcept;
  void slide(const Vec3& goal) noexcept;
  [[nodiscard]] double friction_of(const Touches& touches) const noexcept;
  [[nodiscard]] Vec3 render(const Tick& tick, const Vec3& goal, const Vec3& velocity) noexcept;
  void notice(const Tick& tick, const Vec3& goal) noexcept;
  [[nodiscard]] Vec3 velocity_of(const Slot& slot, const Vec3& point,
                                 double period_s) const noexcept;
  [[nodiscard]] std::span<const Slot> slots() const noexcept { return {slots_.data(), count_}; }

  std::atomic<const Scene*> pending_{nullptr};
  Ring<const Scene*, 64> retired_;
  Ring<ContactEvent, 1024> events_;

  const Scene* scene_ = nullptr;
  std::array<Slot, Scene::kMostBodies> slots_{};
  std::size_t count_ = 0;
  std::array<Obstacle, Scene::kMostBodies> near_{};
  std::size_t near_count_ = 0;
  std::array<Vec3, Scene::kMostBodies> share_{}; ///< each body's part of the force

  Vec3 proxy_{}, velocity_before_{};
  Touches touches_{};
  bool started_ = false;
};

} // namespace tactus::haptic
