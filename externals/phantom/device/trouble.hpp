#pragma once

#include "externals/phantom/device/device_link.hpp"
#include "externals/phantom/reports.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tactus::phantom {

/// Reports troubles of a real device: to the patch as `trouble DRIVER SENTENCE`, and once to the
/// host's window.
class Trouble {
public:
  Trouble(const ServoSession& session, const DeviceLink& link, const Reports& reports)
      : session_(session), link_(link), reports_(reports) {}

  /// Call it when the device has been opened.
  void begin(Host& host);
  /// Reports changes of the open device's state and troubles. `silence_s` is the time since the
  /// servo's last report. Returns a new fault, if there is one.
  [[nodiscard]] std::optional<haptic::Fault> watch(double silence_s, Host& host);
  /// Reports a lasting trouble at once; an empty sentence reports its end.
  void report(std::string_view sentence, Host& host);
  /// Sends a trouble that has no duration.
  void send(std::string_view sentence, Host& host) const;

private:
  void watch_flags(std::uint32_t flags, Host& host);
  void watch_sentence(std::string sentence, Host& host);

  const ServoSession& session_;
  const DeviceLink& link_;
  const Reports& reports_;
  std::optional<std::uint32_t> flags_; ///< empty if not reported since opening
  std::uint32_t faults_ = 0;
  std::string sent_, latest_; ///< last sent to the patch; last read from the driver
  double since_ms_ = 0;       ///< time at which latest_ changed
  double polled_ms_ = -1e9;
};

} // namespace tactus::phantom
