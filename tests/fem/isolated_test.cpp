// The child process that reads foreign files: whatever happens in it, one sentence comes back.
#include "fem/io/isolated_process.hpp"

#include "fem/io/mesh_bytes.hpp"
#include "fem/io/sandbox.hpp"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <termios.h>
#include <thread>
#include <unistd.h>

using namespace tactus::fem;

namespace {

Mesh tetrahedron() {
  Mesh mesh;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.regions = {"horn"};
  mesh.add(Shape::tet4, std::array{0, 1, 2, 3});
  mesh.node_sets["foot"] = {0, 2};
  return mesh;
}

/// What run_isolated() says of a child that does this, or "" when it returns a mesh. No process
/// is left behind in either case.
std::string outcome(const std::function<void()>& action, ChildLimits limits = {1u << 30, 20}) {
  std::string error_text;
  try {
    (void)run_isolated("a.step", limits, {}, [&](const ChildProgress&) {
      action();
      return tetrahedron();
    });
  } catch (const InputError& refusal) {
    error_text = refusal.what();
  }
  CHECK(waitpid(-1, nullptr, WNOHANG) == -1);
  CHECK(errno == ECHILD);
  CHECK(error_text.find('\n') == std::string::npos);
  return error_text;
}

void ends(const std::string& words, const std::function<void()>& action,
          ChildLimits limits = {1u << 30, 20}) {
  const std::string said = outcome(action, limits);
  CAPTURE(said);
  CHECK(said.find(words) != std::string::npos);
}

/// Never inlined, never foreseen by the compiler.
volatile int* volatile g_nowhere = nullptr;
volatile bool g_forever = true;

} // namespace

TEST_CASE("mesh, sentences and stages come back whole") {
  std::vector<std::string> error_text, stages;
  const Mesh mesh =
      run_isolated("a.step", {1u << 30, 20},
                   {[&](const std::string& sentence) { error_text.push_back(sentence); },
                    [&](const std::string& stage, double share) {
                      stages.push_back(stage + " " + std::to_string(share));
                    }},
                   [](const ChildProgress& progress) {
                     progress.notify("first\x1b[2J");
                     progress.report("meshing", .5);
                     progress.notify(std::string(100000, 'x'));
                     return tetrahedron();
                   });
  CHECK(to_bytes(mesh) == to_bytes(tetrahedron()));
  REQUIRE(error_text.size() == 2);
  CHECK(error_text[0] == "first?[2J");
  CHECK(error_text[1].size() == 4096);
  CHECK(stages == std::vector<std::string>{"meshing 0.500000"});
}

TEST_CASE("a refusal, a crash, an exit and a kill come back as one sentence with the file") {
  CHECK(outcome([] { throw InputError("a.step: no solid"); }) == "a.step: no solid");
  CHECK(outcome([] { throw std::logic_error("odd"); }) == "odd");
  ends("failed", [] { throw 7; });
  if (!under_address_sanitizer()) {
    ends("a.step: the reader crashed (an invalid memory access", [] { *g_nowhere = 1; });
    ends("a failed internal check", [] { std::abort(); });
  }
  ends(under_address_sanitizer() ? "a.step" : "division", [] { std::raise(SIGFPE); });
  ends("status 3", [] { _exit(3); });
  if (!under_address_sanitizer()) // whose search for leaks at the end is refused
    ends("without an answer", [] { std::exit(0); });
}

TEST_CASE("memory is limited, in new and in malloc") {
  if (under_address_sanitizer())
    return;
  const ChildLimits limits{200u << 20, 20};
  const auto fill = [] {
    std::vector<std::vector<char>> all;
    while (g_forever)
      all.emplace_back(1 << 20, 'x');
  };
  const auto write_unchecked = [] { // as C code does that looks at no result
    while (g_forever)
      std::memset(std::malloc(1 << 20), 1, 1 << 20);
  };
  ends(
      "0.21 GB", [] { std::vector<char> v(std::size_t{1} << 40); }, limits);
  ends("--memory", fill, limits);
  ends("--memory", write_unchecked, limits);
}

TEST_CASE("silence is limited, progress is not silence") {
  const auto spin = [] {
    while (g_forever) {
    }
  };
  ends("--time-limit", spin, {1u << 30, .5});
  ends("--time-limit", [] { pause(); }, {1u << 30, .5});
  // Longer than a busy machine's stalls.
  const Mesh mesh = run_isolated("a.step", {1u << 30, 2}, {}, [](const ChildProgress& progress) {
    for (int i = 0; i < 25; ++i) {
      progress.report("meshing", i / 25.);
      usleep(100000);
    }
    return tetrahedron();
  });
  CHECK(mesh.elements.size() == 1);
}

