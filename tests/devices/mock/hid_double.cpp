#include "tests/devices/mock/hid_double.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace tactus::mock {
namespace {

std::vector<std::uint8_t> bytes_of(std::istream& words) {
  std::vector<std::uint8_t> bytes;
  for (std::string word; words >> word;)
    for (std::size_t i = 0; i + 1 < word.size(); i += 2)
      bytes.push_back(static_cast<std::uint8_t>(std::stoi(word.substr(i, 2), nullptr, 16)));
  return bytes;
}

std::string state(long writes, std::span<const std::uint8_t> last) {
  return "writes=" + std::to_string(writes) + " last=" + hexadecimal(last);
}

std::string id(std::uint16_t word) {
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(word >> 8),
                                static_cast<std::uint8_t>(word)};
  return hexadecimal(bytes);
}

std::string lower(std::string text) {
  for (char& letter : text)
    letter = static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter + 32 : letter);
  return text;
}

UsbDescription usb_of(const HidDescription& d) {
  UsbDescription usb;
  usb.name = "1-2";
  usb.address = 3;
  usb.vendor = d.vendor;
  usb.product = d.product;
  usb.release = 0x0431;
  usb.manufacturer = d.manufacturer;
  usb.model = d.model;
  usb.serial = d.serial;
  const auto size = static_cast<std::uint16_t>(d.report_descriptor.size());
  const auto low = static_cast<std::uint8_t>(size), high = static_cast<std::uint8_t>(size >> 8);
  usb.configuration = {9, 2, 34,   0,    1, 1, 0, 0x80, 50,  9,    4, 0, 0,    1, 3,  0, 0,
                       0, 9, 0x21, 0x11, 1, 0, 1, 0x22, low, high, 7, 5, 0x81, 3, 16, 0, 8};
  return usb;
}

} // namespace

HidrawDouble::HidrawDouble(UMockdevTestbed* bed, HidDescription description)
    : bed_(bed), description_(std::move(description)), handler_(umockdev_ioctl_base_new()) {
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(on_ioctl), this);
  g_signal_connect(handler_, "handle-write", G_CALLBACK(on_write), this);
  plug();
}

HidrawDouble::~HidrawDouble() {
  for (const std::string& node : nodes_)
    umockdev_testbed_detach_ioctl(bed_, node.c_str(), nullptr);
  g_object_unref(handler_);
}

// The kernel makes four things of a HID device: USB device, interface, hid, hidraw.
void HidrawDouble::plug() {
  if (feed_ >= 0)
    return;
  ++number_;
  const HidDescription& d = description_;
  const std::string number = std::to_string(number_), name = "hidraw" + number;
  const std::string base = "/devices/pci0000:00/0000:00:14.0/usb1/1-2", port = base + "/1-2:1.0";
  const std::string hid_id = "0003:" + id(d.vendor) + ":" + id(d.product) + ".000" + number;
  const std::string hid = port + "/" + hid_id;
  const std::string long_id = "0003:0000" + id(d.vendor) + ":0000" + id(d.product);
  const std::string full_name = d.manufacturer + " " + d.model;
  std::string records = "P: " + base + "\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nE: PRODUCT=" +
                        lower(id(d.vendor)) + "/" + lower(id(d.product)) +
                        "/431\nA: idVendor=" + lower(id(d.vendor)) +
                        "\\n\nA: idProduct=" + lower(id(d.product)) +
                        "\\n\nA: bcdDevice=0431\\n\nA: manufacturer=" + d.manufacturer +
                        "\\n\nA: product=" + d.model + "\\n\n" +
                        (d.serial.empty() ? "" : "A: serial=" + d.serial + "\\n\n") + "\n";
  records += "P: " + port +
             "\nE: DEVTYPE=usb_interface\nE: SUBSYSTEM=usb\nE: INTERFACE=3/0/0\n"
             "A: bInterfaceNumber=00\\n\nA: bInterfaceClass=03\\n\n\n";
  records += "P: " + hid + "\nE: SUBSYSTEM=hid\nE: HID_ID=" + long_id +
             "\nE: HID_NAME=" + full_name + "\nE: HID_UNIQ=" + d.serial +
             "\nA: uevent=HID_ID=" + long_id + "\\nHID_NAME=" + full_name +
             "\\nHID_PHYS=usb-1-2/input0\\nHID_UNIQ=" + d.serial +
             "\\n\nH: report_descriptor=" + hexadecimal(d.report_descriptor) + "\n\n";
  // Without the link hidapi's search finds nothing.
  records += "P: " + hid + "/hidraw/" + name + "\nN: " + name + "\nE: DEVNAME=/dev/" + name +
             "\nE: SUBSYSTEM=hidraw\nE: MAJOR=242\nE: MINOR=" + number + "\nL: device=../../../" +
             hid_id + "\n\n";
  GError* error = nullptr;
  const std::string node = "/dev/" + name;
  if (!umockdev_testbed_add_from_string(bed_, records.c_str(), &error) ||
      !umockdev_testbed_attach_ioctl(bed_, node.c_str(), handler_, &error))
    throw std::runtime_error(error ? error->message : "hidraw double");
  nodes_.push_back(node);
  paths_ = {base, port, hid, hid + "/hidraw/" + name};
  feed_ = umockdev_testbed_get_dev_fd(bed_, node.c_str());
  fcntl(feed_, F_SETFD, FD_CLOEXEC); // the program under test must not keep it alive
}

