#include "tests/devices/mock/mock_usb.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace tactus::mock {
namespace {

std::string digits(int number, int width) {
  std::string text = std::to_string(number);
  while (static_cast<int>(text.size()) < width)
    text.insert(text.begin(), '0');
  return text;
}

std::string hexadecimal_id(std::uint16_t id) {
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id)};
  std::string text = hexadecimal(bytes);
  for (char& letter : text)
    letter = static_cast<char>(letter >= 'A' ? letter + 32 : letter);
  return text;
}

std::vector<std::uint8_t> descriptors(const UsbDescription& d) {
  std::vector<std::uint8_t> bytes{18, 1, 0, 2, 0, 0, 0, 8};
  for (const std::uint16_t word : {d.vendor, d.product, d.release})
    for (const int shift : {0, 8})
      bytes.push_back(static_cast<std::uint8_t>(word >> shift));
  for (const int last : {1, 2, d.serial.empty() ? 0 : 3, 1}) // strings; one configuration
    bytes.push_back(static_cast<std::uint8_t>(last));
  bytes.insert(bytes.end(), d.configuration.begin(), d.configuration.end());
  return bytes;
}

std::string record(const UsbDescription& d, const std::string& path) {
  const std::string node = "bus/usb/" + digits(d.bus, 3) + "/" + digits(d.address, 3);
  const std::string all = hexadecimal(descriptors(d));
  const auto attribute = [](const char* name, const std::string& value) {
    return std::string("A: ") + name + "=" + value + "\\n\n";
  };
  std::string text = "P: " + path + "\nN: " + node + "=" + all + "\n";
  text += "E: DEVNAME=/dev/" + node + "\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\n";
  text += "E: BUSNUM=" + digits(d.bus, 3) + "\nE: DEVNUM=" + digits(d.address, 3) + "\n";
  text += "E: MAJOR=189\nE: MINOR=" + std::to_string(d.address - 1) + "\n";
  text += "E: PRODUCT=" + hexadecimal_id(d.vendor) + "/" + hexadecimal_id(d.product) + "/" +
          hexadecimal_id(d.release) + "\n";
  text +=
      attribute("busnum", std::to_string(d.bus)) + attribute("devnum", std::to_string(d.address));
  text += attribute("idVendor", hexadecimal_id(d.vendor)) +
          attribute("idProduct", hexadecimal_id(d.product)) +
          attribute("bcdDevice", hexadecimal_id(d.release));
  text += attribute("bConfigurationValue", "1") + attribute("bNumConfigurations", "1") +
          attribute("speed", "12");
  text += attribute("manufacturer", d.manufacturer) + attribute("product", d.model);
  if (!d.serial.empty())
    text += attribute("serial", d.serial);
  text += "H: descriptors=" + all + "\n\n";
  return text + d.further_records;
}

void check(gboolean done, GError* error, const char* what) {
  if (done)
    return;
  const std::string reason = error ? error->message : "unknown";
  g_clear_error(&error);
  throw std::runtime_error(std::string(what) + ": " + reason);
}

} // namespace

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

MockUsb::MockUsb(UMockdevTestbed* bed, UsbDescription description, UsbDevice& device)
    : bed_(bed), description_(std::move(description)), device_(device),
      handler_(umockdev_ioctl_base_new()) {
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(on_ioctl), this);
  plug();
}

MockUsb::~MockUsb() {
  for (const std::string& node : nodes_)
    umockdev_testbed_detach_ioctl(bed_, node.c_str(), nullptr);
  g_object_unref(handler_);
}

std::string MockUsb::node() const {
  return "/dev/bus/usb/" + digits(description_.bus, 3) + "/" + digits(description_.address, 3);
}

std::string MockUsb::path() const {
  return "/devices/pci0000:00/0000:00:14.0/usb1/" + description_.name;
}

void MockUsb::plug() {
  if (plugged_)
    return;
  if (!nodes_.empty())
    ++description_.address; // as the kernel does; programs may still hold the old node
  GError* error = nullptr;
  check(umockdev_testbed_add_from_string(bed_, record(description_, path()).c_str(), &error), error,
        "the device cannot be added");
  check(umockdev_testbed_attach_ioctl(bed_, node().c_str(), handler_, &error), error,
        "the node cannot be served");
  nodes_.push_back(node());
  const std::scoped_lock lock(mutex_);
  pending_.clear();
  discarded_.clear();
  plugged_ = true;
}

void MockUsb::unplug() {
  {
    const std::scoped_lock lock(mutex_);
    if (!plugged_)
      return;
    plugged_ = false;
  }
  const std::string sys = "/sys" + path();
  umockdev_testbed_uevent(bed_, sys.c_str(), "remove");
  umockdev_testbed_remove_device(bed_, sys.c_str());
}

gboolean MockUsb::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  static_cast<MockUsb*>(self)->serve(client);
  return TRUE;
}

