#pragma once

#include "devices/driver.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

/// The stand-in service: begun anew in one process for all, or in one of its own that ends with it.
class Mock {
public:
  struct Report {
    double x = 0, y = 0, z = 0; ///< the force it was last asked for, N, the service's axes
    long messages = 0, sessions = 0, wrong = 0;
    std::string profile, basis, preset;
  };

  explicit Mock(const std::string& kind = "one") {
    static Process shared(0);
    process_ = &shared;
    begin(kind);
  }
  /// port: 0 for any.
  static Mock alone(int port = 0) { return Mock(std::make_unique<Process>(port)); }
  Mock(const Mock&) = delete;
  Mock& operator=(const Mock&) = delete;

  Report tell(const std::string& command) {
    std::fprintf(process_->to, "%s\n", command.c_str());
    std::fflush(process_->to);
    char line[256], profile[32] = {}, basis[32] = {}, preset[32] = {};
    Report report;
    REQUIRE(std::fgets(line, sizeof line, process_->from) != nullptr);
    REQUIRE(std::sscanf(line, "report %lf %lf %lf %ld %ld %ld %31s %31s %31s", &report.x, &report.y,
                        &report.z, &report.messages, &report.sessions, &report.wrong, profile,
                        basis, preset) == 9);
    report.profile = profile;
    report.basis = basis;
    report.preset = preset;
    return report;
  }
  Report report() { return tell("report"); }
  [[nodiscard]] int port() const noexcept { return process_->port; }

private:
  struct Process {
    explicit Process(int wanted) {
      int in[2], out[2];
      REQUIRE(pipe(in) == 0);
      REQUIRE(pipe(out) == 0);
      pid = fork();
      REQUIRE(pid >= 0);
      if (pid == 0) {
        dup2(in[0], 0);
        dup2(out[1], 1);
        for (const int end : {in[0], in[1], out[0], out[1]})
          ::close(end);
        execl(TACTUS_PYTHON, TACTUS_PYTHON, MOCK_SERVICE, std::to_string(wanted).c_str(),
              static_cast<char*>(nullptr));
        _exit(127);
      }
      ::close(in[0]);
      ::close(out[1]);
      fcntl(in[1], F_SETFD, FD_CLOEXEC); // another such process must not keep this one alive
      to = fdopen(in[1], "w");
      from = fdopen(out[0], "r");
      char line[64];
      REQUIRE(std::fgets(line, sizeof line, from) != nullptr);
      REQUIRE(std::sscanf(line, "port %d", &port) == 1);
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process() {
      std::fclose(to); // it ends when nobody can tell it anything
      std::fclose(from);
      waitpid(pid, nullptr, 0);
    }
    pid_t pid = -1;
    int port = 0;
    std::FILE *to = nullptr, *from = nullptr;
  };

  explicit Mock(std::unique_ptr<Process> own) : own_(std::move(own)), process_(own_.get()) {
    begin("one");
  }
  void begin(const std::string& kind) {
    tell("begin " + kind);
    setenv("TACTUS_HAPLY", ("127.0.0.1:" + std::to_string(port())).c_str(), 1);
  }
  std::unique_ptr<Process> own_{};
  Process* process_ = nullptr;
};

inline std::unique_ptr<tactus::haptic::Backend> make() {
  return tactus::devices::find_driver("haply")->make();
}

inline std::string set(tactus::haptic::Backend& device, const std::vector<std::string>& words) {
  return device.configure(words);
}

/// Ticks like a servo's, each asking for this force, until the condition holds; half a minute at
/// most. False when it never did.
template <class Condition>
bool drive_until(tactus::haptic::Backend& device, const tactus::Vec3& force, Condition holds) {
  for (int i = 0; i < 30000; ++i) {
    tactus::haptic::State state;
    const bool answered = device.read({}, state);
    CHECK(device.write(force));
    if (holds(answered, state))
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

inline bool alive(bool answered, const tactus::haptic::State&) { return answered; }

inline bool silent(bool answered, const tactus::haptic::State&) { return !answered; }

/// The handle has come to this point.
inline auto at(const tactus::Vec3& point) {
  return [point](bool answered, const tactus::haptic::State& state) {
    return answered && norm(state.position - point) < 1e-9;
  };
}
