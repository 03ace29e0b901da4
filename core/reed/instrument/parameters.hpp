#pragma once

#include "core/reed/bore/termination.hpp"

namespace tactus::reed {

enum class ValveType { kClosed, kOpen, kSwinging }; ///< blown closed, blown open, swinging door
enum class BoreShape { kCylinder, kCone };
enum class FlowMethod { kImplicit, kPaper };

/// Everything that describes a reed instrument at rest; the player's three controls (mouth
/// pressure, reed frequency, bore frequency) arrive beside it, sample by sample.
/// Symbols are those of Smyth, Smyth & Kirkpatrick and of docs/greed.md. SI, angles in rad.
/// The initial values are the clarinet.
struct Parameters {
  // valve
  ValveType type = ValveType::kClosed;
  double rest_angle = -0.04;        // theta_0
  double arm_length = 0.01;         // l, m
  double mass = 3.376e-6;           // m, kg
  double reed_frequency = 2500;     // f_r, Hz: used while the player's control is 0
  double quality = 5;               // Q
  double width = 13e-3;             // w, m
  double mouth_length = 6.5e-3;     // lambda_m, m: length of reed that sees the mouth pressure
  double bore_length = 6.5e-3;      // lambda_b, m: length of reed that sees the bore pressure
  double flow_length = 0;           // mu, m: length of reed that sees the flow
  double channel_length = 1e-3;     // lambda, m
  double leak_area = 0;             // A_leak, m^2
  double restitution = 0;           // of the stop, 0..1
  double displacement_limit = 5e-3; // x_max, m
  bool sweep = true;                // the moving valve's own volume flow enters the bore

  // bore
  BoreShape shape = BoreShape::kCylinder;
  double length = 0.48;         // L, m: used while neither override nor bore frequency is given
  double length_override = 0;   // m; > 0 stands above the bore frequency
  double input_radius = 7.5e-3; // r, m
  double end_radius = 7.5e-3;   // r_e, m, of the radiating opening (bell, tone-hole lattice)
  double apex_distance = 0.2;   // r_0, m, cone only
  double cup_volume = 0;        // V, m^3
  double wall_loss = 1;         // times the theoretical loss
  double bell = 0;         // Hz, above which bell or open holes let sound out; 0: plain open end
  double bell_quality = 1; // Q of its opening
  double brassiness = 0;   // bore lengths over which the radiated wave steepens
  double scalar_reflection = 0; // R_0; > 0 replaces loss and radiation (Raman's model)
  double temperature = 20;      // deg C
  BoreEnd end = BoreEnd::kOpen; // with tune: holes and bell in place of end_radius and bell

  // numerics and voice
  FlowMethod flow = FlowMethod::kImplicit;
  int oversampling = 0;       // 1, 2 or 4; 0: 4 for the swinging valve, else 1
  double breath_noise = 1e-7; // relative to the mouth pressure; as little starts a slow breath
  unsigned seed = 1;
  bool tune = false;    // a player plays f_b: chooses length and embouchure, and listens
  bool ear = true;      // with tune: correct what is heard out of tune
  double fingering = 0; // with tune: MIDI number of the note fingered, instead of f_b; 0: none
  bool tube = false; // with tune and a brass bell: f_b is played with valves or slide (brass.hpp)
  int valves = -1;   // with tune, on a trumpet: bits of those pressed; -1: the player's choice
  double slide = 0;  // with tune, on a trombone: position 1 to 7; 0: the player's choice
  double gain = 2;   // of the sound outlet, 1/Pa at 1 m before the soft clip

  // the player's lips, with tune: what they keep of the note, and factors on the valve above
  double embouchure = 0;       // f_r/f_b; 0: a reed, whose f_r stays as given
  double embouchure_slope = 0; // power of f_b/f_r by which that share changes with the note; of a
                               // reed: by which theta_0 does, at the same closing pressure
  double highest_mode = 0; // of the bore, that lips sound; 0: whichever lies nearest to its length
  double shortest_tract =
      0;                 // m, to which lips shorten the bore so that high notes stay theirs alone
  double steepening = 0; // wavelengths, what brassiness counts; 0: the bore as it is played
  double aim = 0;        // cents beside f_b: what sounding loud adds, known by practice
  double lip_mass = 1;
  double lip_opening = 1; // of theta_0
  double lip_width = 1;
  double lip_quality = 1;
  double lip_limit = 1;   // of x_max, which loud lips must not meet: there they change regime
  double lip_channel = 1; // of lambda: air that follows the lay, and inside and outside the tip
  double lip_cup = 1;     // of the cup's volume: the reed's own compliance is part of a cone's tip
  double played_gain = 1; // times gain
  /// By how much of p_m the breath's first push exceeds it, at 220 Hz and breath_reference (see
  /// Player); 0: no tongue.
  double tongue = 0;

  // how the lips go with the mouth pressure p, with tune: r = p/breath_reference
  double breath_reference = 0; // Pa at which the lips are as above; 0: they do not follow
  double breath_opening = 0.5; // theta_0 times r to this power,
  double breath_tension = 0.5; // stiffness and mass times r to this power, at the same f_r
  double breath_quality = 0;   // Q times r to this power: soft lips damp a reed

  double register_note = 0; // Hz: from here on with the register vent of `end`; 0: never

  // what can be played in tune, with tune: f_b beyond it is refused; 0: no limit
  double lowest_note = 0;  // Hz
  double highest_note = 0; // Hz

  friend bool operator==(const Parameters&, const Parameters&) = default;
};

/// The nearest parameters with which a model can be computed: finite, within wide physical bounds,
/// theta_0 on the side that the type wants (closed: below 0, open: above).
[[nodiscard]] Parameters clamped(const Parameters& parameters) noexcept;

/// Parameters on the way from one set to another: every number a share of the way, words and
/// switches as in `to`.
[[nodiscard]] Parameters interpolate(const Parameters& from, const Parameters& to,
                                     double share) noexcept;

/// Whether an instrument that sounds can become the other one on the straight way of between()
/// without a thump: no switch or word differs, nor what a 0 switches off, and no size is more than
/// a quarter as large again.
[[nodiscard]] bool can_interpolate(const Parameters& a, const Parameters& b) noexcept;
/// Whether what sounds in one instrument can go on in the other: the same kind of valve, bore and
/// player, and no size that holds energy more than twice as large.
[[nodiscard]] bool can_continue(const Parameters& a, const Parameters& b) noexcept;
/// The note meant, Hz: that of the fingering, else the bore frequency as given.
[[nodiscard]] double note_of(const Parameters& parameters, double bore_frequency) noexcept;

/// How many internal samples an instrument with these parameters computes for each sample.
[[nodiscard]] int oversampling_of(const Parameters& parameters) noexcept;

/// Pressure P_M = k |x_0|/(w lambda_m) that closes a blown-closed valve at rest, Pa, at the
/// instrument's own reed frequency; infinite when the mouth has no hold on the valve.
[[nodiscard]] double closing_pressure(const Parameters& parameters) noexcept;

/// Dimensionless strength zeta = Z_0 w |x_0| sqrt(2/(rho P_M)) of valve against bore.
[[nodiscard]] double strength(const Parameters& parameters) noexcept;

} // namespace tactus::reed
