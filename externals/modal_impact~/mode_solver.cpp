#include "externals/modal_impact~/mode_solver.hpp"

#include "core/modal/table/resolved_modes.hpp"
#include "core/serve/modal_fem.hpp"
#include "files/system_folders.hpp"
#include "files/tables.hpp"

#include <new>
#include <utility>

namespace tactus::modal {

using serve::ModesReady;
using serve::ServeHeader;
using serve::ServeKind;

namespace {

constexpr const char* kProgram = "modal_fem";
constexpr double kPollInterval_s = 0.05; // interval of checks of the clock and of cancelled
                                         // requests

std::string text_of(const ServedProgram::Message& message) {
  return printable_line(
      {reinterpret_cast<const char*>(message.payload.data()), message.payload.size()});
}

} // namespace

std::string find_modal_fem(const std::string& program) { return find_program(kProgram, program); }

std::string ModeJob::launch(const Request& request) {
  const std::string program = find_modal_fem(request.program);
  if (program.empty())
    return "the program " + (request.program.empty() ? kProgram : request.program) +
           " was not found: expected beside modal_impact~ or in PATH; else send solver with its "
           "path";
  std::string refusal;
  child_ =
      ServedProgram::start({program, "serve", request.path}, kProgram, limits_.start_s, refusal);
  if (!child_)
    return "the solver: " + refusal;
  child_number_ = request.number;
  loaded_ = false;
  return {};
}

std::optional<ServedProgram::Message>
ModeJob::await(const Turn<Answer>& turn, const ServedProgram::Expects& expects, std::string& lost) {
  while (!turn.is_superseded()) {
    if (auto message = child_->poll(expects, lost); message || !lost.empty())
      return message;
    child_->wait(kPollInterval_s);
  }
  child_.reset();
  return {};
}

bool ModeJob::await_ready(const Request& request, const Turn<Answer>& turn, std::string& lost) {
  const ModalTable& table = request.table->table;
  const auto answer = await(
      turn,
      [](const ServeHeader& header) {
        return header.kind == static_cast<std::uint32_t>(ServeKind::ready) &&
               header.size == sizeof(ModesReady);
      },
      lost);
  if (!answer)
    return false;
  if (answer->kind == ServeKind::refused) {
    lost = "the solver refused the body: " + text_of(*answer);
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
  loaded_ = true;
  return true;
}

std::string ModeJob::exchange(const Request& request, const Turn<Answer>& turn, Answer& answer) {
  const LoadedTable& body = *request.table;
  const ShapeSensitivity& sensitivity = body.table.sensitivity;
  if (!child_)
    if (std::string refusal = launch(request); !refusal.empty())
      return refusal;
  std::string lost;
  if (!loaded_ && !await_ready(request, turn, lost))
    return lost;
  std::vector<double> shapes = request.displacement_m;
  for (std::size_t p = 0; p < sensitivity.parameters(); ++p)
    shapes.push_back(sensitivity.solved_at(p));
  child_->send_request(ServeKind::solve, std::as_bytes(std::span(shapes)), limits_.solve_s);
  const std::uint64_t limit = max_answer_bytes(body.table);
  const auto reply = await(
      turn,
      [limit](const ServeHeader& header) {
        return header.kind == static_cast<std::uint32_t>(ServeKind::modes) && header.size <= limit;
      },
      lost);
  if (!reply)
    return lost;
  if (reply->kind == ServeKind::refused) {
    answer.refusal = text_of(*reply);
    return {};
  }
  ResolvedModes resolved;
  if (const std::string refusal = files::read_resolved_modes(reply->payload, body.table, resolved);
      !refusal.empty())
    return "the solver sent an invalid answer and was stopped: " + refusal;
  answer.seconds = resolved.seconds;
  answer.fraction = resolved.fraction;
  answer.table = std::make_shared<const LoadedTable>(std::move(resolved.table), body,
                                                     std::move(resolved.share));
  return {};
}

double ModeJob::work(const Request& request, Turn<Answer>& turn) {
  if (child_number_ != request.number)
    child_.reset();
  if (!request.table)
    return kNever;
  Answer answer;
  answer.number = request.number;
  answer.before = request.table;
  std::string lost;
  try {
    lost = exchange(request, turn, answer);
  } catch (const std::bad_alloc&) {
    lost = "not enough memory for the solver's answer";
  }
  if (!lost.empty()) {
    child_.reset();
    answer.lost = true;
    answer.refusal = std::move(lost);
  }
  if (answer.table || !answer.refusal.empty()) // else the request was cancelled
    turn.hand_over(std::move(answer));
  return kNever;
}

} // namespace tactus::modal
