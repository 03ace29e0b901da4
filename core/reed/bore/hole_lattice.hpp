#pragma once

#include "core/reed/bore/woodwind.hpp"

#include <array>
#include <complex>
#include <cstddef>
#include <span>

namespace tactus::reed {

/// What an arriving wave meets at an instrument's first open tone hole, for any state of the holes:
/// transfer matrices of the bore from there to the bell's end.
///
/// Plane waves in lossy cylinders (thin boundary layer), cones as rows of short ones; an open hole
/// as a T-section (Keefe 1982, 1990; lengths of Dubos et al. 1999, Nederveen et al. 1998) with an
/// unflanged chimney (Silva et al. 2009). A closed hole is the bore's wall: pad or finger fill its
/// chimney. A hole that is partly covered is one of the area left open. Each opening is a source of
/// the power that it sends out, and sources interfere as sin(kd)/(kd), averaged over all directions
/// (the programs of bench/reed_bores do the same for the standard fingerings).
class HoleLattice {
public:
  using Complex = std::complex<double>;
  struct Response {
    Complex reflected; // R
    double radiated;   // |T|: see Termination
  };

  /// closed: one number for each tone hole from the reed down, 1 closed, 0 open.
  HoleLattice(const Woodwind& instrument, std::span<const double> closed) noexcept;

  /// MIDI number of the note whose first open hole is this state's.
  [[nodiscard]] int key() const noexcept { return key_; }
  /// Where the line ends: from the reed's end, of a cone from its apex; m.
  [[nodiscard]] double start() const noexcept { return start_; }
  /// At omega > 0, rad/s, at 20 deg C.
  [[nodiscard]] Response at(double omega) const noexcept;

private:
  struct PressureFlow { // for a unit flow at the far end
    Complex pressure, flow;
  };
  struct OpenHole {
    double position, radius, height, bore; // of the chimney, and of the bore beside it
    double series_length;                  // series length of the T-section
  };
  [[nodiscard]] PressureFlow through_bore(Complex s, double from, double to,
                                          PressureFlow far_end) const noexcept;

  const Woodwind& instrument_;
  int key_ = 0;
  double start_ = 0, end_ = 0; // of the tube before the bell
  std::array<OpenHole, Woodwind::kMaxToneHoles> open_holes_{};
  std::size_t count_ = 0; // from the reed down
};

} // namespace tactus::reed
