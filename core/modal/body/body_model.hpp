#pragma once

#include "core/geometry/surface.hpp"
#include "core/modal/bank/mode_bank.hpp"
#include "core/modal/contact/contact_solver.hpp"
#include "core/modal/contact/pulse.hpp"
#include "core/modal/radiation/direct_sound.hpp"
#include "core/modal/radiation/multipole.hpp"
#include "core/modal/radiation/radiation.hpp"
#include "core/modal/radiation/raw_radiation.hpp"
#include "core/modal/table/loaded_table.hpp"
#include "core/modal/table/modal_table.hpp"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace tactus::modal {

inline constexpr std::size_t kMaxListeners = 4;
inline constexpr std::size_t kMaxContacts = 64;

enum class Radiation { kModal, kRaw, kBody, kNone };
enum class Damping { kTable, kRayleigh, kLoss, kCurve };

/// How a body lies on its board: at points, through what lies between.
struct RestSettings {
  std::vector<Vec3> point_m; ///< in the body's axes, taken to the nearest of either surface
  /// Between the bodies, at each point: the felt of a piano's bass hammer (Chaigne & Askenfelt,
  /// J. Acoust. Soc. Am. 95, 1994: 4e8 N/m^2.3), with a loss.
  contact::ImpactLaw law{4e8, 2.3, 2};
  double pressing_n =
      0; ///< that holds them together besides the body's weight, all points together
  static constexpr std::size_t kMaxPoints = 8;
  [[nodiscard]] bool operator==(const RestSettings& other) const noexcept {
    return point_m == other.point_m && pressing_n == other.pressing_n &&
           law.stiffness == other.law.stiffness && law.exponent == other.law.exponent &&
           law.dissipation_s_per_m == other.law.dissipation_s_per_m;
  }
};

/// What can be changed of a body while it sounds.
struct BodySettings {
  double youngs_modulus_pa = 0; ///< 0: the table's
  double density_kg_per_m3 = 0; ///< 0: the table's
  double poisson = -1;          ///< below 0: the table's
  double size = 1;              ///< times the table's lengths
  /// Of the table's shape parameters, m in the table's size. Empty, or of another number than the
  /// table has: the shape is the table's.
  std::vector<double> shape_displacement_m;
  Damping damping = Damping::kTable;
  double rayleigh_a_per_s = 0, rayleigh_b_s = 0;
  double loss_factor = 0;
  std::vector<std::array<double, 2>> loss_curve; ///< Hz, loss factor; ascending
  double choke_t60_s = 0; ///< above 0: damps every mode by this decay time besides
  Radiation radiation = Radiation::kModal;
  /// m; before the body, then behind it
  std::array<Vec3, kMaxListeners> listener{Vec3{-0.1, 0.2, 0.5}, Vec3{0.1, 0.2, 0.5},
                                           Vec3{-0.1, 0.2, -0.5}, Vec3{0.1, 0.2, -0.5}};
  std::size_t listeners = 2;
  std::size_t max_modes = 0; ///< 0: all that can be heard
  std::size_t voices = 8;    ///< contacts at once
  RestSettings rest;
  double sample_rate = 48000;
  VectorSet vector_set = best_vector_set(); ///< must be one that this processor runs
};

/// One body made of one material, heard from its listeners: everything that the audio path needs.
/// Made off the audio path from table and settings.
///
/// Scaling at fixed Poisson's ratio: f ~ sqrt(E/rho)/L, phi ~ 1/sqrt(rho L^3), mass ~ rho L^3,
/// inertia ~ rho L^5; a changed Poisson's ratio moves each mode by the table's d ln f/d nu.
/// A moved shape moves each by frequency_factors(), and its decay as its damping law says.
/// Decay: alpha = (a + b omega^2)/2 or omega eta/2, plus radiation's, plus the choke's 6.91/T60.
///
/// A body on a board is one model: `size` is that of both, all other material settings are the
/// body's, and the board is as its table says.
struct BodyModel {
  BodyModel(std::shared_ptr<const LoadedTable> from, const BodySettings& with);

