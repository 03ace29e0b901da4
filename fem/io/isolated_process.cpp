#include "fem/io/isolated_process.hpp"

#include "fem/io/mesh_bytes.hpp"
#include "fem/io/sandbox.hpp"
#include "fem/io/text.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <optional>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tactus::fem {
namespace {

using Clock = std::chrono::steady_clock;

/// A message to the parent: this header, then `size` bytes.
enum class Kind : std::uint32_t { notify = 0x7461'0001, report, mesh, refusal, no_memory };
struct Header {
  Kind kind;
  std::uint32_t zero;
  std::uint64_t size;
};
constexpr std::size_t kMaxText = 4096;

std::atomic<pid_t> g_child{0};

// ---- in the child process

int g_pipe = -1;

/// Async-signal-safe and without allocation. Ends the child if the parent no longer reads.
void send(Kind kind, const char* bytes, std::size_t size) noexcept {
  const auto write_all = [](const char* from, std::size_t left) {
    while (left > 0) {
      const ssize_t written = write(g_pipe, from, left);
      if (written < 0 && errno == EINTR)
        continue;
      if (written <= 0)
        _exit(1);
      from += written;
      left -= static_cast<std::size_t>(written);
    }
  };
  const Header header{kind, 0, size};
  std::array<char, sizeof header> raw;
  std::memcpy(raw.data(), &header, sizeof header);
  write_all(raw.data(), raw.size());
  write_all(bytes, size);
}

void send_text(Kind kind, const std::string& text) noexcept {
  send(kind, text.data(), std::min(text.size(), kMaxText));
}

[[noreturn]] void out_of_memory() {
  send(Kind::no_memory, "", 0);
  _exit(0);
}

[[noreturn]] void run_child(int pipe_end, pid_t parent, const ChildLimits& limits,
                            const std::function<Mesh(const ChildProgress&)>& work) noexcept {
  prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  if (getppid() != parent)
    _exit(1);
  leave_terminal_and_environment();
  std::signal(SIGPIPE, SIG_IGN);
  const int null_device = open("/dev/null", O_RDWR);
  if (null_device < 0)
    _exit(1); // otherwise stdin and stdout would remain the parent's
  dup2(null_device, STDIN_FILENO);
  dup2(null_device, STDOUT_FILENO); // the CAD kernel prints its statistics
  if (!under_address_sanitizer())   // the sanitizer reports on stderr
    dup2(null_device, STDERR_FILENO);
  g_pipe = dup2(pipe_end, STDERR_FILENO + 1);
  if (close_range(static_cast<unsigned>(g_pipe) + 1, ~0U, 0) != 0) // before Linux 5.9
    for (int open_file = g_pipe + 1; open_file < sysconf(_SC_OPEN_MAX); ++open_file)
      close(open_file);
  std::set_new_handler(out_of_memory);
  const double cpu = std::min(8 * limits.progress_timeout_s + 60, 1e9);
  enter_sandbox(limits.memory_bytes, static_cast<std::uint64_t>(cpu));
  try {
    const ChildProgress progress{
        [](const std::string& sentence) { send_text(Kind::notify, sentence); },
        [](const std::string& stage, double share) {
          std::string bytes(sizeof share, '\0');
          std::memcpy(bytes.data(), &share, sizeof share);
          send_text(Kind::report, bytes + stage);
        }};
    const std::string bytes = to_bytes(work(progress));
    send(Kind::mesh, bytes.data(), bytes.size());
  } catch (const std::bad_alloc&) {
    out_of_memory();
  } catch (const std::exception& error) {
    send_text(Kind::refusal, error.what());
  } catch (...) {
    send_text(Kind::refusal, "the reader failed: unknown error");
  }
  _exit(0); // without flushing or destroying the parent's objects a second time
}

// ---- in the parent process

std::uint64_t half_of_free_memory() {
  unsigned long long kilobytes = 0;
  if (std::FILE* file = std::fopen("/proc/meminfo", "r")) {
    std::array<char, 128> line;
    while (std::fgets(line.data(), static_cast<int>(line.size()), file))
      if (std::sscanf(line.data(), "MemAvailable: %llu", &kilobytes) == 1)
        break;
    std::fclose(file);
  }
  return std::max<std::uint64_t>(kilobytes * 512, std::uint64_t{256} << 20);
}

/// Resident memory of the process, bytes; 0 if it cannot be read.
std::uint64_t resident(pid_t process) {
  unsigned long long all = 0, pages = 0;
  if (std::FILE* file = std::fopen(format("/proc/%d/statm", process).c_str(), "r")) {
    if (std::fscanf(file, "%llu %llu", &all, &pages) != 2)
      pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// The child process. The destructor kills it and waits for it.
class Child {
public:
  explicit Child(pid_t process, int pipe_end) : process_(process), pipe_(pipe_end) {
    g_child = process;
  }
  ~Child() {
    close(pipe_);
    (void)end();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Kills it, and returns its status.
  int end() noexcept {
    if (process_ <= 0)
      return status_;
    kill(process_, SIGKILL);
    while (wait4(process_, &status_, 0, &usage_) < 0 && errno == EINTR) {
    }
    forget();
    return status_;
  }
  /// The child's status after its end of the pipe has closed. The child has two seconds to end by
  /// itself.
  int wait_for_exit() noexcept {
    for (int tries = 0; tries < 200; ++tries) {
      if (wait4(process_, &status_, WNOHANG, &usage_) == process_) {
        forget();
        return status_;
      }
      poll(nullptr, 0, 10);
    }
    return end();
  }
  [[nodiscard]] pid_t process() const noexcept { return process_; }
  [[nodiscard]] int pipe() const noexcept { return pipe_; }
  [[nodiscard]] std::uint64_t peak_bytes() const noexcept {
    return 1024 * static_cast<std::uint64_t>(usage_.ru_maxrss);
  }

private:
  void forget() noexcept { process_ = g_child = 0; }

  pid_t process_;
  int pipe_, status_ = 0;
  rusage usage_{};
};

const char* name_of(int signal_number) {
  switch (signal_number) {
  case SIGSEGV:
    return "an invalid memory access";
  case SIGBUS:
    return "a memory access beyond a file's end";
  case SIGFPE:
    return "a division by zero";
  case SIGILL:
    return "an invalid instruction";
  case SIGABRT:
    return "a failed internal check";
  case SIGSYS:
    return "a forbidden system call";
  default:
    return "a signal";
  }
}

std::string printable_value(double value) { return format("%.3g", value); }

/// Error texts for a child process that ended without a mesh.
class ChildErrors {
public:
  ChildErrors(const std::string& file, const ChildLimits& limits)
      : file_(printable(file, 300)), limits_(limits) {}

  [[nodiscard]] InputError memory() const {
    return InputError(
        file_ + ": reading and meshing need more than " +
        printable_value(1e-9 * static_cast<double>(limits_.memory_bytes)) +
        " GB: use a coarser mesh (--h) or allow more memory (--memory); else the file is "
        "damaged");
  }
  [[nodiscard]] InputError silence() const {
    return InputError(file_ + ": reading and meshing made no progress in " +
                      format("%.5g", limits_.progress_timeout_s) +
                      " s and were stopped: use a coarser mesh (--h) or wait longer (--time-limit "
                      "SECONDS); else the file is damaged");
  }
  [[nodiscard]] InputError damaged() const {
    return InputError(file_ + ": the reader process sent an invalid answer");
  }
  [[nodiscard]] InputError death(int status, std::uint64_t peak) const {
    if (!WIFSIGNALED(status))
      return InputError(file_ + ": the reader ended without an answer (status " +
                        std::to_string(WEXITSTATUS(status)) +
                        "); the file is damaged or not supported: export it again");
    const int signal_number = WTERMSIG(status);
    if (signal_number == SIGXCPU)
      return silence();
    if (signal_number == SIGINT || signal_number == SIGTERM)
      return InputError(file_ + ": reading was interrupted");
    if (signal_number == SIGKILL)
      return InputError(
          file_ + ": the system stopped the reader, probably for lack of memory: use a coarser "
                  "mesh (--h)");
    if (static_cast<double>(peak) > .7 * static_cast<double>(limits_.memory_bytes))
      return memory(); // the CAD kernel does not check its allocations
    return InputError(
        file_ + ": the reader crashed (" + name_of(signal_number) +
        "); the file is damaged or not supported: repair it, or export it again from the "
        "program that made it");
  }

private:
  std::string file_;
  ChildLimits limits_;
};

/// Splits the received bytes into messages. Lengths are checked before they are used.
class MessageReader {
public:
  MessageReader(const ChildErrors& child_errors, const ChildLimits& limits,
                const ChildProgress& progress)
      : child_errors_(child_errors), limits_(limits), progress_(progress) {}

  /// Returns the mesh once it is complete.
  std::optional<Mesh> take(const char* from, std::size_t size) {
    bytes_.append(from, size);
    while (true) {
      if (bytes_.size() - at_ < sizeof(Header))
        break;
      Header header{};
      std::memcpy(&header, bytes_.data() + at_, sizeof header);
      const bool text = header.kind != Kind::mesh;
      if (header.zero != 0 || header.kind < Kind::notify || header.kind > Kind::no_memory ||
          header.size > (text ? kMaxText : limits_.memory_bytes))
        throw child_errors_.damaged();
      if (bytes_.size() - at_ - sizeof header < header.size)
        break;
      const std::string_view content = std::string_view(bytes_).substr(
          at_ + sizeof header, static_cast<std::size_t>(header.size));
      if (header.kind == Kind::mesh)
        return mesh_from_bytes(content);
      deliver(header.kind, content);
      at_ += sizeof header + content.size();
    }
    bytes_.erase(0, at_);
    at_ = 0;
    return std::nullopt;
  }

private:
  void deliver(Kind kind, std::string_view content) const {
    if (kind == Kind::no_memory)
      throw child_errors_.memory();
    if (kind == Kind::refusal)
      throw InputError(printable(content, kMaxText));
    if (kind == Kind::notify && progress_.notify)
      progress_.notify(printable(content, kMaxText));
    if (kind == Kind::report && progress_.report) {
      double share = 0;
      if (content.size() < sizeof share)
        throw child_errors_.damaged();
      std::memcpy(&share, content.data(), sizeof share);
      if (std::isfinite(share))
        progress_.report(printable(content.substr(sizeof share), kMaxText),
                         std::clamp(share, 0.0, 1.0));
    }
  }

  ChildErrors child_errors_;
  ChildLimits limits_;
  const ChildProgress& progress_;
  std::string bytes_;
  std::size_t at_ = 0;
};

} // namespace

void end_isolated_child() noexcept {
  const pid_t child = g_child.exchange(0);
  if (child <= 0)
    return;
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

Mesh run_isolated(const std::string& file, const ChildLimits& requested,
                  const ChildProgress& progress,
                  const std::function<Mesh(const ChildProgress&)>& work) {
  ChildLimits limits = requested;
  if (limits.memory_bytes == 0)
    limits.memory_bytes = half_of_free_memory();
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw InputError("cannot start a process to read " + file + ": " + std::strerror(errno));
  std::fflush(nullptr);
  const pid_t parent = getpid();
  const pid_t process = fork();
  if (process == 0)
    run_child(ends[1], parent, limits, work);
  close(ends[1]);
  if (process < 0) {
    close(ends[0]);
    throw InputError("cannot start a process to read " + file + ": " + std::strerror(errno));
  }
  Child child(process, ends[0]);
  const ChildErrors child_errors(file, limits);
  MessageReader inbox(child_errors, limits, progress);
  auto last_progress = Clock::now();
  std::array<char, 1 << 16> buffer;
  while (true) {
    pollfd waiting{child.pipe(), POLLIN, 0};
    const int ready = poll(&waiting, 1, 200);
    if (ready < 0 && errno != EINTR)
      throw child_errors.damaged();
    if (ready > 0) {
      const ssize_t size = read(child.pipe(), buffer.data(), buffer.size());
      if (size == 0) {
        const int status = child.wait_for_exit();
        throw child_errors.death(status, child.peak_bytes());
      }
      if (size > 0) {
        last_progress = Clock::now();
        if (auto mesh = inbox.take(buffer.data(), static_cast<std::size_t>(size)))
          return std::move(*mesh);
      }
    }
    if (std::chrono::duration<double>(Clock::now() - last_progress).count() >
        limits.progress_timeout_s)
      throw child_errors.silence();
    if (resident(child.process()) > limits.memory_bytes + (std::uint64_t{256} << 20))
      throw child_errors.memory(); // if the address space is not limited
  }
}

} // namespace tactus::fem
