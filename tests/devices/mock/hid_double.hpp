#pragma once

#include "tests/devices/mock/mock_usb.hpp"

#include <deque>

namespace tactus::mock {

/// A HID device: what it says of itself, and reports that a test sends through it by command:
///   report HEX...   an input report, its id first if it has one
///   state           writes=N last=HEX: output reports that the program sent
struct HidDescription {
  std::uint16_t vendor = 0, product = 0;
  std::string manufacturer, model, serial;
  std::vector<std::uint8_t> report_descriptor;
};

/// SpaceNavigator, translation and rotation in reports of their own.
[[nodiscard]] HidDescription space_navigator();
/// SpaceMouse Compact, all six axes in one report.
[[nodiscard]] HidDescription space_mouse_compact();
/// A game pad with two sticks of 8 bits, a slider and ten buttons; its reports have no id.
[[nodiscard]] HidDescription game_pad();

/// The device as the kernel's hidraw node.
class HidrawDouble {
public:
  HidrawDouble(UMockdevTestbed* bed, HidDescription description);
  ~HidrawDouble();
  HidrawDouble(const HidrawDouble&) = delete;
  HidrawDouble& operator=(const HidrawDouble&) = delete;
  std::string command(const std::string& line);

private:
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  static gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  void plug();
  void unplug();

  UMockdevTestbed* bed_;
  HidDescription description_;
  UMockdevIoctlBase* handler_;
  std::mutex mutex_;
  std::vector<std::uint8_t> written_;
  long writes_ = 0;
  int number_ = -1; // of the node
  int feed_ = -1;   // descriptor that feeds the node
  std::vector<std::string> nodes_, paths_;
};

/// The device as seen through USB transfers.
class UsbHidDouble final : public UsbDevice {
public:
  UsbHidDouble(UMockdevTestbed* bed, HidDescription description);
  int control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t> payload) override;
  int out(std::uint8_t endpoint, std::span<const std::uint8_t> payload) override;
  int in(std::uint8_t endpoint, std::span<std::uint8_t> payload) override;
  std::string command(const std::string& line);

private:
  HidDescription description_;
  std::mutex mutex_;
  std::deque<std::vector<std::uint8_t>> reports_;
  std::vector<std::uint8_t> written_;
  long writes_ = 0;
  MockUsb usb_;
};

} // namespace tactus::mock
