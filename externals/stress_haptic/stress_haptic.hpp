#pragma once

#include "core/haptic/chain/velocity.hpp"
#include "core/rows.hpp"
#include "core/stress/render.hpp"
#include "core/stress/vector_ramp.hpp"
#include "externals/stress_haptic/stress_worker.hpp"

#include <array>
#include <optional>
#include <string>

namespace tactus::stress {

inline constexpr double kMm_per_m = 1e3;

/// Text of a message as it was sent, such as "range fixed 2 1", for its error text.
[[nodiscard]] std::string sentence_of(std::string_view message, std::span<const Atom> arguments);

/// [stress_haptic]: haptic feedback of a part's stress while the user reshapes it (core/stress,
/// docs/stress_haptic.md).
class StressHaptic {
public:
  static const Declaration declaration;
  static constexpr std::size_t timers = 1;

  explicit StressHaptic(StressJob::SolverFactory solvers);
  StressHaptic(); ///< uses part_stress as solver
  void scalar(std::size_t inlet, double value, Host& host);
  void list(std::size_t inlet, std::span<const Atom> atoms, Host& host);
  void tick(std::size_t timer, Host& host);
  void posted(Host& host) { collect(host); }
  void created(Host& host);
  void dump(Host& host);

private:
  struct Rows;
  /// How gamma is rendered on the handle.
  enum class Feel : std::uint8_t { kSpring, kDamper, kBoth, kOff };
  struct Device {
    Feel feel = Feel::kSpring;
    bool drag = true; ///< the handle moves the grabbed control point
    double scale = 1, nominal_n_per_m = 1000, share = 0.6, damping_n_s_per_m = 5;
  };
  static constexpr std::size_t kGammaOutlet = 0, kForceOutlet = 1, kProtocolOutlet = 3;
  static constexpr double kFade_s = 0.1; ///< fade time of a new gamma and of a moved anchor
  void load(const Atom& name, Host& host);
  void take_table(const StressJob::Answer& answer, Host& host);
  void set_solver(const Atom& program, Host& host);
  void set_control_point(std::span<const Atom> arguments, Host& host);
  void set_parameters(std::span<const Atom> arguments, Host& host);
  void grab(std::span<const Atom> arguments, Host& host);
  void release(Host& host);
  void reset(Host& host);
  void send_all(Host& host) {
    if (host_)
      send(host, true);
  }
  void settings_changed();
  void state_changed();
  void weights_changed();
  void resolve_changed();
  [[nodiscard]] double power() const noexcept { return request_.settings.power; }
  void set_power(double q) noexcept;
  void set_range(std::span<const Atom> arguments, Host& host);
  void set_gains(std::span<const Atom> arguments, Host& host);
  void set_anchor(std::span<const Atom> arguments, Host& host);
  void send_points(Host& host);
  void draw(std::span<const Atom> arguments, Host& host);
  void send_picture(Host& host);

  /// Returns false after one error if no table is loaded.
  [[nodiscard]] bool has_table(std::string_view message, Host& host) const;
  /// The control point of this id; nullopt after one error.
  [[nodiscard]] std::optional<std::size_t> control_point(std::string_view message, double id,
                                                         Host& host) const;
  /// Sets the displacements of a control point's parameters, limited to their bounds.
  void displace(std::size_t control_point, const Vec3& displacement_m) noexcept;
  [[nodiscard]] Vec3 displacement_of(std::size_t control_point) const noexcept;
  // Each function warns of a setting that the table or the object does not support; processing
  // continues.
  void warn_about_state(Host& host) const;
  void warn_about_weights(Host& host) const;
  void warn_about_resolve(Host& host) const;
  void submit(Host& host);
  void request(Host& host);
  void collect(Host& host);
  void send(Host& host, bool all);
  void send_info(Host& host);
  void send_feedback(Host& host, const Vec3& gamma);
  void schedule(Host& host);
  [[nodiscard]] Vec3 force(double now_s) noexcept;
  [[nodiscard]] RenderGains gains_in_force() const noexcept;
  [[nodiscard]] double stiffness_limit() const noexcept {
    return device_.share * device_.nominal_n_per_m;
  }
  [[nodiscard]] bool is_axis() const noexcept {
    return request_.settings.mapping == Mapping::kAxis;
  }

