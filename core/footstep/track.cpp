#include "core/footstep/track.hpp"

#include "core/dsp/elementary.hpp"

#include <numbers>

namespace tactus::footstep {
namespace {

using std::numbers::pi;

} // namespace

Track& Track::to(double value, double duration_s, double sine_share, double hump) noexcept {
  if (!(duration_s > 0) || count_ == kMaxPieces)
    return *this;
  end_ += duration_s;
  pieces_[count_++] = {end_, duration_s, last_, value, sine_share, hump};
  last_ = value;
  return *this;
}

Track& Track::append(const Track& other) noexcept {
  for (std::size_t i = 0; i < other.count_; ++i) {
    const Piece& piece = other.pieces_[i];
    to(piece.to, piece.duration_s, piece.sine_share, piece.hump);
  }
  return *this;
}

Track Track::scaled(double value_factor, double time_factor) const noexcept {
  Track result(value_factor * initial_);
  for (std::size_t i = 0; i < count_; ++i) {
    const Piece& piece = pieces_[i];
    result.to(value_factor * piece.to, time_factor * piece.duration_s, piece.sine_share,
              value_factor * piece.hump);
  }
  return result;
}

double Track::value(const Piece& piece, double time_s) noexcept {
  double value = piece.to;
  const double left = (piece.end_s - time_s) / piece.duration_s;
  if (piece.from != piece.to) {
    const bool rises = piece.to > piece.from;
    const double sine = math::sin(0.5 * pi * (rises ? 1 - left : left));
    const double part = sine * (piece.sine_share + (1 - piece.sine_share) * sine);
    value = rises ? piece.from + (piece.to - piece.from) * part
                  : piece.to + (piece.from - piece.to) * part;
  }
  if (piece.hump != 0) {
    const double sine = math::sin(pi * left);
    value += piece.hump * sine * sine;
  }
  return value;
}

double Track::integral() const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Piece& p = pieces_[i];
    // Mean of the part between the ends: 1/2 for the square of a sine, 2 / pi for a sine.
    const double part = 0.5 + (2 / pi - 0.5) * p.sine_share;
    const double low = p.to > p.from ? p.from : p.to, high = p.to > p.from ? p.to : p.from;
    sum += p.duration_s * (low + (high - low) * part + 0.5 * p.hump);
  }
  return sum;
}

} // namespace tactus::footstep
