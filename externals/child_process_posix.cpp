#include "externals/child_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#ifdef __APPLE__
#include <crt_externs.h>
#else
extern char** environ;
#endif

namespace tactus {
namespace {

constexpr std::size_t kMaxStderrBytes = 4096;

// Both ends close when a program starts. On macOS, which cannot make them so, a program that
// another thread starts between the two calls keeps them.
#ifdef __APPLE__
bool close_on_start(const std::array<int, 2>& ends) {
  return ::fcntl(ends[0], F_SETFD, FD_CLOEXEC) == 0 && ::fcntl(ends[1], F_SETFD, FD_CLOEXEC) == 0;
}
bool open_socket_pair(std::array<int, 2>& ends) {
  const int on = 1; // a send() raises no SIGPIPE
  return ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0 && close_on_start(ends) &&
         ::setsockopt(ends[0], SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on) == 0;
}
bool open_pipe(std::array<int, 2>& ends) {
  return ::pipe(ends.data()) == 0 && close_on_start(ends);
}
char** environment() { return *_NSGetEnviron(); }
#else
bool open_socket_pair(std::array<int, 2>& ends) {
  return ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0;
}
bool open_pipe(std::array<int, 2>& ends) { return ::pipe2(ends.data(), O_CLOEXEC) == 0; }
char** environment() { return environ; }
#endif

/// Owns a file descriptor and closes it.
class Descriptor {
public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void reset(int number = -1) {
    if (number_ >= 0)
      ::close(number_);
    number_ = number;
  }
  /// Moves the descriptor above 0, 1 and 2: the child's stdin, stdout and stderr get these numbers.
  [[nodiscard]] bool move_above_stderr() {
    if (number_ > STDERR_FILENO)
      return true;
    const int duplicate = ::fcntl(number_, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    reset(duplicate);
    return duplicate >= 0;
  }
  [[nodiscard]] int get() const { return number_; }
  [[nodiscard]] int release() { return std::exchange(number_, -1); }

private:
  int number_;
};

/// The state with which the child starts: its three streams, no other open file of this process,
/// and default signal handling.
struct Surroundings {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};

  Surroundings(int stream, int errors) {
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, stream, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, stream, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, errors, STDERR_FILENO);
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 34)
    posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
#endif
    posix_spawnattr_init(&attributes);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    sigdelset(&all, SIGKILL);
    sigdelset(&all, SIGSTOP);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
#ifdef __APPLE__
    flags |= POSIX_SPAWN_CLOEXEC_DEFAULT;
#endif
    posix_spawnattr_setflags(&attributes, flags);
  }
  ~Surroundings() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
  Surroundings(const Surroundings&) = delete;
  Surroundings& operator=(const Surroundings&) = delete;
};

std::string last_line(const std::string& text) {
  const std::size_t last = text.find_last_not_of("\r\n");
  if (last == std::string::npos)
    return {};
  const std::size_t before = text.find_last_of("\r\n", last); // npos + 1 is 0
  return text.substr(before + 1, last - before);
}

bool set_nonblocking(int descriptor) { return ::fcntl(descriptor, F_SETFL, O_NONBLOCK) == 0; }

} // namespace

struct ChildProcess::Process {
  pid_t child = -1; ///< -1 once reaped
  int status = 0;
  int stream = -1, errors = -1;
  std::string stderr_tail; ///< last part of its stderr

  void read_errors();
  [[nodiscard]] bool has_ended(int options);
};

ChildProcess::ChildProcess(std::unique_ptr<Process> process) : process_(std::move(process)) {}

