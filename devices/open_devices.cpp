#include "devices/open_devices.hpp"

#include <algorithm>
#include <mutex>

namespace tactus::devices {
namespace {

struct Entry {
  const OpenDevice* owner;
  Opened device;
};

// Never destroyed: a device may be closed while the program ends.
std::mutex& guard() {
  static std::mutex& mutex = *new std::mutex;
  return mutex;
}
std::vector<Entry>& entries() {
  static std::vector<Entry>& all = *new std::vector<Entry>;
  return all;
}

} // namespace

void OpenDevice::set(std::string_view driver, int index, haptic::Identity identity,
                     std::string address) {
  clear();
  const std::scoped_lock lock(guard());
  entries().push_back(
      {this, {{driver, index, std::move(identity), "open in this program"}, std::move(address)}});
  set_ = true;
}

void OpenDevice::clear() noexcept {
  if (!set_)
    return;
  const std::scoped_lock lock(guard());
  std::erase_if(entries(), [this](const Entry& entry) { return entry.owner == this; });
  set_ = false;
}

bool is_open(std::string_view driver, std::string_view address) {
  const std::scoped_lock lock(guard());
  return std::any_of(entries().begin(), entries().end(), [&](const Entry& entry) {
    return entry.device.found.driver == driver && entry.device.address == address;
  });
}

std::vector<Opened> open_devices(std::string_view driver) {
  const std::scoped_lock lock(guard());
  std::vector<Opened> opened;
  for (const Entry& entry : entries())
    if (entry.device.found.driver == driver)
      opened.push_back(entry.device);
  return opened;
}

} // namespace tactus::devices
