#pragma once

#include "core/haptic/chain/velocity.hpp"
#include "core/object.hpp"
#include "core/stress/linear_glide.hpp"
#include "core/stress/render.hpp"
#include "externals/stress_haptic/declaration.hpp"
#include "externals/stress_haptic/stress_worker.hpp"

#include <array>
#include <optional>
#include <string>

namespace tactus::stress {

inline constexpr double kMm_per_m = 1e3;

/// Text of a message as it was sent, "range fixed 2 1", for its error.
[[nodiscard]] std::string sentence_of(std::string_view message, std::span<const Atom> arguments);

/// [stress_haptic]: haptic feedback of a part's stress while the user reshapes it (core/stress,
/// docs/stress_haptic.md).
class StressHaptic {
public:
  static constexpr Declaration declaration{
      "stress_haptic",
      "the stress of a part, felt while it is reshaped",
      "Moves the control points of a part, recomputes the stress of every element by its "
      "sensitivities, and renders one number of it, gamma, as a spring or a damper: where the part "
      "is strained, the handle is stiff. The table of a part is made offline by finite elements.",
      "stress design optimisation haptic finite elements sensitivity spring damper",
      stress_haptic::kInlets,
      stress_haptic::kOutlets,
      stress_haptic::kParameters,
      stress_haptic::kMessages,
      stress_haptic::kArguments,
      "phantom, haptic_server, beam.pd",
      "the model: stress_haptic.md, making a table: part_stress.md",
      "design/struck_beam.wav: a beam struck while it changes shape"};
  static constexpr std::size_t timers = 1;

  explicit StressHaptic(StressWorker::SolverFactory solvers);
  StressHaptic(); ///< solves by part_stress
  void set(std::size_t parameter, double value) noexcept;
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return value_[parameter]; }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
  void scalar(std::size_t inlet, double value, Host& host);
  void list(std::size_t inlet, std::span<const Atom> atoms, Host& host);
  void tick(std::size_t timer, Host& host);
  void posted(Host& host) { collect(host); }
  void created(Host& host);
  void dump(Host& host);

private:
  static constexpr double kFade_s = 0.1; ///< of gamma at a swap, and of a moved anchor
  using Numbers = std::span<const double>;
  void load(const Atom& name, Host& host);
  void take_table(StressWorker::Loaded loaded, Host& host);
  void set_solver(const Atom& program, Host& host);
  void set_control_point(Numbers numbers, Host& host);
  void set_parameters(Numbers numbers, Host& host);
  void grab(Numbers numbers, Host& host);
  void release(Host& host);
  void set_range(std::span<const Atom> arguments, Host& host);
  void set_gains(Numbers numbers, Host& host);
  void set_anchor(std::span<const Atom> arguments, Host& host);
  void send_points(Host& host);
  void draw(std::span<const Atom> arguments, Host& host);
  void send_picture(Host& host);

  /// False after one error if no table is loaded.
  [[nodiscard]] bool has_table(std::string_view message, Host& host) const;
  /// The control point of this id, or none after one error.
  [[nodiscard]] std::optional<std::size_t> control_point(std::string_view message, double id,
                                                         Host& host) const;
  /// Displacements of a control point's parameters, within their bounds.
  void displace(std::size_t control_point, const haptic::Vec3& displacement_m) noexcept;
  [[nodiscard]] haptic::Vec3 displacement_of(std::size_t control_point) const noexcept;
  /// Reports settings that the table or the object does not support; the rest continues to work.
  void warn_if_inactive(std::size_t parameter, Host& host) const;
  void submit(Host& host);
  void collect(Host& host);
  void send(Host& host, bool all);
  void send_info(Host& host);
  void send_feedback(Host& host, const haptic::Vec3& gamma);
  void schedule(Host& host);
  [[nodiscard]] haptic::Vec3 force(double now_s) noexcept;
  [[nodiscard]] RenderGains gains_in_force() const noexcept;
  [[nodiscard]] double stiffness_limit() const noexcept {
    return value_[stress_haptic::kShare] * value_[stress_haptic::kNominal];
  }
  [[nodiscard]] bool is_axis() const noexcept { return value_[stress_haptic::kMode] >= 1.5; }

  std::array<double, stress_haptic::kParameterCount> value_{};
  Host* host_ = nullptr;   ///< outlives the object
  std::string first_name_; ///< creation argument; loaded after all flags are set
  std::uint64_t loads_ = 0;
  std::shared_ptr<const StressTable> table_;
  bool can_solve_ = false;
  SessionRequest request_;
  SessionResult result_;
  RenderGains gains_{0, 400, 0, 4};
  LinearGlide gamma_{}, anchor_{};
  bool anchored_ = false;     ///< else the first position becomes the anchor
  bool has_position_ = false; ///< the handle's position is known
  haptic::Vec3 position_m_{}, velocity_m_per_s_{};
  haptic::VelocityEstimator velocity_estimate_;
  haptic::Vec3 grab_position_m_{}, grab_displacement_m_{}; ///< at the grab
  // Last output, and its time.
  std::optional<haptic::Vec3> sent_gamma_, sent_force_n_, sent_feedback_;
  double feedback_ms_ = -1e9, info_ms_ = -1e9;
  std::uint64_t feedback_sequence_ = 0;
  bool info_due_ = false;
  std::uint64_t pictures_ = 0, sent_picture_ = 0; ///< requested, and sent
  bool draw_when_loaded_ = false;
  std::vector<PictureFace> sent_faces_; ///< empty: all must be sent
  StressWorker worker_;
};

} // namespace tactus::stress
