#pragma once
#include "fem/modes/lanczos.hpp"

#include <string>

namespace tactus::fem {

/// The elastic modes of a body, frequencies ascending.
struct Modes {
  std::vector<double> frequency_hz;
  std::vector<double> shapes;    ///< columns dofs long, mass-normalised: phi' M phi = 1, 1/sqrt(kg)
  std::vector<int> multiplicity; ///< size of the mode's group of frequencies within 0.1 %
  std::vector<double> residual;  ///< ||K u - lambda M u|| / (lambda ||M u||)
  std::size_t rigid = 0;         ///< motions without strain that were left out
  std::size_t solves = 0;
  FactorCost cost;
};

/// Progress callback: the stage and its completed fraction, 0 to 1.
using Report = std::function<void(const std::string& stage, double share)>;

struct ModeSettings {
  std::size_t count = 40;
  Report report{};
  /// Called with the predicted cost before the factorisation starts; may throw to refuse it.
  std::function<void(const FactorCost&)> predict{};
  /// Called with the modes while the factor they were computed with still exists.
  std::function<void(const Modes&, ShiftedFactor&)> inspect{};
};

/// An estimate of the lowest elastic frequency, from a bar's or plate's bending: c t / L^2.
[[nodiscard]] double estimated_frequency(const Mesh&, std::span<const Material>);
/// The same without a mesh, from the sides of the bounding box (m), the volume (m^3) and the speed
/// of sound in a bar (m/s).
[[nodiscard]] double estimated_frequency(const Vec3& box, double volume, double bar_speed);

/// s of K + s M, rad^2/s^2: near (0.3 omega_1)^2, from the estimate.
[[nodiscard]] double default_shift(const Mesh&, std::span<const Material>);

/// The largest wave number (1/m) among the `count` lowest modes of a body, roughly: from the number
/// of modes below omega of a plate of the body's mean thickness t = 2 V / S, of a bar of its
/// length, and of a solid of its volume,
///
///   N = S k^2 / (8 pi) + L k / pi + V (omega/c)^3 / (2 pi^2),
///
/// k Timoshenko's wave number of bending, which tends to the shear wave's for short waves.
[[nodiscard]] double highest_wave_number(double volume, double skin, double length, const Material&,
                                         std::size_t count);

[[nodiscard]] Modes find_modes(const Mesh&, std::span<const Material>, const Matrices&,
                               const ModeSettings&);

/// Keeps only the first modes.
void keep_first(Modes&, std::size_t count);

/// Sets frequencies from lambda = u' K u / u' M u, sorts by them, makes u' M u = 1, sets residuals.
void sort_by_quotient(const Matrices&, Modes&);

/// Fixes what an eigensolver leaves arbitrary in sorted modes, so that results repeat: the signs,
/// and the directions inside groups of equal frequency (a relative gap below `same`). A group's
/// first mode has the largest motion that the group can have at the body's surface point farthest
/// along +x; the next, among those at rest there, along +y, then +z. Frequencies and residuals
/// remain those of the matrices' own eigenvectors: an uneven mesh splits the pair of a round body
/// by some 1e-4, and the quotients of turned shapes would average the two values.
void make_canonical(const Mesh&, Modes&, double same = 3e-4);

} // namespace tactus::fem
