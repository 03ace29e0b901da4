#pragma once

#include "core/modal/bank/mode_bank.hpp"
#include "core/modal/radiation/arrivals.hpp"
#include "core/modal/table/modal_table.hpp"

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// Mean and shape of a force within a sample: its integrals over the sample with Legendre's
/// polynomials P_j(2 v - 1), v the time that is left to the sample's end, in samples. N
using ForceMoments = std::array<double, 3>;

/// What a listener hears of a force besides the modes that ring: the sound of the true surface
/// acceleration, less what the mode bank gives while it rings.
///
/// Mode k, driven, has the acceleration q'' = b f - 2 alpha q' - |s|^2 q, and the pressure is
/// p = rho g_k * q_k'', g_k the distribution of the delays from the surface (Arrivals). Once the
/// force and the latest arrival are over this is exactly Im(w_k z_k) with
///   w_k = rho s_k^2 / omega_k  int g_k(tau) exp(-s_k tau) dtau,
/// which is what the bank plays. The difference
///   D_k(t) = rho (g_k * (delta + Im(s_k^2 e^(s_k t))/omega_k))(t) - Im(w_k e^(s_k t))
/// is zero after the latest arrival: a short filter of the force, sum over k of b_k D_k, whose
/// response to a constant force cancels the bank's. Modes that decay within the arrivals' spread,
/// those too high for the bank and rigid motions are in the filter alone (w = 0).
///
/// Two forms: for forces that are impulses at the samples (as ModeBank takes them), and for forces
/// that act all through a sample, given by their moments (as ContactSolver finds them).
///
/// The sum over the modes is taken where a force begins to act. Of a body of many modes it is taken
/// beforehand instead, for a unit force at every vertex of the surface along each axis: between
/// vertices modal gains are linear, and so a force anywhere takes the sum of nine rows, however
/// many modes there are.
class DirectKernels {
public:
  static constexpr std::size_t kMaxMoments = std::tuple_size_v<ForceMoments>;
  /// Modes times taps above which the sums over the modes are taken beforehand: below, a force
  /// that begins to act costs less than 20 us a listener.
  static constexpr std::size_t kMaxSummed = std::size_t{1} << 15;
  /// Products of those sums above which a force's shape within a sample is left out, so that a
  /// model is made within some seconds: -2.6 dB of the direct part at 20 kHz and 48 kHz.
  static constexpr std::size_t kMaxProducts = std::size_t{1} << 33;
  /// Numbers that the rows of one listener take at most, 256 MB: kernels are cut to fit.
  static constexpr std::size_t kMaxNumbers = std::size_t{1} << 26;
  static constexpr std::size_t kMaxTaps = 4096;
  /// A mode whose amplitude falls by more than this (Np) within the arrivals is not left to the
  /// bank, which would have to play it so much too loud and have it cancelled.
  static constexpr double kMaxDecay = 3;

  struct Mode {
    std::complex<double> rate; ///< 1/s
    std::size_t motion;        ///< of Arrivals
    enum class Part {
      kRinging,  ///< in the bank
      kTooHigh,  ///< for the bank: it only follows the force
      kInaudible ///< not to be heard
    } part;
    double pulse_gain = 1; ///< factor of the gain when pulses strike (BodyModel)
  };
  /// Shapes [V][K][3] of a table, and the kernels that add up matrices.
  struct SurfaceShapes {
    std::span<const float> shape; ///< empty: there are none
    std::size_t modes = 0;        ///< K
    const BankKernel* kernel = nullptr;
    [[nodiscard]] std::size_t vertices() const noexcept {
      return modes > 0 ? shape.size() / (3 * modes) : 0;
    }
  };
  /// A row of a vertex's x, and how much of it a force has; y and z follow.
  struct VertexGain {
    std::size_t vertex;
    Vec3 gain; ///< b = gain . shape
  };
  using SurfaceGain = std::array<VertexGain, 3>;
  /// Samples of arrivals that rows for so many modes, or vertices where these give the shorter
  /// list, have room for.
  [[nodiscard]] static std::size_t max_spread(std::size_t modes, std::size_t vertices) noexcept;
  /// Allocates. Not for the audio path.
  void build(const Arrivals& arrivals, std::span<const Mode> modes, bool rigid, double sample_rate,
             const SurfaceShapes& shapes);
  void build(const Arrivals& arrivals, std::span<const Mode> modes, bool rigid,
             double sample_rate) {
    build(arrivals, modes, rigid, sample_rate, {});
  }
  /// Nothing but what makes a constant force silent: velocities, for a listener that hears
  /// Im(w z) at once.
  void build_velocity(std::span<const Mode> modes, std::span<const std::complex<double>> weight,
                      double sample_rate);

  /// w of the modes that ring, Pa s/(m sqrt(kg)).
  [[nodiscard]] const std::vector<std::complex<double>>& weight() const noexcept { return weight_; }
  [[nodiscard]] std::size_t taps() const noexcept { return taps_; }
  /// Of a force within a sample, that count.
  [[nodiscard]] std::size_t moments() const noexcept { return moment_count_; }
  [[nodiscard]] bool has_rigid() const noexcept { return !rigid_moments_.empty(); }