// Strings are answered here, as every device has them; the rest is the device's.
int MockUsb::control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t> payload) {
  constexpr std::uint8_t kGetDescriptor = 6, kString = 3;
  if (setup[0] != 0x80 || setup[1] != kGetDescriptor || setup[3] != kString)
    return device_.control(setup, payload);
  const std::string* strings[] = {&description_.manufacturer, &description_.model,
                                  &description_.serial};
  if (setup[2] > 3)
    return -EPIPE;
  std::vector<std::uint8_t> bytes{0, kString};
  if (setup[2] == 0) {
    bytes.push_back(0x09); // English
    bytes.push_back(0x04);
  } else {
    for (const char letter : *strings[setup[2] - 1]) {
      bytes.push_back(static_cast<std::uint8_t>(letter));
      bytes.push_back(0);
    }
  }
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  const std::size_t length = std::min(bytes.size(), payload.size());
  std::copy_n(bytes.begin(), length, payload.begin());
  return static_cast<int>(length);
}

// True when the transfer is done, well or badly.
bool MockUsb::finish(Transfer& transfer) {
  auto* urb = reinterpret_cast<usbdevfs_urb*>(transfer.urb->data);
  const std::span<std::uint8_t> payload(transfer.payload ? transfer.payload->data : nullptr,
                                        static_cast<std::size_t>(urb->buffer_length));
  int result = -ENODEV;
  if (plugged_) {
    if (urb->type == USBDEVFS_URB_TYPE_CONTROL)
      result = control(payload.first<8>(), payload.subspan(8));
    else if (urb->endpoint & 0x80)
      result = device_.in(urb->endpoint, payload);
    else
      result = device_.out(urb->endpoint, payload);
  }
  if (result == -EAGAIN)
    return false;
  urb->status = result < 0 ? result : 0;
  urb->actual_length = result < 0 ? 0 : result;
  return true;
}

void MockUsb::reap(UMockdevIoctlClient* client, UMockdevIoctlData* result) {
  const auto deliver = [&](const Transfer& transfer) {
    umockdev_ioctl_data_set_ptr(result, 0, transfer.urb);
    umockdev_ioctl_client_complete(client, 0, 0);
  };
  if (!discarded_.empty()) {
    const Transfer transfer = discarded_.front();
    discarded_.pop_front();
    reinterpret_cast<usbdevfs_urb*>(transfer.urb->data)->status = -ENOENT;
    return deliver(transfer);
  }
  for (auto i = pending_.begin(); i != pending_.end(); ++i)
    if (finish(*i)) {
      const Transfer transfer = *i;
      pending_.erase(i);
      return deliver(transfer);
    }
  // The node is a plain file, always ready for poll(): without a pause clients spin.
  usleep(200);
  umockdev_ioctl_client_complete(client, -1, plugged_ ? EAGAIN : ENODEV);
}

void MockUsb::serve(UMockdevIoctlClient* client) {
  const std::scoped_lock lock(mutex_);
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  const std::size_t size = _IOC_SIZE(request);
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  UMockdevIoctlData* data =
      size ? umockdev_ioctl_data_resolve(argument, 0, size, nullptr) : nullptr;
  const auto answer = [client](long result, int error) {
    umockdev_ioctl_client_complete(client, result, error);
  };
  if (size && !data)
    return answer(-1, EIO); // the client has gone
  switch (request) {
  case USBDEVFS_GET_CAPABILITIES:
    *reinterpret_cast<std::uint32_t*>(data->data) =
        USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION | USBDEVFS_CAP_NO_PACKET_SIZE_LIM;
    return answer(0, 0);
  case USBDEVFS_CLAIMINTERFACE:
  case USBDEVFS_DISCONNECT_CLAIM:
  case USBDEVFS_RELEASEINTERFACE:
  case USBDEVFS_SETCONFIGURATION:
  case USBDEVFS_SETINTERFACE:
  case USBDEVFS_CLEAR_HALT:
  case USBDEVFS_RESET:
    return plugged_ ? answer(0, 0) : answer(-1, ENODEV);
  case USBDEVFS_GETDRIVER:
  case USBDEVFS_IOCTL:
    return answer(-1, ENODATA); // no kernel driver holds the interface
  case USBDEVFS_SUBMITURB: {
    if (!plugged_)
      return answer(-1, ENODEV);
    const auto length =
        static_cast<std::size_t>(reinterpret_cast<usbdevfs_urb*>(data->data)->buffer_length);
    UMockdevIoctlData* payload =
        length ? umockdev_ioctl_data_resolve(data, offsetof(usbdevfs_urb, buffer), length, nullptr)
               : nullptr;
    if (length && !payload)
      return answer(-1, EIO);
    pending_.push_back({data, payload});
    return answer(0, 0);
  }
  case USBDEVFS_DISCARDURB: {
    const unsigned long address = *reinterpret_cast<unsigned long*>(argument->data);
    for (auto i = pending_.begin(); i != pending_.end(); ++i)
      if (i->urb->client_addr == address) {
        discarded_.push_back(*i);
        pending_.erase(i);
        return answer(0, 0);
      }
    return answer(-1, EINVAL);
  }
  case USBDEVFS_REAPURB:
  case USBDEVFS_REAPURBNDELAY:
    return reap(client, data);
  default:
    return answer(-1, ENOTTY);
  }
}

} // namespace tactus::mock
