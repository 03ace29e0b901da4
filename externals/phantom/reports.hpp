#pragma once

#include "externals/phantom/words.hpp"

#include <array>
#include <cstddef>
#include <initializer_list>
#include <string_view>

namespace tactus::phantom {

/// The outputs that the message `report TAG 0|1` switches.
enum Tag : std::size_t {
  kMm,
  kVel,
  kForce,
  kButton,
  kStatus,
  kJitter,
  kError,
  kHit,
  kContact,
  kRelease,
  kRot,
  kTorque,
  kGrip
};
inline constexpr std::array<std::string_view, 13> kTags{
    "mm",  "vel",     "force",   "button", "status", "jitter", "error",
    "hit", "contact", "release", "rot",    "torque", "grip"};

/// Stores which outputs are on.
class Reports {
public:
  [[nodiscard]] bool on(Tag tag) const noexcept { return on_[tag]; }
  /// Sends a line if its tag is on.
  void send(Tag tag, std::initializer_list<Atom> line, Host& host) const {
    if (on_[tag])
      host.info(line);
  }
  /// Handles the message `report TAG 0|1`.
  void set(Words words, Host& host);

private:
  std::array<bool, kTags.size()> on_{false, false, false, true,  true,  false, true,
                                     true,  true,  true,  false, false, false};
};

} // namespace tactus::phantom
