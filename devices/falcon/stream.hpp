#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/haptic/device/force_timeout.hpp"
#include "devices/falcon/link.hpp"
#include "devices/falcon/packet.hpp"
#include "devices/real_time.hpp"

#include <array>
#include <atomic>
#include <thread>

namespace tactus::devices::falcon {

/// An answer and its time of arrival.
struct Frame {
  Response response{};
  std::uint64_t number = 0; ///< counts answers from 1
  double time_s = 0;        ///< steady clock
};

/// The stream of commands and answers while the Falcon's firmware runs. One thread submits libusb
/// transfers, another handles those that complete. The servo only accesses memory: its send() and
/// receive() allocate nothing, take no lock and never wait. A newer command replaces an unsent one.
/// At most two commands are unanswered, so that no queue can form in front of a device that is
/// slower than the servo; after 10 ms the stream stops waiting for an answer. The device applies a
/// command until the next one arrives, so while the servo stalls the stream sends commands without
/// force (force_timeout.hpp).
class Stream {
public:
  explicit Stream(Link& link) : link_(link) {}
  ~Stream() { stop(); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Returns an empty text, or a sentence if there is no memory or no thread. If the device has
  /// left the bus, lost() is true.
  [[nodiscard]] std::string start();
  /// Sends a command without force and waits until it is delivered. This takes at most half a
  /// second, including the end of the threads.
  void stop() noexcept;

  /// The servo's thread calls it.
  void send(const Command& command) noexcept;
  /// True if an answer came since the last call; latest() then returns the newest answer.
  [[nodiscard]] bool receive() noexcept { return frames_.read(); }
  [[nodiscard]] const Frame& latest() const noexcept { return frames_.latest(); }

  /// The device has left the bus, or its connection has failed permanently.
  [[nodiscard]] bool lost() const noexcept { return lost_.load(std::memory_order_acquire); }
  struct Counts {
    std::uint64_t sent, answered, broken, skipped, failed;
  };
  /// Numbers of commands sent, answers, broken packets, commands replaced by a newer one, failed
  /// transfers.
  [[nodiscard]] Counts counts() const noexcept;

private:
  struct Numbered {
    Command command{};
    std::uint64_t number = 0;
    double written_s = -1e9;
  };
  struct Transfer {
    Stream* stream = nullptr;
    libusb_transfer* usb = nullptr;
    std::array<unsigned char, kTransferBytes> bytes{};
    std::atomic<bool> under_way{false};
    std::uint64_t number = 0;
  };

  static void LIBUSB_CALL on_in(libusb_transfer* transfer);
  static void LIBUSB_CALL on_out(libusb_transfer* transfer);
  bool submit(Transfer& transfer) noexcept;
  void process(const Transfer& transfer) noexcept;
  void failed() noexcept;
  void send_commands() noexcept;
  void handle_events() noexcept;
  void wake() noexcept;
  [[nodiscard]] bool idle() const noexcept;
  [[nodiscard]] Transfer* free_out(double since_s) noexcept;

  Link& link_;
  std::array<Transfer, 2> in_, out_;
  Mailbox<Numbered> commands_;
  std::atomic<double> written_s_{-1e9}; // time of the newest command
  Mailbox<Frame> frames_;
  ResponseParser parser_;
  std::uint64_t commands_written_ = 0; // number written by the servo
  std::uint64_t frame_ = 0;
  int failures_ = 0; // consecutive
  std::atomic<std::uint64_t> delivered_{0};
  std::atomic<std::uint64_t> sent_{0}, answered_{0}, broken_{0}, skipped_{0}, failed_{0};
  std::atomic<int> unanswered_{0};
  WakeCount wakes_;
  std::atomic<bool> waiting_{false}, lost_{false}, stopping_{false}, ended_{false};
  std::thread sender_, handler_;
};

} // namespace tactus::devices::falcon
