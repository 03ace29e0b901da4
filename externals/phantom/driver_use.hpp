#pragma once

#include "devices/driver.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tactus::phantom {

/// One device of a driver while it is opened, open or closed, whichever object of this process
/// holds it. A driver that is in use is not asked for a list: some libraries count, load or close
/// devices then, beside the one that runs.
class DriverUse {
public:
  /// Waits until no list and no closing of that driver is under way, as long as `wanted`; null and
  /// one sentence in `refusal` when they take too long.
  [[nodiscard]] static std::unique_ptr<DriverUse> enter(const devices::Driver& driver,
                                                        const std::function<bool()>& keep_waiting,
                                                        std::string& refusal);
  ~DriverUse();
  DriverUse(const DriverUse&) = delete;
  DriverUse& operator=(const DriverUse&) = delete;

  /// Other objects have devices of this driver, too.
  [[nodiscard]] bool shared() const;
  void opened(haptic::Identity identity);
  /// It is not wanted any more: who opens a device of this driver waits until this is destroyed.
  void leave();

  /// What one driver finds: from the driver itself or, while it is in use, from what is known.
  struct Listed {
    std::string problem; ///< why the driver cannot work
    std::vector<devices::Found> found;
  };
  [[nodiscard]] static Listed list(const devices::Driver& driver);

private:
  enum class Phase { kOpening, kOpen, kLeaving };
  explicit DriverUse(const devices::Driver& driver) : driver_(driver) {}
  static Listed known(const devices::Driver& driver);
  struct Table;
  static Table& table();

  const devices::Driver& driver_;
  Phase phase_ = Phase::kOpening;
  haptic::Identity identity_{};
};

} // namespace tactus::phantom
