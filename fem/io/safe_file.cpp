#include "fem/io/safe_file.hpp"

#include "fem/io/isolated_process.hpp"
#include "fem/mesh/mesh.hpp"
#include "files/file_bytes.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <unistd.h>

namespace tactus::fem {
namespace {

// The signal handler reads this name; only one file is written at a time.
char g_partial[4096];
std::atomic<bool> g_writing{false};
std::atomic<void (*)()> g_also{nullptr};

extern "C" void on_interrupt(int) {
  end_isolated_child();
  if (g_writing.load())
    unlink(g_partial);
  if (const auto also = g_also.load())
    also();
  constexpr char text[] = "\nstopped; nothing was written\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, sizeof text - 1);
  _exit(130);
}

} // namespace

void clean_up_on_interrupt() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  std::signal(SIGXFSZ, SIG_IGN); // beyond a file size limit, write() then fails with an error
}

void also_on_interrupt(void (*action)()) { g_also = action; }

SafeFile::SafeFile(std::string path) : path_(std::move(path)), partial_(path_ + ".partial") {
  if (partial_.size() >= sizeof g_partial)
    throw InputError("the file name " + path_ + " is too long");
  std::copy_n(partial_.c_str(), partial_.size() + 1, g_partial);
  file_ = std::fopen(partial_.c_str(), "wb");
  if (!file_)
    throw InputError("cannot write " + path_ + ": " + std::strerror(errno));
  g_writing = true;
}

SafeFile::~SafeFile() {
  if (file_)
    std::fclose(file_);
  if (!partial_.empty())
    unlink(partial_.c_str());
  g_writing = false;
}

void SafeFile::write(const void* bytes, std::size_t size) {
  if (size && std::fwrite(bytes, 1, size, file_) != size)
    throw InputError("cannot write " + path_ + ": " + std::strerror(errno));
}

void SafeFile::commit() {
  const int status = std::fclose(file_);
  file_ = nullptr;
  if (status != 0 || std::rename(partial_.c_str(), path_.c_str()) != 0)
    throw InputError("cannot write " + path_ + ": " + std::strerror(errno));
  partial_.clear();
  g_writing = false;
}

namespace {

void emit(const NpzWriter& arrays, const NpzWriter::Sink& sink) {
  if (const std::string refusal = arrays.emit(sink); !refusal.empty())
    throw InputError(refusal);
}

} // namespace

void write_npz(const std::string& path, const NpzWriter& arrays) {
  SafeFile file(path);
  emit(arrays, [&](const void* bytes, std::size_t size) { file.write(bytes, size); });
  file.commit();
}

std::string npz_bytes(const NpzWriter& arrays) {
  std::string out;
  emit(arrays, [&](const void* bytes, std::size_t size) {
    out.append(static_cast<const char*>(bytes), size);
  });
  return out;
}

std::string read_bytes(const std::string& path, std::uint64_t largest) {
  std::string bytes;
  if (const std::string refusal = files::read_file(path, bytes, largest); !refusal.empty())
    throw InputError("cannot read " + path + ": " + refusal);
  return bytes;
}

} // namespace tactus::fem
