#include "externals/modal_impact~/table_worker.hpp"

#include <cstddef>
#include <fstream>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

namespace tactus::modal {
namespace {

constexpr std::streamoff kMostBytes = std::streamoff{2} << 30;

std::string read_file(const std::string& path, std::vector<std::byte>& bytes) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file)
    return "it cannot be opened";
  const std::streamoff size = file.tellg();
  if (size < 0 || size > kMostBytes)
    return "it is no file of less than 2 GB";
  bytes.resize(static_cast<std::size_t>(size));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size))
    return "it cannot be read";
  return {};
}

} // namespace

TableWorker::~TableWorker() {
  if (!thread_.joinable())
    return;
  thread_.request_stop();
  wake_.notify_all();
  thread_.join();
}

std::string TableWorker::request(const Request& request, std::function<void()> ready) {
  if (!thread_.joinable()) {
    try {
      thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
    } catch (const std::system_error& error) {
      return std::string("no thread starts to read tables (") + error.what() +
             "); it is done at once, which the audio may miss";
    }
  }
  {
    const std::lock_guard lock(mutex_);
    // A load that still waits is not forgotten for a change of settings.
    if (waiting_ && request.path.empty() && !waiting_->path.empty()) {
      waiting_->settings = request.settings;
    } else {
      waiting_ = request;
    }
    ready_ = std::move(ready);
  }
  wake_.notify_all();
  return {};
}

std::optional<TableWorker::Result> TableWorker::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(done_, std::nullopt);
}

TableWorker::Result TableWorker::carry_out(const Request& request) {
  Result result;
  result.loaded = !request.path.empty();
  result.table = request.table;
  try {
    if (result.loaded) {
      std::vector<std::byte> bytes;
      ModalTable table;
      std::string refusal = read_file(request.path, bytes);
      if (refusal.empty())
        refusal = read_modal_table(bytes, table);
      if (!refusal.empty()) {
        result.refusal = "load " + request.name + ": " + refusal;
        return result;
      }
      result.table = std::make_shared<const LoadedTable>(std::move(table));
    }
    if (result.table)
      result.model = std::make_unique<BodyModel>(result.table, request.settings);
  } catch (const std::bad_alloc&) {
    result.refusal = "load " + request.name + ": not enough memory";
    result.model.reset();
  }
  return result;
}

void TableWorker::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Request request;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return waiting_.has_value(); }))
        return;
      request = std::move(*waiting_);
      waiting_.reset();
    }
    Result result = carry_out(request);
    const std::lock_guard lock(mutex_);
    // A result nobody has taken yet is replaced, unless it is a body that only now was read.
    if (done_ && done_->loaded && !result.loaded && done_->table != result.table)
      continue;
    if (done_ && done_->loaded && done_->table == result.table)
      result.loaded = true;
    done_ = std::move(result);
    if (ready_)
      ready_();
  }
}

} // namespace tactus::modal