namespace {

/// Runs in a process whose controlling terminal is a terminal of this test, as under a user's
/// shell. True if action() came back.
bool on_terminal(const std::function<void(const char* terminal)>& action) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY);
  REQUIRE((master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0));
  const std::string terminal = ptsname(master);
  const pid_t user = fork();
  if (user == 0) {
    setsid();
    open(terminal.c_str(), O_RDWR); // becomes the controlling terminal
    const int tty = open("/dev/tty", O_RDWR);
    if (tty < 0)
      _exit(2);
    action(terminal.c_str());
    _exit(0);
  }
  int status = 1;
  while (waitpid(user, &status, 0) < 0 && errno == EINTR) {
  }
  close(master);
  return status == 0;
}

} // namespace

// Each row of the table in docs/security.md.
TEST_CASE("the reader reads files and thinks, and reaches nothing else") {
  char folder[] = "/tmp/tactus_sandbox_XXXXXX";
  REQUIRE(mkdtemp(folder));
  const std::string kept = std::string(folder) + "/kept", canary = std::string(folder) + "/canary";
  REQUIRE(close(creat(kept.c_str(), 0600)) == 0);
  const int opened = open(kept.c_str(), O_RDONLY); // not closed on exec, as a library's may be
  const int leaked = fcntl(opened, F_DUPFD, 10);   // 3 is the child's pipe
  close(opened);
  const int shared = shmget(IPC_PRIVATE, 4096, 0600);
  setenv("TACTUS_TEST_SECRET", "1", 1);
  std::signal(SIGUSR1, SIG_IGN);
  sigset_t blocked, before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGUSR2);
  sigprocmask(SIG_BLOCK, &blocked, &before);
  const auto refused = [](bool failed, const char* what) {
    if (!failed)
      throw InputError(std::string("not refused: ") + what);
  };
  const pid_t parent = getpid();
  const bool came_back = on_terminal([&](const char* terminal) {
    const std::string said = outcome([&] {
      refused(std::system(("touch " + canary).c_str()) != 0, "system");
      execl("/usr/bin/touch", "touch", canary.c_str(), static_cast<char*>(nullptr));
      refused(fork() < 0, "fork");
      refused(socket(AF_INET, SOCK_STREAM, 0) < 0, "socket");
      refused(open(canary.c_str(), O_CREAT | O_WRONLY, 0600) < 0, "creating");
      refused(open(kept.c_str(), O_WRONLY) < 0, "writing");
      refused(open(kept.c_str(), O_RDONLY | O_TRUNC) < 0, "truncating");
      refused(std::fopen(canary.c_str(), "w") == nullptr, "fopen");
      refused(mkdir(canary.c_str(), 0700) < 0, "mkdir");
      refused(rename(kept.c_str(), canary.c_str()) < 0, "rename");
      refused(symlink(kept.c_str(), canary.c_str()) < 0, "symlink");
      refused(link(kept.c_str(), canary.c_str()) < 0, "link");
      refused(unlink(kept.c_str()) < 0, "unlink");
      refused(chmod(kept.c_str(), 0777) < 0, "chmod");
      refused(syscall(452, AT_FDCWD, kept.c_str(), 0777, 0) < 0 && errno == ENOSYS, "fchmodat2");
      refused(kill(parent, SIGTERM) < 0, "kill");
      char byte = 0;
      refused(read(STDIN_FILENO, &byte, 1) == 0, "reading stdin");
      // The terminal.
      refused(open("/dev/tty", O_RDONLY) < 0, "/dev/tty");
      refused(getsid(0) == getpid(), "the terminal's session");
      const int tty = open(terminal, O_RDONLY | O_NOCTTY);
      refused(tty >= 0, "(reading must work)");
      refused(ioctl(tty, TIOCSTI, "x") < 0, "typing");
      refused(ioctl(tty, TIOCSCTTY, 0) < 0, "taking the terminal");
      termios modes{};
      refused(tcgetattr(tty, &modes) < 0, "the terminal's modes");
      close(tty);
      // What it inherits.
      refused(fcntl(leaked, F_GETFD) < 0, "an open file");
      for (int number = 4; number < 1024; ++number)
        refused(fcntl(number, F_GETFD) < 0, "an open file");
      refused(!std::getenv("TACTUS_TEST_SECRET") && (!environ || !*environ), "the environment");
      struct sigaction action {};
      sigset_t mask;
      sigaction(SIGUSR1, nullptr, &action);
      sigprocmask(SIG_BLOCK, nullptr, &mask);
      refused(under_address_sanitizer() || // which keeps its own
                  (action.sa_handler == SIG_DFL && !sigismember(&mask, SIGUSR2)),
              "signals");
      std::array<std::uint32_t, 2> header{0x20080522, 0};
      std::array<std::uint32_t, 6> capabilities{};
      syscall(SYS_capget, header.data(), capabilities.data());
      refused((capabilities[0] & ~4U) == 0 && capabilities[3] == 0, "capabilities");
      // Other processes of the user.
      std::array<int, 2> ends{};
      refused(pipe(ends.data()) == 0, "(a pipe must work)");
      refused(fcntl(ends[0], F_SETOWN, parent) < 0, "a signal by F_SETOWN");
      refused(fcntl(ends[0], F_SETSIG, SIGKILL) < 0, "a signal by F_SETSIG");
      refused(setpriority(PRIO_PROCESS, static_cast<id_t>(parent), 19) < 0, "priority");
      cpu_set_t one{};
      CPU_SET(0, &one);
      refused(sched_setaffinity(parent, sizeof one, &one) < 0, "affinity");
      refused(shmat(shared, nullptr, 0) == reinterpret_cast<void*>(-1), "shared memory");
      refused(shmctl(shared, IPC_RMID, nullptr) < 0, "removing shared memory");
      const int reading = open(kept.c_str(), O_RDONLY);
      refused(reading >= 0, "(reading must work)");
      refused(flock(reading, LOCK_EX) < 0, "flock");
      struct flock lock {};
      lock.l_type = F_RDLCK;
      refused(fcntl(reading, F_SETLK, &lock) < 0, "a lock");
      refused(syscall(SYS_request_key, "user", "x", nullptr, 0) < 0 && errno == EPERM, "keys");
      // Limits, by a pointer whose lower half is zero, too; and its own end.
      rlimit limit{};
      refused(setrlimit(RLIMIT_NOFILE, &limit) < 0, "setrlimit");
      void* const even =
          mmap(reinterpret_cast<void*>(std::uintptr_t{1} << 40), 4096, PROT_READ | PROT_WRITE,
               MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
      refused(even != MAP_FAILED, "(memory there)");
      refused(syscall(SYS_prlimit64, parent, RLIMIT_CORE, even, nullptr) < 0, "another's limits");
      refused(prctl(PR_SET_PDEATHSIG, 0) < 0, "outliving the program");
      std::atomic<int> ran{0};
      std::thread([&] { ran = 1; }).join();
      refused(ran == 1, "(threads must work)");
    });
    if (!said.empty()) {
      std::fprintf(stderr, "%s\n", said.c_str());
      _exit(1);
    }
  });
  CHECK(came_back);
  sigprocmask(SIG_SETMASK, &before, nullptr);
  std::signal(SIGUSR1, SIG_DFL);
  shmctl(shared, IPC_RMID, nullptr);
  close(leaked);
  CHECK(access(kept.c_str(), F_OK) == 0);
  CHECK(unlink(kept.c_str()) == 0);
  CHECK(rmdir(folder) == 0); // nothing else is in it
}

