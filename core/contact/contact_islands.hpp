#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::contact {

/// Contacts divided into islands, the connected components of the graph in which two contacts are
/// neighbours if they share a mode. No force of one island moves a mode of another, so each island
/// can be solved separately.
class Islands {
public:
  /// Ranges of one island in the lists of the contacts and modes of all islands.
  struct Island {
    std::size_t first_slot = 0, slots = 0, first_mode = 0, modes = 0;
  };

  Islands(std::size_t max_modes, std::size_t max_contacts);

  [[nodiscard]] std::size_t size() const noexcept { return islands_.size(); }
  [[nodiscard]] const Island& operator[](std::size_t island) const noexcept {
    return islands_[island];
  }
  /// Slots of an island's contacts, in the order in which they were given.
  [[nodiscard]] std::span<const std::size_t> slots(std::size_t island) const noexcept {
    return std::span(slots_).subspan(islands_[island].first_slot, islands_[island].slots);
  }
  /// Indices of the modes that an island's contacts move, ascending.
  [[nodiscard]] std::span<const std::uint32_t> modes(std::size_t island) const noexcept {
    return std::span(modes_).subspan(islands_[island].first_mode, islands_[island].modes);
  }

private:
  friend class PointModes;
  std::vector<Island> islands_; ///< islands in the order of their first contacts
  std::vector<std::size_t> slots_;
  std::vector<std::uint32_t> modes_;
};

/// The modes that a force at each contact point moves: those whose shape there is not zero.
class PointModes {
public:
  PointModes(std::size_t max_modes, std::size_t points);

  /// Sets the modes of a point from its shape, one number per mode.
  void set(std::size_t point, std::span<const double> shape) noexcept;
  /// Indices of the point's modes, ascending.
  [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t point) const noexcept {
    return modes_[point];
  }
  /// Divides the contacts at these points into islands. The time grows with the sum of the
  /// contacts' mode counts and with the highest index of a mode.
  void divide(std::span<const std::size_t> points, Islands& into) noexcept;

private:
  [[nodiscard]] std::uint32_t root(std::uint32_t contact) noexcept;

  static constexpr std::uint32_t kNone = ~0U;
  std::vector<std::vector<std::uint32_t>> modes_;
  std::vector<std::uint32_t> owner_;  ///< by mode: index of a contact that moves it
  std::vector<std::uint32_t> parent_; ///< by contact: index of its parent in the union-find forest
  std::vector<std::uint32_t> island_; ///< by contact: index of its island
};

} // namespace tactus::contact
