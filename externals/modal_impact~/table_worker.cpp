#include "externals/modal_impact~/table_worker.hpp"

#include "externals/modal_impact~/units.hpp"
#include "files/file_bytes.hpp"
#include "files/modal_table.hpp"

#include <cstddef>
#include <exception>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

namespace tactus::modal {
namespace {

bool reads_first(const TableWorker::Request& request) {
  return !request.path.empty() && !request.table;
}

} // namespace

std::string TableWorker::request(const Request& request, std::function<void()> ready) {
  if (!thread_.running())
    if (const std::string reason = thread_.start(state_); !reason.empty())
      return "no thread starts to read tables (" + reason +
             "); they are read at once, which may interrupt the sound";
  State& state = *state_;
  {
    const std::lock_guard lock(state.mutex);
    // A change of settings keeps a load that still waits.
    Request next = request;
    next.number = ++requested_;
    if (state.waiting && next.path.empty()) {
      next.path = state.waiting->path;
      next.name = state.waiting->name;
    }
    if (state.waiting && state.waiting->replaces && state.waiting->replaces == next.table) {
      next.replaces = state.waiting->replaces;
      next.table = state.waiting->table;
    }
    if (state.waiting && !next.board)
      next.board = state.waiting->board;
    state.waiting = std::move(next);
    if (reads_first(*state.waiting))
      state.loads_first = true;
    state.ready = std::move(ready);
  }
  state.changed.notify_all();
  return {};
}

/// Redirects a request for a replaced table to the new one.
void TableWorker::State::follow(Request& request) const {
  if (!pending_table || request.table != pending_before)
    return;
  if (request.table && &request.table->body() != &pending_table->body() &&
      !pending_table->body().follows(
          request.table->body())) // the displacements belong to the old body
    request.settings.shape_displacement_m.clear();
  request.table = pending_table;
}

std::optional<TableWorker::Result> TableWorker::take() {
  State& state = *state_;
  const std::lock_guard lock(state.mutex);
  if (state.waiting)
    state.follow(*state.waiting);
  state.pending_before = state.pending_table = nullptr;
  state.loads_first = state.reading_first || (state.waiting && reads_first(*state.waiting));
  return std::exchange(state.done, std::nullopt);
}

std::string TableWorker::radiation_refusal(const LoadedTable& table, Radiation radiation,
                                           Radiation instead) {
  const auto name = [](Radiation r) {
    return std::string(modal_impact::kRadiations[static_cast<std::size_t>(r)]);
  };
  const std::string_view missing = missing_arrays(table, radiation);
  return missing.empty() ? std::string()
                         : "radiation " + name(radiation) + ": the table has no arrays " +
                               std::string(missing) + ": " + name(instead) + " is used";
}

TableWorker::Result TableWorker::execute(const Request& request) {
  Result result;
  result.table = request.table;
  result.number = request.number;
  BodySettings settings = request.settings;
  std::string subject = "load " + request.name + ": ";
  const auto read = [&](const std::string& path) -> std::shared_ptr<const LoadedTable> {
    std::vector<std::byte> bytes;
    ModalTable table;
    result.refusal = files::read_file(path, bytes);
    if (result.refusal.empty())
      result.refusal = files::read_modal_table(bytes, table);
    return result.refusal.empty() ? std::make_shared<const LoadedTable>(std::move(table)) : nullptr;
  };
  try {
    std::shared_ptr<const LoadedTable> body = request.table, board;
    Vec3 displacement{};
    if (body && !body->parts.empty()) {
      board = request.table->parts[LoadedTable::kBoard].loaded;
      displacement = request.table->parts[LoadedTable::kBoard].displacement_m;
      body = request.table->parts[0].loaded;
    }
    if (!request.path.empty()) {
      body = read(request.path);
      result.loaded = true;
      result.path = request.path;
      settings.shape_displacement_m.clear();
    }
    if (request.board && result.refusal.empty()) {
      subject = "board " + request.board->name + ": ";
      result.board_loaded = !request.board->path.empty();
      result.board_name = request.board->name;
      board = result.board_loaded ? read(request.board->path) : nullptr;
      displacement = request.board->displacement_m;
      if (result.refusal.empty() && !body)
        result.refusal = "there is no body yet: load one first";
    }
    const bool is_new = result.loaded || request.board;
    if (is_new && result.refusal.empty() && board)
      result.refusal = LoadedTable::refusal(*body, *board);
    if (is_new && result.refusal.empty())
      result.table = board ? std::make_shared<const LoadedTable>(body, board, displacement) : body;
    if (!result.refusal.empty())
      result.refusal = subject + result.refusal;
    else if (result.table) {
      result.refusal =
          radiation_refusal(*result.table, settings.radiation, BodySettings().radiation);
      if (!result.refusal.empty())
        settings.radiation = BodySettings().radiation;
      result.model = std::make_unique<BodyModel>(result.table, settings);
    }
  } catch (const std::exception&) { // bad_alloc, or the length_error of a container
    result.refusal = subject + "not enough memory";
    result.model.reset();
  }
  return result;
}

void TableWorker::State::work() {
  for (;;) {
    Request request;
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return waiting.has_value() || stop; });
      if (stop)
        return;
      request = std::move(*waiting);
      waiting.reset();
      follow(request);
      reading_first = reads_first(request);
    }
    Result result = execute(request);
    const std::lock_guard lock(mutex);
    if (stop)
      return;
    reading_first = false;
    // A newer result replaces one that has not been taken, unless it failed or its table has been
    // replaced meanwhile.
    if (done && done->model && !result.model) {
      done->refusal = result.refusal;
    } else if (!done || !done->loaded || result.loaded || request.table == done->table) {
      if (done && result.model) {
        if (done->loaded && !result.loaded)
          result.path = done->path;
        if (done->board_loaded && !result.board_loaded)
          result.board_name = done->board_name;
        result.loaded |= done->loaded;
        result.board_loaded |= done->board_loaded;
      }
      if (result.model && (result.table != request.table || request.replaces)) {
        if (!pending_table)
          pending_before = request.replaces ? request.replaces : request.table;
        pending_table = result.table;
      }
      done = std::move(result);
    }
    if (done)
      done->number = request.number;
    if (ready)
      ready();
  }
}

} // namespace tactus::modal
