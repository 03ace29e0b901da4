#pragma once

#include "core/haptic/servo.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// The sum of several models' forces, asked in the given order at every tick.
template <std::size_t Count> class LocalModels final : public LocalModel {
public:
  explicit LocalModels(const std::array<LocalModel*, Count>& models) noexcept : models_(models) {}

  void begin() noexcept override {
    for (LocalModel* model : models_)
      model->begin();
  }
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override {
    Vec3 sum;
    for (LocalModel* model : models_)
      sum += model->force(tick, state);
    return sum;
  }

private:
  std::array<LocalModel*, Count> models_;
};

} // namespace tactus::haptic
