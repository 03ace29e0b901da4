#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace tactus::net {

/// A playout delay (jitter buffer): each message is output this long after its time stamp, s.
///
/// If the delay is automatic, each slot of kSlot_s in which messages arrive gives one sample, the
/// longest transit time among them. Of the n samples of the last kWindow_s, the delay settles at
/// the m-th smallest, w_(m), plus a margin,
///
///     d = w_(m) + kMargin_s,   m = 1 + floor(kPercentile (n - 1)),
///
/// a percentile playout (Moon, Kurose and Towsley, Multimedia Systems 6, 1998). Messages that a
/// stalled computer or connection has held back arrive together. However many they are, they fill
/// only one or two slots and stay above the percentile. A connection that has become slower fills
/// all slots, so it takes effect after 1 - kPercentile of kWindow_s.
///
/// A message that is later than the delay raises it to its own transit time at once, since the
/// messages behind it are equally late. The delay then falls back to d at kFall_rate: the spike
/// mode of Ramjee, Kurose, Towsley and Schulzrinne (INFOCOM 1994), which excludes a spike from the
/// estimate. While it falls, messages are output closer together by that fraction and never out of
/// order. The delay is at most kMax_s; a message that is later counts as late.
class PlayoutDelay {
public:
  static constexpr double kMax_s = 0.4, kMargin_s = 2e-3, kPercentile = 0.9;
  static constexpr double kSlot_s = 0.05, kWindow_s = 5, kFall_rate = 0.25;

  /// Sets the delay in s, 0 to kMax_s; nullopt: automatic.
  void set_fixed(std::optional<double> delay_s) noexcept { fixed_s_ = delay_s; }
  /// Adds a message with this transit time, 0 or more.
  void add(double delay_s, double now_s) noexcept;
  [[nodiscard]] double value(double now_s) noexcept;

private:
  static constexpr std::size_t kSlots = static_cast<std::size_t>(kWindow_s / kSlot_s + 0.5);
  struct Slot {
    std::int64_t number = -1;
    double max_s = 0;
  };

  void update(double now_s) noexcept;
  [[nodiscard]] std::optional<double> percentile_s() const noexcept;

  std::optional<double> fixed_s_{};
  std::array<Slot, kSlots> slots_{}; ///< indexed by number modulo kSlots
  std::int64_t last_slot_ = 0;       ///< the slot of the last update
  double last_s_ = -1e18, value_s_ = 0, target_s_ = 0;
};

} // namespace tactus::net
