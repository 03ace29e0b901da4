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

/// A child's text as one line of at most 300 bytes, control characters replaced by spaces.
[[nodiscard]] std::string printable_line(std::string_view text);

static_assert(std::endian::native == std::endian::little, "messages are copied byte by byte");

/// The value at an offset; `bytes` must be long enough.
template <class T>
[[nodiscard]] T value_at(std::span<const std::byte> bytes, std::size_t offset = 0) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// A child process `part_stress serve` or `modal_fem serve`: sends requests and receives answers
/// without blocking, with a time limit for each (core/serve/protocol.hpp). Not thread-safe.
class ServedProgram {
public:
  struct Message {
    serve::ServeKind kind = serve::ServeKind::refused;
    std::vector<std::byte> payload;
  };
  /// True if a header belongs to the expected answer.
  using Expects = std::function<bool(const serve::ServeHeader&)>;

  /// Starts the program words[0], a path, with arguments `words`. `name` is the program's name in
  /// error texts; `limit_s` is the time limit of its first message. On failure returns null and
  /// sets `refusal`.
  [[nodiscard]] static std::unique_ptr<ServedProgram> start(const std::vector<std::string>& words,
                                                            std::string name, double limit_s,
                                                            std::string& refusal);

  /// Sends a request, whose answer must arrive within `limit_s`.
  void send_request(serve::ServeKind kind, std::span<const std::byte> payload, double limit_s);
  /// Waits for bytes from the child, or for its end, for at most this time.
  void wait(double seconds) { child_->wait(seconds); }
  /// Sends and receives as much as the pipes allow now. Returns a message once it is complete. Sets
  /// `lost` if the child has ended, has sent something unexpected (such as a refusal of more than
  /// 4096 bytes) or exceeds its time or the memory. This object must then be destroyed.
  [[nodiscard]] std::optional<Message> poll(const Expects& expects, std::string& lost);

private:
  using Clock = std::chrono::steady_clock;
  void set_limit(double seconds);
  [[nodiscard]] std::optional<Message> exchange(const Expects& expects, std::string& lost);

  std::string name_;
  std::unique_ptr<ChildProcess> child_;
  bool awaiting_response_ = true;
  Clock::time_point limit_;
  double limit_s_ = 0;
  std::vector<std::byte> out_, in_;
  std::size_t sent_ = 0;
};

} // namespace tactus
