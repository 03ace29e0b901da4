#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tactus {

/// A program that runs as a child: bytes to its stdin and from its stdout, none of which blocks;
/// what it says on stderr is kept for an error. The destructor kills and reaps it. It sees the end
/// of its stdin when this process ends, however that happens. Not safe for use by two threads at
/// once. child_process_posix.cpp, child_process_windows.cpp.
class ChildProcess {
public:
  /// Runs a program: words[0] is its path. Null after a reason.
  [[nodiscard]] static std::unique_ptr<ChildProcess> start(const std::vector<std::string>& words,
                                                           std::string& refusal);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Sends what the pipe takes now; how many bytes. Raises no SIGPIPE: nothing is sent to a child
  /// that has closed its stdin, which receive() tells.
  [[nodiscard]] std::size_t send(std::span<const std::byte> bytes);
  /// Appends up to `limit` bytes that wait. False at the end of the child's stdout.
  [[nodiscard]] bool receive(std::vector<std::byte>& into, std::size_t limit);
  /// Waits for bytes from the child or for its end.
  void wait(double seconds);
  /// Closes its streams, kills it if it still runs after the grace, and reaps it. How it ended: its
  /// last line on stderr, else its exit status or the signal.
  [[nodiscard]] std::string end(double grace_s);

private:
  struct Process; ///< of the system
  explicit ChildProcess(std::unique_ptr<Process> process);

  std::unique_ptr<Process> process_;
};

} // namespace tactus
