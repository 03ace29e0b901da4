#include "devices/falcon/link.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

namespace tactus::devices::falcon {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint16_t kVendor = 0x0403, kProduct = 0xcb48;
// A pending transfer cannot be interrupted, so each has a short timeout; libusb then reports the
// bytes transferred, and the rest is sent in the next transfer.
constexpr unsigned kControl_ms = 200, kBulk_ms = 100;
constexpr double kSend_s = 0.5, kSlice_s = 0.05;
constexpr std::uint8_t kToChip = 0x40; // vendor request, host to device
constexpr std::uint16_t kEightBits = 8, kNoFlow = 0;
constexpr std::uint16_t kReadyLow = 0x0100, kReadyHigh = 0x0101, kSendLow = 0x0200;
constexpr std::uint16_t kDivisor9600 = 0x4138, kDivisor140k = 0x15, kDivisor1500k = 0x2;
constexpr std::uint8_t kClearToSend = 0x10; // bit of the first status byte

std::string path_of(UsbLibrary& usb, libusb_device* device) {
  std::array<std::uint8_t, 7> ports{};
  const int depth = usb.get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string path = std::to_string(usb.get_bus_number(device));
  for (int i = 0; i < depth; ++i)
    path += (i ? "." : "-") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return path;
}

std::string why_not_opened(UsbLibrary& usb, int error) {
  if (error == LIBUSB_ERROR_ACCESS)
    return "no permission: install tactus's udev rules and plug the device in again";
  if (error == LIBUSB_ERROR_BUSY)
    return "another program uses it: close that program";
  if (error == LIBUSB_ERROR_NO_DEVICE || error == LIBUSB_ERROR_NOT_FOUND)
    return "it was unplugged: plug it in again";
  return std::string("libusb reports ") + usb.error_name(error);
}

// Calls visit(device, descriptor) for each Falcon until visit returns true.
template <class Visit> void for_each_falcon(UsbLibrary& usb, libusb_context* context, Visit visit) {
  libusb_device** list = nullptr;
  const auto count = usb.get_device_list(context, &list);
  for (decltype(+count) i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (usb.get_device_descriptor(list[i], &descriptor) == 0 && descriptor.idVendor == kVendor &&
        descriptor.idProduct == kProduct && visit(list[i], descriptor))
      break;
  }
  if (count >= 0)
    usb.free_device_list(list, 1);
}

Port port_of(UsbLibrary& usb, libusb_device* device, const libusb_device_descriptor& descriptor,
             libusb_device_handle* handle) {
  Port port;
  port.path = path_of(usb, device);
  std::array<unsigned char, 128> text{};
  if (descriptor.iSerialNumber) {
    const int length = usb.get_string_descriptor_ascii(handle, descriptor.iSerialNumber,
                                                       text.data(), static_cast<int>(text.size()));
    if (length > 0)
      port.serial.assign(text.begin(), text.begin() + length);
  }
  return port;
}

} // namespace

std::vector<Port> Link::ports(UsbLibrary& usb, const IsOpen& is_open) {
  std::vector<Port> found;
  libusb_context* context = nullptr;
  if (usb.init(&context) != 0)
    return found;
  for_each_falcon(usb, context,
                  [&](libusb_device* device, const libusb_device_descriptor& descriptor) {
                    if (std::string path = path_of(usb, device); is_open(path)) {
                      found.push_back({std::move(path), {}, {}});
                      return false;
                    }
                    libusb_device_handle* handle = nullptr;
                    const int error = usb.open(device, &handle);
                    if (error == 0) {
                      found.push_back(port_of(usb, device, descriptor, handle));
                      usb.close(handle);
                    } else {
                      found.push_back({path_of(usb, device), {}, why_not_opened(usb, error)});
                    }
                    return false;
                  });
  usb.exit(context);
  return found;
}

