#pragma once

#include "core/dsp/complex.hpp"
#include "core/modal/bank/mode_bank.hpp"
#include "core/modal/radiation/arrivals.hpp"
#include "core/modal/table/modal_table.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

/// The course of a force within a sample, N: its integrals with the Legendre polynomials
/// P_j(2 v - 1), v the time from now to the sample's end, in samples. Moment 0 is the mean.
using ForceMoments = std::array<double, 3>;

/// Short FIR filters from a force to its direct sound: the exact pressure of the driven surface,
/// minus the output of the mode bank.
///
/// A driven mode k has the acceleration q'' = b f - 2 alpha q' - |s|^2 q and radiates the pressure
/// p = rho g_k * q_k'', where g_k is its response in Arrivals. After the end of the force and the
/// latest arrival, p equals Im(w_k z_k), the output of the mode bank, with the weight
///   w_k = rho s_k^2 / omega_k  int g_k(tau) exp(-s_k tau) dtau.
/// Until then they differ by
///   D_k(t) = rho (g_k * (delta + Im(s_k^2 e^(s_k t))/omega_k))(t) - Im(w_k e^(s_k t)),
/// so that the direct sound is the force filtered by the sum over k of b_k D_k. Its response to a
/// constant force cancels that of the bank. Modes that decay within the arrivals' spread, modes too
/// high for the bank and rigid motions are in this filter only (w = 0).
///
/// There are two forms: for impulses at the samples, as ModeBank takes forces, and for forces that
/// act throughout a sample, given by their moments, as ContactSolver computes them.
///
/// The sum over the modes is taken when a force begins to act. For bodies of many modes it is taken
/// beforehand, for a unit force at every vertex along each axis. Modal gains are linear between
/// vertices, so that a force at any point needs a sum of nine rows, however many modes there are.
class DirectKernels {
public:
  static constexpr std::size_t kMaxMoments = std::tuple_size_v<ForceMoments>;
  /// Modes times taps above which the sums over the modes are computed in advance; below this
  /// number, the beginning of a force costs less than 20 us per listener.
  static constexpr std::size_t kMaxSummed = std::size_t{1} << 15;
  /// Products in those sums above which only moment 0 is used, so that a model is built within
  /// seconds. The error of the direct part is then -2.6 dB at 20 kHz (at 48 kHz).
  static constexpr std::uint64_t kMaxProducts = std::uint64_t{1} << 33;
  /// The largest number of floats in the rows of one listener, 256 MB; kernels are truncated to
  /// fit.
  static constexpr std::size_t kMaxNumbers = std::size_t{1} << 26;
  static constexpr std::size_t kMaxTaps = 4096;
  /// A mode that decays by more than this (Np) within the arrivals is not given to the bank,
  /// because its weight would be too large by that factor and the filter would have to cancel it.
  static constexpr double kMaxDecay = 3;

  struct Mode {
    Complex rate;       ///< 1/s
    std::size_t motion; ///< index of the motion in Arrivals
    enum class Part {
      kRinging,  ///< a mode in the bank
      kTooHigh,  ///< a mode above the bank's limit, which follows the force quasi-statically
      kInaudible ///< a mode that is left out
    } part;
    double pulse_gain = 1; ///< factor of the gain for pulses (BodyModel)
  };
  /// Mode shapes [V][K][3] of a table, and the kernel that multiplies matrices.
  struct SurfaceShapes {
    std::span<const float> shape; ///< empty: there are none
    std::size_t modes = 0;        ///< K
    const BankKernel* kernel = nullptr;
    [[nodiscard]] std::size_t vertices() const noexcept {
      return modes > 0 ? shape.size() / (3 * modes) : 0;
    }
  };
  /// The share of a force that acts at a vertex: b = gain . shape.
  struct VertexGain {
    std::size_t vertex;
    Vec3 gain;
  };
  using SurfaceGain = std::array<VertexGain, 3>;
  /// The longest arrivals in samples that fit in kMaxNumbers, for rows of `modes`, or of `vertices`
  /// if these are fewer; 0 vertices: there is no surface.
  [[nodiscard]] static std::size_t max_spread(std::size_t modes, std::size_t vertices) noexcept;
  /// Allocates. Not for the audio path.
  void build(const Arrivals& arrivals, std::span<const Mode> modes, bool rigid, double sample_rate,
             const SurfaceShapes& shapes);
  void build(const Arrivals& arrivals, std::span<const Mode> modes, bool rigid,
             double sample_rate) {
    build(arrivals, modes, rigid, sample_rate, {});
  }
  /// For a listener without arrivals, whose signal is a velocity Im(w z): one tap, which makes a
  /// constant force silent.
  void build_velocity(std::span<const Mode> modes, std::span<const Complex> weight,
                      double sample_rate);

