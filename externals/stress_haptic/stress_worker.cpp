#include "externals/stress_haptic/stress_worker.hpp"

#include "files/file_bytes.hpp"
#include "files/stress_table.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

namespace tactus::stress {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr double kMaxSleep_s = 3600;

} // namespace

std::string StressWorker::start(std::function<void()> ready) {
  state_->ready = std::move(ready);
  if (const std::string reason = thread_.start(state_); !reason.empty())
    return "no thread starts for the stress (" + reason +
           "); it is computed in the host's time, which the audio may miss";
  return {};
}

void StressWorker::load(const std::string& path, std::uint64_t number) {
  if (!threaded())
    return state_->execute_load(path, number);
  {
    const std::lock_guard lock(state_->mutex);
    state_->pending_load = {path, number};
    state_->wake_requested = true;
  }
  state_->changed.notify_all();
}

void StressWorker::set_program(const std::string& program) {
  if (!threaded())
    return state_->execute_program(program);
  {
    const std::lock_guard lock(state_->mutex);
    state_->to_program = program;
    state_->wake_requested = true;
  }
  state_->changed.notify_all();
}

void StressWorker::request(const SessionRequest& request, double now) {
  state_->requests.write(request);
  if (!threaded())
    return state_->step(now);
  {
    const std::lock_guard lock(state_->mutex);
    state_->wake_requested = true;
  }
  state_->changed.notify_all();
}

void StressWorker::poll(double now) {
  if (due_in_s(now) <= 0)
    state_->step(now);
}

double StressWorker::due_in_s(double now) const noexcept {
  return !threaded() && state_->session ? state_->session->due_in_s(now)
                                        : std::numeric_limits<double>::infinity();
}

std::optional<StressWorker::Loaded> StressWorker::take_loaded() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->loaded, std::nullopt);
}

std::string StressWorker::take_refusal() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->refusal, {});
}

std::unique_ptr<Reanalysis> StressWorker::State::solver_for(const StressTable& table) const {
  return solvers ? solvers({table, table_path, solver_program, blocking_solvers}) : nullptr;
}

void StressWorker::State::execute_program(const std::string& program) {
  solver_program = program;
  if (session)
    session->attach(solver_for(session->table()));
}

void StressWorker::State::execute_load(const std::string& path, std::uint64_t number) {
  Loaded fresh;
  fresh.number = number;
  try {
    std::vector<std::byte> bytes;
    StressTable table;
    fresh.refusal = files::read_file(path, bytes);
    if (fresh.refusal.empty())
      fresh.refusal = files::read_stress_table(bytes, table);
    if (fresh.refusal.empty()) {
      fresh.table = std::make_shared<const StressTable>(std::move(table));
      table_path = path;
      session = std::make_unique<StressSession>(fresh.table, solver_for(*fresh.table));
      fresh.can_solve = session->can_solve();
      table_number = number;
    }
  } catch (const std::bad_alloc&) {
    fresh.refusal = "not enough memory";
    fresh.table = nullptr;
  }
  const std::lock_guard lock(mutex);
  loaded = std::move(fresh);
}

/// Requests made for another table are skipped: their sizes differ.
void StressWorker::State::step(double now) {
  requests.read();
  const SessionRequest& request = requests.latest();
  if (!session || request.table != table_number)
    return;
  std::string problem;
  try {
    const double begin_s = now_s();
    SessionResult result = session->step(now, request);
    result.update_s = now_s() - begin_s;
    results.write(result);
    problem = session->take_refusal();
  } catch (const std::bad_alloc&) {
    problem = "not enough memory for the stress; the last value stays";
  }
  if (!problem.empty()) {
    const std::lock_guard lock(mutex);
    refusal = std::move(problem);
  }
}

void StressWorker::State::work() {
  while (!stop) {
    std::optional<std::pair<std::string, std::uint64_t>> to_load;
    std::optional<std::string> program;
    {
      std::unique_lock lock(mutex);
      const double sleep_s =
          session ? std::min(session->due_in_s(now_s()), kMaxSleep_s) : kMaxSleep_s;
      changed.wait_for(lock, std::chrono::duration<double>(sleep_s),
                       [&] { return wake_requested || stop; });
      wake_requested = false;
      to_load = std::exchange(pending_load, std::nullopt);
      program = std::exchange(to_program, std::nullopt);
    }
    if (stop)
      return;
    if (program)
      execute_program(*program);
    if (to_load)
      execute_load(to_load->first, to_load->second);
    step(now_s());
    const std::lock_guard lock(mutex);
    if (ready)
      ready();
  }
}

} // namespace tactus::stress
