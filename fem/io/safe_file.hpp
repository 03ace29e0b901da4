#pragma once

#include "files/npz_writer.hpp"

#include <cstdint>
#include <cstdio>
#include <span>
#include <string>

namespace tactus::fem {

/// A file that appears under its name only when it is complete: it is written as NAME.partial in
/// the same folder, and commit() renames it. An interrupt or an error removes the partial file.
class SafeFile {
public:
  explicit SafeFile(std::string path);
  ~SafeFile();
  SafeFile(const SafeFile&) = delete;
  SafeFile& operator=(const SafeFile&) = delete;

  void write(const void* bytes, std::size_t size);
  void write(const std::string& text) { write(text.data(), text.size()); }
  void commit();

private:
  std::string path_, partial_;
  std::FILE* file_ = nullptr;
};

/// From now on, SIGINT and SIGTERM end the process that reads a file, remove files being written,
/// and end this process with status 130.
void clean_up_on_interrupt();

/// Sets a further function that the interrupt calls. It must be async-signal-safe; null for none.
void also_on_interrupt(void (*)());

using files::NpzWriter;

/// Writes all arrays; the file appears only when complete. Refuses arrays of more than 4 GB.
void write_npz(const std::string& path, const NpzWriter& arrays);
/// The file of write_npz() in memory.
[[nodiscard]] std::string npz_bytes(const NpzWriter& arrays);

/// Reads a whole regular file. Refuses anything else (a pipe or a device may never end) and a file
/// of more than `largest` bytes.
[[nodiscard]] std::string read_bytes(const std::string& path,
                                     std::uint64_t largest = std::uint64_t{4} << 30);

} // namespace tactus::fem
