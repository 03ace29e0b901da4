#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// What a program does with the words of its command line; returns its exit status, or refuses.
using Run = int (*)(const std::vector<std::string>& words);

/// A command line that begins with a word of its own: `modal_fem raw ...`. It gets the words
/// behind.
struct Command {
  std::string_view word;
  Run run;
};

/// The main() of a program on bodies: --help, the commands, or else run(). A refusal is one
/// sentence on stderr; an interrupt removes what was begun.
[[nodiscard]] int body_program(int argc, char** argv, const char* name, std::string (*usage)(),
                               std::span<const Command> commands, Run run);

} // namespace tactus::fem
