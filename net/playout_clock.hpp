#pragma once

#include <array>
#include <cstdint>
#include <optional>

/// Times of messages from another computer. All times are in seconds of this side's clock and never
/// decrease, unless stated otherwise.
namespace tactus::net {

/// A clock's reading in microseconds modulo 2^32 (71 minutes), as it is transmitted.
[[nodiscard]] std::uint32_t stamp_of(double clock_s) noexcept;

/// The smallest sample of the last seconds, which is a delay without queueing. One minimum is kept
/// for each second, so that a clock's drift r takes effect within kWindow_s, with an error of at
/// most r kWindow_s.
class MinimumFilter {
public:
  static constexpr double kWindow_s = 8;

  void add(double sample, double now_s) noexcept;
  /// Empty before the first sample. Without new samples the last minimum is kept.
  [[nodiscard]] std::optional<double> value(double now_s) const noexcept;

private:
  struct Bin {
    std::int64_t second = -1;
    double minimum = 0;
  };
  std::array<Bin, static_cast<std::size_t>(kWindow_s) + 1> bins_{};
  std::int64_t newest_ = -1;
};

/// An offset that follows its target without jumps, so that time translated by it never goes back.
/// The rate is kMin_rate; for a large error it is higher (a time constant of kTimeConstant_s), up
/// to kMax_rate. During the first warm_up_s_ after the first target, nothing depends on the offset
/// yet, so it equals the target.
class SlewedOffset {
public:
  static constexpr double kMin_rate = 2e-3, kMax_rate = 0.5, kTimeConstant_s = 4;

  explicit SlewedOffset(double warm_up_s) noexcept : warm_up_s_(warm_up_s) {}
  void update(double target_s, double now_s) noexcept;
  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] double value() const noexcept { return value_s_; }

private:
  double warm_up_s_, value_s_ = 0, first_s_ = 0, last_s_ = 0;
  bool known_ = false;
};

/// The offset of the other side's clock from this side's, from the smallest one-way delays in both
/// directions.
///
/// A message stamped S by the other side that arrives at R on this side's clock gives the sample x
/// = R - S = offset + delay. Both sides keep the minimum of their samples and send it to each
/// other. If the shortest delays in both directions are equal (as NTP assumes, Mills 1991), offset
/// = (x_min - x'_min)/2. An asymmetry of the shortest delays causes an error of half of it, which
/// cannot be observed at the ends of a connection. The error has opposite signs on the two sides,
/// so a time that is sent there and back is still correct.
class PlayoutClock {
public:
  /// Adds the stamp of a message that arrived at that time.
  void add(std::uint32_t stamp, double arrived_s) noexcept;
  /// The minimum that the other side reports.
  void set_remote_minimum(std::uint32_t minimum_us, double now_s) noexcept;

  /// The minimum to send to the other side; nullopt before the first sample.
  [[nodiscard]] std::optional<std::uint32_t> minimum_us(double now_s) const noexcept;
  /// True once both sides have measured.
  [[nodiscard]] bool known() const noexcept { return offset_.known(); }
  /// The transit time of that message, 0 or more. Before known(), the excess over the fastest
  /// message.
  [[nodiscard]] double delay_s(std::uint32_t stamp, double arrived_s) const noexcept;
  /// The shortest round trip, without processing times of the computers.
  [[nodiscard]] double round_trip_s() const noexcept { return round_trip_s_; }

private:
  static constexpr double kWarmUp_s = 1;
  [[nodiscard]] double sample_of(std::uint32_t stamp, double arrived_s) const noexcept;

  std::optional<std::uint32_t> origin_{}; ///< the first sample, us
  MinimumFilter minimum_{};
  SlewedOffset offset_{kWarmUp_s};
  double round_trip_s_ = 0;
};

} // namespace tactus::net