std::string Link::open(const std::string& which, const IsOpen& is_open) {
  close();
  if (usb_->init(&context_) != 0) {
    context_ = nullptr;
    return "libusb cannot start: check that /dev/bus/usb exists";
  }
  int index = -1;
  std::string problem;
  const auto visit = [&](libusb_device* device, const libusb_device_descriptor& descriptor) {
    ++index;
    const std::string path = path_of(*usb_, device);
    const bool named = which == std::to_string(index) || which == path;
    if (is_open(path)) {
      problem = "the Falcon at " + path + " is already open in this program: close it there";
      return named;
    }
    libusb_device_handle* handle = nullptr;
    const int error = usb_->open(device, &handle);
    Port port = error == 0 ? port_of(*usb_, device, descriptor, handle) : Port{path, {}, {}};
    const bool requested = named || which.empty() || which == port.serial;
    if (requested && error == 0) {
      handle_ = handle;
      port_ = std::move(port);
      return true;
    }
    if (requested)
      problem = "the Falcon at " + path + " cannot be opened: " + why_not_opened(*usb_, error);
    if (error == 0)
      usb_->close(handle);
    return requested;
  };
  for_each_falcon(*usb_, context_, visit);
  if (!handle_) {
    close();
    if (!problem.empty())
      return problem;
    return index < 0 ? "no Falcon (USB 0403:cb48) is plugged in: check its cable and power"
                     : "Falcon " + which + ": not found; send devices for a list";
  }
  usb_->set_auto_detach_kernel_driver(handle_, 1);
  const int error = usb_->claim_interface(handle_, 0);
  if (error != 0) {
    close();
    return "cannot claim the Falcon's USB interface: " + why_not_opened(*usb_, error);
  }
  claimed_ = true;
  return {};
}

void Link::close() noexcept {
  if (handle_) {
    if (claimed_)
      usb_->release_interface(handle_, 0);
    usb_->close(handle_);
  }
  if (context_)
    usb_->exit(context_);
  handle_ = nullptr;
  context_ = nullptr;
  claimed_ = clear_to_send_ = false;
}

bool Link::set(Request request, std::uint16_t value) noexcept {
  return !cancelled() &&
         usb_->control_transfer(handle_, kToChip, static_cast<std::uint8_t>(request), value, 0,
                                nullptr, 0, kControl_ms) >= 0;
}

bool Link::enter_boot_loader() noexcept {
  return purge() && set(Request::kLatency, 16) && set(Request::kDivisor, kDivisor9600) &&
         set(Request::kFormat, kEightBits) && set(Request::kFlow, kNoFlow) &&
         set(Request::kModem, kSendLow) && set(Request::kModem, kReadyLow) &&
         set(Request::kModem, kReadyHigh);
}

bool Link::enter_upload() noexcept {
  return set(Request::kModem, kReadyLow) && set(Request::kDivisor, kDivisor140k);
}

bool Link::enter_run() noexcept {
  return set(Request::kLatency, 1) && set(Request::kDivisor, kDivisor1500k) &&
         set(Request::kFormat, kEightBits) && set(Request::kFlow, kNoFlow) && purge();
}

bool Link::send(std::span<const std::uint8_t> bytes) noexcept {
  const auto end = Clock::now() + std::chrono::duration<double>(kSend_s);
  std::array<unsigned char, kTransferBytes> buffer{};
  while (!bytes.empty()) {
    if (cancelled() || Clock::now() > end)
      return false;
    const std::size_t length = std::min(bytes.size(), buffer.size());
    std::copy_n(bytes.begin(), length, buffer.begin());
    int sent = 0;
    const int error = usb_->bulk_transfer(handle_, kOutEndpoint, buffer.data(),
                                          static_cast<int>(length), &sent, kBulk_ms);
    if (error != 0 && error != LIBUSB_ERROR_TIMEOUT)
      return false;
    bytes = bytes.subspan(static_cast<std::size_t>(std::max(sent, 0)));
  }
  return true;
}

bool Link::receive(std::vector<std::uint8_t>& bytes, std::size_t requested, double limit_s) {
  const auto end = Clock::now() + std::chrono::duration<double>(limit_s);
  while (bytes.size() < requested) {
    const double left_s = std::chrono::duration<double>(end - Clock::now()).count();
    if (cancelled())
      return false;
    if (left_s <= 0)
      return true;
    std::array<unsigned char, kTransferBytes> buffer{};
    int got = 0;
    const int error =
        usb_->bulk_transfer(handle_, kInEndpoint, buffer.data(), static_cast<int>(buffer.size()),
                            &got, static_cast<unsigned>(std::min(left_s, kSlice_s) * 1e3) + 1);
    if (error != 0 && error != LIBUSB_ERROR_TIMEOUT)
      return false;
    if (got > 0)
      clear_to_send_ = (buffer[0] & kClearToSend) != 0;
    if (got > static_cast<int>(kStatusBytes))
      bytes.insert(bytes.end(), buffer.begin() + kStatusBytes, buffer.begin() + got);
  }
  return true;
}

bool Link::pause(double seconds) const {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!cancelled() && Clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !cancelled();
}

} // namespace tactus::devices::falcon
