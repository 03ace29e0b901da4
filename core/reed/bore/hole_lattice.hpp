#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/bore/woodwind.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace tactus::reed {

/// Reflectance and radiation of a woodwind beyond its first open tone hole, for any state of the
/// holes, by transfer matrices of the bore from there to the end of the bell.
///
/// - Bore: plane waves in lossy cylinders (thin boundary layer); cones as many short cylinders.
/// - Open hole: T-section (Keefe 1982, 1990; lengths of Dubos et al. 1999, Nederveen et al. 1998)
///   with an unflanged chimney (Silva et al. 2009).
/// - Closed hole: the wall of the bore; pad or finger fill its chimney.
/// - Partly covered hole: an open hole of the remaining area.
/// - Sound outside: each opening radiates its power; openings interfere as sin(kd)/(kd), the mean
///   over all directions.
/// Limits: plane waves, 20 deg C. The programs of bench/reed_bores compute the standard fingerings
/// in the same way.
class HoleLattice {
public:
  struct Response {
    Complex reflected; // R
    double radiated;   // |T| as in Termination
  };

  /// closed: one number for each tone hole from the reed down, 1 closed, 0 open.
  HoleLattice(const Woodwind& instrument, std::span<const double> closed) noexcept;

  /// MIDI number of the note that has the same first open hole as this state.
  [[nodiscard]] int key() const noexcept { return key_; }
  /// Position of the first open hole, m from the reed's end, or for a cone from its apex.
  [[nodiscard]] double start() const noexcept { return start_; }
  /// Response at omega > 0, rad/s.
  [[nodiscard]] Response at(double omega) const noexcept;

private:
  struct PressureFlow { // relative to the flow out of the bell
    Complex pressure, flow;
  };
  struct OpenHole {
    double position, radius, height; // position and size of the chimney, with its length
                                     // corrections
    double bore;                     // radius of the bore at the hole
    double series_length;            // length of the T-section
  };
  /// A radiating opening.
  struct Source {
    double position;
    Complex flow;
    double resistance; // radiation resistance
  };
  using Sources = std::array<Source, Woodwind::kMaxToneHoles + 1>;

  /// Pressure and flow at the beginning of the bell for a flow of 1 out of its mouth.
  [[nodiscard]] PressureFlow bell_state(Complex s, Source& mouth) const noexcept;
  /// Pressure and flow on the near side of an open hole, from those on its far side.
  [[nodiscard]] static PressureFlow across_hole(Complex s, const OpenHole& hole,
                                                PressureFlow far_side, Source& source) noexcept;
  /// sqrt of the mean square of the pressure at 1 m over all directions, for flows times scale.
  [[nodiscard]] static double radiated_pressure(double omega, Complex scale, const Sources& sources,
                                                std::size_t count) noexcept;
  [[nodiscard]] PressureFlow through_bore(Complex s, double from, double to,
                                          PressureFlow far_end) const noexcept;

  const Woodwind& instrument_;
  int key_ = 0;
  double start_ = 0, end_ = 0; // ends of the tube before the bell
  std::array<OpenHole, Woodwind::kMaxToneHoles> open_holes_{};
  std::size_t count_ = 0; // number of holes, counted from the reed down
};

} // namespace tactus::reed
