#pragma once

#include "core/haptic/device/device.hpp"
#include "devices/haply/transform.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// The messages to and from Haply's service, as JSON texts. The service answers each message with
/// one state; its first message, before any of ours, lists the devices. A state may leave out
/// fields that have not changed.
namespace tactus::devices::haply {

/// The state of one device in a message of the service. Project frame: x right, y up, z towards the
/// user.
struct DeviceState {
  std::string id, type, firmware;
  std::optional<Vec3> position, velocity; ///< m, m/s, in the application's space
  std::optional<bool> calibrated;
  std::optional<Transform> workspace; ///< the workspace transform
  std::optional<Transform> mount;     ///< mount, preset and basis: in answers to status_request()
  std::string preset, basis;
};

/// A message of the service.
struct Message {
  std::vector<DeviceState> devices;
  std::optional<std::uint32_t> buttons; ///< of a VerseGrip, if there is one
  std::optional<Vec3> rotation;         ///< of a VerseGrip: axis times angle, rad
};

/// Reads a message of the service. Returns nullopt if the text is not a JSON object. Numbers that
/// are not finite are left out.
[[nodiscard]] std::optional<Message> parse(std::string_view text);

/// The preset that puts the origin into the middle of the workspace, and the service's own axes.
constexpr const char* kPreset = "arm_front_centered";
constexpr const char* kBasis = "XYZ";

/// The key of the force in set_cursor_force. Services of version 3.5 take "vector" (docs.haply.co,
/// control commands); public clients of version 3.1 send "values" (isaac-sim/IsaacLab,
/// source/isaaclab/isaaclab/devices/haply/se3_haply.py).
enum class ForceKey { kVector, kBoth };

/// A force on one device, N, project frame.
[[nodiscard]] std::string force_message(std::string_view device_id, const Vec3& force_n,
                                        ForceKey key = ForceKey::kVector);
/// The first message of a session: this client's name, the axes and the preset, and zero force
/// under both keys.
[[nodiscard]] std::string first_message(std::string_view device_id);
/// Sets zero force under both keys and requests an answer that contains the configuration. If basis
/// is true, it sets the axes again, since a preset may have changed them.
[[nodiscard]] std::string status_request(std::string_view device_id, bool basis);

/// Vectors between the service's axes (x right, y forward, z up) and the project's.
[[nodiscard]] inline Vec3 to_project(const Vec3& v) noexcept { return {v.x, v.z, -v.y}; }
[[nodiscard]] inline Vec3 to_service(const Vec3& v) noexcept { return {v.x, -v.z, v.y}; }

} // namespace tactus::devices::haply
