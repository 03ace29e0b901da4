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
  /// Publishes the servo's signals under the name; false: another object has it.
  bool publish(Host& host);
  /// Withdraws them.
  void withdraw(Host& host);
  /// Now and then, where another object had the name: it may have been deleted.
  void publish_again(Host& host);
  /// Publishes those of another servo in place of those that are.
  void replace(Host& host);
  /// Whether a [phantom~] steps the servo, so that the clock must not.
  [[nodiscard]] bool steps(const Host& host) noexcept;

private:
  const ServoSession& session_;
  std::string name_ = "-";
  bool published_ = false;
  std::uint64_t ticks_ = 0; ///< since it was published last
  std::uint64_t blocks_ = 0;
  double seen_ms_ = -1e9; ///< when audio was last seen to step
};

} // namespace tactus::phantom
