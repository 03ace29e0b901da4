#include "programs/body/body_program.hpp"

#include "fem/blas_kernels.hpp"
#include "fem/io/safe_file.hpp"

#include <cstdio>
#include <exception>
#include <new>

namespace tactus::fem {

int body_program(int argc, char** argv, const char* name, std::string (*usage)(),
                 std::span<const Command> commands, Run run) {
  restart_with_faster_blas_kernels(argv);
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string_view first = words.empty() ? "" : std::string_view(words[0]);
  clean_up_on_interrupt();
  try {
    if (first == "--help" || first == "-h") {
      std::fputs(usage().c_str(), stdout);
      return 0;
    }
    for (const Command& command : commands)
      if (first == command.word)
        return command.run({words.begin() + 1, words.end()});
    return run(words);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: out of memory: use a coarser mesh (--h)\n", name);
  } catch (const std::exception& refusal) {
    std::fprintf(stderr, "%s: %s\n", name, refusal.what());
  }
  return 1;
}

} // namespace tactus::fem
