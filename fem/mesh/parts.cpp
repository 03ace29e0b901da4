#include "fem/mesh/parts.hpp"

#include "fem/io/text.hpp"
#include "fem/io/triangles.hpp"

#include <algorithm>
#include <numeric>

namespace tactus::fem {
namespace {

constexpr double kMinPartShare = 1e-4;  ///< share of the largest part's volume
constexpr double kMaxDebrisShare = .01; ///< the same for all small pieces together

std::string described(const Part& part) {
  return part.name + format(" (%.3g mm)", 1e3 * part.box.largest()) +
         near_position(.5 * (part.box.low + part.box.high));
}

std::string list_of(const std::vector<Part>& parts, const std::vector<std::size_t>& among) {
  std::string list;
  for (std::size_t i = 0; i < among.size() && i < 8; ++i)
    list += (i > 0 ? ", " : "") + std::to_string(among[i] + 1) + " " + described(parts[among[i]]);
  return list + (among.size() > 8 ? ", ..." : "");
}

std::size_t part_called(const std::vector<Part>& parts, const std::string& requested_part) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts[i].name == requested_part)
      return i;
  const auto number = to_number(requested_part);
  if (number && *number == std::floor(*number) && *number >= 1 &&
      *number <= static_cast<double>(parts.size()))
    return static_cast<std::size_t>(*number) - 1;
  std::vector<std::size_t> all(parts.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  throw InputError("--only " + requested_part + ": expected the name or number of one of " +
                   std::to_string(parts.size()) + " separate parts: " + list_of(parts, all));
}

void report_discarded_parts(const std::vector<Part>& parts, const std::vector<std::size_t>& left,
                            double whole, const LoadChoice& choice) {
  double sum = 0;
  for (const std::size_t i : left)
    sum += parts[i].volume;
  if (!left.empty() && choice.notify)
    choice.notify(format("%zu small pieces, together %.2g %% of the body's volume, were left out: ",
                         left.size(), 100 * sum / whole) +
                  list_of(parts, left));
}

} // namespace

std::vector<std::size_t> chosen_parts(const std::vector<Part>& parts, const LoadChoice& choice) {
  if (!choice.part.empty())
    return {part_called(parts, choice.part)};
  std::vector<std::size_t> order(parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return parts[a].volume > parts[b].volume; });
  const double largest = parts[order[0]].volume;
  double rest = 0;
  for (std::size_t i = 1; i < order.size(); ++i)
    rest += parts[order[i]].volume;
  std::vector<std::size_t> kept, left;
  const bool debris = !choice.multi && rest < kMaxDebrisShare * largest;
  for (const std::size_t i : order)
    (i == order[0] || (!debris && parts[i].volume >= kMinPartShare * largest) ? kept : left)
        .push_back(i);
  std::sort(kept.begin(), kept.end());
  report_discarded_parts(parts, left, largest, choice);
  if (kept.size() > 1 && !choice.multi)
    throw InputError("it has " + std::to_string(kept.size()) +
                     " separate parts, expected one body: " + list_of(parts, kept) +
                     "; select one with --only NUMBER or NAME, or all as one table with --multi");
  return kept;
}

} // namespace tactus::fem
