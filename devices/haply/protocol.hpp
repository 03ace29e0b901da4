#pragma once

#include "core/haptic/device.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What is said to Haply's service and what it answers: JSON texts. The service answers each
/// message with one state; its first message, before any of ours, lists the devices. Fields that
/// have not changed may be left out of a state.
namespace tactus::devices::haply {

/// One device as a message of the service shows it. Project frame.
struct Sight {
  std::string id, type, firmware;
  std::optional<haptic::Vec3> position, velocity; ///< m, m/s
  std::optional<bool> calibrated;
};

/// A message of the service.
struct Message {
  std::vector<Sight> devices;
  std::optional<std::uint32_t> buttons; ///< of a VerseGrip, when there is one
  std::optional<haptic::Vec3> rotation; ///< of a VerseGrip: axis times angle, rad
};

/// Nothing when the text is no JSON object. Numbers that are not finite are left out.
[[nodiscard]] std::optional<Message> parse(std::string_view text);

/// A force on one device, N, project frame. The first message of a session also gives our name and
/// asks for the service's own axes.
[[nodiscard]] std::string force_message(std::string_view device_id, const haptic::Vec3& force_n,
                                        bool first);

/// The service's axes are x right, y forward, z up.
[[nodiscard]] inline haptic::Vec3 to_project(const haptic::Vec3& v) noexcept {
  return {v.x, v.z, -v.y};
}
[[nodiscard]] inline haptic::Vec3 to_service(const haptic::Vec3& v) noexcept {
  return {v.x, -v.z, v.y};
}

} // namespace tactus::devices::haply
