#include "externals/modal_impact~/table_worker.hpp"

#include "files/file_bytes.hpp"
#include "files/modal_table.hpp"

#include <cstddef>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

namespace tactus::modal {
namespace {

bool reads_first(const TableWorker::Request& request) {
  return !request.path.empty() && !request.table;
}

} // namespace

TableWorker::~TableWorker() {
  if (!thread_.joinable())
    return;
  {
    const std::lock_guard lock(mutex_); // or the thread could look before and wait after
    thread_.request_stop();
  }
  wake_.notify_all();
  thread_.join();
}

std::string TableWorker::request(const Request& request, std::function<void()> ready) {
  if (!thread_.joinable()) {
    try {
      thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
    } catch (const std::system_error& error) {
      return std::string("no thread starts to read tables (") + error.what() +
             "); they are read at once, which may interrupt the sound";
    }
  }
  {
    const std::lock_guard lock(mutex_);
    // A change of settings keeps a load that still waits.
    Request next = request;
    next.number = ++requested_;
    if (waiting_ && next.path.empty()) {
      next.path = waiting_->path;
      next.name = waiting_->name;
    }
    if (waiting_ && waiting_->replaces && waiting_->replaces == next.table) {
      next.replaces = waiting_->replaces;
      next.table = waiting_->table;
    }
    if (waiting_ && !next.board)
      next.board = waiting_->board;
    waiting_ = std::move(next);
    if (reads_first(*waiting_))
      loads_first_ = true;
    ready_ = std::move(ready);
  }
  wake_.notify_all();
  return {};
}

/// Redirects a request for a replaced table to the new one.
void TableWorker::follow(Request& request) const {
  if (!pending_table_ || request.table != pending_before_)
    return;
  if (request.table && &request.table->body() != &pending_table_->body() &&
      !pending_table_->body().follows(
          request.table->body())) // the displacements belong to the old body
    request.settings.shape_displacement_m.clear();
  request.table = pending_table_;
}

std::optional<TableWorker::Result> TableWorker::take() {
  const std::lock_guard lock(mutex_);
  if (waiting_)
    follow(*waiting_);
  pending_before_ = pending_table_ = nullptr;
  loads_first_ = reading_first_ || (waiting_ && reads_first(*waiting_));
  return std::exchange(done_, std::nullopt);
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
    else if (result.table)
      result.model = std::make_unique<BodyModel>(result.table, settings);
  } catch (const std::bad_alloc&) {
    result.refusal = subject + "not enough memory";
    result.model.reset();
  }
  return result;
}

void TableWorker::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Request request;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return waiting_.has_value() || stop.stop_requested(); });
      if (stop.stop_requested())
        return;
      request = std::move(*waiting_);
      waiting_.reset();
      follow(request);
      reading_first_ = reads_first(request);
    }
    Result result = execute(request);
    const std::lock_guard lock(mutex_);
    reading_first_ = false;
    // A newer result replaces one that has not been taken, unless it failed or its table has been
    // replaced meanwhile.
    if (done_ && done_->model && !result.model) {
      done_->refusal = result.refusal;
    } else if (!done_ || !done_->loaded || result.loaded || request.table == done_->table) {
      if (done_ && result.model) {
        if (done_->loaded && !result.loaded)
          result.path = done_->path;
        result.loaded |= done_->loaded;
        result.board_loaded |= done_->board_loaded;
      }
      if (result.model && (result.table != request.table || request.replaces)) {
        if (!pending_table_)
          pending_before_ = request.replaces ? request.replaces : request.table;
        pending_table_ = result.table;
      }
      done_ = std::move(result);
    }
    if (done_)
      done_->number = request.number;
    if (ready_)
      ready_();
  }
}

} // namespace tactus::modal
