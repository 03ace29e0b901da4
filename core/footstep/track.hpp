#pragma once

#include <array>
#include <cstddef>

namespace tactus::footstep {

/// A quantity over time, made of pieces that join without a step: a load, a share of a load, a
/// speed of sliding. From a to b over u = 0..1 a piece rises as
///   a + (b - a) ((1 - s) sin^2(pi u / 2) + s sin(pi u / 2)) + hump sin^2(pi u),
/// and falls as the same mirrored in time: level at its higher end, and at its lower end as well
/// for s = 0 (half a cosine).
class Track {
public:
  static constexpr std::size_t kMaxPieces = 10;
  explicit Track(double initial = 0) noexcept : initial_(initial), last_(initial) {}

  /// On to `value` in `duration_s`. A duration that is not positive or a piece too many changes
  /// nothing.
  Track& to(double value, double duration_s, double sine_share = 0, double hump = 0) noexcept;
  /// The same value for that long.
  Track& hold(double duration_s) noexcept { return to(last_, duration_s); }

  /// The pieces of another, which should begin where this one ends.
  Track& append(const Track& other) noexcept;
  /// With all values and all times multiplied.
  [[nodiscard]] Track scaled(double by, double times) const noexcept;

  /// At a time; before the first piece its beginning, after the last its end.
  [[nodiscard]] double at(double time_s) const noexcept {
    std::size_t piece = 0;
    return at(time_s, piece);
  }
  /// The same for times that never fall from call to call: `piece`, 0 at first, is the one in which
  /// the last time was.
  [[nodiscard]] double at(double time_s, std::size_t& piece) const noexcept {
    if (!(time_s > 0))
      return initial_;
    while (piece < count_ && time_s >= pieces_[piece].end_s)
      ++piece;
    return piece < count_ ? value(pieces_[piece], time_s) : last_;
  }
  /// From the first piece's begin to the last one's end, s.
  [[nodiscard]] double duration_s() const noexcept { return end_; }
  /// Integral over all pieces, exact.
  [[nodiscard]] double integral() const noexcept;

private:
  struct Piece {
    double end_s, duration_s, from, to, sine_share, hump;
  };
  [[nodiscard]] static double value(const Piece& piece, double time_s) noexcept;

  std::array<Piece, kMaxPieces> pieces_{};
  std::size_t count_ = 0;
  double initial_ = 0, last_ = 0, end_ = 0;
};

} // namespace tactus::footstep
