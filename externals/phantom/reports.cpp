#include "externals/phantom/reports.hpp"

#include "externals/phantom/numbers.hpp"

namespace tactus::phantom {

std::string Reports::set(std::span<const Atom> words) {
  for (std::size_t i = 0; i < kTags.size(); ++i)
    if (is(words[0], kTags[i])) {
      if (words[1].is_word)
        return expected("report", words[1], "0 or 1");
      on_[i] = words[1].number != 0;
      return {};
    }
  return expected("report", words[0],
                  "mm, vel, force, button, status, jitter, error, hit, contact, release, rot, "
                  "torque or grip");
}

} // namespace tactus::phantom
