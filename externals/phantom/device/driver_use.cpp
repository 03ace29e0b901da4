#include "externals/phantom/device/driver_use.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>

namespace tactus::phantom {
namespace {

constexpr auto kWaitInterval = std::chrono::milliseconds(5);
constexpr auto kTimeout = std::chrono::seconds(3);

} // namespace

struct DriverUse::Table {
  std::mutex mutex;
  std::vector<DriverUse*> uses;
  std::map<const devices::Driver*, int> listings;
  std::map<const devices::Driver*, std::vector<devices::Found>> last_found;
};

/// Never destroyed, since threads that hang in a driver may still use it.
DriverUse::Table& DriverUse::table() {
  static auto* const made = new Table;
  return *made;
}

std::unique_ptr<DriverUse> DriverUse::enter(const devices::Driver& driver,
                                            const std::function<bool()>& keep_waiting,
                                            std::string& refusal) {
  auto use = std::unique_ptr<DriverUse>(new DriverUse(driver));
  const auto end = std::chrono::steady_clock::now() + kTimeout;
  for (;;) {
    {
      const std::scoped_lock lock(table().mutex);
      const bool leaving =
          std::any_of(table().uses.begin(), table().uses.end(), [&](const DriverUse* other) {
            return &other->driver_ == &driver && other->phase_ == Phase::kLeaving;
          });
      if (!leaving && table().listings[&driver] == 0) {
        table().uses.push_back(use.get());
        return use;
      }
    }
    if (!keep_waiting() || std::chrono::steady_clock::now() > end)
      break;
    std::this_thread::sleep_for(kWaitInterval);
  }
  refusal = std::string(driver.name) +
            ": an earlier call of this driver has not returned; switch the device off and on, "
            "then open it again, and if that does not help, restart the host";
  return nullptr;
}

DriverUse::~DriverUse() {
  const std::scoped_lock lock(table().mutex);
  std::erase(table().uses, this);
}

bool DriverUse::shared() const {
  const std::scoped_lock lock(table().mutex);
  return std::any_of(table().uses.begin(), table().uses.end(), [this](const DriverUse* other) {
    return other != this && &other->driver_ == &driver_;
  });
}

void DriverUse::opened(haptic::Identity identity) {
  const std::scoped_lock lock(table().mutex);
  phase_ = phase_ == Phase::kLeaving ? phase_ : Phase::kOpen;
  identity_ = std::move(identity);
}

void DriverUse::leave() {
  const std::scoped_lock lock(table().mutex);
  phase_ = Phase::kLeaving;
}

/// Returns the last list, with the devices in use marked. The caller holds the table's lock.
DriverUse::Listed DriverUse::known(const devices::Driver& driver) {
  Listed listed{{}, table().last_found[&driver]};
  for (const DriverUse* use : table().uses) {
    if (&use->driver_ != &driver)
      continue;
    const char* state = use->phase_ == Phase::kOpen ? "open" : "busy";
    const std::string& serial = use->identity_.serial;
    const auto entry =
        std::find_if(listed.found.begin(), listed.found.end(), [&](const devices::Found& found) {
          const bool same =
              serial.empty() || found.identity.serial.empty() || found.identity.serial == serial;
          return same && found.state != "open" && found.state != "busy";
        });
    if (entry == listed.found.end()) {
      const auto index = static_cast<int>(listed.found.size());
      listed.found.push_back({driver.name, index, use->identity_, state});
      continue;
    }
    entry->state = state;
    if (!serial.empty()) // the open device reports more than the list
      entry->identity = use->identity_;
  }
  return listed;
}

DriverUse::Listed DriverUse::list(const devices::Driver& driver) {
  {
    const std::scoped_lock lock(table().mutex);
    if (std::any_of(table().uses.begin(), table().uses.end(),
                    [&](const DriverUse* use) { return &use->driver_ == &driver; }))
      return known(driver);
    ++table().listings[&driver];
  }
  Listed listed;
  listed.problem = driver.problem();
  if (listed.problem.empty())
    listed.found = driver.list();
  const std::scoped_lock lock(table().mutex);
  --table().listings[&driver];
  table().last_found[&driver] = listed.found;
  return listed;
}

} // namespace tactus::phantom
