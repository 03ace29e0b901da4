#pragma once

#include "core/reed/bore/termination.hpp"

namespace tactus::reed {

/// Samples between two readings of the controls of a reed: f_r, f_b, the player, parameters that
/// glide. They are counted from reset(), whatever the size of the host's blocks.
inline constexpr int kControlPeriod = 32;

enum class ValveType { kClosed, kOpen, kSwinging }; ///< blown closed, blown open, swinging door
enum class BoreShape { kCylinder, kCone };
/// How the flow of a step is found: solved with the pressure it causes, or by the paper's explicit
/// formula.
enum class FlowMethod { kImplicit, kPaper };

/// The parameters of a reed instrument: valve, bore, numerics and player. The three control signals
/// (mouth pressure, reed frequency, bore frequency) are not among them.
///
/// Symbols are those of Smyth, Smyth & Kirkpatrick and of docs/theory/greed.md. SI units, angles in
/// rad. The initial values are a clarinet's valve on a cylinder with an open end.
struct Parameters {
  // valve
  ValveType type = ValveType::kClosed;
  double rest_angle = -0.04;        // theta_0
  double arm_length = 0.01;         // l, m
  double mass = 3.376e-6;           // m, kg
  double reed_frequency = 2500;     // f_r, Hz: used while the player's control is 0
  double quality = 5;               // Q
  double width = 13e-3;             // w, m
  double mouth_length = 6.5e-3;     // lambda_m, m: length of reed on which the mouth pressure acts
  double bore_length = 6.5e-3;      // lambda_b, m: length of reed on which the bore pressure acts
  double flow_length = 0;           // mu, m: length of reed on which the flow acts
  double channel_length = 1e-3;     // lambda, m
  double leak_area = 0;             // A_leak, m^2
  double restitution = 0;           // restitution of the stop, 0..1
  double displacement_limit = 5e-3; // x_max, m
  bool sweep = true;                // the moving valve's own volume flow enters the bore

  // bore
  BoreShape shape = BoreShape::kCylinder;
  double length = 0.48;         // L, m: used while neither override nor bore frequency is given
  double length_override = 0;   // m; > 0: used whatever the bore frequency is
  double input_radius = 7.5e-3; // r, m
  double end_radius = 7.5e-3;   // r_e, m, of the radiating opening (bell, tone-hole lattice)
  double apex_distance = 0.2;   // r_0, m, cone only
  double cup_volume = 0;        // V, m^3
  double wall_loss = 1;         // factor on the theoretical loss
  double bell = 0;              // Hz, cut-off of bell or open holes; 0: plain open end
  double bell_quality = 1;      // Q at the cut-off
  double brassiness = 0;        // bore lengths over which the radiated wave steepens
  double scalar_reflection = 0; // R_0; > 0 replaces loss and radiation (Raman's model)
  double temperature = 20;      // deg C
  BoreEnd end = BoreEnd::kOpen; // with tune: holes and bell in place of end_radius and bell

  // numerics and voice
  FlowMethod flow = FlowMethod::kImplicit;
  int oversampling = 0;       // 1, 2 or 4; 0: 4 for the swinging valve, else 1
  double breath_noise = 1e-7; // relative to the jet's pressure (up to 1e-5: to the mouth pressure)
  unsigned seed = 1;
  bool tune = false;         // a player plays f_b and chooses length and lips (player.hpp)
  bool correct_pitch = true; // with tune: TuningController corrects the pitch
  double fingering = 0;      // with tune: MIDI number of the note fingered, instead of f_b; 0: none
  bool tube = false; // with tune and a brass bell: f_b is played with valves or slide (brass.hpp)
  int valves = -1;   // with tune, on a trumpet: bits of the pressed valves; -1: the player chooses
  double slide = 0;  // with tune, on a trombone: position 1 to 7; 0: the player chooses
  double gain = 2;   // gain of the sound outlet, 1/Pa at 1 m before the soft clip

