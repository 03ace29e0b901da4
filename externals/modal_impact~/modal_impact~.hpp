#pragma once

#include "core/dsp/random.hpp"
#include "core/modal/body/struck_body.hpp"
#include "core/rows.hpp"
#include "externals/modal_impact~/mode_solver.hpp"
#include "externals/modal_impact~/table_worker.hpp"
#include "externals/modal_impact~/units.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::modal {

/// [modal_impact~]: strikes, presses and rubs a body from a modal table, and outputs its sound at
/// up to four listeners. A shell around StruckBody: it parses messages, and reads tables and builds
/// models in threads. See docs/modal_impact.md.
class ModalImpact {
public:
  static const Declaration declaration;
  enum Timer : std::size_t { kSettleTimer, kReplyTimer, kLoadedTimer };
  static constexpr std::size_t timers = 3;

  ModalImpact();
  void prepare(double sample_rate, std::size_t max_block);
  void posted(Host& host);
  void tick(std::size_t timer, Host& host);
  void created(Host& host);
  void dump_first(Host& host) { host.info({"preset", preset_}); }
  void dump(Host& host);

  template <class S> void process(const Block<S>& block) noexcept {
    const std::array<std::span<S>, kMaxListeners> out{block.out(0), block.out(1), block.out(3),
                                                      block.out(4)};
    begin_block(block.start_ms);
    body_.process<S>(block.in(0), block.in(1), out, block.out(2),
                     {block.in(2), block.in(3), block.out(5)});
  }

private:
  struct Rows;
  using Numbers = std::span<const double>;
  enum class Limit { kAuto, kOn, kOff };
  enum class Sync { kBackground, kAtOnce, kInOrder };
  enum class Resolve { kAuto, kOff };
  /// The event that a message waits for. kForBody: the first body, while it is read. kAsStrike and
  /// kAsInfo: with `sync 2` also the changes requested before the message.
  enum class Waits { kNever, kForBody, kAsStrike, kAsInfo };
  static constexpr std::size_t kFewNumbers = 8; ///< maximum in a message that allocates nothing
  static constexpr std::size_t kMaxWaiting = 64;
  /// A message to a body that is still being read, or changed.
  struct WaitingMessage {
    void (ModalImpact::*carry_out)(Numbers, Host&) = nullptr;
    bool strikes = false;
    std::size_t count = 0;
    std::uint64_t after = 0; ///< number of the request that must be answered first
    std::array<double, kFewNumbers> numbers{};
  };
  void begin_block(double start_ms) noexcept;
  /// The sample of a message that arrives now.
  [[nodiscard]] std::int64_t sample_now(const Host& host) const;
  /// A message of numbers: runs at once, or when the event that it waits for has occurred.
  template <auto handler, Waits waits = Waits::kNever>
  void numeric(const Message& row, std::span<const Atom> arguments, Host& host) {
    carry_out(row, arguments, handler, waits, host);
  }
  void carry_out(const Message& row, std::span<const Atom> arguments,
                 void (ModalImpact::*handler)(Numbers, Host&), Waits waits, Host& host);
  /// Whether changes are computed in the calling thread.
  [[nodiscard]] bool at_once() const;
  /// Whether the message must wait (see Waits); it is then stored. If the queue is full it is
  /// refused with an error. Allocates nothing.
  [[nodiscard]] bool must_wait(const Message& row, Numbers numbers,
                               void (ModalImpact::*handler)(Numbers, Host&), Waits waits,
                               Host& host);
  void carry_out_waiting(Host& host);
  /// Full path of a table, by its name with or without .modal.npz; empty after an error.
  [[nodiscard]] static std::string find_table(std::string_view message, const std::string& name,
                                              Host& host);
  void load_named(std::span<const Atom> arguments, Host& host);
  void load(const std::string& name, bool at_once, Host& host);
  void hit(Numbers numbers, Host& host);
  void drop(Numbers numbers, Host& host);
  void repeat_last(Numbers, Host& host);
  void hit_vertex(Numbers numbers, Host& host);
  void hit_face(Numbers numbers, Host& host);
  void strike(const SurfacePoint& point, double speed, Host& host, bool falls = false);
  /// A strike with the random scatter of `variation`.
  [[nodiscard]] Hit varied(Hit hit) noexcept;
  void set_normal(Numbers numbers, Host& host);
  void set_striker(Numbers numbers, Host& host);
  void set_hardness(Numbers numbers, Host& host);
  void set_point(Numbers numbers, Host& host);
  void set_rub(Numbers numbers, Host& host);
  void set_friction(Numbers numbers, Host& host);
  void set_board(std::span<const Atom> arguments, Host& host);
  void set_rest(Numbers numbers, Host& host);
  void set_listener(Numbers numbers, Host& host);
  void set_material(Numbers numbers, Host& host);
  void set_preset(const Atom& name, Host& host);
  void set_shape(Numbers numbers, Host& host);
  void set_control_point(Numbers numbers, Host& host);
  void choose_damping(const Message& row, std::span<const Atom> arguments, Host& host);
  void set_rayleigh(Numbers numbers, Host& host);
  void set_loss(Numbers numbers, Host& host);
  void set_loss_curve(Numbers numbers, Host& host);
  void reset(Numbers, Host& host);
  void post_info_now(Numbers, Host& host) {
    body_.adopt();
    post_info(host);
  }
  void post_info(Host& host);
  void post_loaded(Host& host);
  void post_ring(Numbers, Host& host);
  /// Sends the settings that are messages, each as the message that sets it.
  void post_settings(Host& host) const;
  void post_damping(Host& host) const;
  void post_shape(Host& host) const;
  /// The body's shape parameters; null after an error if it has none.
  const design::ShapeParameters* shape_parameters(std::string_view message, Host& host);
  /// Present displacements of all shape parameters, m.
  [[nodiscard]] std::vector<double> shape_displacement_m(const design::ShapeParameters&) const;
  void deform(std::vector<double> displacement_m, const design::ShapeParameters&, Host& host);
  // Solving changed shapes, defined in resolve.cpp.
  [[nodiscard]] bool needs_solve() const;
  /// Displacements of the control points from the shape that was solved, m.
  [[nodiscard]] std::vector<Vec3>
  control_point_offsets_m(const std::vector<double>& displacement_m) const;
  /// The largest of these displacements, divided by the table's trust distance.
  [[nodiscard]] double trust_ratio() const;
  [[nodiscard]] bool still_since_wait() const;
  void start_settle_timer(double ms, Host& host); ///< below 0, stops the timer
  void shape_moved(bool beyond_trust, Host& host);
  void start_solve(Host& host);
  void take_solution(Host& host);
  void accept_solution(ModeJob::Answer result, Host& host);
  void resolved(Host& host);
  void reset_solver(Host* host);
  void set_solver(const Atom& program, Host& host);

