#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include <umockdev.h>

namespace tactus::mock {

/// A USB device as its firmware sees it. Called from umockdev's own thread, one call at a time.
/// Each returns a number of bytes or a negative errno.
class UsbDevice {
public:
  virtual ~UsbDevice() = default;
  virtual int control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t> payload) = 0;
  virtual int out(std::uint8_t endpoint, std::span<const std::uint8_t> payload) = 0;
  /// -EAGAIN: nothing yet, ask again.
  virtual int in(std::uint8_t endpoint, std::span<std::uint8_t> payload) = 0;
};

/// What the kernel tells of a device.
struct UsbDescription {
  std::string name; ///< of the port, such as "1-1"
  int bus = 1, address = 2;
  std::uint16_t vendor = 0, product = 0, release = 0;
  std::string manufacturer, model, serial;
  std::vector<std::uint8_t> configuration; ///< configuration descriptor with all that follows it
  std::string further_records; ///< umockdev records of what the kernel makes of the device
};

/// The kernel's side of a USB device in an umockdev test bed: programs that use libusb find it,
/// open it and exchange transfers with a UsbDevice.
class MockUsb {
public:
  MockUsb(UMockdevTestbed* bed, UsbDescription description, UsbDevice& device);
  ~MockUsb();
  MockUsb(const MockUsb&) = delete;
  MockUsb& operator=(const MockUsb&) = delete;

  /// The device leaves the bus: transfers under way and all later ones fail, the node goes.
  void unplug();
  void plug();
  [[nodiscard]] bool plugged() const { return plugged_; }
  [[nodiscard]] std::string node() const; ///< another after each plugging in
  [[nodiscard]] std::string path() const;

private:
  struct Transfer {
    UMockdevIoctlData *urb, *payload;
  };
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  void serve(UMockdevIoctlClient* client);
  int control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t> payload);
  bool finish(Transfer& transfer);
  void reap(UMockdevIoctlClient* client, UMockdevIoctlData* result);

  UMockdevTestbed* bed_;
  UsbDescription description_;
  UsbDevice& device_;
  UMockdevIoctlBase* handler_;
  std::mutex mutex_;
  bool plugged_ = false;
  std::vector<std::string> nodes_; // all that are served, the newest last
  std::deque<Transfer> pending_, discarded_;
};

[[nodiscard]] std::string hexadecimal(std::span<const std::uint8_t> bytes);

} // namespace tactus::mock
