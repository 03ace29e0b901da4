#pragma once

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

/// The stand-in service as a process of its own; ends with the object.
class Mock {
public:
  struct Report {
    double x = 0, y = 0, z = 0; ///< the force it was last asked for, N, the service's axes
    long messages = 0, sessions = 0, wrong = 0;
    std::string profile, basis, preset;
  };

  explicit Mock(const std::string& kind = "one", int port = 0) {
    int in[2], out[2];
    REQUIRE(pipe(in) == 0);
    REQUIRE(pipe(out) == 0);
    pid_ = fork();
    REQUIRE(pid_ >= 0);
    if (pid_ == 0) {
      dup2(in[0], 0);
      dup2(out[1], 1);
      for (const int end : {in[0], in[1], out[0], out[1]})
        ::close(end);
      execl(TACTUS_PYTHON, TACTUS_PYTHON, MOCK_SERVICE, kind.c_str(), std::to_string(port).c_str(),
            static_cast<char*>(nullptr));
      _exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    to_ = fdopen(in[1], "w");
    from_ = fdopen(out[0], "r");
    char line[64];
    REQUIRE(std::fgets(line, sizeof line, from_) != nullptr);
    REQUIRE(std::sscanf(line, "port %d", &port_) == 1);
    setenv("TACTUS_HAPLY", ("127.0.0.1:" + std::to_string(port_)).c_str(), 1);
  }
  ~Mock() {
    std::fclose(to_); // it ends when nobody can tell it anything
    std::fclose(from_);
    waitpid(pid_, nullptr, 0);
  }
  Mock(const Mock&) = delete;
  Mock& operator=(const Mock&) = delete;

  Report tell(const std::string& command) {
    std::fprintf(to_, "%s\n", command.c_str());
    std::fflush(to_);
    char line[256], profile[32] = {}, basis[32] = {}, preset[32] = {};
    Report report;
    REQUIRE(std::fgets(line, sizeof line, from_) != nullptr);
    REQUIRE(std::sscanf(line, "report %lf %lf %lf %ld %ld %ld %31s %31s %31s", &report.x, &report.y,
                        &report.z, &report.messages, &report.sessions, &report.wrong, profile,
                        basis, preset) == 9);
    report.profile = profile;
    report.basis = basis;
    report.preset = preset;
    return report;
  }
  Report report() { return tell("report"); }
  [[nodiscard]] int port() const noexcept { return port_; }

private:
  pid_t pid_ = -1;
  int port_ = 0;
  std::FILE *to_ = nullptr, *from_ = nullptr;
};
