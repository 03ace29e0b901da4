#pragma once

#include <cstdint>
#include <string_view>

/// The haptic protocol (docs/formats/haptic_protocol.md): messages between a computer with a haptic
/// device and its clients. net includes core/haptic, but no driver.
namespace tactus::net {

/// The address of a message of the haptic protocol. On the wire it is `/hap/NAME` in OSC and `hap
/// NAME` in FUDI, where a blank replaces the slash inside a name.
enum class Address : std::uint8_t {
  kUnknown,
  // Sent by a client:
  kHello,     ///< i protocol, s name, s role [, s token]
  kWorkspace, ///< 6 f: min x y z, max x y z, mm
  kCpBegin,   ///< i number of control points
  kCpSet,     ///< i id, 3 f position, mm
  kCpEnd,     ///< no arguments
  kCpClear,   ///< no arguments
  kGains,     ///< 4 f: kmin kmax (N/m), bmin bmax (N s/m)
  kForceMax,  ///< f force limit for this client, at most the server's, N
  kStart,     ///< s mode
  kStop,      ///< no arguments
  kFeedback,  ///< i sequence, f gamma or 3 f
  kForce,     ///< [i sequence,] 3 f, N
  kAnchor,    ///< 3 f, mm
  kSubscribe, ///< s stream, f Hz
  kPing,      ///< i sequence [, i ms of the server's newest pos, vel or pong]
  kUdp,       ///< i 0|1; as a datagram: i key, i newest received sequence or -1
  // Sent by the server:
  kWelcome,  ///< i protocol, s device, s model, i dof, f force limit, f rate
  kPosition, ///< i sequence, i ms, 3 f, mm [, i key in a datagram]
  kVelocity, ///< i sequence, i ms, 3 f, m/s [, i key in a datagram]
  kButton,   ///< i number, i 0|1
  kCpMove,   ///< i id, 3 f, mm
  kGrab,     ///< i id, i 0|1
  kPong,     ///< i sequence, i ms
  kStatus,   ///< s word, ...
  kError,    ///< s code, s text
  kBye,      ///< s reason
  // Sent on a bus of modules as `/bus/TOPIC`; each message has its own name:
  kTopic, ///< i sequence, i us, fields of the topic (net/bus_topic.hpp)
};

/// The NAME of an address, such as "cp/begin"; "?" for kUnknown and kTopic.
[[nodiscard]] std::string_view name_of(Address address) noexcept;
/// Returns kUnknown if there is no such name.
[[nodiscard]] Address find_address(std::string_view name) noexcept;
/// As above, for a name in two words, such as "cp" and "begin".
[[nodiscard]] Address find_address(std::string_view first, std::string_view second) noexcept;

} // namespace tactus::net
