#include "tests/devices/mock/child.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tactus::mock {
namespace {

// Lines out of a descriptor, as they come.
struct Lines {
  int from, to;
  std::string rest{};

  bool serve(const std::function<std::string(const std::string&)>& answer) {
    std::array<char, 512> buffer{};
    const ssize_t got = ::read(from, buffer.data(), buffer.size());
    if (got <= 0)
      return got < 0 && errno == EINTR;
    rest.append(buffer.data(), static_cast<std::size_t>(got));
    for (auto end = rest.find('\n'); end != std::string::npos; end = rest.find('\n')) {
      const std::string reply = answer(rest.substr(0, end)) + "\n";
      rest.erase(0, end + 1);
      if (::write(to, reply.data(), reply.size()) < 0)
        return false;
    }
    return true;
  }
};

constexpr int kHardwarePriority = 80; // devices/real_time.hpp: drivers have 60 and 61

void set_scheduling(int policy, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  static_cast<void>(sched_setscheduler(0, policy, &parameters)); // else as all others
}

} // namespace

UMockdevTestbed* new_test_bed() {
  set_scheduling(SCHED_FIFO, kHardwarePriority); // which the test bed's own thread inherits
  return umockdev_testbed_new();
}

int run_child(char** arguments, const std::function<std::string(const std::string&)>& answer,
              const std::function<void()>& idle, bool from_stdin) {
  int up[2], down[2];
  if (pipe(up) != 0 || pipe(down) != 0) {
    std::perror("pipe");
    return 1;
  }
  std::signal(SIGPIPE, SIG_IGN);
  const pid_t child = fork();
  if (child == 0) {
    set_scheduling(SCHED_OTHER, 0);
    close(up[0]);
    close(down[1]);
    const std::string descriptors = std::to_string(down[0]) + " " + std::to_string(up[1]);
    setenv("TACTUS_DOUBLE", descriptors.c_str(), 1);
    std::signal(SIGPIPE, SIG_DFL);
    if (from_stdin) { // the commands are ours, not the child's
      const int nothing = open("/dev/null", O_RDONLY);
      dup2(nothing, 0);
    }
    execvp(arguments[0], arguments);
    std::perror(arguments[0]);
    _exit(127);
  }
  close(up[1]);
  close(down[0]);
  Lines from_child{up[0], down[1]}, from_user{0, 1};
  for (;;) {
    pollfd watched[] = {{from_child.from, POLLIN, 0}, {from_stdin ? 0 : -1, POLLIN, 0}};
    poll(watched, 2, 5);
    if (watched[0].revents && !from_child.serve(answer))
      from_child.from = -1;
    if (watched[1].revents && !from_user.serve(answer))
      from_stdin = false;
    idle();
    int status = 0;
    if (waitpid(child, &status, WNOHANG) == child)
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
}

} // namespace tactus::mock
