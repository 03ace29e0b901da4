#pragma once

#include "net/message.hpp"

#include <array>
#include <optional>
#include <span>

/// Positions and velocities as UDP datagrams, beside the TCP connection of the same client
/// (docs/formats/haptic_protocol.md): each is one numbered OSC packet with the key that the server
/// gave the client over TCP. A lost packet of TCP delays all later packets by a round trip or more;
/// a lost datagram costs one sample. Messages that move a motor are never sent as datagrams.
namespace tactus::net {

/// Interval at which a client confirms over UDP the newest sample received.
inline constexpr double kProbeInterval_s = 0.05;
/// If the client confirms no new sample for this long, TCP carries the samples again. This is half
/// of the silence after which a remote device counts as failed; the other half is for the samples
/// over TCP.
inline constexpr double kDatagramSilence_s = 0.25;
/// If a client has sent no probe for this long, the server sends it no datagrams.
inline constexpr double kProbeTimeout_s = 5;
/// Longest datagram of the protocol, bytes; longer datagrams are ignored unread.
inline constexpr std::size_t kMaxDatagram = 128;
/// Datagrams read per millisecond; the kernel drops any more.
inline constexpr int kMaxDatagramsPerTick = 32;

/// Sequence numbers run from 0 to 2^31 - 1 and then restart. b counts as older than a if a is ahead
/// of b by less than half of this range.
[[nodiscard]] constexpr bool is_newer(std::int32_t a, std::int32_t b) noexcept {
  const std::uint32_t ahead =
      (static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b)) & 0x7fffffffu;
  return ahead != 0 && ahead < 0x40000000u;
}

/// A random key, 1 to 2^31 - 1, that cannot be guessed. Makes a system call; not for the servo.
[[nodiscard]] std::int32_t make_datagram_key();

/// One packet to be sent.
struct Datagram {
  std::array<std::uint8_t, kMaxDatagram> bytes{};
  std::size_t size = 0;
  [[nodiscard]] std::span<const std::uint8_t> span() const noexcept { return {bytes.data(), size}; }
};

/// The server's side of the datagrams of one client.
class DatagramSender {
public:
  /// Sends the client datagrams under this key from now on.
  void open(std::int32_t key) noexcept;
  void close() noexcept { *this = {}; }
  [[nodiscard]] std::int32_t key() const noexcept { return key_; } ///< 0 if closed

  /// A probe of this client (`udp key sequence`). The probe confirms a sample if it names one that
  /// was sent as a datagram and is newer than all confirmed before.
  void take_probe(std::int32_t sequence, double now_s) noexcept;
  /// True while probes arrive, so that there is an address to send to.
  [[nodiscard]] bool reachable(double now_s) const noexcept {
    return key_ != 0 && now_s - probed_s_ < kProbeTimeout_s;
  }
  /// True while samples arrive as datagrams, so that TCP need not carry them.
  [[nodiscard]] bool confirmed(double now_s) const noexcept {
    return key_ != 0 && now_s - confirmed_s_ < kDatagramSilence_s;
  }

  /// Queues a message whose first argument is its sequence number; the key is appended. If the
  /// queue is full, the oldest message is replaced.
  void add(Message message) noexcept;
  /// The next datagram to be sent; nullopt if all have been sent.
  [[nodiscard]] std::optional<Datagram> take() noexcept;

private:
  static constexpr std::size_t kMaxQueued = 4; ///< pos and vel of two ticks

  std::int32_t key_ = 0;
  std::int32_t newest_ = -1;    ///< newest sample added
  std::int32_t confirmed_ = -1; ///< newest sample confirmed
  double probed_s_ = -1e9, confirmed_s_ = -1e9;
  std::array<Datagram, kMaxQueued> waiting_{};
  std::size_t begin_ = 0, count_ = 0;
};

/// The client's side of the datagrams.
class DatagramReceiver {
public:
  /// Called with the server's answer: the key and the UDP port to which probes are sent.
  void open(std::int32_t key, int port) noexcept;
  void close() noexcept { *this = {}; }
  [[nodiscard]] int port() const noexcept { return port_; } ///< 0 if closed

  /// Reads a datagram into `message`, without the key. Any datagram except a `pos` or `vel` with
  /// five arguments and our key after them is counted as ignored and returns false.
  [[nodiscard]] bool take(std::span<const std::uint8_t> bytes, Message& message) noexcept;
  /// The probe, if one is due.
  [[nodiscard]] std::optional<Datagram> probe(double now_s) noexcept;

  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }

private:
  std::int32_t key_ = 0, newest_ = -1;
  int port_ = 0;
  double probed_s_ = -1e9;
  std::uint64_t received_ = 0, ignored_ = 0;
};

/// A probe's key and sequence number; nullopt if the datagram is anything else.
struct Probe {
  std::int32_t key = 0, sequence = -1;
};
[[nodiscard]] std::optional<Probe> read_probe(std::span<const std::uint8_t> bytes) noexcept;

} // namespace tactus::net
