#include "core/contact/contact_islands.hpp"

#include <algorithm>
#include <utility>

namespace tactus::contact {

Islands::Islands(std::size_t max_modes, std::size_t max_contacts) {
  islands_.reserve(max_contacts);
  slots_.reserve(max_contacts);
  modes_.reserve(max_modes);
}

PointModes::PointModes(std::size_t max_modes, std::size_t points)
    : modes_(points), owner_(max_modes, kNone), parent_(points), island_(points) {
  for (std::vector<std::uint32_t>& modes : modes_)
    modes.reserve(max_modes);
}

void PointModes::set(std::size_t point, std::span<const double> shape) noexcept {
  modes_[point].clear();
  for (std::size_t i = 0; i < shape.size(); ++i)
    if (shape[i] != 0)
      modes_[point].push_back(static_cast<std::uint32_t>(i));
}

std::uint32_t PointModes::root(std::uint32_t contact) noexcept {
  while (parent_[contact] != contact)
    contact = parent_[contact] = parent_[parent_[contact]];
  return contact;
}

/// Union-find over the modes (Tarjan 1975). The root is always the first contact of an island.
void PointModes::divide(std::span<const std::size_t> points, Islands& into) noexcept {
  const auto count = static_cast<std::uint32_t>(points.size());
  std::size_t end = 0; // one past the last mode that any contact moves
  for (std::uint32_t c = 0; c < count; ++c) {
    parent_[c] = c;
    for (const std::uint32_t mode : modes_[points[c]]) {
      if (owner_[mode] == kNone) {
        owner_[mode] = c;
        continue;
      }
      std::uint32_t a = root(c), b = root(owner_[mode]);
      if (a > b)
        std::swap(a, b);
      parent_[b] = a;
    }
    if (!modes_[points[c]].empty())
      end = std::max<std::size_t>(end, modes_[points[c]].back() + 1);
  }
  into.islands_.clear();
  for (std::uint32_t c = 0; c < count; ++c) {
    const std::uint32_t first = root(c);
    if (first == c) {
      island_[c] = static_cast<std::uint32_t>(into.islands_.size());
      into.islands_.emplace_back();
    }
    island_[c] = island_[first];
    ++into.islands_[island_[c]].slots;
  }
  for (std::size_t mode = 0; mode < end; ++mode)
    if (owner_[mode] != kNone)
      ++into.islands_[island_[owner_[mode]]].modes;
  std::size_t slots = 0, modes = 0;
  for (Islands::Island& island : into.islands_) {
    island.first_slot = std::exchange(slots, slots + island.slots);
    island.first_mode = std::exchange(modes, modes + island.modes);
    island.slots = island.modes = 0;
  }
  into.slots_.resize(slots);
  into.modes_.resize(modes);
  for (std::uint32_t c = 0; c < count; ++c) {
    Islands::Island& island = into.islands_[island_[c]];
    into.slots_[island.first_slot + island.slots++] = points[c];
  }
  for (std::size_t mode = 0; mode < end; ++mode) {
    if (owner_[mode] == kNone)
      continue;
    Islands::Island& island = into.islands_[island_[owner_[mode]]];
    into.modes_[island.first_mode + island.modes++] = static_cast<std::uint32_t>(mode);
    owner_[mode] = kNone;
  }
}

} // namespace tactus::contact
