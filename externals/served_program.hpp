#pragma once

#include "core/serve/protocol.hpp"
#include "externals/child_process.hpp"

#include <bit>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tactus {

/// The program of that name beside the module that this code is part of, else in PATH; or the one
/// that is given instead, a path if it has a slash. Empty when there is none that can be run.
[[nodiscard]] std::string find_program(const char* name, const std::string& given);

/// What a child says, on one line of at most 300 bytes.
[[nodiscard]] std::string printable_line(std::string_view text);

static_assert(std::endian::native == std::endian::little, "messages are copied as they lie");

/// The value that lies at an offset; there must be as many bytes.
template <class T>
[[nodiscard]] T value_at(std::span<const std::byte> bytes, std::size_t offset = 0) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// `part_stress serve` or `modal_fem serve` as a child process: messages to and from it, none of
/// which blocks, with a limit of time for each answer (core/serve/protocol.hpp). Not safe for
/// use by two threads at once.
class ServedProgram {
public:
  struct Message {
    serve::ServeKind kind = serve::ServeKind::refused;
    std::vector<std::byte> payload;
  };
  /// Whether a header is that of an answer that is awaited now.
  using Expects = std::function<bool(const serve::ServeHeader&)>;

  /// Runs `words`, words[0] a path; null after a reason. `name`: of the program, for sentences.
  [[nodiscard]] static std::unique_ptr<ServedProgram> start(const std::vector<std::string>& words,
                                                            std::string name, double limit_s,
                                                            std::string& refusal);

  /// Sends a request, whose answer is awaited for so long.
  void send_request(serve::ServeKind kind, std::span<const std::byte> payload, double limit_s);
  /// Waits for bytes from the child or for its end.
  void wait(double seconds) { child_->wait(seconds); }
  /// Sends and receives what the pipes take. A message when one is whole; none, and the reason in
  /// `lost`, when the child has ended, sends what is not expected, takes too long or more memory
  /// than there is: it must then be given up. Of a refusal at most 4096 bytes are taken.
  [[nodiscard]] std::optional<Message> poll(const Expects& expects, std::string& lost);

private:
  using Clock = std::chrono::steady_clock;
  void set_limit(double seconds);
  [[nodiscard]] std::optional<Message> exchange(const Expects& expects, std::string& lost);

  std::string name_;
  std::unique_ptr<ChildProcess> child_;
  bool awaiting_response_ = true; ///< an answer
  Clock::time_point limit_;
  double limit_s_ = 0;
  std::vector<std::byte> out_, in_;
  std::size_t sent_ = 0;
};

} // namespace tactus
