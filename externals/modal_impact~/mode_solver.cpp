#include "externals/modal_impact~/mode_solver.hpp"

#include "core/modal/table/resolved_modes.hpp"
#include "core/serve/modal_fem.hpp"
#include "externals/normal_priority.hpp"
#include "externals/program_file.hpp"
#include "files/resolved_modes.hpp"

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

namespace tactus::modal {

using serve::ModesReady;
using serve::ServeHeader;
using serve::ServeKind;

namespace {

constexpr const char* kProgram = "modal_fem";
constexpr double kPollInterval_s = 0.05; // between checks of the clock and of cancelled requests

std::string text_of(const ServedProgram::Message& message) {
  return printable_line(
      {reinterpret_cast<const char*>(message.payload.data()), message.payload.size()});
}

} // namespace

std::string find_modal_fem(const std::string& program) { return find_program(kProgram, program); }

ModeSolver::~ModeSolver() {
  if (!thread_.joinable())
    return;
  {
    const std::lock_guard lock(mutex_); // or the thread could look before and wait after
    thread_.request_stop();
  }
  wake_.notify_all();
  thread_.join();
}

std::string ModeSolver::request(Request request, std::function<void()> ready) {
  if (!thread_.joinable()) {
    try {
      thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
    } catch (const std::system_error& error) {
      return std::string("no thread starts for the solver (") + error.what() + ")";
    }
  }
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(request);
    ready_ = std::move(ready);
  }
  wake_.notify_all();
  return {};
}

std::optional<ModeSolver::Result> ModeSolver::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(done_, std::nullopt);
}

void ModeSolver::restart(std::uint64_t number) {
  number_ = number;
  if (!thread_.joinable()) {
    child_.reset();
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    restarting_ = true;
    waiting_.reset();
    done_.reset();
  }
  wake_.notify_all();
}

std::string ModeSolver::launch(const Request& request) {
  const std::string program = find_modal_fem(request.program);
  if (program.empty())
    return "the program " + (request.program.empty() ? kProgram : request.program) +
           " was not found: expected it beside modal_impact~, in PATH, or by solver PATH";
  std::string refusal;
  child_ =
      ServedProgram::start({program, "serve", request.path}, kProgram, limits_.start_s, refusal);
  if (!child_)
    return "the solver: " + refusal;
  child_number_ = request.number;
  loaded_ = false;
  return {};
}

std::optional<ServedProgram::Message> ModeSolver::await(const Request& request,
                                                        const std::stop_token& stop,
                                                        const ServedProgram::Expects& expects,
                                                        std::string& lost) {
  while (!stop.stop_requested() && number_ == request.number) {
    if (auto message = child_->poll(expects, lost); message || !lost.empty())
      return message;
    child_->wait(kPollInterval_s);
  }
  child_.reset();
  return {};
}

bool ModeSolver::await_ready(const Request& request, const std::stop_token& stop,
                             std::string& lost) {
  const ModalTable& table = request.table->body().table;
  const auto ready = await(
      request, stop,
      [](const ServeHeader& header) {
        return header.kind == static_cast<std::uint32_t>(ServeKind::ready) &&
               header.size == sizeof(ModesReady);
      },
      lost);
  if (!ready)
    return false;
  if (ready->kind == ServeKind::refused) {
    lost = "the solver refuses the body: " + text_of(*ready);
    return false;
  }
  const auto found = value_at<ModesReady>(ready->payload);
  if (found.vertices != table.vertices() || found.parameters != table.sensitivity.parameters()) {
    lost = "the solver's body has " + std::to_string(found.vertices) + " vertices and " +
           std::to_string(found.parameters) + " parameters: expected the table's " +
           std::to_string(table.vertices()) + " and " +
           std::to_string(table.sensitivity.parameters());
    return false;
  }
  loaded_ = true;
  return true;
}

std::string ModeSolver::exchange(const Request& request, const std::stop_token& stop,
                                 Result& result) {
  const LoadedTable& body = request.table->body();
  const ShapeSensitivity& sensitivity = body.table.sensitivity;
  if (child_ && child_number_ != request.number)
    child_.reset();
  if (!child_)
    if (std::string refusal = launch(request); !refusal.empty())
      return refusal;
  std::string lost;
  if (!loaded_ && !await_ready(request, stop, lost))
    return lost;
  std::vector<double> shapes = request.displacement_m;
  for (std::size_t p = 0; p < sensitivity.parameters(); ++p)
    shapes.push_back(sensitivity.solved_at(p));
  child_->send_request(ServeKind::solve, std::as_bytes(std::span(shapes)), limits_.solve_s);
  const std::uint64_t limit = max_answer_bytes(body.table);
  const auto reply = await(
      request, stop,
      [limit](const ServeHeader& header) {
        return header.kind == static_cast<std::uint32_t>(ServeKind::modes) && header.size <= limit;
      },
      lost);
  if (!reply)
    return lost;
  if (reply->kind == ServeKind::refused) {
    result.refusal = text_of(*reply);
    return {};
  }
  ResolvedModes resolved;
  if (const std::string refusal = files::read_resolved_modes(reply->payload, body.table, resolved);
      !refusal.empty())
    return "the solver's answer is invalid, and it was ended: " + refusal;
  result.seconds = resolved.seconds;
  result.fraction = resolved.fraction;
  auto solved = std::make_shared<const LoadedTable>(std::move(resolved.table), body,
                                                    std::move(resolved.share));
  if (!request.table->parts.empty()) {
    result.refusal =
        LoadedTable::refusal(*solved, *request.table->parts[LoadedTable::kBoard].loaded);
    if (!result.refusal.empty())
      return {};
    solved = std::make_shared<const LoadedTable>(std::move(solved), *request.table);
  }
  result.table = std::move(solved);
  return {};
}

ModeSolver::Result ModeSolver::solve(const Request& request, const std::stop_token& stop) {
  Result result;
  result.number = request.number;
  result.before = request.table;
  std::string lost;
  try {
    lost = exchange(request, stop, result);
  } catch (const std::bad_alloc&) {
    lost = "there is not enough memory for the solver's answer";
  }
  if (!lost.empty()) {
    child_.reset();
    result.lost = true;
    result.refusal = std::move(lost);
  }
  return result;
}

void ModeSolver::work(const std::stop_token& stop) {
  set_normal_priority();
  while (!stop.stop_requested()) {
    std::optional<Request> request;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return waiting_ || restarting_ || stop.stop_requested(); });
      if (stop.stop_requested())
        break;
      request = std::exchange(waiting_, std::nullopt);
      restarting_ = false;
    }
    if (child_ && child_number_ != number_)
      child_.reset();
    if (!request || request->number != number_)
      continue;
    Result result = solve(*request, stop);
    const std::lock_guard lock(mutex_);
    if (result.number != number_ || (!result.table && result.refusal.empty()))
      continue; // given up
    done_ = std::move(result);
    if (ready_)
      ready_();
  }
  child_.reset();
}

} // namespace tactus::modal
