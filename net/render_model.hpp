#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/haptic/servo/servo.hpp"
#include "core/stress/render.hpp"
#include "core/stress/vector_ramp.hpp"

#include <cstdint>

namespace tactus::net {

/// The force that the server renders: nothing, the stress as a spring or as a damper, or the
/// client's forces.
enum class RenderMode : std::uint8_t { kStopped, kSpring, kDamper, kForce };

/// The request of the client in control for the force to render; the newest request counts.
struct RenderRequest {
  RenderMode mode = RenderMode::kStopped;
  stress::RenderGains gains{};
  bool anchored = false;    ///< if false, the anchor is the handle's position at the start
  Vec3 anchor{};            ///< m
  Vec3 gamma{};             ///< for each axis, 0..1
  std::uint64_t starts = 0; ///< counts `start`
  friend bool operator==(const RenderRequest&, const RenderRequest&) = default;
};

/// Spring and damper of the stress feedback, computed inside the servo. In force mode it adds
/// nothing, because those forces are the servo's commands.
class RenderModel final : public haptic::LocalModel {
public:
  /// Called by the network's thread.
  void set(const RenderRequest& request) noexcept { requests_.write(request); }

  [[nodiscard]] Vec3 force(const haptic::Tick& tick, const haptic::State& state) noexcept override;

private:
  Mailbox<RenderRequest> requests_;
  stress::VectorRamp gamma_{}, anchor_{};
  std::uint64_t starts_ = 0;
  bool waiting_ = false; ///< waiting for a position as the anchor
};

} // namespace tactus::net
