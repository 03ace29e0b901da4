#pragma once

#include "core/haptic/servo/servo.hpp"
#include "externals/phantom/reports.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tactus::phantom {

/// Troubles of a real device: sent to the patch as `trouble DRIVER SENTENCE`, and once to the
/// host's window.
class Trouble {
public:
  /// The device has been opened.
  void begin(std::string_view driver, const Reports& reports, Host& host);
  /// Reports changes of the device's state flags. The first report after opening always
  /// includes whether the device is homed, since it may have been homed before this thread first
  /// read the flags.
  void watch_flags(std::uint32_t flags, const Reports& reports, Host& host);
  /// Whether it is time to ask the driver for its trouble.
  [[nodiscard]] bool due(double now_ms) noexcept;
  /// What it says; reported when it has lasted, as is its end.
  void watch(std::string problem, std::string_view driver, const Reports& reports, Host& host);
  /// A trouble that is reported now; empty: its end.
  void report(std::string_view sentence, std::string_view driver, const Reports& reports,
              Host& host);

private:
  std::optional<std::uint32_t> flags_; ///< none: not reported since opening
  std::string sent_, latest_;          ///< as sent to the patch; as last read from the driver
  double since_ms_ = 0;                ///< when the latest one changed
  double polled_ms_ = -1e9;
};

/// Sends one of no duration.
void send_trouble(std::string_view sentence, std::string_view driver, const Reports& reports,
                  Host& host);

} // namespace tactus::phantom
