#pragma once

#include "core/dsp/random.hpp"
#include "core/modal/body/struck_body.hpp"
#include "core/object.hpp"
#include "externals/modal_impact~/declaration.hpp"
#include "externals/modal_impact~/mode_solver.hpp"
#include "externals/modal_impact~/table_worker.hpp"

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
  static constexpr Declaration declaration{
      "modal_impact~",
      "any solid body, struck anywhere and heard anywhere",
      "Plays a body whose modes modal_fem has computed. Strikes are contacts in which striker and "
      "body are coupled; material, size and damping can be changed while it sounds, forces from "
      "other objects push it, and the contact force comes out for a haptic device.",
      "physical model modal synthesis impact contact finite elements",
      modal_impact::kInlets,
      modal_impact::kOutlets,
      modal_impact::kParameters,
      modal_impact::kMessages,
      modal_impact::kArguments,
      "contact_impact~, struck_disk.pd, struck_beam.pd",
      "the model: modal_impact.md, making a body: modal_fem.md",
      "bodies/piece.wav: a piece for nine bodies"};
  enum Timer : std::size_t { kSettleTimer, kReplyTimer, kLoadedTimer };
  static constexpr std::size_t timers = 3;

  ModalImpact();
  void prepare(double sample_rate, std::size_t max_block);
  void set(std::size_t parameter, double value) noexcept;
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return value_[parameter]; }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
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
  using Numbers = std::span<const double>;
  static constexpr std::size_t kFewNumbers = 8; ///< of a message that allocates nothing
  static constexpr std::size_t kMaxWaiting = 64;
  /// A message to a body that is still being read, or changed.
  struct WaitingMessage {
    std::size_t index = 0, count = 0;
    std::uint64_t after = 0; ///< number of the request that must be answered first
    std::array<double, kFewNumbers> numbers{};
  };
  void begin_block(double start_ms) noexcept;
  /// The sample of a message that arrives now.
  [[nodiscard]] std::int64_t sample_now(const Host& host) const;
  void carry_out(std::size_t index, Numbers numbers, Host& host);
  /// Whether changes are computed where they are asked for.
  [[nodiscard]] bool at_once() const;
  /// Whether the message must wait for the first body, which is being read, or with `sync 2` for
  /// changes before it: it is then kept. A full queue refuses it in a sentence. Allocates nothing.
  [[nodiscard]] bool waits_for_body(std::size_t index, Numbers numbers, Host& host);
  void carry_out_waiting(Host& host);
  /// Full path of a table, by its name with or without .modal.npz; empty after an error.
  [[nodiscard]] static std::string find_table(std::string_view message, const std::string& name,
                                              Host& host);
  void load(std::span<const Atom> arguments, Host& host);
  void load(const std::string& name, bool at_once, Host& host);
  void hit(Numbers numbers, Host& host);
  void drop(Numbers numbers, Host& host);
  void repeat_last(Host& host);
  void hit_vertex(Numbers numbers, Host& host);
  void hit_face(Numbers numbers, Host& host);
  void strike(const SurfacePoint& point, double speed, Host& host, bool falls = false);
  /// What a strike is meant to be, as `variation` lets it be.
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
  void choose_damping(std::span<const Atom> arguments, Host& host);
  void set_damping(std::size_t index, Numbers numbers, Host& host);
  void post_info(Host& host);
  void post_loaded(Host& host);
  void post_ring(Host& host);
  /// The settings by message, each as the message that sets it.
  void post_settings(Host& host) const;
  void post_damping(Host& host) const;
  void post_shape(Host& host) const;
  /// The body's shape parameters; null after an error if it has none.
  const design::ShapeParameters* shape_parameters(std::string_view message, Host& host);
  /// Present displacements of all shape parameters, m.
  [[nodiscard]] std::vector<double> shape_displacement_m(const design::ShapeParameters&) const;
  void deform(std::vector<double> displacement_m, const design::ShapeParameters&, Host& host);
  // Solving changed shapes: resolve.cpp.
  [[nodiscard]] bool needs_solve() const;
  /// Displacements of the control points from the shape that was solved, m.
  [[nodiscard]] std::vector<Vec3>
  control_point_offsets_m(const std::vector<double>& displacement_m) const;
  /// The largest of them over the table's trust distance.
  [[nodiscard]] double trust_ratio() const;
  [[nodiscard]] bool still_since_wait() const;
  void start_settle_timer(double ms, Host& host); ///< below 0: stop
  void shape_moved(bool beyond_trust, Host& host);
  void start_solve(Host& host);
  void accept_solution(ModeSolver::Result result, Host& host);
  void resolved(Host& host);
  void reset_solver(Host* host);
  void set_solver(const Atom& program, Host& host);

  /// The present body; null after an error if there is none.
  const BodyModel* body(Host& host);
  [[nodiscard]] SurfacePoint at_vertex(std::size_t vertex) const noexcept;
  void warn_if_far(const SurfacePoint& point, Host& host);
  /// If the table has no motion along a direction (a plate's in its plane). Allocates nothing.
  void warn_if_still(std::string_view message, const SurfacePoint& point, const Vec3& direction,
                     Host& host);
  [[nodiscard]] BodySettings settings() const;
  void update_options() noexcept;
  /// Builds a model of the present settings: at once if that is quick or `sync` is set, else in the
  /// worker's thread.
  /// changes_body: strikes may have to wait for it (`sync 2`).
  void rebuild_model(bool changes_body = true);
  /// Takes other settings, and builds their model.
  template <class T> void change(T& setting, const T& value, bool changes_body = true) {
    if (setting == value)
      return;
    setting = value;
    rebuild_model(changes_body);
  }
  void accept(TableWorker::Result result, Host* host);
  /// Executes a request at once, or in the worker's thread.
  void execute(const TableWorker::Request& request, const std::string& subject, bool at_once,
               Host& host);
  /// False if the body cannot rest on its points: the last valid ones are restored.
  bool accept_support(const BodyModel& model, bool same_table, Host* host);

  std::array<double, modal_impact::kParameters.size()> value_{};
  BodySettings settings_;
  BodySettings last_valid_; ///< the last valid `rest`
  StruckBody body_;
  std::shared_ptr<const LoadedTable> table_;
  Host* host_ = nullptr; ///< lives as long as the object; for the worker's callback
  bool created_ = false;
  bool has_cords_ = false; // the box has been made, and with it its cords
  std::string first_name_; ///< a creation argument: read when all flags are known
  std::string_view preset_ = "table";
  std::array<WaitingMessage, kMaxWaiting> waiting_;
  std::size_t waiting_count_ = 0;
  /// Numbers of the worker's requests: the last that was answered, and the last that changes the
  /// body, not only where it is heard.
  std::uint64_t answered_ = 0, body_change_ = 0;
  Random random_; // of variation
  std::optional<Vec3> normal_;
  std::optional<SurfacePoint> last_point_;
  double last_speed_ = 1;
  bool last_was_drop_ = false;
  bool warned_ = false, warned_still_ = false;
  bool warned_of_trust_ = false;
  double sample_rate_ = 48000;
  std::string table_path_;     ///< of the body
  std::string board_name_;     ///< as the user wrote it
  std::string solver_program_; ///< empty: searched for
  std::uint64_t load_number_ =
      0; ///< counts bodies and solvers; answers to earlier ones are dropped
  std::uint64_t solve_count_ = 0;
  double solve_s_ = 0; ///< the last one's duration
  bool solving_ = false, solver_unavailable_ = false, solve_failed_ = false;
  std::optional<std::vector<double>> settle_displacement_m_; ///< at the start of the settle timer
  std::optional<ModeSolver::Request>
      solver_request_; ///< in a render: answered at a set logical time
  ModeSolver solver_;
  TableWorker worker_;
};

} // namespace tactus::modal
