#include "externals/phantom/reports.hpp"

namespace tactus::phantom {

void Reports::set(Words words, Host& host) {
  for (std::size_t i = 0; i < kTags.size(); ++i)
    if (is(words[0], kTags[i])) {
      if (words[1].is_word)
        return host.error(expected("report", words[1], "0 or 1"));
      on_[i] = words[1].number != 0;
      return;
    }
  host.error(expected("report", words[0], one_of(kTags)));
}

} // namespace tactus::phantom