  /// The present body; null after an error if there is none.
  const BodyModel* body(Host& host);
  [[nodiscard]] SurfacePoint at_vertex(std::size_t vertex) const noexcept;
  void warn_if_far(const SurfacePoint& point, Host& host);
  /// Warns if the table has no motion along a direction, such as a plate's in its plane. Allocates
  /// nothing.
  void warn_if_still(std::string_view message, const SurfacePoint& point, const Vec3& direction,
                     Host& host);
  [[nodiscard]] BodySettings settings() const;
  void update_options() noexcept;
  [[nodiscard]] Radiation radiation() const noexcept { return settings_.radiation; }
  void set_radiation(Radiation wanted);
  [[nodiscard]] bool pulses() const noexcept { return !options_.coupled; }
  void set_pulses(bool on) noexcept;
  [[nodiscard]] unsigned seed() const noexcept { return static_cast<unsigned>(options_.seed); }
  void set_seed(unsigned value) noexcept;
  void model_changed() { rebuild_model(); }
  void resolve_changed() {
    if (host_ && table_)
      shape_moved(false, *host_);
  }
  /// Builds a model of the present settings: at once if that is quick or `sync` is set, else in the
  /// worker's thread.
  /// changes_body: strikes may have to wait for it (`sync 2`).
  void rebuild_model(bool changes_body = true);
  void build_here(const BodySettings& now);
  /// Changes a setting and rebuilds the model.
  template <class T> void change(T& setting, const T& value, bool changes_body = true) {
    if (setting == value)
      return;
    setting = value;
    rebuild_model(changes_body);
  }
  /// Sends the current request, to be carried out at once or in the worker's thread.
  void request(bool at_once, Host& host);
  void take_tables(Host* host);
  void accept(TableJob::Answer answer, Host* host);
  /// Whether the first body is being read.
  [[nodiscard]] bool loads_first() const noexcept { return !table_ && answered_ < load_; }
  /// If the body cannot rest on its points, restores the last valid points and returns false. The
  /// caller must then build a model with these points.
  bool accept_support(const BodyModel& model, bool same_table, Host* host);

