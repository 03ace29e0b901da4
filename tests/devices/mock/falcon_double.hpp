#pragma once

#include "tests/devices/mock/mock_usb.hpp"

#include <array>
#include <chrono>
#include <deque>

namespace tactus::mock {

/// The device as the bus describes it, at port 1-1.
[[nodiscard]] UsbDescription falcon_description();

/// A Novint Falcon as seen from its wire: the FTDI chip's requests, the boot loader, homing, and
/// run frames, written from the protocol's public description and not from tactus's driver: it
/// stays homed while each packet has the homing bit (libnifalcon,
/// include/falcon/core/FalconFirmware.h); its chip sends less than 62 bytes when its latency timer
/// has run out (FTDI, AN232B-04). Its handle is three upper arms in a hand whose intention sweeps;
/// motors push them.
///
/// command() takes one line, for faults and questions:
///   unplug, plug             handled by the program around it
///   stall MS                 no byte comes for so long
///   split N                  at most N payload bytes a transfer (62 is normal)
///   garbage N                N random bytes come before the next answer
///   bad N                    the next N answers begin with '!'
///   lose N                   of the next N answers the fifth byte is lost
///   freeze 0|1               encoders stand still
///   wild N                   the next N answers have 1000 counts too many on the first arm
///   pose A B C               every answer has these counts; without counts, its own again
///   unhome                   the homed flags fall
///   echo N                   the next N firmware uploads echo a wrong byte
///   deaf N                   the next N greetings of the boot loader are not answered
///   shy 0|1                  a byte in run mode before the firmware makes its boot loader deaf
///   until
///                            the power is cut (said of some devices; we know of no source)
///   boot MS                  the boot loader hears nothing for so long after its restart
///   still                    the hand's intention stands at the centre
///   buttons B                the four bits of the grip
///   forget                   as after a power cut: no firmware, not homed
///   state                    answers with numbers, name=value, blanks between
class FalconDouble final : public UsbDevice {
public:
  explicit FalconDouble(bool loaded = false) : loaded_(loaded) {}

  int control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t> payload) override;
  int out(std::uint8_t endpoint, std::span<const std::uint8_t> payload) override;
  int in(std::uint8_t endpoint, std::span<std::uint8_t> payload) override;

  /// Answers a line; "?" when the command is not known. Thread-safe, as the rest.
  std::string command(const std::string& line);
  /// Writes the answer to "state", a line a number, whole or not at all; nothing without a name.
  void report(const std::string& file);

private:
  using Clock = std::chrono::steady_clock;
  void boot(std::span<const std::uint8_t> payload);
  void run(std::uint8_t byte);
  void frame();
  void move();
  void unhome() noexcept { homed_ = 0, homing_frames_ = 0; }
  [[nodiscard]] std::string state() const;

  mutable std::mutex mutex_;

  // the serial chip
  int divisor_ = 0, latency_ms_ = 16;
  bool terminal_ready_ = false;
  std::deque<std::uint8_t> to_host_;
  Clock::time_point last_in_{}, stalled_until_{}, restarted_{};
  int split_ = 62;

  // the boot loader
  bool loaded_ = false, greeted_ = false, acknowledged_ = false, shy_ = false, confused_ = false;
  std::deque<std::uint8_t> greeting_;
  long uploads_ = 0, firmware_bytes_ = 0, wrong_echoes_ = 0, deaf_ = 0, boot_ms_ = 0;

  // the firmware
  std::array<std::uint8_t, 16> packet_{};
  std::size_t filled_ = 0;
  long frames_ = 0, broken_ = 0, garbage_ = 0, bad_ = 0, lose_ = 0, homing_frames_ = 0, wild_ = 0;
  std::array<int, 3> motors_{};
  int flags_ = 0, homed_ = 0, buttons_ = 0;
  bool frozen_ = false, still_ = false;
  std::array<int, 3> sent_{}, pose_{};
  bool posed_ = false;
  std::array<double, 3> angle_{-500, -500, -500}, speed_{}; // counts, counts/s
  std::uint32_t noise_ = 12345;
};

} // namespace tactus::mock
