#include "programs/modal_fem/progress.hpp"

#include <cstdio>

namespace tactus::fem {

void ProgressLine::stage(const std::string& name, double share) {
  const int tenth = static_cast<int>(10 * share + 1e-9);
  if (quiet_ || (name == last_ && tenth <= tenth_))
    return;
  last_ = name;
  tenth_ = tenth;
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  std::fprintf(stderr, "%7.1f s  %s", seconds, name.c_str());
  if (tenth > 0)
    std::fprintf(stderr, " %d %%", 10 * tenth);
  std::fputc('\n', stderr);
}

void ProgressLine::say(const std::string& sentence) {
  if (!quiet_)
    std::fprintf(stderr, "           %s\n", sentence.c_str());
}

} // namespace tactus::fem
