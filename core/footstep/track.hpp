#pragma once

#include <array>
#include <cstddef>

namespace tactus::footstep {

/// A continuous function of time built from pieces: a load, a share of a load, or a sliding speed.
/// From a to b over u = 0..1 a rising piece is
///     a + (b - a) ((1 - s) sin^2(pi u / 2) + s sin(pi u / 2)) + hump sin^2(pi u);
/// a falling piece is the same mirrored in time. The slope is 0 at the higher end, and for s = 0
/// (half a cosine) at the lower end too.
class Track {
public:
  static constexpr std::size_t kMaxPieces = 10;
  explicit Track(double initial = 0) noexcept : initial_(initial), last_(initial) {}

  /// Appends a piece to `value`. Ignored if the duration is not positive or the track is full.
  Track& to(double value, double duration_s, double sine_share = 0, double hump = 0) noexcept;
  /// Appends a constant piece.
  Track& hold(double duration_s) noexcept { return to(last_, duration_s); }

  /// Appends the pieces of another track, which should start at this one's last value.
  Track& append(const Track& other) noexcept;
  /// A copy with all values multiplied by `value_factor` and all times by `time_factor`.
  [[nodiscard]] Track scaled(double value_factor, double time_factor) const noexcept;

  /// Value at a time; the initial value before the first piece, the last after the last.
  [[nodiscard]] double at(double time_s) const noexcept {
    std::size_t piece = 0;
    return at(time_s, piece);
  }
  /// Value at a time, for times that do not decrease from call to call. `piece`, initially 0, keeps
  /// the index of the current piece.
  [[nodiscard]] double at(double time_s, std::size_t& piece) const noexcept {
    if (!(time_s > 0))
      return initial_;
    while (piece < count_ && time_s >= pieces_[piece].end_s)
      ++piece;
    return piece < count_ ? value(pieces_[piece], time_s) : last_;
  }
  /// Sum of the pieces' durations, s.
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
