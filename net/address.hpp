#pragma once

#include <cstdint>
#include <string_view>

/// The haptic protocol (docs/formats/haptic_protocol.md): messages between a computer with a haptic
/// device and its clients. net includes core/haptic and no driver.
namespace tactus::net {

/// The address of a message of the haptic protocol. On the wire `/hap/NAME` in OSC and `hap NAME`
/// in FUDI, where the slash inside a name is a blank.
enum class Address : std::uint8_t {
  kUnknown,
  // Sent by a client:
  kHello,     ///< i protocol, s name, s role [, s token]
  kWorkspace, ///< 6 f: min x y z, max x y z, mm
  kCpBegin,   ///< i number of control points
  kCpSet,     ///< i id, 3 f position, mm
  kCpEnd,     ///<
  kCpClear,   ///<
  kGains,     ///< 4 f: kmin kmax (N/m), bmin bmax (N s/m)
  kForceMax,  ///< f, N: the client lowers the force limit for itself
  kStart,     ///< s mode
  kStop,      ///<
  kFeedback,  ///< i sequence, f gamma or 3 f
  kForce,     ///< [i sequence,] 3 f, N
  kAnchor,    ///< 3 f, mm
  kSubscribe, ///< s stream, f Hz
  kPing,      ///< i sequence [, i ms of the server's newest pos, vel or pong]
  kUdp,       ///< i 0|1; as a datagram: i key, i sequence of the newest that came, or -1
  // Sent by the server:
  kWelcome,  ///< i protocol, s device, s model, i dof, f force limit, f rate
  kPosition, ///< i sequence, i ms, 3 f, mm [, i key, of a datagram]
  kVelocity, ///< i sequence, i ms, 3 f, m/s [, i key, of a datagram]
  kButton,   ///< i number, i 0|1
  kCpMove,   ///< i id, 3 f, mm
  kGrab,     ///< i id, i 0|1
  kPong,     ///< i sequence, i ms
  kStatus,   ///< s word, ...
  kError,    ///< s code, s text
  kBye,      ///< s reason
  // of a bus of modules, `/bus/TOPIC`; its name is the message's own
  kTopic, ///< i sequence, i us, fields of the topic (net/bus_topic.hpp)
};

/// The NAME of an address, such as "cp/begin"; "?" for kUnknown and kTopic.
[[nodiscard]] std::string_view name_of(Address address) noexcept;
/// kUnknown when there is no such name.
[[nodiscard]] Address find_address(std::string_view name) noexcept;
/// The same for a name in two words, "cp" and "begin".
[[nodiscard]] Address find_address(std::string_view first, std::string_view second) noexcept;

} // namespace tactus::net
