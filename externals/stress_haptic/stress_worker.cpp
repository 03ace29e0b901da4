#include "externals/stress_haptic/stress_worker.hpp"

#include "files/file_bytes.hpp"
#include "files/tables.hpp"

#include <chrono>
#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace tactus::stress {

std::unique_ptr<Reanalysis> StressJob::solver_for(const StressTable& table,
                                                  const Request& request) const {
  return solvers_ ? solvers_({table, path_, request.program, request.wait}) : nullptr;
}

void StressJob::load(const Request& request, Turn<Answer>& turn) {
  std::string refusal;
  try {
    std::vector<std::byte> bytes;
    StressTable read;
    refusal = files::read_file(request.path, bytes);
    if (refusal.empty())
      refusal = files::read_stress_table(bytes, read);
    if (refusal.empty()) {
      auto table = std::make_shared<const StressTable>(std::move(read));
      path_ = request.path;
      session_ = std::make_unique<StressSession>(table, solver_for(*table, request));
      answer_ = {std::move(table), request.load, session_->can_solve(), {}};
      return turn.hand_over(answer_);
    }
  } catch (const std::bad_alloc&) {
    refusal = "not enough memory";
  }
  turn.say("load " + request.name + ": " + refusal);
}

double StressJob::work(const Request& request, Turn<Answer>& turn) {
  if (std::exchange(set_solver_seen_, request.set_solver) != request.set_solver && session_)
    session_->attach(solver_for(session_->table(), request));
  if (std::exchange(load_seen_, request.load) != request.load)
    load(request, turn);
  if (!session_ || request.table != answer_.load)
    return kNever;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  answer_.result = session_->step(turn.now_s(), request);
  answer_.result.update_s = std::chrono::duration<double>(Clock::now() - begin).count();
  turn.hand_over(answer_);
  if (std::string refusal = session_->take_refusal(); !refusal.empty())
    turn.say(std::move(refusal));
  return session_->due_s();
}

} // namespace tactus::stress
