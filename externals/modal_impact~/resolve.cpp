#include "core/declaration_text.hpp"
#include "externals/modal_impact~/modal_impact~.hpp"

#include <algorithm>
#include <string>
#include <utility>

/// ModalImpact: solving the modes of a changed shape with modal_fem, in the background.
namespace tactus::modal {

using namespace modal_impact;

namespace {

constexpr double kSettleTime_ms = 150; // time without a move, as in [stress_haptic]
constexpr double kBatchReply_ms = 10;  // a render's logical time from request to answer
// Fraction of the trust distance below which the shape counts as unmoved. The tremor of a hand at
// rest is smaller. Below this fraction the derivatives, whose error is quadratic, are accurate to
// about 1e-6.
constexpr double kMovedRatio = 0.01;

double max_norm(const std::vector<Vec3>& offsets) {
  double maximum = 0;
  for (const Vec3& offset : offsets)
    maximum = std::max(maximum, norm(offset));
  return maximum;
}

} // namespace

bool ModalImpact::needs_solve() const {
  if (!table_ || !table_->body().table.has_mesh || resolve_ == Resolve::kOff)
    return false;
  return trust_ratio() > kMovedRatio;
}

std::vector<Vec3>
ModalImpact::control_point_offsets_m(const std::vector<double>& displacement_m) const {
  const ShapeSensitivity& sensitivity = table_->table.sensitivity;
  std::vector<Vec3> moved(sensitivity.shape.control_point_m.size());
  for (std::size_t p = 0; p < sensitivity.parameters(); ++p) {
    const design::DesignParameter& at = sensitivity.shape.parameters[p];
    moved[at.control_point][at.axis] =
        (p < displacement_m.size() ? displacement_m[p] : 0) - sensitivity.solved_at(p);
  }
  return moved;
}

double ModalImpact::trust_ratio() const {
  return max_norm(control_point_offsets_m(settings_.shape_displacement_m)) /
         table_->table.sensitivity.shape.trust_m;
}

/// True if the shape has not moved, apart from tremor, since the settle timer was started.
bool ModalImpact::still_since_wait() const {
  if (!settle_displacement_m_)
    return false;
  std::vector<Vec3> offset = control_point_offsets_m(settings_.shape_displacement_m);
  const std::vector<Vec3> then = control_point_offsets_m(*settle_displacement_m_);
  for (std::size_t c = 0; c < offset.size(); ++c)
    offset[c] = offset[c] - then[c];
  return max_norm(offset) <= kMovedRatio * table_->table.sensitivity.shape.trust_m;
}

void ModalImpact::start_settle_timer(double ms, Host& host) {
  settle_displacement_m_.reset();
  if (ms >= 0)
    settle_displacement_m_ = settings_.shape_displacement_m;
  host.wake_in(kSettleTimer, ms);
}

void ModalImpact::shape_moved(bool beyond_trust, Host& host) {
  solve_failed_ = false;
  if (solver_unavailable_ || !needs_solve())
    return start_settle_timer(-1, host);
  if (beyond_trust && !solving_)
    start_solve(host);
  else if (!still_since_wait())
    start_settle_timer(kSettleTime_ms, host);
}

void ModalImpact::start_solve(Host& host) {
  start_settle_timer(-1, host);
  if (solving_ || solve_failed_ || solver_unavailable_ || !needs_solve())
    return;
  std::vector<double> displacement = settings_.shape_displacement_m;
  displacement.resize(table_->table.sensitivity.parameters());
  ModeJob::Request request{load_number_, in_use_.body.path, solver_program_,
                           table_->parts.empty() ? table_ : table_->parts[0].loaded,
                           std::move(displacement)};
  solving_ = true;
  if (!host.real_time()) { // the answer arrives at the same logical time in every render
    solver_request_ = std::move(request);
    return host.wake_in(kReplyTimer, kBatchReply_ms);
  }
  solver_.on_ready([waiting = &host] { waiting->wake_from_thread(); });
  if (const std::string refusal = solver_.request(request); !refusal.empty()) {
    solving_ = false;
    solver_unavailable_ = true;
    host.error("resolve: cannot start a thread for the solver (" + refusal +
               "); frequencies are extrapolated until 'load' or 'solver'");
  }
}

void ModalImpact::tick(std::size_t timer, Host& host) {
  host_ = &host;
  if (timer == kSettleTimer)
    return start_solve(host);
  if (timer == kLoadedTimer)
    return post_loaded(host);
  if (auto request = std::exchange(solver_request_, std::nullopt)) {
    solver_.request_here(*request);
    solver_.finish();
    take_solution(host);
  }
}

void ModalImpact::take_solution(Host& host) {
  auto taken = solver_.take();
  for (const std::string& sentence : taken.sentences)
    host.error(sentence);
  if (taken.answer)
    accept_solution(std::move(*taken.answer), host);
}

void ModalImpact::accept_solution(ModeJob::Answer result, Host& host) {
  if (result.number != load_number_)
    return;
  solving_ = false;
  if (result.lost) {
    solver_unavailable_ = true;
    return host.error("resolve: " + result.refusal +
                      "; frequencies are extrapolated until 'load' or 'solver'");
  }
  if (!result.refusal.empty()) {
    solve_failed_ = true; // until the shape moves
    return host.error("resolve: " + result.refusal + "; frequencies are extrapolated");
  }
  if (resolve_ == Resolve::kOff)
    return;
  if (result.before.get() != &table_->body()) // another solution arrived first
    return start_settle_timer(0, host);
  if (result.fraction < 1) {
    solve_failed_ = true;
    host.error("resolve: elements would be inverted at this shape: the modes are solved "
               "at " +
               number_text(100 * result.fraction) + " % of the move, and extrapolated from there");
  }
  solve_s_ = result.seconds;
  wanted_.solved = std::move(result.table);
  wanted_.solved_body = in_use_.body.number;
  wanted_.solved_number = ++solve_count_;
  request(at_once(), host);
  body_change_ = worker_.requested();
}

/// Called when a solved table has taken effect.
void ModalImpact::resolved(Host& host) {
  if (last_point_)
    last_point_ =
        table_->surface.on(last_point_->triangle, last_point_->weight[1], last_point_->weight[2]);
  warned_of_trust_ = false;
  host.info({"resolved", static_cast<double>(solve_count_), solve_s_});
  if (needs_solve() && !solve_failed_)
    shape_moved(trust_ratio() > 1 + 1e-9, host);
}

void ModalImpact::reset_solver(Host* host) {
  ModeJob::Request none;
  none.number = ++load_number_;
  if (!solver_.is_here()) {
    static_cast<void>(solver_.request(none)); // cannot fail: the thread exists
  } else {
    solver_.request_here(none);
    solver_.finish();
  }
  solver_request_.reset();
  settle_displacement_m_.reset();
  solving_ = solver_unavailable_ = solve_failed_ = false;
  if (!host)
    return;
  host->wake_in(kSettleTimer, -1);
  host->wake_in(kReplyTimer, -1);
}

void ModalImpact::set_solver(const Atom& program, Host& host) {
  if (!program.is_word)
    return host.error("solver: expected the path of modal_fem, or auto");
  std::string path;
  if (program.word != "auto") {
    path = host.find_file(program.word);
    if (path.empty() || find_modal_fem(path).empty())
      return host.error("solver " + std::string(program.word) +
                        ": no executable file found beside the patch or in the search path: "
                        "expected the path of modal_fem");
  }
  solver_program_ = std::move(path);
  reset_solver(&host);
  if (needs_solve())
    start_settle_timer(0, host);
}

} // namespace tactus::modal
