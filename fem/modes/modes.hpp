#pragma once
#include "fem/modes/lanczos.hpp"

#include <string>

namespace tactus::fem {

/// The elastic modes of a body, frequencies ascending.
struct Modes {
  std::vector<double> frequency_hz;
  std::vector<double> shapes;    ///< columns dofs long, mass-normalised: phi' M phi = 1, 1/sqrt(kg)
  std::vector<int> multiplicity; ///< number of modes in its group of frequencies within 0.1 %
  std::vector<double> residual;  ///< ||K u - lambda M u|| / (lambda ||M u||)
  std::size_t rigid = 0;         ///< number of motions without strain, which were left out
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
  /// Called with the modes while the factor that computed them still exists.
  std::function<void(const Modes&, ShiftedFactor&)> inspect{};
};

/// An estimate of the lowest elastic frequency, from a bar's or plate's bending: c t / L^2.
[[nodiscard]] double estimated_frequency(const Mesh&, std::span<const Material>);
/// As above without a mesh, from the sides of the bounding box (m), the volume (m^3) and the speed
/// of sound in a bar (m/s).
[[nodiscard]] double estimated_frequency(const Vec3& box, double volume, double bar_speed);

/// The shift s of K + s M, rad^2/s^2: about (0.3 omega_1)^2, from the estimated omega_1.
[[nodiscard]] double default_shift(const Mesh&, std::span<const Material>);

/// A rough largest wave number (1/m) among the `count` lowest modes of a body. It follows from the
/// number of modes below omega of a plate with the body's mean thickness t = 2 V / S, a bar of its
/// length, and a solid of its volume,
///
///   N = S k^2 / (8 pi) + L k / pi + V (omega/c)^3 / (2 pi^2),
///
/// with k the wave number of Timoshenko bending, which approaches that of shear waves for short
/// waves.
[[nodiscard]] double highest_wave_number(double volume, double skin, double length, const Material&,
                                         std::size_t count);

[[nodiscard]] Modes find_modes(const Mesh&, std::span<const Material>, const Matrices&,
                               const ModeSettings&);

/// Keeps only the first modes.
void keep_first(Modes&, std::size_t count);

/// Sets the frequencies from lambda = u' K u / u' M u, sorts the modes by them, normalises to u' M
/// u = 1 and sets the residuals.
void sort_by_quotient(const Matrices&, Modes&);

/// Makes sorted modes repeatable by fixing what an eigensolver leaves arbitrary: the signs, and the
/// directions inside groups of equal frequency (a relative gap below `same`). A group's first mode
/// has the largest motion that the group can have at the body's surface point farthest along +x;
/// the next mode, among those at rest there, along +y, then +z. Frequencies and residuals remain
/// those of the matrices' own eigenvectors. An uneven mesh splits the pair of a round body by about
/// 1e-4, and the quotients of rotated shapes would average the two values.
void make_canonical(const Mesh&, Modes&, double same = 3e-4);

} // namespace tactus::fem
