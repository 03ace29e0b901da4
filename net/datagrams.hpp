#pragma once

#include "net/message.hpp"

#include <array>
#include <optional>
#include <span>

/// Positions and velocities as UDP datagrams, beside the TCP connection of the same client
/// (docs/formats/haptic_protocol.md): one OSC packet each, numbered, and with the key that the
/// server gave the client over TCP. A lost packet of TCP holds back all that follow it by a round
/// trip or more; a lost datagram costs one sample. Nothing that moves a motor travels so.
namespace tactus::net {

/// Interval at which a client confirms over UDP the newest sample received.
inline constexpr double kProbeInterval_s = 0.05;
/// Without news of samples that arrived for this long, TCP carries them again: half of the silence
/// after which a remote device counts as failed; the other half is for the samples over TCP.
inline constexpr double kDatagramSilence_s = 0.25;
/// A client that sent no probe for this long is sent no datagrams.
inline constexpr double kProbeTimeout_s = 5;
/// Longest datagram of the protocol, bytes; longer ones are ignored unread.
inline constexpr std::size_t kMaxDatagram = 128;
/// Datagrams read per millisecond; beyond that the kernel drops them.
inline constexpr int kMaxDatagramsPerTick = 32;

/// Sequence numbers run from 0 to 2^31 - 1 and begin again: b counts as older than a when a is
/// ahead of it by less than half of that.
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

/// The server's side for one client.
class DatagramSender {
public:
  /// The client asks for datagrams under this key, from now on.
  void open(std::int32_t key) noexcept;
  void close() noexcept { *this = {}; }
  [[nodiscard]] std::int32_t key() const noexcept { return key_; } ///< 0: closed

  /// A probe of this client (`udp key sequence`). It confirms when it names a sample that was sent
  /// by datagram and is newer than those confirmed before.
  void take_probe(std::int32_t sequence, double now_s) noexcept;
  /// True while probes arrive, so that there is an address to send to.
  [[nodiscard]] bool reachable(double now_s) const noexcept {
    return key_ != 0 && now_s - probed_s_ < kProbeTimeout_s;
  }
  /// Samples arrive, so that TCP need not carry them.
  [[nodiscard]] bool confirmed(double now_s) const noexcept {
    return key_ != 0 && now_s - confirmed_s_ < kDatagramSilence_s;
  }

  /// Queues a message whose first argument is its sequence number; the key is appended. If the
  /// queue is full, the oldest message is replaced.
  void add(Message message) noexcept;
  /// The next to be sent; nothing when all are.
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

/// The client's side.
class DatagramReceiver {
public:
  /// The server's answer: its key and the UDP port to which probes go.
  void open(std::int32_t key, int port) noexcept;
  void close() noexcept { *this = {}; }
  [[nodiscard]] int port() const noexcept { return port_; } ///< 0: closed

  /// Reads a datagram. False, and counted, when it is no `pos` or `vel` with five arguments and our
  /// key behind them. The message has the key no more.
  [[nodiscard]] bool take(std::span<const std::uint8_t> bytes, Message& message) noexcept;
  /// The probe, when one is due.
  [[nodiscard]] std::optional<Datagram> probe(double now_s) noexcept;

  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }

private:
  std::int32_t key_ = 0, newest_ = -1;
  int port_ = 0;
  double probed_s_ = -1e9;
  std::uint64_t received_ = 0, ignored_ = 0;
};

/// A probe's key and sequence number; nothing when the datagram is anything else.
struct Probe {
  std::int32_t key = 0, sequence = -1;
};
[[nodiscard]] std::optional<Probe> read_probe(std::span<const std::uint8_t> bytes) noexcept;

} // namespace tactus::net
