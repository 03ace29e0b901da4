#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The Falcon's packets in run mode, sixteen bytes in both directions:
///
///   '<'  3 values of 16 bits, each as 4 nibbles, low first, nibble + 'A'  flags + 'A'  'A'  '>'
namespace tactus::devices::falcon {

constexpr std::size_t kPacketBytes = 16;
using Packet = std::array<std::uint8_t, kPacketBytes>;
using Values = std::array<std::int16_t, 3>;

struct Command {
  enum Flags : std::uint8_t { kHoming = 1, kGreen = 2, kBlue = 4, kRed = 8, kLights = 14 };
  Values motors{};
  std::uint8_t flags = 0;
};

/// No force. The device stays homed only while each packet has the homing bit (libnifalcon,
/// include/falcon/core/FalconFirmware.h, "Homing Mode").
constexpr Command kNoForce{{}, Command::kHoming};

struct Response {
  enum Flags : std::uint8_t { kButtons = 0x0f, kHomed = 0x70 };
  Values encoders{};
  std::uint8_t flags = 0;
};

[[nodiscard]] Packet encode(const Command& command) noexcept;
[[nodiscard]] Packet encode(const Response& response) noexcept;

/// Cuts a stream of bytes into answers. '<' occurs only at the start of a packet, so the parser
/// finds the next whole packet after lost or added bytes.
class ResponseParser {
public:
  /// True when this byte completes an answer.
  bool process(std::uint8_t byte) noexcept;
  [[nodiscard]] const Response& response() const noexcept { return response_; }
  /// The number of unfinished packets plus the number of runs of bytes between packets.
  [[nodiscard]] std::uint64_t errors() const noexcept { return errors_; }
  /// Discards a partly received packet.
  void reset() noexcept { filled_ = 0; }

private:
  void refuse() noexcept;

  Packet packet_{};
  std::size_t filled_ = 0;
  bool between_ = false;
  Response response_{};
  std::uint64_t errors_ = 0;
};

} // namespace tactus::devices::falcon
