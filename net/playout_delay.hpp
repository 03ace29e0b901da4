#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace tactus::net {

/// How long after its time a message is let out, so that what comes unevenly goes out evenly.
///
/// Automatic: the delay within which kShare of the messages of the last kGeneration_s to
/// 2 kGeneration_s came, in steps of 1 ms, and a margin (percentile playout with fast attack after
/// Moon, Kurose and Towsley, Multimedia Systems 6, 1998). It rises at once with a message that is
/// later, since those behind it are as late; it falls by kFall_rate, so that messages are let out
/// closer together by that share and never out of order. kMax_s at most: who is later is late.
class PlayoutDelay {
public:
  static constexpr double kMax_s = 0.4, kMargin_s = 2e-3, kShare = 0.995;
  static constexpr double kGeneration_s = 5, kFall_rate = 0.1, kBin_s = 1e-3;

  /// s, 0 to kMax_s; nothing: automatic.
  void fix(std::optional<double> delay_s) noexcept { fixed_s_ = delay_s; }
  /// A message that was on its way for so long, 0 or more.
  void add(double delay_s, double now_s) noexcept;
  [[nodiscard]] double value(double now_s) noexcept;

private:
  static constexpr std::size_t kBins = static_cast<std::size_t>(kMax_s / kBin_s + 0.5);
  using Histogram = std::array<std::uint32_t, kBins + 1>; ///< the last: later than kMax_s

  void age(double now_s) noexcept;
  void follow(double now_s) noexcept;
  [[nodiscard]] double quantile_s() const noexcept;

  std::optional<double> fixed_s_{};
  std::array<Histogram, 2> counts_{};
  std::array<std::uint64_t, 2> totals_{};
  std::size_t current_ = 0;
  double began_s_ = -1e18, last_s_ = -1e18, looked_s_ = -1e18, value_s_ = 0, target_s_ = 0;
};

} // namespace tactus::net
