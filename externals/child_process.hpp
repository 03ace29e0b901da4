#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tactus {

/// A program that runs as a child process. Sending to its stdin and receiving from its stdout do
/// not block; its output on stderr is stored for error texts. The destructor kills the child and
/// reaps it. The child sees the end of its stdin when this process ends, for whatever reason. Not
/// safe for use by two threads at once. Implemented in child_process_posix.cpp and
/// child_process_windows.cpp.
class ChildProcess {
public:
  /// Starts a program: words[0] is its path. On failure returns null and sets `refusal`.
  [[nodiscard]] static std::unique_ptr<ChildProcess> start(const std::vector<std::string>& words,
                                                           std::string& refusal);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Sends as many bytes as the pipe accepts now and returns their number. Raises no SIGPIPE: if
  /// the child has closed its stdin, nothing is sent, and receive() reports the end.
  [[nodiscard]] std::size_t send(std::span<const std::byte> bytes);
  /// Appends up to `limit` bytes that have arrived. Returns false at the end of the child's stdout.
  [[nodiscard]] bool receive(std::vector<std::byte>& into, std::size_t limit);
  /// Waits for bytes from the child or for its end.
  void wait(double seconds);
  /// Closes the child's streams, kills the child if it still runs after grace_s, and reaps it.
  /// Returns how the child ended: its last line on stderr, else its exit status or the signal.
  [[nodiscard]] std::string end(double grace_s);

private:
  struct Process; ///< depends on the system
  explicit ChildProcess(std::unique_ptr<Process> process);

  std::unique_ptr<Process> process_;
};

} // namespace tactus