void HidrawDouble::unplug() {
  if (feed_ < 0)
    return;
  for (; !paths_.empty(); paths_.pop_back())
    umockdev_testbed_remove_device(bed_, ("/sys" + paths_.back()).c_str());
  close(feed_); // whoever reads the node sees it hang up
  feed_ = -1;
}

std::string HidrawDouble::command(const std::string& line) {
  std::istringstream words(line);
  std::string name;
  words >> name;
  if (name == "report") {
    const auto bytes = bytes_of(words);
    const bool sent = feed_ >= 0 && write(feed_, bytes.data(), bytes.size()) > 0;
    usleep(8000); // a device's pace; the node here is a terminal, which would join two reports
    return sent ? "ok" : "gone";
  }
  if (name == "unplug" || name == "plug") {
    name == "plug" ? plug() : unplug();
    return "ok";
  }
  const std::scoped_lock lock(mutex_);
  return name == "state" ? state(writes_, written_) : "?";
}

gboolean HidrawDouble::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  const auto& bytes = static_cast<HidrawDouble*>(self)->description_.report_descriptor;
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  bool known = true;
  if (request == HIDIOCGRDESCSIZE) {
    auto* size = umockdev_ioctl_data_resolve(argument, 0, sizeof(int), nullptr);
    if (size)
      *reinterpret_cast<int*>(size->data) = static_cast<int>(bytes.size());
  } else if (request == HIDIOCGRDESC) {
    auto* data =
        umockdev_ioctl_data_resolve(argument, 0, sizeof(hidraw_report_descriptor), nullptr);
    if (data) {
      auto* descriptor = reinterpret_cast<hidraw_report_descriptor*>(data->data);
      descriptor->size = static_cast<std::uint32_t>(bytes.size());
      std::copy(bytes.begin(), bytes.end(), descriptor->value);
    }
  } else {
    known = false;
  }
  umockdev_ioctl_client_complete(client, known ? 0 : -1, known ? 0 : ENOTTY);
  return TRUE;
}

gboolean HidrawDouble::on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  auto& hidraw = *static_cast<HidrawDouble*>(self);
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  {
    const std::scoped_lock lock(hidraw.mutex_);
    ++hidraw.writes_;
    hidraw.written_.assign(argument->data, argument->data + argument->data_len);
  }
  umockdev_ioctl_client_complete(client, static_cast<glong>(argument->data_len), 0);
  return TRUE;
}

UsbHidDouble::UsbHidDouble(UMockdevTestbed* bed, HidDescription description)
    : description_(std::move(description)), usb_(bed, usb_of(description_), *this) {}

int UsbHidDouble::control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t> payload) {
  const std::scoped_lock lock(mutex_);
  const int value = setup[2] | setup[3] << 8;
  if (setup[0] == 0x81 && setup[1] == 6 && value == 0x2200) { // report descriptor
    const auto& bytes = description_.report_descriptor;
    const std::size_t length = std::min(bytes.size(), payload.size());
    std::copy_n(bytes.begin(), length, payload.begin());
    return static_cast<int>(length);
  }
  if (setup[0] == 0x21 && setup[1] == 9) { // set report
    ++writes_;
    written_.assign(payload.begin(), payload.end());
    return static_cast<int>(payload.size());
  }
  return setup[0] & 0x80 ? -EPIPE : 0;
}

int UsbHidDouble::out(std::uint8_t, std::span<const std::uint8_t> payload) {
  return static_cast<int>(payload.size());
}

int UsbHidDouble::in(std::uint8_t, std::span<std::uint8_t> payload) {
  const std::scoped_lock lock(mutex_);
  if (reports_.empty())
    return -EAGAIN;
  const std::size_t length = std::min(reports_.front().size(), payload.size());
  std::copy_n(reports_.front().begin(), length, payload.begin());
  reports_.pop_front();
  return static_cast<int>(length);
}

std::string UsbHidDouble::command(const std::string& line) {
  std::istringstream words(line);
  std::string name;
  words >> name;
  if (name == "unplug" || name == "plug") {
    name == "plug" ? usb_.plug() : usb_.unplug();
    return "ok";
  }
  const std::scoped_lock lock(mutex_);
  if (name == "report") {
    reports_.push_back(bytes_of(words));
    return "ok";
  }
  return name == "state" ? state(writes_, written_) : "?";
}

} // namespace tactus::mock
