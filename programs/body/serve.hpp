#pragma once
#include "core/serve/protocol.hpp"
#include "fem/mesh/mesh.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

/// Code shared by `part_stress serve` and `modal_fem serve`: reading the table that contains a
/// part's command line, and messages on stdin and stdout (core/serve/protocol.hpp).
namespace tactus::fem {

/// A part as stored in its table.
struct ServedPart {
  std::string bytes; ///< content of the whole file
  Mesh mesh;
  std::vector<std::string> command; ///< the command line that made the table
};

/// Reads the arrays `mesh` and `command` (in meta) of a table whose meta has the format `format`.
/// Refuses a table without them and names the file. `program` is the program that should have
/// written the table.
[[nodiscard]] ServedPart read_served_part(const std::string& path, const std::string& format,
                                          const std::string& program);

/// Parses a table's command with `read`; its exceptions are rethrown with the file's name.
template <class Read>
[[nodiscard]] auto read_served_options(const std::string& path,
                                       const std::vector<std::string>& command, Read&& read) {
  try {
    return read(command);
  } catch (const InputError& refusal) {
    throw InputError(path + ": " + refusal.what());
  }
}

/// A message to stdout.
class ServeMessage {
public:
  explicit ServeMessage(serve::ServeKind kind) { header_.kind = static_cast<std::uint32_t>(kind); }
  template <class T> void add(const T& value) { append(&value, sizeof value); }
  template <class T> void add(std::span<const T> values) {
    append(values.data(), values.size_bytes());
  }
  void add_text(const std::string& text) { append(text.data(), text.size()); }
  /// Refuses if the reader has closed stdout.
  void send();

private:
  void append(const void* from, std::size_t size) {
    bytes_.append(static_cast<const char*>(from), size);
  }
  serve::ServeHeader header_;
  std::string bytes_;
};

/// Answers requests on stdin until it ends: calls `answer` with the bytes of each `solve`. If
/// `answer` refuses by an exception, the refusal is sent as `refused` and the next request is read.
/// Returns the process's exit status: 0 at the end of stdin or after `quit`, 1 after a broken
/// stream.
[[nodiscard]] int serve_requests(const char* program,
                                 const std::function<void(std::span<const char>)>& answer);

} // namespace tactus::fem
