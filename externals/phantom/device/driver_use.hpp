#pragma once

#include "devices/driver.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tactus::phantom {

/// Registers that a device of a driver is being opened, open or being closed by any object of this
/// process. A driver in use is not asked for a list, since some libraries would then disturb the
/// running device.
class DriverUse {
public:
  /// Waits while that driver makes a list or closes a device, while keep_waiting() is true and for
  /// 3 s at most. After that returns null, with one sentence in `refusal`.
  [[nodiscard]] static std::unique_ptr<DriverUse> enter(const devices::Driver& driver,
                                                        const std::function<bool()>& keep_waiting,
                                                        std::string& refusal);
  ~DriverUse();
  DriverUse(const DriverUse&) = delete;
  DriverUse& operator=(const DriverUse&) = delete;

  /// Whether other objects use devices of this driver, too.
  [[nodiscard]] bool shared() const;
  /// Marks the device as open.
  void opened(haptic::Identity identity);
  /// Call it before the device is closed. enter() for this driver then waits until this object is
  /// destroyed.
  void leave();

  /// The devices of one driver: the driver's own list or, while the driver is in use, its last list
  /// and the devices in use.
  struct Listed {
    std::string problem; ///< why the driver is unavailable
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
