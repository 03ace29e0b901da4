#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

#include <unistd.h>

namespace tactus::mock {

/// The other end of run_child, for a test that runs inside a double. No program of tactus's reads
/// this; a test may ask the double for faults and for what it saw.
class Control {
public:
  Control() {
    const char* descriptors = std::getenv("TACTUS_DOUBLE");
    present_ = descriptors && std::sscanf(descriptors, "%d %d", &read_, &write_) == 2;
  }
  [[nodiscard]] bool present() const { return present_; }

  /// The double's answer to one command.
  std::string ask(const std::string& command) const {
    const std::string line = command + "\n";
    if (!present_ || ::write(write_, line.data(), line.size()) < 0)
      return {};
    std::string answer;
    for (char letter = 0; ::read(read_, &letter, 1) == 1 && letter != '\n';)
      answer += letter;
    return answer;
  }
  /// One number of the double's state.
  [[nodiscard]] long value(const std::string& name) const {
    const std::string state = " " + ask("state");
    const auto at = state.find(" " + name + "=");
    return at == std::string::npos ? -999999
                                   : std::strtol(state.c_str() + at + name.size() + 2, nullptr, 10);
  }

private:
  int read_ = -1, write_ = -1;
  bool present_ = false;
};

} // namespace tactus::mock