  /// Whether rows belong to the surface's vertices; else they belong to modes.
  [[nodiscard]] bool on_surface() const noexcept { return on_surface_; }
  /// sum of b D over the modes, for impulses: [taps()] Pa/N. Allocates nothing.
  void assemble_samples(std::span<const double> gain, std::span<float> out) const noexcept;
  void assemble_samples(const SurfaceGain& gain, std::span<float> out) const noexcept;
  void assemble_pulse(const SurfaceGain& gain, std::span<float> out) const noexcept;
  /// The same for moments: [moments()][taps()].
  void assemble_moments(std::span<const double> gain, std::span<float> out) const noexcept;
  void assemble_moments(const SurfaceGain& gain, std::span<float> out) const noexcept;
  void assemble_rigid_samples(const std::array<double, Arrivals::kRigid>& gain,
                              std::span<float> out) const noexcept;
  void assemble_rigid_moments(const std::array<double, Arrivals::kRigid>& gain,
                              std::span<float> out) const noexcept;

private:
  /// Of one mode, [taps()] and [moments()][taps()].
  void find_mode(const Arrivals& arrivals, const Mode& mode, double sample_rate, float* samples,
                 float* moments);
  void sum_over_modes(const Arrivals& arrivals, std::span<const Mode> modes, double sample_rate,
                      const SurfaceShapes& shapes);
  void add_rigid(const Arrivals& arrivals, std::size_t motion, std::vector<double>& pressure);

  std::size_t taps_ = 0, moment_count_ = 1;
  bool on_surface_ = false;
  std::vector<std::complex<double>> weight_;
  /// [row][taps], [row][moments][taps]; rows are modes, or x, y and z of vertices.
  std::vector<float> samples_, moments_;
  std::vector<float> pulses_; ///< as samples_, of vertices, every mode times its pulse_gain
  std::vector<float> rigid_samples_, rigid_moments_; ///< the same of the rigid motions
  std::vector<double> pressure_;                     ///< of a mode, while they are built
  std::vector<std::complex<double>> motion_;
};

/// Kernels of one source of force to one listener, with room for the largest.
struct ForceKernel {
  std::vector<float> elastic, rigid;
};

/// The sound that forces give besides the modes, on its way to the listeners. Kernels may change
/// with every force: what has been given goes on as it was. While the bank's weights glide
/// (Glide), forces sound by the kernels that belong to each of its three weights, in the same
/// blend.
class DirectSound {
public:
  static constexpr std::size_t kChunk = 64;
  static constexpr std::size_t kListeners = 4;
  /// A free body hangs so softly: its rigid motions follow forces above, and come to rest below.
  static constexpr double kSuspensionHz = 4;

  /// Allocates.
  void prepare(double sample_rate);
  void clear() noexcept;
  /// Of this listener and those after it.
  void clear_from(std::size_t listener) noexcept;
  /// A force at a sample of the segment at hand, N, by the kernels of one of the glide's parts.
  void add_sample(std::size_t listener, ModeBank::Part part, std::size_t at,
                  const ForceKernel& kernel, std::size_t taps, double force) noexcept;
  void add_moments(std::size_t listener, ModeBank::Part part, std::size_t at,
                   const ForceKernel& kernel, std::size_t taps,
                   std::span<const double> force) noexcept;
  /// The glide's exchanges: parts move as its values do. A part that begins is what the one before
  /// it gave; add_history() makes it its own.
  void start() noexcept;
  void rotate(const Glide& before, const Glide& after) noexcept;
  /// All parts become the same, blended as `glide` is now.
  void merge_parts(const Glide& glide) noexcept;
  /// Forces that have acted for long are, in the freshest part, as if they had acted by another
  /// kernel all along. Call it with that kernel and the force, and with the one before and its
  /// negative.
  void add_history(std::size_t listener, const ForceKernel& kernel, std::size_t taps,
                   std::span<const double> force) noexcept;
  /// Adds the segment's sound and goes on to the next; within a segment `glide` makes no exchange.
  void finish(std::size_t listener, std::span<float> sound, const Glide& glide) noexcept;

private:
  struct Line {
    std::vector<float> elastic, rigid;
    std::size_t end = 0; ///< samples from now that are not zero
  };
  using Lines = std::array<Line, 3>; ///< by Part
  static void add(Line& line, std::size_t at, const ForceKernel& kernel, std::size_t taps,
                  std::span<const float> force) noexcept;
  static void shift(Line& line, std::size_t frames) noexcept;
  static void clear(Line& line) noexcept;
  static void copy(const Line& from, Line& to) noexcept;

  std::array<Lines, kListeners> lines_;
  /// Second-order Butterworth high-pass, transposed direct form II.
  struct HighPass {
    double b0 = 1, b1 = -2, b2 = 1, a1 = -2, a2 = 1;
  } suspension_;
  std::array<std::array<double, 2>, kListeners> suspension_state_{};
};

} // namespace tactus::modal