TEST_CASE("the parent believes no message") {
  // The child's end of the pipe is descriptor 3.
  const auto sent = [](const char* words, const std::string& bytes) {
    ends(words, [&] {
      CHECK(write(3, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
      _exit(0);
    });
  };
  const auto message = [](std::uint32_t kind, std::uint64_t size, const std::string& content) {
    const std::array<std::uint32_t, 2> head{kind, 0};
    std::string bytes(reinterpret_cast<const char*>(head.data()), 8);
    return bytes.append(reinterpret_cast<const char*>(&size), 8) + content;
  };
  constexpr std::uint32_t kNotify = 0x74610001, kReport = kNotify + 1, kMesh = kNotify + 2,
                          kRefusal = kNotify + 3;
  sent("without an answer", "nonsense");
  sent("an invalid answer", std::string(100, 'x'));
  sent("an invalid answer", message(kNotify, 1u << 20, ""));
  sent("without an answer", message(kReport, 3, "abc")); // nobody wants reports here
  sent("an invalid answer", message(kMesh, ~std::uint64_t{0}, ""));
  sent("without an answer", message(kMesh, 1u << 29, "few"));
  sent("damaged", message(kMesh, 0, ""));
  sent("a?b?[2J c", message(kRefusal, 9, "a\nb\x1b[2J c"));
  sent("an invalid answer", message(kNotify, 5, "hello") + message(99, 0, ""));
}

TEST_CASE("no damaged bytes of a mesh are taken for one that would be used out of range") {
  const std::string whole = to_bytes(tetrahedron());
  CHECK(to_bytes(mesh_from_bytes(whole)) == whole);
  for (std::size_t size = 0; size < whole.size(); ++size)
    CHECK_THROWS_AS((void)mesh_from_bytes(whole.substr(0, size)), InputError);
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const int flip : {1, 0x80, 0xff}) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ flip);
      try {
        const Mesh mesh = mesh_from_bytes(bytes);
        for (const Element& e : mesh.elements)
          for (const int n : mesh.nodes_of(e))
            CHECK((n >= 0 && static_cast<std::size_t>(n) < mesh.nodes.size()));
      } catch (const InputError&) {
      }
    }
}