  std::shared_ptr<const LoadedTable> loaded;
  BodySettings settings;
  double youngs_modulus_pa, poisson, density_kg_per_m3;
  double shape_scale, mass_kg;
  /// Table's number of each mode: first those of the bank, then those that only give way in a
  /// contact, up to kContactLimit.
  std::vector<std::size_t> mode;
  std::vector<std::size_t>
      index_of; ///< in `mode`, of each of the table's modes; its size: left out
  std::size_t audible_modes = 0;
  std::vector<std::complex<double>> rate;                              ///< of `mode`
  std::array<std::vector<std::complex<double>>, kMaxListeners> weight; ///< of the first `heard`
  std::array<double, kMaxListeners> delay_s{};                         ///< of the delay line
  bool uses_recordings = false; ///< blows start recordings instead of contacts
  std::array<RawListener, kMaxListeners> raw;
  ModeBank bank;
  ContactSolver solver;

  /// What forces sound like besides the modes that ring, and at their places: at the force inlet's
  /// point (first) and where pulses strike, and of each contact of the solver.
  std::array<DirectKernels, kMaxListeners> direct;
  std::vector<std::array<ForceKernel, kMaxListeners>> sample_kernel, contact_kernel;
  using RigidGain = std::array<double, ContactSolver::kRigid>;
  /// The kernels of a force at a point of the surface against `direction`, gains of the modes as
  /// gains() has them or none. Allocates nothing; may use `scratch`.
  void build_point_kernels(const SurfacePoint& point, const Vec3& direction) noexcept;
  /// `gain`: times `pulse_gain`.
  void build_pulse_kernels(std::size_t slot, const SurfacePoint& point, const Vec3& direction,
                           std::span<const double> gain = {}) noexcept;
  void build_contact_kernels(std::size_t slot, const SurfacePoint& point, const Vec3& direction,
                             std::span<const double> gain = {}) noexcept;

  std::vector<float> force_gain; ///< gains b of the modes at the force inlet's point
  RigidGain force_rigid{};       ///< and of the rigid motions, of a body that rests on a board
  /// A pulse's samples are means of the force over their time, which takes sin(x)/x from a tone,
  /// x = omega/(2 fs); these factors of the gains give it back.
  std::vector<double> pulse_gain;
  std::vector<std::uint8_t> band;                  ///< pulse_band() of `mode`
  std::vector<double> scratch;                     ///< as long as `mode`
  std::vector<double> scratch_level;               ///< as long as `heard`
  std::vector<std::complex<double>> scratch_state; ///< as long as `mode`
  std::vector<std::complex<double>> bank_state;    ///< as long as `heard`
  std::vector<double> a_weight;                    ///< A-weighting of the heard modes
  std::vector<double> loudness; ///< of the heard modes: at the loudest listener and to the ear
  /// What the contact solver listens with: a listener, and which of its gliding weights.
  struct ListenerPart {
    std::size_t listener = 0;
    ModeBank::Part part = ModeBank::kLatest;
  };
  std::array<ListenerPart, 3 * kMaxListeners> listener_parts{};
  std::size_t listener_part_count = 0;

  static constexpr double kContactLimit = 60000; ///< Hz
  /// Contacts of the solver besides the strikes': a hand's, and that of a surface that rubs.
  static constexpr std::size_t kContacts = 2;

  /// A point at which the body and its board touch.
  struct RestingContact {
    SurfacePoint on_body, on_board;
    Vec3 direction{};         ///< of length 1: the force's on the body, the opposite on the board
    std::vector<double> gain; ///< on the body less on the board: by which the two come apart
    std::array<double, ContactSolver::kRigid> rigid{};
    contact::ImpactLaw law; ///< with the compliance of both surfaces
    double preload_n = 0;
  };
  std::vector<RestingContact> resting_contacts;
  /// Why the body cannot rest as the settings want; it rests nowhere then. Else empty.
  std::string resting_refusal;
  /// Distance between the two surfaces at the points, the largest, m.
  double largest_gap_m = 0;
  /// The contacts of `rests` in the solver begin here.
  [[nodiscard]] std::size_t resting_slot() const noexcept { return kContacts + settings.voices; }
  /// The body moves as a whole when it is pushed here; else its support, or the board's, takes it.
  [[nodiscard]] bool recoils(const SurfacePoint& point) const noexcept;
  /// Of the body that a place is on.
  [[nodiscard]] double modulus_at(const SurfacePoint& point) const noexcept;
  [[nodiscard]] double poisson_at(const SurfacePoint& point) const noexcept;

