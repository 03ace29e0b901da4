#include "net/bus_topic.hpp"

#include <algorithm>

namespace tactus::net {
namespace {

struct Row {
  std::string_view name;
  BusTopic topic;
};
constexpr BusTopic kEvent{true, true}, kStream{false, true};
constexpr std::array<Row, 12> kRows{{{"raw", kStream},
                                     {"rawbutton", kEvent},
                                     {"hand", kStream},
                                     {"button", kEvent},
                                     {"grip", kEvent},
                                     {"hit", kEvent},
                                     {"contact", kStream},
                                     {"release", kEvent},
                                     {"excite", kEvent},
                                     {"force", kStream},
                                     {"listener", kStream},
                                     {"mark", kEvent}}};

} // namespace

BusTopic bus_topic(std::string_view name) noexcept {
  for (const Row& row : kRows)
    if (row.name == name)
      return row.topic;
  return {};
}

bool is_topic_name(std::string_view name) noexcept {
  constexpr std::size_t kMaxTopicName = 32;
  return !name.empty() && name.size() <= kMaxTopicName &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-';
         });
}

} // namespace tactus::net
