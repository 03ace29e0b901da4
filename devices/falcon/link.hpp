#pragma once

#include "devices/falcon/usb_library.hpp"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tactus::devices::falcon {

constexpr std::uint8_t kOutEndpoint = 0x02, kInEndpoint = 0x81;
constexpr std::size_t kTransferBytes = 64; ///< bytes per transfer of a full-speed bulk endpoint
constexpr std::size_t kStatusBytes = 2;    ///< the serial chip's status, first in each IN transfer

/// The USB port of a Falcon.
struct Port {
  std::string path;    ///< bus and ports: "1-2.3"
  std::string serial;  ///< empty if it cannot be read
  std::string problem; ///< empty if the Falcon can be opened
};

/// The serial connection to a Falcon: an FTDI FT232R chip at 0403:cb48. Blocking, for setup; in run
/// mode a Stream takes over. Any wait ends within 0.2 s after *cancelled has become true.
class Link {
public:
  explicit Link(std::shared_ptr<UsbLibrary> usb, const std::atomic<bool>* cancelled = nullptr)
      : usb_(std::move(usb)), cancelled_(cancelled) {}
  ~Link() { close(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// True for the path of a Falcon that this process has already opened: such a device is not
  /// accessed.
  using IsOpen = std::function<bool(const std::string& path)>;

  /// Lists all Falcons on the buses. For a Falcon that is already open, it gives only the path.
  [[nodiscard]] static std::vector<Port> ports(UsbLibrary& usb, const IsOpen& is_open);

  /// which: an index into ports(), a serial number or a path; empty: the first that is not open.
  /// Returns an empty text on success, else a sentence.
  [[nodiscard]] std::string open(const std::string& which, const IsOpen& is_open);
  void close() noexcept;

  /// Sets 9600 baud and restarts the boot loader.
  [[nodiscard]] bool enter_boot_loader() noexcept;
  /// Sets about 140 kbaud, for the firmware.
  [[nodiscard]] bool enter_upload() noexcept;
  /// Sets 1.5 Mbaud and the shortest latency.
  [[nodiscard]] bool enter_run() noexcept;

  /// Sends within at most half a second. False if the device is gone or accepts nothing, or if the
  /// opening was cancelled.
  [[nodiscard]] bool send(std::span<const std::uint8_t> bytes) noexcept;
  /// Appends arriving bytes until there are `requested` of them or the time is up. False if the
  /// device is gone or the opening was cancelled.
  [[nodiscard]] bool receive(std::vector<std::uint8_t>& bytes, std::size_t requested,
                             double limit_s);
  /// Waits; returns false if the opening was cancelled meanwhile.
  [[nodiscard]] bool pause(double seconds) const;
  [[nodiscard]] bool cancelled() const noexcept { return cancelled_ && cancelled_->load(); }
  /// The chip's "clear to send" input, as of the last transfer.
  [[nodiscard]] bool clear_to_send() const noexcept { return clear_to_send_; }

  [[nodiscard]] UsbLibrary& usb() noexcept { return *usb_; }
  [[nodiscard]] libusb_context* context() noexcept { return context_; }
  [[nodiscard]] libusb_device_handle* handle() noexcept { return handle_; }
  [[nodiscard]] const Port& port() const noexcept { return port_; }

private:
  enum class Request : std::uint8_t {
    kReset = 0,
    kModem = 1,
    kFlow = 2,
    kDivisor = 3,
    kFormat = 4,
    kLatency = 9
  };
  bool set(Request request, std::uint16_t value) noexcept;
  bool purge() noexcept { return set(Request::kReset, 1) && set(Request::kReset, 2); }

  std::shared_ptr<UsbLibrary> usb_;
  const std::atomic<bool>* cancelled_ = nullptr;
  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  bool claimed_ = false, clear_to_send_ = false;
  Port port_;
};

} // namespace tactus::devices::falcon