  /// Gains b = -phi . direction of all modes at a place of the surface, 1/sqrt(kg), for a push
  /// against `direction` (usually the outward normal). No allocation beyond `gain`'s size.
  void gains(const SurfacePoint& point, const Vec3& direction,
             std::span<double> gain) const noexcept;
  /// The same of a free body's three displacements and three rotations; of a body that rests on a
  /// board, what its points resist of them.
  [[nodiscard]] std::array<double, ContactSolver::kRigid>
  rigid_gains(const SurfacePoint& point, const Vec3& direction) const noexcept;
  /// Static compliance of the modes that the table leaves out, m/N.
  [[nodiscard]] double residual_compliance(const SurfacePoint& point) const noexcept;
  /// Of a mode at the listener that hears it most.
  [[nodiscard]] double loudest_weight(std::size_t mode) const noexcept;
  /// The nearest place of the surface to a point in metres, in the body's present size.
  [[nodiscard]] SurfacePoint nearest(const Vec3& position_m) const noexcept;
  /// Lets this model go on where another of the same table was: modal displacement and velocity
  /// stay, and so does the sound, whose weights glide.
  void continue_from(BodyModel& before) noexcept;
  /// The same while something touches the body: motion is in the solvers. Contacts are still to be
  /// taken over.
  void continue_in_contact(BodyModel& before) noexcept;
  /// The same where another table of the same body was, which this one's follows; `touched`: motion
  /// is in the solvers. Energies of modes, and their sound, go over by the table's shares: no
  /// energy arises. What has no successor is left in `before`'s bank, being released; false when
  /// nothing is.
  bool continue_modes_from(BodyModel& before, bool in_contact_now) noexcept;

  /// Gives the contact solver the weights that the bank's glides are at now, if they have changed.
  void refresh_listener_weights() noexcept;

private:
  void glide_from(BodyModel& before) noexcept;
  void release_from(BodyModel& before) noexcept;
  void glide_by_shares(BodyModel& before) noexcept;
  [[nodiscard]] double decay_rate(std::size_t mode, double omega) const;
  [[nodiscard]] double shape_scale_of(std::size_t part) const noexcept;
  [[nodiscard]] double part_modulus(std::size_t part) const noexcept;
  void find_resting_contacts();
  void make_resting_kernels();
  [[nodiscard]] std::unique_ptr<Arrivals> arrivals_of(std::size_t part, const Vec3& listener,
                                                      double delay_from_s) const;
  [[nodiscard]] std::unique_ptr<Arrivals> arrivals(const Vec3& listener) const;
  void find_rates();
  void find_weights();

  std::array<std::vector<std::complex<double>>, 3> scratch_weight_;    ///< as long as `heard`
  std::vector<std::array<double, ContactSolver::kRigid>> rigid_basis_; ///< of a body that rests
  double board_shape_scale_ = 1;
  std::uint64_t weights_version_ = 0; ///< of the bank's weights that the solver has
  [[nodiscard]] std::vector<DirectKernels::Mode> direct_modes() const;
  [[nodiscard]] RadiatingSurface::RigidShapes rigid_shapes() const;
  [[nodiscard]] std::vector<double> omega_by_mode(std::size_t part) const;
  [[nodiscard]] std::array<RigidDipole, 3> free_dipoles() const;
  void make_kernels();
  [[nodiscard]] bool needs_gains() const noexcept;
  [[nodiscard]] DirectKernels::SurfaceGain surface_gain(const SurfacePoint& point,
                                                        const Vec3& direction) const noexcept;
};

} // namespace tactus::modal