  Device device_;
  Host* host_ = nullptr;   ///< outlives the object
  std::string first_name_; ///< creation argument; loaded after all flags are set
  std::shared_ptr<const StressTable> table_;
  bool can_solve_ = false;
  StressJob::Request request_;
  bool threaded_ = false;
  SessionResult result_;
  RenderGains gains_{0, 400, 0, 4};
  VectorRamp gamma_{}, anchor_{};
  bool anchored_ = false;     ///< if false, the next position becomes the anchor
  bool has_position_ = false; ///< the handle has sent a position
  Vec3 position_m_{}, velocity_m_per_s_{};
  haptic::VelocityEstimator velocity_estimate_;
  Vec3 grab_position_m_{}, grab_displacement_m_{}; ///< values at the grab
  // The last outputs and their times.
  std::optional<Vec3> sent_gamma_, sent_force_n_, sent_feedback_;
  double feedback_ms_ = -1e9, info_ms_ = -1e9;
  std::uint64_t feedback_sequence_ = 0;
  bool info_due_ = false;
  std::uint64_t pictures_ = 0, sent_picture_ = 0; ///< numbers of the requested and the sent picture
  bool draw_when_loaded_ = false;
  std::vector<PictureFace> sent_faces_; ///< if empty, all must be sent
  StressWorker worker_;
};

/// The words of each choice are in the order of its enumeration in core/stress.
struct StressHaptic::Rows {
  using Self = StressHaptic;
  using Feedback = FeedbackSettings;
  using Words = std::string_view;
  static constexpr std::array<Words, 3> modes{"mean", "weighted", "axis"};
  static constexpr std::array<Words, 2> weightings{"uniform", "volume"}, signs{"signed", "abs"},
      states{"vonmises", "shear"}, norms{"mean", "sum"};
  static constexpr std::array<Words, 4> renders{"spring", "damper", "both", "off"},
      resolves{"auto", "taylor", "pcg", "full"};
  /// A member of the settings of the feedback.
  template <auto setting, auto changed = &Self::settings_changed>
  static constexpr auto feedback =
      member<&Self::request_, &SessionRequest::settings, setting>.template then<changed>();
  static constexpr std::array parameters{
      feedback<&Feedback::mapping>.row("mode", modes,
                                       "quantity that gamma follows: mean stress, stress weighted "
                                       "by its sensitivity, or the latter for each axis"),
      feedback<&Feedback::weights, &Self::weights_changed>.row(
          "weights", weightings, "weights of the elements: equal, or by volume"),
      feedback<&Feedback::sensitivity>.row("sens", signs,
                                           "use of the sensitivities: signed values or magnitudes"),
      member<&Self::device_, &Device::feel>.row(
          "render", renders, "force that gamma sets: spring, damper, both or none"),
      feedback<&Feedback::state, &Self::state_changed>.row(
          "state", states, "stress measure: von Mises or maximum shear"),
      member<&Self::request_, &SessionRequest::resolve>.then<&Self::resolve_changed>().row(
          "resolve", resolves,
          "solver of a changed shape: cheapest method, Taylor series alone, conjugate gradients, "
          "or new factorisation"),
      feedback<&Feedback::norm>.row(
          "norm", norms,
          "norm over the elements: mean, or sum as in the paper's equations 1 and 2"),
      property<&Self::power, &Self::set_power>.row(
          "power", "", 1, 1, kMaxPower,
          "exponent q of `mode mean`: 1: the mean; above 1: (mean of s^q)^(1/q), which follows the "
          "largest stresses; rounded to an integer"),
      member<&Self::device_, &Device::drag>.row(
          "drag", "switch: 1 lets the handle move the grabbed control point"),
      member<&Self::device_, &Device::scale>.row("scale", "", 1e-3, 1000,
                                                 "ratio of control point motion to handle motion"),
      member<&Self::device_, &Device::nominal_n_per_m>.row("nominal", "N/m", 0, 100000,
                                                           "nominal stiffness of the device"),
      member<&Self::device_, &Device::share>.row("share", "", 0, 1,
                                                 "limit of kmin and kmax as a share of `nominal`"),
      member<&Self::device_, &Device::damping_n_s_per_m>.row("damping", "N s/m", 0, 1000,
                                                             "limit of bmin and bmax"),
  };
  static constexpr std::array messages{
      takes_file(action<&Self::load>("load", "name", 1, 1,
                                     "stress table, NAME or NAME.stress.npz, in the folder of the "
                                     "patch, search path or object's folder"))
          .with_name_behind("*"),
      action<&Self::set_control_point>("cp", "id x y z", 4, 4, "position of a control point, mm"),
      action<&Self::set_parameters>("list", "d ...", 1, 12288,
                                    "displacements of all parameters, mm, in the table's order"),
      action<&Self::grab>(
          "grab", "id [0|1]", 1, 2,
          "dragged control point, whose sensitivities are used as weights; 0 releases it"),
      action<&Self::release>(
          "release", "", 0, 0,
          "release the control point: weights become means over all control points"),
      action<&Self::reset>("reset", "", 0, 0, "reset the shape to the table's"),
      action<&Self::set_range>(
          "range", "current | initial | fixed a b", 1, 3,
          "range for gamma from 0 to 1: minimum and maximum of this shape, of the table's shape, "
          "or two numbers (Pa; Pa^2/m with `mode weighted` or `axis`)"),
      action<&Self::set_gains>("gains", "kmin kmax bmin bmax", 4, 4,
                               "stiffness (N/m) and damping (N s/m) at gamma 0 and 1"),
      action<&Self::set_anchor>("anchor", "here | x y z", 1, 3,
                                "anchor of the spring, where its force is zero, mm"),
      action<&Self::send_all>("bang", "", 0, 0, "send gamma, force and info"),
      action<&Self::send_points>(
          "points", "", 0, 0,
          "send workspace and control points to the protocol outlet, for haptic_server"),
      action<&Self::set_solver>("solver", "path | auto", 1, 1,
                                "path of the program part_stress, which restarts and solves the "
                                "part again; auto: in the object's folder or PATH"),
      action<&Self::draw>("draw", "[all]", 0, 1,
                          "send the picture to the info outlet: changed faces, or all faces"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kControl, "shape", "mm",
           "messages: `cp id x y z`, a list of parameters, all others"},
      Port{Port::Kind::kList, "device", "mm, m/s",
           "list x y z [vx vy vz]: position in mm and velocity in m/s of the handle"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "gamma", "",
           "normalised stress gamma, 0..1; three numbers with `mode axis`"},
      Port{Port::Kind::kControl, "force", "N", "list fx fy fz: force for [phantom]"},
      Port{Port::Kind::kControl, kInfoOutlet, "",
           "`gmin gmax raw err method iters ms` and more; answers"},
      Port{Port::Kind::kControl, "protocol", "",
           "messages `hap feedback sequence gamma` and `hap cp ...` for a haptic_server"},
  };
  static constexpr std::array arguments{CreationArgument{"load"}};
};

inline constexpr Declaration StressHaptic::declaration{
    "stress_haptic",
    "stress of a part, felt while you reshape the part",
    "Moves the control points of a part, recomputes the stress of every element from "
    "sensitivities, and renders one number, gamma, as a spring or a damper. The handle is stiffer "
    "where the stress is higher. Finite elements compute the part's stress table offline.",
    "stress design optimisation haptic finite elements sensitivity spring damper",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "phantom, haptic_server, beam.pd",
    "use: stress_haptic.md, the model: theory/stress_haptic.md, making a table: part_stress.md",
    "design/struck_beam.wav: a beam struck while it changes shape"};

} // namespace tactus::stress
