#pragma once

#include "externals/phantom/device/device_link.hpp"
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
  Trouble(const ServoSession& session, const DeviceLink& link, const Reports& reports)
      : session_(session), link_(link), reports_(reports) {}

  /// The device has been opened.
  void begin(Host& host);
  /// Reports what is new of the open device's state and troubles. `silence_s`: time since the
  /// servo's last report. Returns a new fault.
  [[nodiscard]] std::optional<haptic::Fault> watch(double silence_s, Host& host);
  /// A trouble that is reported now, and lasts; empty: its end.
  void report(std::string_view sentence, Host& host);
  /// One of no duration.
  void send(std::string_view sentence, Host& host) const;

private:
  void watch_flags(std::uint32_t flags, Host& host);
  void watch_sentence(std::string sentence, Host& host);

  const ServoSession& session_;
  const DeviceLink& link_;
  const Reports& reports_;
  std::optional<std::uint32_t> flags_; ///< none: not reported since opening
  std::uint32_t faults_ = 0;
  std::string sent_, latest_; ///< as sent to the patch; as last read from the driver
  double since_ms_ = 0;       ///< when the latest one changed
  double polled_ms_ = -1e9;
};

} // namespace tactus::phantom
