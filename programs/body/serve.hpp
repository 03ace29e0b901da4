#pragma once
#include "core/serve/protocol.hpp"
#include "fem/mesh/mesh.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

/// What `part_stress serve` and `modal_fem serve` share: the table that says how its part was made,
/// and messages on stdin and stdout (core/serve/protocol.hpp).
namespace tactus::fem {

/// A part as its table keeps it.
struct ServedPart {
  std::string bytes; ///< of the whole file
  Mesh mesh;
  std::vector<std::string> command; ///< the words with which the program made it
};

/// Reads the arrays `mesh` and `command` (in meta) of a table whose meta names `format`. Refuses,
/// naming the file, one that does not hold them; `program` is what should have written it.
[[nodiscard]] ServedPart read_served_part(const std::string& path, const std::string& format,
                                          const std::string& program);

/// The order that a table's command is; `read` refuses by exception, and the file is named.
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
  /// Refuses when the reader of stdout has closed it.
  void send();

private:
  void append(const void* from, std::size_t size) {
    bytes_.append(static_cast<const char*>(from), size);
  }
  serve::ServeHeader header_;
  std::string bytes_;
};

/// Answers requests on stdin until it ends: calls `answer` with the bytes of each `solve`; what it
/// refuses by exception is sent as `refused`, and the next request is read. Returns the process's
/// exit status: 0 at the end of stdin or `quit`, 1 after a stream that is broken.
[[nodiscard]] int serve_requests(const char* program,
                                 const std::function<void(std::span<const char>)>& answer);

} // namespace tactus::fem
