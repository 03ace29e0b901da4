#include "externals/modal_impact~/mode_solver.hpp"

#include "core/modal/table/resolved_modes.hpp"
#include "core/serve/modal_fem.hpp"
#include "externals/program_file.hpp"
#include "files/resolved_modes.hpp"

#include <algorithm>
#include <mutex>
#include <new>
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

std::string ModeSolver::request(Request request, std::function<void()> ready) {
  if (!thread_.running())
    if (const std::string reason = thread_.start(state_); !reason.empty())
      return "no thread starts for the solver (" + reason + ")";
  {
    const std::lock_guard lock(state_->mutex);
    state_->waiting = std::move(request);
    state_->ready = std::move(ready);
  }
  state_->changed.notify_all();
  return {};
}

std::optional<ModeSolver::Result> ModeSolver::take() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->done, std::nullopt);
}

void ModeSolver::restart(std::uint64_t number) {
  state_->number = number;
  if (!thread_.running()) {
    state_->child.reset();
    return;
  }
  {
    const std::lock_guard lock(state_->mutex);
    state_->restarting = true;
    state_->waiting.reset();
    state_->done.reset();
  }
  state_->changed.notify_all();
}

std::string ModeSolver::State::launch(const Request& request) {
  const std::string program = find_modal_fem(request.program);
  if (program.empty())
    return "the program " + (request.program.empty() ? kProgram : request.program) +
           " was not found: expected it beside modal_impact~, in PATH, or by solver PATH";
  std::string refusal;
  child = ServedProgram::start({program, "serve", request.path}, kProgram, limits.start_s, refusal);
  if (!child)
    return "the solver: " + refusal;
  child_number = request.number;
  loaded = false;
  return {};
}

std::optional<ServedProgram::Message>
ModeSolver::State::await(const Request& request, const ServedProgram::Expects& expects,
                         std::string& lost) {
  while (!stop && number == request.number) {
    if (auto message = child->poll(expects, lost); message || !lost.empty())
      return message;
    child->wait(kPollInterval_s);
  }
  child.reset();
  return {};
}

bool ModeSolver::State::await_ready(const Request& request, std::string& lost) {
  const ModalTable& table = request.table->body().table;
  const auto answer = await(
      request,
      [](const ServeHeader& header) {
        return header.kind == static_cast<std::uint32_t>(ServeKind::ready) &&
               header.size == sizeof(ModesReady);
      },
      lost);
  if (!answer)
    return false;
  if (answer->kind == ServeKind::refused) {
    lost = "the solver refuses the body: " + text_of(*answer);
    return false;
  }
  const auto found = value_at<ModesReady>(answer->payload);
  if (found.vertices != table.vertices() || found.parameters != table.sensitivity.parameters()) {
    lost = "the solver's body has " + std::to_string(found.vertices) + " vertices and " +
           std::to_string(found.parameters) + " parameters: expected the table's " +
           std::to_string(table.vertices()) + " and " +
           std::to_string(table.sensitivity.parameters());
    return false;
  }
  loaded = true;
  return true;
}

std::string ModeSolver::State::exchange(const Request& request, Result& result) {
  const LoadedTable& body = request.table->body();
  const ShapeSensitivity& sensitivity = body.table.sensitivity;
  if (child && child_number != request.number)
    child.reset();
  if (!child)
    if (std::string refusal = launch(request); !refusal.empty())
      return refusal;
  std::string lost;
  if (!loaded && !await_ready(request, lost))
    return lost;
  std::vector<double> shapes = request.displacement_m;
  for (std::size_t p = 0; p < sensitivity.parameters(); ++p)
    shapes.push_back(sensitivity.solved_at(p));
  child->send_request(ServeKind::solve, std::as_bytes(std::span(shapes)), limits.solve_s);
  const std::uint64_t limit = max_answer_bytes(body.table);
  const auto reply = await(
      request,
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

ModeSolver::Result ModeSolver::State::solve(const Request& request) {
  Result result;
  result.number = request.number;
  result.before = request.table;
  std::string lost;
  try {
    lost = exchange(request, result);
  } catch (const std::bad_alloc&) {
    lost = "there is not enough memory for the solver's answer";
  }
  if (!lost.empty()) {
    child.reset();
    result.lost = true;
    result.refusal = std::move(lost);
  }
  return result;
}

void ModeSolver::State::work() {
  while (!stop) {
    std::optional<Request> request;
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return waiting || restarting || stop; });
      if (stop)
        break;
      request = std::exchange(waiting, std::nullopt);
      restarting = false;
    }
    if (child && child_number != number)
      child.reset();
    if (!request || request->number != number)
      continue;
    Result result = solve(*request);
    const std::lock_guard lock(mutex);
    if (result.number != number || (!result.table && result.refusal.empty()))
      continue; // given up
    done = std::move(result);
    if (ready)
      ready();
  }
  child.reset();
}

} // namespace tactus::modal