std::unique_ptr<ChildProcess> ChildProcess::start(const std::vector<std::string>& words,
                                                  std::string& refusal) {
  const auto failed = [&](const char* what, int error) {
    refusal = std::string(what) + ": " + std::strerror(error);
    return nullptr;
  };
  // A socket pair serves stdin and stdout: send() with MSG_NOSIGNAL raises no SIGPIPE on it.
  std::array<int, 2> ends{};
  if (!open_socket_pair(ends))
    return failed("cannot create a pipe to the program", errno);
  Descriptor parent_end(ends[0]), child_end(ends[1]);
  if (!open_pipe(ends))
    return failed("cannot create a pipe to the program", errno);
  Descriptor errors(ends[0]), child_stderr(ends[1]);
  if (!child_end.move_above_stderr() || !child_stderr.move_above_stderr() ||
      !set_nonblocking(parent_end.get()) || !set_nonblocking(errors.get()))
    return failed("cannot create a pipe to the program", errno);
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words)
    arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const Surroundings surroundings(child_end.get(), child_stderr.get());
  auto process = std::make_unique<Process>();
  if (const int error = ::posix_spawn(&process->child, words[0].c_str(), &surroundings.files,
                                      &surroundings.attributes, arguments.data(), environment());
      error != 0)
    return failed((words[0] + ": cannot start").c_str(), error);
  process->stream = parent_end.release();
  process->errors = errors.release();
  return std::unique_ptr<ChildProcess>(new ChildProcess(std::move(process)));
}

ChildProcess::~ChildProcess() { static_cast<void>(end(0)); }

std::size_t ChildProcess::send(std::span<const std::byte> bytes) {
  for (;;) {
    const ssize_t count = ::send(process_->stream, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count >= 0)
      return static_cast<std::size_t>(count);
    if (errno != EINTR)
      return 0;
  }
}

bool ChildProcess::receive(std::vector<std::byte>& into, std::size_t limit) {
  process_->read_errors();
  constexpr std::size_t kPiece = 1 << 18;
  while (limit > 0) {
    const std::size_t before = into.size(), piece = std::min(limit, kPiece);
    into.resize(before + piece);
    const ssize_t count = ::recv(process_->stream, into.data() + before, piece, 0);
    const int error = errno;
    into.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count == 0 || (count < 0 && error != EINTR && error != EAGAIN))
      return false;
    if (count < 0 && error == EAGAIN)
      return true;
    limit -= static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  return true;
}

void ChildProcess::wait(double seconds) {
  std::array<pollfd, 1> watched{{{process_->stream, POLLIN, 0}}};
  static_cast<void>(::poll(watched.data(), 1, static_cast<int>(std::ceil(1e3 * seconds))));
}

void ChildProcess::Process::read_errors() {
  std::array<char, 1024> piece{};
  for (int i = 0; i < 64; ++i) { // bounded: the child may never stop writing
    const ssize_t count = ::read(errors, piece.data(), piece.size());
    if (count <= 0)
      return;
    stderr_tail.append(piece.data(), static_cast<std::size_t>(count));
    if (stderr_tail.size() > kMaxStderrBytes)
      stderr_tail.erase(0, stderr_tail.size() - kMaxStderrBytes);
  }
}

/// True once the child has ended, even if another part of the process has reaped it.
bool ChildProcess::Process::has_ended(int options) {
  pid_t found = 0;
  do
    found = ::waitpid(child, &status, options);
  while (found < 0 && errno == EINTR);
  return found != 0;
}

std::string ChildProcess::end(double grace_s) {
  Process& p = *process_;
  if (p.child >= 0) {
    ::shutdown(p.stream, SHUT_RDWR);
    bool ended = p.has_ended(WNOHANG);
    for (; !ended && grace_s > 0; grace_s -= 1e-3) {
      ::usleep(1000);
      ended = p.has_ended(WNOHANG);
    }
    if (!ended) {
      ::kill(p.child, SIGKILL);
      static_cast<void>(p.has_ended(0));
    }
    p.child = -1;
    p.read_errors();
    ::close(p.stream);
    ::close(p.errors);
  }
  if (std::string line = last_line(p.stderr_tail); !line.empty())
    return line;
  return WIFSIGNALED(p.status) ? "signal " + std::to_string(WTERMSIG(p.status))
                               : "status " + std::to_string(WEXITSTATUS(p.status));
}

} // namespace tactus
