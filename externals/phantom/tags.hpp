#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace tactus::phantom {

/// The outputs that the message `report TAG 0|1` switches.
enum Tag : std::size_t {
  kMm,
  kVel,
  kForce,
  kButtonTag,
  kStatus,
  kJitter,
  kError,
  kHitTag,
  kContactTag,
  kReleaseTag,
  kRot,
  kTorqueTag,
  kGripTag
};
inline constexpr std::array<std::string_view, 13> kTags{
    "mm",  "vel",     "force",   "button", "status", "jitter", "error",
    "hit", "contact", "release", "rot",    "torque", "grip"};

} // namespace tactus::phantom
