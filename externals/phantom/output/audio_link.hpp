#pragma once

#include "core/object.hpp"
#include "externals/phantom/servo/servo_session.hpp"

#include <cstdint>
#include <string>
#include <utility>

namespace tactus::phantom {

/// The link to the audio of [phantom~], which finds a servo by the object's name.
class AudioLink {
public:
  explicit AudioLink(const ServoSession& session) : session_(session) {}
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  void set_name(std::string name) { name_ = std::move(name); }
  /// Publishes the servo's signals under the name. Returns false if another object has this name.
  bool publish(Host& host);
  /// Withdraws the published signals.
  void withdraw(Host& host);
  /// Tries again from time to time if another object had the name, since that object may have been
  /// deleted.
  void publish_again(Host& host);
  /// Publishes the signals of a new servo in place of the published ones.
  void replace(Host& host);
  /// True if a [phantom~] steps the servo, so that the clock must not step it.
  [[nodiscard]] bool steps(const Host& host) noexcept;

private:
  const ServoSession& session_;
  std::string name_ = "-";
  bool published_ = false;
  std::uint64_t ticks_ = 0; ///< ticks since the last attempt to publish
  std::uint64_t blocks_ = 0;
  double seen_ms_ = -1e9; ///< time at which audio was last seen to step
};

} // namespace tactus::phantom
