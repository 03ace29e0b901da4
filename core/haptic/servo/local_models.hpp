#pragma once

#include "core/haptic/servo/servo.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// A local model that sums the forces of several others, evaluated in the given order in every
/// tick.
template <std::size_t Count> class LocalModels final : public LocalModel {
public:
  explicit LocalModels(const std::array<LocalModel*, Count>& models) noexcept : models_(models) {}

  void begin() noexcept override {
    for (LocalModel* model : models_)
      model->begin();
  }
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override {
    Vec3 sum;
    for (std::size_t i = 0; i < Count; ++i)
      sum += forces_[i] = models_[i]->force(tick, state);
    return sum;
  }
  /// The last force of a model, N; for models that are evaluated after it in the same tick.
  [[nodiscard]] const Vec3& force_of(std::size_t model) const noexcept { return forces_[model]; }

private:
  std::array<LocalModel*, Count> models_;
  std::array<Vec3, Count> forces_{};
};

} // namespace tactus::haptic
