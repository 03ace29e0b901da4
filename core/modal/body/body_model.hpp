#pragma once

#include "core/dsp/complex.hpp"
#include "core/geometry/surface.hpp"
#include "core/modal/bank/mode_bank.hpp"
#include "core/modal/body/events.hpp"
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
#include <string_view>
#include <vector>

namespace tactus::modal {

inline constexpr std::size_t kMaxListeners = 4;
inline constexpr std::size_t kMaxContacts = 64;
inline constexpr double kGravity = 9.80665; // m/s^2
/// The largest number of samples that are computed together; a ChannelBlock holds the sound of
/// these samples at each listener.
inline constexpr std::size_t kChunk = 64;
using ChannelBlock = std::array<std::array<float, kChunk>, kMaxListeners>;

/// How the sound at a listener is computed from the modes: by Rayleigh's integral for each mode
/// (kModal), from the surface velocities in the table (kRaw), or by the body's multipoles (kBody).
/// With kNone the surface velocity itself is heard.
enum class Radiation { kModal, kRaw, kBody, kNone };
/// Names of the arrays that this radiation needs and the table lacks; empty if it has them.
[[nodiscard]] std::string_view missing_arrays(const LoadedTable& loaded,
                                              Radiation radiation) noexcept;
/// Where the damping of the modes comes from: the table, Rayleigh's law, one loss factor, or a
/// curve of loss factors over frequency.
enum class Damping { kTable, kRayleigh, kLoss, kCurve };

/// How a body rests on its board: contact points, contact law and load.
struct RestSettings {
  std::vector<Vec3> point_m; ///< points in the body's axes; moved to the nearest point of each
                             ///< surface
  /// The contact law at each point. Default: the felt of a piano's bass hammer with a loss (Chaigne
  /// & Askenfelt, J. Acoust. Soc. Am. 95, 1994: 4e8 N/m^2.3).
  contact::ImpactLaw law{4e8, 2.3, 2};
  double pressing_n = 0; ///< force on the board besides the body's weight, over all points
  static constexpr std::size_t kMaxPoints = 8;
  [[nodiscard]] bool operator==(const RestSettings& other) const noexcept {
    return point_m == other.point_m && pressing_n == other.pressing_n &&
           law.stiffness == other.law.stiffness && law.exponent == other.law.exponent &&
           law.dissipation_s_per_m == other.law.dissipation_s_per_m;
  }
};

/// The settings of a body that can change while it sounds.
struct BodySettings {
  double youngs_modulus_pa = 0; ///< 0: the value of the table
  double density_kg_per_m3 = 0; ///< 0: the value of the table
  double poisson = -1;          ///< below 0: the value of the table
  double size = 1;              ///< factor on the table's lengths
  /// Displacements of the table's shape parameters, m in the table's size. If the list is empty, or
  /// not as long as the table's list, the table's shape is used.
  std::vector<double> shape_displacement_m;
  Damping damping = Damping::kTable;
  double rayleigh_a_per_s = 0, rayleigh_b_s = 0;
  double loss_factor = 0;
  std::vector<std::array<double, 2>> loss_curve; ///< Hz, loss factor; ascending
  double choke_t60_s = 0; ///< above 0: additional damping of every mode, by decay time
  Radiation radiation = Radiation::kModal;
  /// m, in the body's axes. By default two listeners are in front of the body, then two behind it.
  /// The first two are not mirror images: they would hear a body that swings from one to the other,
  /// as a struck tube does, in opposite phase, and their sum would be silent.
  std::array<Vec3, kMaxListeners> listener{Vec3{-0.1, 0.2, 0.5}, Vec3{-0.03, 0.2, 0.55},
                                           Vec3{-0.1, 0.2, -0.5}, Vec3{0.1, 0.2, -0.5}};
  std::size_t listeners = 2;
  std::size_t max_modes = 0; ///< largest number of modes in the bank; 0: no limit
  std::size_t voices = 8;    ///< strikes at once
  RestSettings rest;
  double sample_rate = 48000;
  VectorSet vector_set = simd::kWidest; ///< the widest that is used
};

/// A modal table with settings applied: all rates, weights and kernels that the audio path needs.
/// Built outside the audio path.
///
/// Scaling at fixed Poisson's ratio: f ~ sqrt(E/rho)/L, phi ~ 1/sqrt(rho L^3), mass ~ rho L^3,
/// inertia ~ rho L^5. Another Poisson's ratio multiplies each frequency by exp(d ln f/d nu *
/// change), from the table; another shape by frequency_factors(). Decay: alpha = (a + b omega^2)/2
/// or omega eta/2, plus the decay rate by radiation, plus the choke's 6.91/T60.
///
/// A body on a board is one model with the modes of both. `size` applies to both; the other
/// material settings apply to the body only.
struct BodyModel {
  BodyModel(std::shared_ptr<const LoadedTable> from, const BodySettings& with);

