#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::contact {

/// Contacts divided into islands: within one, any two share a mode of the body, directly or by way
/// of others; no force of one island moves a mode of another.
class Islands {
public:
  /// Contacts and modes of one, as parts of the lists.
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
  /// Modes that its contacts move, ascending.
  [[nodiscard]] std::span<const std::uint32_t> modes(std::size_t island) const noexcept {
    return std::span(modes_).subspan(islands_[island].first_mode, islands_[island].modes);
  }

private:
  friend class PointModes;
  std::vector<Island> islands_; ///< in the order of their first contacts
  std::vector<std::size_t> slots_;
  std::vector<std::uint32_t> modes_;
};

/// The modes that a contact at each place moves: those whose shape there is not zero.
class PointModes {
public:
  PointModes(std::size_t max_modes, std::size_t points);

  /// From the place's shape.
  void set(std::size_t point, std::span<const double> shape) noexcept;
  /// Ascending.
  [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t point) const noexcept {
    return modes_[point];
  }
  /// Divides the contacts at these places into islands. Time: of the contacts' modes and those up
  /// to the last.
  void divide(std::span<const std::size_t> points, Islands& into) noexcept;

private:
  [[nodiscard]] std::uint32_t root(std::uint32_t contact) noexcept;

  static constexpr std::uint32_t kNone = ~0U;
  std::vector<std::vector<std::uint32_t>> modes_;
  std::vector<std::uint32_t> owner_;  ///< by mode: a contact that moves it
  std::vector<std::uint32_t> parent_; ///< by contact: another of its island, nearer to the root
  std::vector<std::uint32_t> island_; ///< by contact
};

} // namespace tactus::contact