  BodySettings settings_;
  StruckBody::Options options_;
  Limit limit_ = Limit::kAuto;
  Sync sync_ = Sync::kBackground;
  Resolve resolve_ = Resolve::kAuto;
  double restitution_ = 1, variation_ = 0;
  double max_modes_ = 0, voices_ = 8, listeners_ = 2; ///< as given; the fraction is ignored
  BodySettings last_valid_;                           ///< the last valid `rest`
  StruckBody body_;
  std::shared_ptr<const LoadedTable> table_;
  TablesInUse in_use_;       ///< the files of table_
  TableJob::Request wanted_; ///< the requested files and settings
  Host* host_ = nullptr;     ///< lives as long as the object; for the worker's callback
  bool created_ = false;
  bool has_cords_ = false; // the box and its connections exist
  std::string first_name_; ///< a creation argument; its table is read once all flags are known
  std::string_view preset_ = "table";
  std::array<WaitingMessage, kMaxWaiting> waiting_;
  std::size_t waiting_count_ = 0;
  /// Numbers of three of the worker's requests: the last answered one, the last one that changes
  /// the body and not only its listeners, and the last one that reads a body.
  std::uint64_t answered_ = 0, body_change_ = 0, load_ = 0;
  /// Number of the last request with settings that the present model lacks; 0 if it lacks none.
  std::uint64_t model_request_ = 0;
  Random random_; // for variation
  std::optional<Vec3> normal_;
  std::optional<SurfacePoint> last_point_;
  double last_speed_ = 1;
  bool last_was_drop_ = false;
  bool warned_ = false, warned_still_ = false;
  bool warned_of_trust_ = false;
  double sample_rate_ = 48000;
  std::string solver_program_; ///< if empty, searched for
  std::uint64_t load_number_ =
      0; ///< counts bodies and solvers; answers to earlier ones are dropped
  std::uint64_t solve_count_ = 0;
  double solve_s_ = 0; ///< duration of the last solution
  bool solving_ = false, solver_unavailable_ = false, solve_failed_ = false;
  std::optional<std::vector<double>> settle_displacement_m_; ///< when the settle timer started
  /// In a render the request is answered after a fixed logical time.
  std::optional<ModeJob::Request> solver_request_;
  ModeSolver solver_;
  TableWorker worker_;
};