  // the player's lips, with tune: how they follow the note, and factors on the valve above
  double embouchure = 0;       // f_r/f_b that lips keep; 0: a reed, whose f_r stays as given
  double embouchure_slope = 0; // embouchure is proportional to (f_b/f_r) to this power; for a reed,
                               // theta_0 is, at the same closing pressure
  double highest_mode = 0;     // highest mode of the bore that lips play; 0: the mode nearest to
                               // the bore's length
  double shortest_tract = 0;   // m, to which a singer shortens the bore for high notes; 0: never
  double steepening = 0;       // unit of brassiness: this many wavelengths; 0: the length of the
                               // bore
  double aim = 0; // cents added to f_b for linear theory: compensates the pitch shift at playing
                  // level
  double lip_mass = 1;
  double lip_opening = 1; // factor on theta_0
  double lip_width = 1;
  double lip_quality = 1;
  double lip_limit = 1;   // factor on x_max: lips that reach it at loud levels change regime
  double lip_channel = 1; // factor on lambda: the jet's inertance includes air on both sides of the
                          // tip
  double lip_cup = 1;     // factor on cup_volume: the reed's own compliance is part of a cone's tip
  double played_gain = 1; // factor on gain
  double tongue = 0;      // first push of the breath beyond p_m, relative, at 220 Hz and
                          // breath_reference (Player); 0: no tongue

  // how the lips follow the mouth pressure p, with tune: r = p/breath_reference
  double breath_reference = 0; // Pa at which the lips are as above; 0: they do not follow
  double breath_opening = 0.5; // theta_0 times r to this power
  double breath_tension = 0.5; // stiffness and mass times r to this power, at the same f_r
  double breath_quality = 0;   // Q times r to this power: soft lips damp a reed

  double register_note = 0; // Hz: notes from here on use the register vent of `end`; 0: none

  // compass, with tune: f_b outside is refused; 0: no limit
  double lowest_note = 0;  // Hz
  double highest_note = 0; // Hz

  /// Gives theta_0 the sign of the type: closed below 0, open above 0, swinging either sign.
  constexpr void orient() noexcept {
    const double size = rest_angle < 0 ? -rest_angle : rest_angle;
    if (type != ValveType::kSwinging)
      rest_angle = type == ValveType::kClosed ? -size : size;
  }

  friend bool operator==(const Parameters&, const Parameters&) = default;
};

/// The nearest parameters that are usable: finite, within the ranges of parameter_rows.hpp, theta_0
/// with the sign of the type.
[[nodiscard]] Parameters clamped(const Parameters& parameters) noexcept;

/// Linear interpolation, share in 0..1, of the numbers that glide; all other numbers, words and
/// switches are those of `to`.
[[nodiscard]] Parameters interpolate(const Parameters& from, const Parameters& to,
                                     double share) noexcept;

/// Whether interpolate() between the two makes no thump in the sound: no parameter changes by more
/// than its row allows (Change::factor, Change::step).
[[nodiscard]] bool can_interpolate(const Parameters& a, const Parameters& b) noexcept;
/// Whether the oscillation in one instrument can continue in the other: the same kind of valve,
/// bore and player, and no quantity that stores energy changes by more than its row allows
/// (Change::continued_factor, Change::continued_step).
[[nodiscard]] bool can_continue(const Parameters& a, const Parameters& b) noexcept;
/// The target note, Hz: that of Parameters::fingering, else bore_frequency.
[[nodiscard]] double note_of(const Parameters& parameters, double bore_frequency) noexcept;

/// Internal samples computed per sample: 1, 2 or 4.
[[nodiscard]] int oversampling_of(const Parameters& parameters) noexcept;

/// Pressure P_M = k |x_0|/(w lambda_m) that closes a blown-closed valve at rest, Pa, at the
/// instrument's own reed frequency; infinite when lambda_m is 0.
[[nodiscard]] double closing_pressure(const Parameters& parameters) noexcept;

/// Dimensionless embouchure parameter zeta = Z_0 w |x_0| sqrt(2/(rho P_M)): the flow through the
/// open valve at the pressure drop P_M, relative to P_M/Z_0.
[[nodiscard]] double strength(const Parameters& parameters) noexcept;

} // namespace tactus::reed