  /// Weights w of the modes in the bank, Pa s/(m sqrt(kg)).
  [[nodiscard]] const std::vector<Complex>& weight() const noexcept { return weight_; }
  [[nodiscard]] std::size_t taps() const noexcept { return taps_; }
  /// The number of moments of a force that are used.
  [[nodiscard]] std::size_t moments() const noexcept { return moment_count_; }
  [[nodiscard]] bool has_rigid() const noexcept { return !rigid_moments_.empty(); }

  /// True if rows belong to the surface's vertices, false if they belong to modes.
  [[nodiscard]] bool on_surface() const noexcept { return on_surface_; }
  /// The kernel of a force at a point, sum of b D, for impulses: [taps()] Pa/N. Does not allocate.
  void assemble_samples(std::span<const double> gain, std::span<float> out) const noexcept;
  void assemble_samples(const SurfaceGain& gain, std::span<float> out) const noexcept;
  void assemble_pulse(const SurfaceGain& gain, std::span<float> out) const noexcept;
  /// The kernel of a force at a point for moments: [moments()][taps()].
  void assemble_moments(std::span<const double> gain, std::span<float> out) const noexcept;
  void assemble_moments(const SurfaceGain& gain, std::span<float> out) const noexcept;
  void assemble_rigid_samples(const std::array<double, Arrivals::kRigid>& gain,
                              std::span<float> out) const noexcept;
  void assemble_rigid_moments(const std::array<double, Arrivals::kRigid>& gain,
                              std::span<float> out) const noexcept;

private:
  /// D of one mode: `samples` [taps()] and `moments` [moments()][taps()].
  void compute_mode(const Arrivals& arrivals, const Mode& mode, double sample_rate, float* samples,
                    float* moments);
  /// The states of a mode of pole p at the samples, driven by its arrivals.
  void integrate_motion(Complex pole, const std::array<Complex, 4>& shape) noexcept;
  void sum_over_modes(const Arrivals& arrivals, std::span<const Mode> modes, double sample_rate,
                      const SurfaceShapes& shapes);
  void add_rigid(const Arrivals& arrivals, std::size_t motion, std::vector<double>& pressure);

  std::size_t taps_ = 0, moment_count_ = 1;
  bool on_surface_ = false;
  std::vector<Complex> weight_;
  /// [row][taps], [row][moments][taps]; rows are modes, or x, y and z of vertices.
  std::vector<float> samples_, moments_;
  std::vector<float> pulses_; ///< as samples_, for vertices, every mode times its pulse_gain
  std::vector<float> rigid_samples_, rigid_moments_; ///< the same for the rigid motions
  std::vector<double> pressure_;                     ///< pressure of a mode, while the kernels are
                                                     ///< built
  std::vector<Complex> motion_;
};

/// The kernels from one force to one listener, with room for the largest.
struct ForceKernel {
  std::vector<float> elastic, rigid;
};

/// Filters forces by their DirectKernels and sums the direct sound at each listener.
///
/// The kernels are applied as forces arrive, into output buffers, so that they may change at any
/// time without affecting earlier forces. While the bank's weights glide (Glide), each force is
/// filtered by the kernels that belong to each of the three weights, blended as the weights are.
class DirectSound {
public:
  static constexpr std::size_t kChunk = 64;
  static constexpr std::size_t kListeners = 4;
  /// A free body hangs in a soft suspension, so its rigid motions are high-passed at this
  /// frequency.
  static constexpr double kSuspensionHz = 4;

  /// Allocates.
  void prepare(double sample_rate);
  void clear() noexcept;
  /// Clears this listener and the listeners after it.
  void clear_from(std::size_t listener) noexcept;
  /// Adds a force in N at sample `at` of the present segment, by the kernels of one part of the
  /// glide.
  void add_sample(std::size_t listener, ModeBank::Part part, std::size_t at,
                  const ForceKernel& kernel, std::size_t taps, double force) noexcept;
  void add_moments(std::size_t listener, ModeBank::Part part, std::size_t at,
                   const ForceKernel& kernel, std::size_t taps,
                   std::span<const double> force) noexcept;
  /// Exchange the parts as the glide exchanges its values. A new part begins as a copy of the one
  /// before it; add_history() turns it into its own.
  void start() noexcept;
  void rotate(const Glide& before, const Glide& after) noexcept;
  /// Sets all parts to their present blend.
  void merge_parts(const Glide& glide) noexcept;
  /// Replaces, in the latest part, the kernel of a force that has been constant for a long time.
  /// Call it once with the new kernel and the force, and once with the old kernel and the negative
  /// force.
  void add_history(std::size_t listener, const ForceKernel& kernel, std::size_t taps,
                   std::span<const double> force) noexcept;
  /// Adds the segment's output to `sound` and begins the next segment. `glide`: as at the segment's
  /// beginning; it must not exchange its values within the segment.
  void finish(std::size_t listener, std::span<float> sound, const Glide& glide) noexcept;

private:
  struct Line {
    std::vector<float> elastic, rigid;
    std::size_t end = 0; ///< samples that may differ from zero
  };
  using Lines = std::array<Line, 3>; ///< lines by Part
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