  std::shared_ptr<const LoadedTable> loaded;
  BodySettings settings;
  double youngs_modulus_pa, poisson, density_kg_per_m3;
  double shape_scale, mass_kg;
  /// The table's index of each mode: first the audible modes, which ring in the bank, then higher
  /// ones up to kContactLimit, which only add compliance to contacts.
  std::vector<std::size_t> mode;
  std::vector<std::size_t>
      index_of; ///< index in `mode` of each of the table's modes; mode.size(): left out
  std::size_t audible_modes = 0;
  std::vector<Complex> rate;                              ///< rates of the modes in
                                                          ///< `mode`
  std::array<std::vector<Complex>, kMaxListeners> weight; ///< weights of the audible
                                                          ///< modes
  std::array<double, kMaxListeners> delay_s{};            ///< delays of the delay line
  bool uses_recordings = false; ///< strikes play recordings (RawTable) instead of contacts
  std::array<RawListener, kMaxListeners> raw;
  /// The motion: in the solver while something touches the body, else in the bank, which is much
  /// cheaper. While the modes are in the solver the bank still rings from pulses and releases.
  ModeBank bank;
  ContactSolver solver;
  bool in_solver = false;
  std::size_t culled = 0; ///< modes that were last left out as inaudible
  /// Moves the motion to the solver, where a body on a board touches the board.
  void enter_contact() noexcept;
  /// Ends all contacts and moves the motion to the bank, without modes that are quieter than the
  /// loudest by `cull_db` or more. A body that has settled is at rest.
  void leave_contact(double gain, double cull_db) noexcept;
  /// True if nothing but the board touches the body and its motion is about a millionth of the
  /// static deflection (less for a gain above kReferenceGain).
  [[nodiscard]] bool has_settled(double gain) const noexcept;
  /// Contacts without those on the board.
  [[nodiscard]] std::size_t active_strikes() const noexcept;

  /// The direct sound of forces (DirectKernels). sample_kernel: kernels at the points of the
  /// external force (first) and of the pulses. contact_kernel: kernels of the solver's contacts.
  std::array<DirectKernels, kMaxListeners> direct;
  std::vector<std::array<ForceKernel, kMaxListeners>> sample_kernel, contact_kernel;
  using RigidGain = std::array<double, ContactSolver::kRigid>;
  /// Build the kernels of a force at a point of the surface against `direction`. `gain`: gains of
  /// the modes, as gains() computes them; if it is empty, they are computed here. These functions
  /// do not allocate; they may use `scratch`.
  void build_point_kernels(const SurfacePoint& point, const Vec3& direction) noexcept;
  /// `gain`: multiplied by `pulse_gain`.
  void build_pulse_kernels(std::size_t slot, const SurfacePoint& point, const Vec3& direction,
                           std::span<const double> gain = {}) noexcept;
  void build_contact_kernels(std::size_t slot, const SurfacePoint& point, const Vec3& direction,
                             std::span<const double> gain = {}) noexcept;

  /// Sets where the external force acts.
  void set_force_point(const ForcePoint& point) noexcept;
  std::vector<float> force_gain; ///< gains b of the modes at the force point
  RigidGain force_rigid{};       ///< gains b of the rigid motions, for a body on a board
  /// x/sin(x), x = omega/(2 fs), for each mode: compensates the low-pass sin(x)/x of pulses, whose
  /// samples are means of the force over a sample.
  std::vector<double> pulse_gain;
  std::vector<std::uint8_t> band;     ///< pulse_band() of `mode`
  std::vector<double> scratch;        ///< as long as `mode`
  std::vector<double> scratch_level;  ///< [audible_modes]
  std::vector<Complex> scratch_state; ///< as long as `mode`
  std::vector<Complex> bank_state;    ///< [audible_modes]
  std::vector<double> a_weight;       ///< A-weighting of the audible modes
  std::vector<double> loudness;       ///< loudness of the audible modes: A-weighted, at the loudest
                                      ///< listener
  /// An output of the contact solver: a listener, and one of its three gliding weights.
  struct ListenerPart {
    std::size_t listener = 0;
    ModeBank::Part part = ModeBank::kLatest;
  };
  std::array<ListenerPart, 3 * kMaxListeners> listener_parts{};
  std::size_t listener_part_count = 0;

  static constexpr double kContactLimit = 60000; ///< Hz
  /// Slots of the solver besides the strikes: a hand, and a rubbing surface.
  static constexpr std::size_t kContacts = 2;

  /// A point at which the body and its board touch.
  struct RestingContact {
    SurfacePoint on_body, on_board;
    Vec3 direction{};         ///< unit vector of the force on the body
    std::vector<double> gain; ///< gains on the body minus gains on the board
    std::array<double, ContactSolver::kRigid> rigid{};
    contact::ImpactLaw law; ///< law with the residual compliance of both bodies
    double preload_n = 0;
  };
  std::vector<RestingContact> resting_contacts;
  /// Reason why the body cannot rest as set; it has no resting contacts then. Else empty.
  std::string resting_refusal;
  /// The largest distance between the two surfaces at a contact point, m.
  double largest_gap_m = 0;
  [[nodiscard]] bool rests() const noexcept { return !resting_contacts.empty(); }
  /// The solver's slots after those of the strikes: the slot of a hand, of a rubbing surface, and
  /// of the first of resting_contacts.
  [[nodiscard]] std::size_t hand_slot() const noexcept { return settings.voices; }
  [[nodiscard]] std::size_t rub_slot() const noexcept { return settings.voices + 1; }
  [[nodiscard]] std::size_t resting_slot() const noexcept { return settings.voices + kContacts; }
  /// True if a force at this point moves the body as a whole; false if its support, or that of the
  /// board, prevents this.
  [[nodiscard]] bool recoils(const SurfacePoint& point) const noexcept;
  /// The law of a striker's contact with the body (or the board) at a point.
  [[nodiscard]] contact::ImpactLaw impact_law(const Striker& striker, double speed_m_per_s,
                                              const SurfacePoint& point) const noexcept;

