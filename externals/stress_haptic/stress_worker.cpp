#include "externals/stress_haptic/stress_worker.hpp"

#include "externals/normal_priority.hpp"
#include "files/file_bytes.hpp"
#include "files/stress_table.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

namespace tactus::stress {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr double kMaxSleep_s = 3600;

} // namespace

StressWorker::~StressWorker() {
  if (!thread_.joinable())
    return;
  {
    const std::lock_guard lock(mutex_); // or the thread could look before and wait after
    thread_.request_stop();
  }
  wake_.notify_all();
  thread_.join();
}

std::string StressWorker::start(std::function<void()> ready) {
  ready_ = std::move(ready);
  try {
    thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  } catch (const std::system_error& error) {
    return std::string("no thread starts for the stress (") + error.what() +
           "); it is computed in the host's time, which the audio may miss";
  }
  return {};
}

void StressWorker::load(const std::string& path, std::uint64_t number) {
  if (!threaded())
    return execute_load(path, number);
  {
    const std::lock_guard lock(mutex_);
    pending_load_ = {path, number};
    wake_requested_ = true;
  }
  wake_.notify_all();
}

void StressWorker::set_program(const std::string& program) {
  if (!threaded())
    return execute_program(program);
  {
    const std::lock_guard lock(mutex_);
    to_program_ = program;
    wake_requested_ = true;
  }
  wake_.notify_all();
}

void StressWorker::request(const SessionRequest& request, double now) {
  requests_.write(request);
  if (!threaded())
    return step(now);
  {
    const std::lock_guard lock(mutex_);
    wake_requested_ = true;
  }
  wake_.notify_all();
}

void StressWorker::poll(double now) {
  if (due_in_s(now) <= 0)
    step(now);
}

double StressWorker::due_in_s(double now) const noexcept {
  return !threaded() && session_ ? session_->due_in_s(now)
                                 : std::numeric_limits<double>::infinity();
}

std::optional<StressWorker::Loaded> StressWorker::take_loaded() {
  const std::lock_guard lock(mutex_);
  return std::exchange(loaded_, std::nullopt);
}

std::string StressWorker::take_refusal() {
  const std::lock_guard lock(mutex_);
  return std::exchange(refusal_, {});
}

std::unique_ptr<Reanalysis> StressWorker::solver_for(const StressTable& table) const {
  return solvers_ ? solvers_({table, path_, program_, blocking_solvers_}) : nullptr;
}

void StressWorker::execute_program(const std::string& program) {
  program_ = program;
  if (session_)
    session_->attach(solver_for(session_->table()));
}

void StressWorker::execute_load(const std::string& path, std::uint64_t number) {
  Loaded loaded;
  loaded.number = number;
  try {
    std::vector<std::byte> bytes;
    StressTable table;
    loaded.refusal = files::read_file(path, bytes);
    if (loaded.refusal.empty())
      loaded.refusal = files::read_stress_table(bytes, table);
    if (loaded.refusal.empty()) {
      loaded.table = std::make_shared<const StressTable>(std::move(table));
      path_ = path;
      session_ = std::make_unique<StressSession>(loaded.table, solver_for(*loaded.table));
      loaded.can_solve = session_->can_solve();
      number_ = number;
    }
  } catch (const std::bad_alloc&) {
    loaded.refusal = "not enough memory";
    loaded.table = nullptr;
  }
  const std::lock_guard lock(mutex_);
  loaded_ = std::move(loaded);
}

/// Requests made for another table are skipped: their sizes differ.
void StressWorker::step(double now) {
  requests_.read();
  const SessionRequest& request = requests_.latest();
  if (!session_ || request.table != number_)
    return;
  std::string refusal;
  try {
    const double begin_s = now_s();
    SessionResult result = session_->step(now, request);
    result.update_s = now_s() - begin_s;
    results_.write(result);
    refusal = session_->take_refusal();
  } catch (const std::bad_alloc&) {
    refusal = "not enough memory for the stress; the last value stays";
  }
  if (!refusal.empty()) {
    const std::lock_guard lock(mutex_);
    refusal_ = std::move(refusal);
  }
}

void StressWorker::work(const std::stop_token& stop) {
  set_normal_priority();
  while (!stop.stop_requested()) {
    std::optional<std::pair<std::string, std::uint64_t>> to_load;
    std::optional<std::string> to_program;
    {
      std::unique_lock lock(mutex_);
      const double sleep_s =
          session_ ? std::min(session_->due_in_s(now_s()), kMaxSleep_s) : kMaxSleep_s;
      wake_.wait_for(lock, std::chrono::duration<double>(sleep_s),
                     [&] { return wake_requested_ || stop.stop_requested(); });
      wake_requested_ = false;
      to_load = std::exchange(pending_load_, std::nullopt);
      to_program = std::exchange(to_program_, std::nullopt);
    }
    if (stop.stop_requested())
      return;
    if (to_program)
      execute_program(*to_program);
    if (to_load)
      execute_load(to_load->first, to_load->second);
    step(now_s());
    ready_();
  }
}

} // namespace tactus::stress