struct ModalImpact::Rows {
  using Self = ModalImpact;
  using Options = StruckBody::Options;
  using Words = std::string_view;
  static constexpr std::array<Words, 2> contacts{"coupled", "pulse"}, resolves{"auto", "off"};
  static constexpr std::array<Words, 3> limits{"auto", "on", "off"};
  /// Settings of the model; a change rebuilds it.
  template <auto... path>
  static constexpr auto
      model = member<&Self::settings_, path...>.template then<&Self::model_changed>();
  /// Settings of the layer between body and board.
  template <auto... path>
  static constexpr auto layer = model<&BodySettings::rest, &RestSettings::law, path...>;
  template <auto option>
  static constexpr auto
      options = member<&Self::options_, option>.template then<&Self::update_options>();
  using Law = contact::ImpactLaw;
  static constexpr std::array parameters{
      not_realtime(property<&Self::radiation, &Self::set_radiation>.row(
          "radiation", modal_impact::kRadiations,
          "model of radiation: baffled surface by mode (low modes of thin bodies too loud, a bar's "
          "first by 18 dB), surface velocities of the table, free body by multipoles, or surface "
          "velocity alone",
          0)),
      property<&Self::pulses, &Self::set_pulses>.row("contact", contacts,
                                                     "model of contact: coupled striker and body, "
                                                     "or half-sine pulses for many strikes at once",
                                                     0),
      not_realtime(model<&BodySettings::size>.row("size", "", 1, 0.01, 100,
                                                  "factor on the table's lengths")),
      not_realtime(member<&Self::max_modes_>.then<&Self::model_changed>().row(
          "modes", "", 0, 0, 20000,
          "maximum number of modes; the last group of nearly equal frequencies stays complete; 0: "
          "all")),
      options<&Options::cull_db>.row(
          "cull", "dB", 20, 200,
          "level below a strike's loudest mode (A-weighted) beyond which modes are omitted"),
      not_realtime(model<&BodySettings::choke_t60_s>.row(
          "choke", "s", 0, 0, 100, "decay time T60 of a hand that damps the body; 0: none")),
      options<&Options::gain>.row(
          "gain", "1/Pa", 0, 1000,
          "output for 1 Pa of sound pressure; at 0.01, 100 Pa reach full scale"),
      member<&Self::limit_>.then<&Self::update_options>().row(
          "limit", limits,
          "soft clip of the sound, within +-1 and linear up to 0.5; auto: on for gains below 0.1, "
          "off above, for measurements",
          0),
      member<&Self::restitution_>.then<&Self::update_options>().row(
          "restitution", "", 1, 0.01, 1,
          "coefficient of restitution on a rigid wall; below 1 it sets the contact loss"),
      options<&Options::spring_n_per_m>.row("spring", "N/m", 0, 100000,
                                            "stiffness of a spring, with `pos 1`: its force "
                                            "replaces the contact force at the outlet; 0: none"),
      options<&Options::driven>.row(
          "pos", "switch: 1 reads inlet 2 as the height of a striker that a hand moves"),
      options<&Options::doppler>.row("doppler",
                                     "switch: 1 adds the Doppler shift of a moving listener"),
      not_realtime(member<&Self::voices_>.then<&Self::model_changed>().row(
          "voices", "", 8, 1, 64,
          "maximum number of contacts at once; one more strike ends the oldest")),
      not_realtime(member<&Self::listeners_>.then<&Self::model_changed>().row(
          "out", "", 2, 1, 4,
          "number of listeners; 1: same sound left and right at half the cost")),
      member<&Self::sync_>.row(
          "sync", "", 0, 0, 2,
          "computation of tables and changes: 0: in the background; 1: at once, as in every "
          "render; 2: in the background, while later strikes and `info` wait"),
      not_realtime(layer<&Law::stiffness>.row("rest_stiffness", "N/m^a", 4e8, 100, 1e13,
                                              "stiffness k of the layer between body and board at "
                                              "each point, F = k d^a; initially that of felt")),
      not_realtime(layer<&Law::exponent>.row(
          "rest_exponent", "", 2.3, 1, 5,
          "exponent a of the layer: 1: spring, 1.5: hard and round, 2.3: felt")),
      not_realtime(layer<&Law::dissipation_s_per_m>.row(
          "rest_loss", "s/m", 2, 0, 100, "loss of the layer: F = k d^a (1 + loss v)")),
      not_realtime(model<&BodySettings::rest, &RestSettings::pressing_n>.row(
          "rest_force", "N", 0, 0, 1000,
          "force that adds to the weight and presses the body on the board, over all points")),
      not_realtime(member<&Self::resolve_>.then<&Self::resolve_changed>().row(
          "resolve", resolves,
          "modes of a changed shape: solved again in the background, or only extrapolated", 0)),
      member<&Self::variation_>.row(
          "variation", "", 0, 0, 1,
          "scatter of the strikes' speed, point and direction: 0: none, 1: as by a hand"),
      property<&Self::seed, &Self::set_seed>.seed<"seed of the variation and of a rub's roughness">(),
  };
  static constexpr std::array messages{
      takes_file(action<&Self::load_named>(
                     "load", "name [-sync]", 1, 2,
                     "modal table, NAME or NAME.modal.npz, in the folder of the patch, the search "
                     "path or the object's folder (bar bell board bowl glass plate tube ...); the "
                     "old body sounds until the table is read"))
          .with_name_behind("*"),
      realtime(action<&Self::numeric<&Self::hit, Waits::kAsStrike>>(
          "hit", "[x y z] v", 1, 4,
          "strike at x y z mm with v m/s; without position: at the last one")),
      realtime(action<&Self::numeric<&Self::hit_vertex, Waits::kAsStrike>>(
          "hitv", "vertex v", 2, 2, "strike at a vertex of the table")),
      realtime(action<&Self::numeric<&Self::hit_face, Waits::kAsStrike>>(
          "hitf", "face u v speed", 4, 4,
          "strike on a triangle, with u and v the weights of its corners 2 and 3")),
      realtime(action<&Self::numeric<&Self::drop, Waits::kAsStrike>>(
          "drop", "[x y z] h", 1, 4,
          "drop the striker from h mm onto x y z mm; it bounces until it rests")),
      realtime(action<&Self::numeric<&Self::repeat_last, Waits::kAsStrike>>(
          "bang", "", 0, 0, "repeat the last strike")),
      action<&Self::numeric<&Self::set_normal>>(
          "normal", "[x y z]", 0, 3,
          "direction out of the body, opposite to the strike; none: the surface normal"),
      action<&Self::numeric<&Self::set_striker>>("striker", "mass radius E nu", 4, 4,
                                                 "striking ball: kg, m, Pa (Hertz contact)"),
      action<&Self::numeric<&Self::set_hardness>>(
          "hardness", "k exponent loss", 1, 3,
          "contact law k d^exponent (1 + loss v) in place of Hertz; 0: Hertz"),
      action<&Self::numeric<&Self::set_point, Waits::kForBody>>(
          "point", "x y z or vertex", 1, 3, "contact point of inlets 1 and 2, mm"),
      action<&Self::numeric<&Self::set_rub, Waits::kForBody>>(
          "rub", "[x y z [dx dy dz]]", 0, 6,
          "contact point of inlets 3 and 4, mm, and direction of positive velocity; without "
          "numbers: as `point`"),
      action<&Self::numeric<&Self::set_friction>>(
          "friction", "static dynamic stribeck breakaway stiffness damping viscosity roughness", 1,
          8, "friction law of contact_friction~, whose defaults replace missing numbers"),
      action<&Self::set_board>("board", "name [dx dy dz] or none", 1, 4,
                               "modal table of a board on which the body lies: a supported body, "
                               "displaced by dx dy dz mm in the body's axes")
          .with_name_behind("*"),
      action<&Self::numeric<&Self::set_rest>>("rest", "[x y z] ...", 0, 24,
                                              "points where body and board touch, up to 8, mm in "
                                              "the body's axes; without numbers: none"),
      action<&Self::numeric<&Self::set_listener>>(
          "listener", "i x y z or x1 y1 z1 ...", 3, 12,
          "position of listener i (1 to 4), or of all from 1 on, mm; below 18 cm the sound is up "
          "to 0.5 ms late"),
      action<&Self::numeric<&Self::set_material>>(
          "material", "E rho", 2, 2,
          "Young's modulus in Pa and density in kg/m^3; 0: as in the table"),
      action<&Self::set_preset>(
          "preset",
          "aluminium|steel|iron|brass|bronze|copper|lead|glass|ceramic|wood|plastic|"
          "polycarbonate|rubber|table",
          1, 1, "elasticity, density and damping of a material; table: as in the table"),
      action<&Self::numeric<&Self::set_shape, Waits::kForBody>>(
          "shape", "d1 d2 ...", 1, 3 * 4096,
          "displacements of the table's shape parameters, mm, in their order; 0: original shape"),
      action<&Self::numeric<&Self::set_control_point, Waits::kForBody>>(
          "cp", "id x y z", 4, 4, "position of a control point of the body's shape, mm"),
      action<&Self::set_solver>("solver", "path | auto", 1, 1,
                                "path of the program modal_fem, which solves changed shapes and is "
                                "restarted; auto: in the object's folder or PATH"),
      action<&Self::numeric<&Self::set_rayleigh>>("rayleigh", "a b", 2, 2,
                                                  "damping (a + b omega^2)/2 in 1/s"),
      action<&Self::numeric<&Self::set_loss>>("loss", "eta", 1, 1,
                                              "loss factor at all frequencies"),
      action<&Self::numeric<&Self::set_loss_curve>>("losscurve", "f1 eta1 f2 eta2 ...", 2, 64,
                                                    "loss factor over frequency in Hz"),
      action<&Self::choose_damping>(
          "damping", "table | rayleigh a b | loss eta | losscurve f1 eta1 ...", 1, 65,
          "law of damping: the table's, or that of the named message, as `dump` reports it"),
      realtime(action<&Self::numeric<&Self::reset>>("reset", "", 0, 0, "stop: silence")),
      action<&Self::numeric<&Self::post_info_now, Waits::kAsInfo>>(
          "info", "", 0, 0, "send body, counts, frequencies and decay times to the info outlet"),
      action<&Self::numeric<&Self::post_ring>>(
          "ring", "", 0, 0,
          "send the levels of the modes, dB re full scale, by frequency, to the info outlet"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "force", "N", "external force into the body at `point`"},
      Port{Port::Kind::kSignal, "height", "m",
           "height of a hand's striker above `point`, with `pos 1`"},
      Port{Port::Kind::kSignal, "normal", "N", "normal force of a rubbing surface; 0: no contact"},
      Port{Port::Kind::kSignal, "velocity", "m/s",
           "velocity of the rubbing surface along its direction"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "left", "", "sound pressure at listener 1 times `gain`"},
      Port{Port::Kind::kSignal, "right", "", "sound pressure at listener 2 times `gain`"},
      Port{Port::Kind::kSignal, "contact", "N",
           "contact force between strikers and body, with exact impulses"},
      Port{Port::Kind::kControl, kInfoOutlet, "", "answers to `info`, `ring`, `get` and `dump`"},
      Port{Port::Kind::kSignal, "third", "",
           "sound pressure at listener 3 times `gain`, with `-out 3` or more"},
      Port{Port::Kind::kSignal, "fourth", "",
           "sound pressure at listener 4 times `gain`, with `-out 4`"},
      Port{Port::Kind::kSignal, "friction", "N", "friction force along the body's surface"},
  };

  static constexpr std::array arguments{CreationArgument{"load"}};
};

inline constexpr Declaration ModalImpact::declaration{
    "modal_impact~",
    "any solid body, struck and heard at any point",
    "Plays a body whose modes modal_fem has computed. Striker and body are coupled at the contact. "
    "Material, size and damping can change while the body sounds. Forces from other objects can "
    "act on it, and an outlet gives the contact force for a haptic device.",
    "physical model modal synthesis impact contact finite elements",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "contact_impact~, struck_disk.pd, struck_beam.pd",
    "use: modal_impact.md, the model: theory/modal_impact.md, making a body: modal_fem.md",
    "bodies/piece.wav: a piece for nine bodies"};

} // namespace tactus::modal