  /// Gains b = -phi . direction of all modes at a point of the surface, 1/sqrt(kg), for a force
  /// against `direction` (usually the outward normal). `gain`: [mode.size()]. Does not allocate.
  void gains(const SurfacePoint& point, const Vec3& direction,
             std::span<double> gain) const noexcept;
  /// Whether any mode moves any corner of a point's triangle along a direction of length 1, by more
  /// than rounding.
  [[nodiscard]] bool moves_along(const SurfacePoint& point, const Vec3& direction) const noexcept;
  /// Gains b of a free body's three translations and three rotations; for a body on a board, their
  /// projection on the motions that its contact points resist.
  [[nodiscard]] std::array<double, ContactSolver::kRigid>
  rigid_gains(const SurfacePoint& point, const Vec3& direction) const noexcept;
  /// Static compliance of the modes that the table omits, m/N.
  [[nodiscard]] double residual_compliance(const SurfacePoint& point) const noexcept;
  /// The largest |weight| of a mode over the listeners.
  [[nodiscard]] double loudest_weight(std::size_t mode) const noexcept;
  /// The point of the surface nearest to a position in m, in the body's present size.
  [[nodiscard]] SurfacePoint nearest(const Vec3& position_m) const noexcept;
  /// Continues the motion of another model of the same body. Without a contact every mode keeps its
  /// state z, and so its energy |z|^2/2, whether its pitch rises or falls. The weights of the sound
  /// glide from the old ones to the new; during the glide no mode is louder than at the louder end.
  /// During a contact the part of z that is the deflection under the contact forces becomes the new
  /// body's deflection under these forces, since it would otherwise spring back with a thump. Only
  /// the contacts on the board are continued here.
  ///
  /// If the modes were solved again (LoadedTable::follows), motion and sound are mapped by the
  /// table's shares (ModeShare), which cannot raise the energy. Returns true if motion without a
  /// successor fades out in the bank of `before`.
  bool continue_from(BodyModel& before) noexcept;
  /// Continues another contact of `before`, if it is active; gains as in build_contact_kernels().
  /// `held`: without rigid motion if the body does not recoil at the point.
  void take_over_contact(std::size_t slot, const BodyModel& before, std::size_t old_slot,
                         const SurfacePoint& point, const Vec3& direction,
                         bool held = false) noexcept;

  /// Updates the contact solver's weights to those that the bank glides between, if they have
  /// changed.
  void refresh_listener_weights() noexcept;

private:
  [[nodiscard]] Complex pressed_state(std::size_t i) const noexcept;
  [[nodiscard]] Complex deflection_ratio(std::size_t i, const BodyModel& before,
                                         std::size_t j) const noexcept;
  [[nodiscard]] Complex sound_ratio(std::size_t i, const BodyModel& before,
                                    std::size_t j) const noexcept;
  std::span<Complex> keep_states(const BodyModel& before, std::size_t count,
                                 std::size_t old_count) noexcept;
  void continue_in_bank(BodyModel& before) noexcept;
  void continue_in_contact(BodyModel& before) noexcept;
  bool continue_by_shares(BodyModel& before) noexcept;
  void take_over_rigid(const BodyModel& before) noexcept;
  void begin_resting_contacts() noexcept;
  void glide_from(BodyModel& before) noexcept;
  void release_from(BodyModel& before) noexcept;
  void glide_by_shares(BodyModel& before) noexcept;
  [[nodiscard]] double decay_rate(std::size_t mode, double omega) const;
  [[nodiscard]] double modulus_at(const SurfacePoint& point) const noexcept;
  [[nodiscard]] double poisson_at(const SurfacePoint& point) const noexcept;
  [[nodiscard]] double shape_scale_of(std::size_t part) const noexcept;
  void find_resting_contacts();
  void make_resting_kernels();
  [[nodiscard]] std::unique_ptr<Arrivals> arrivals_of(std::size_t part, const Vec3& listener,
                                                      double delay_from_s) const;
  [[nodiscard]] std::unique_ptr<Arrivals> arrivals(const Vec3& listener) const;
  void compute_rates();
  void compute_weights();

  std::array<std::vector<Complex>, 3> scratch_weight_;                 ///< [audible_modes]
  std::vector<std::array<double, ContactSolver::kRigid>> rigid_basis_; ///< basis of a body on a
                                                                       ///< board
  double board_shape_scale_ = 1;
  std::uint64_t weights_version_ = 0; ///< ModeBank::glide_version() of the solver's weights
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
