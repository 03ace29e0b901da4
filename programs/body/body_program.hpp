#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// Runs a program with the words of its command line; returns its exit status, or refuses.
using Run = int (*)(const std::vector<std::string>& words);

/// A command, such as `raw` in `modal_fem raw ...`. It receives the words after its own.
struct Command {
  std::string_view word;
  Run run;
};

/// The main() of a program on bodies. It handles --help and the commands, or else calls run(). It
/// prints a refusal as one sentence on stderr; an interrupt removes unfinished files.
[[nodiscard]] int body_program(int argc, char** argv, const char* name, std::string (*usage)(),
                               std::span<const Command> commands, Run run);

} // namespace tactus::fem
