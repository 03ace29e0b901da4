#pragma once

#include "core/contact/exciter.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::contact {

class BodyKernel;

/// Four impacts under way, each alone on one mode of the body, in steps of one sample: what
/// Exciter and Impact hold of them, side by side for vectors. Lanes that are not used have numbers
/// that stay as they are.
struct PressedBlock {
  static constexpr std::size_t kLanes = 4;
  using Row = std::array<double, kLanes>;

  // Exciter.
  alignas(64) Row depth{}, approach{}, mean_velocity{}, position{}, velocity{}, external_force{};
  Row force{}, level_energy{}, duration{}, impulse{}, peak{};
  Row own_mobility{}; ///< the mass's mobility, m/(N s)
  Row mobility{};     ///< and with the body's
  Row mass{};         ///< effective
  // Impact.
  Row psi{}, energy_account{}, gamma_scale{}, psi_scale{}, loss_scale{};
  Row power_value{}, power_inverse{}, power_limit{}, exponent{}; ///< of TaylorPower
  std::array<Row, 6> power_term{};
  // The place, and its mode's step.
  Row shape{}, pole_real{}, pole_imaginary{}, response_real{}, response_imaginary{}, mean_real{},
      mean_imaginary{}, displacement{}, decay_over_omega{};
  Row before{}, step_force{}; ///< depth before the last step, and its force

  std::array<std::uint32_t, kLanes> mode{};
  std::array<std::size_t, kLanes> slot{};
  std::uint32_t used = 0;            ///< lanes, from the first on
  std::uint32_t needs_attention = 0; ///< bits of lanes that a kernel leaves to the general way
};

/// The impacts of a ExcitedBody that are in PressedBlocks: their Exciters are brought up to date
/// when they leave or are looked at.
class PressedContacts {
public:
  explicit PressedContacts(std::size_t exciters);

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] bool holds(std::size_t slot) const noexcept { return at_[slot] != kNone; }
  [[nodiscard]] double force(std::size_t slot) const noexcept {
    return block_of(slot).force[lane_of(slot)];
  }
  /// Depth before the last step, m, and its force, N.
  struct Step {
    double before_m, force_n;
  };
  [[nodiscard]] Step last_step(std::size_t slot) const noexcept {
    return {block_of(slot).before[lane_of(slot)], block_of(slot).step_force[lane_of(slot)]};
  }
  void set_external_force(std::size_t slot, double force_n) noexcept {
    block_of(slot).external_force[lane_of(slot)] = force_n;
  }
  [[nodiscard]] std::span<PressedBlock> blocks() noexcept {
    return std::span(blocks_).first((count_ + PressedBlock::kLanes - 1) / PressedBlock::kLanes);
  }

  /// A contact's mode, and what a step of a sample does to it.
  struct ModeStep {
    std::uint32_t mode = 0;
    double shape = 0, pole_real = 1, pole_imaginary = 0, response_real = 0, response_imaginary = 0,
           mean_real = 0, mean_imaginary = 0, displacement = 0, decay_over_omega = 0;
  };
  /// Takes in an impact under way whose law does not yield; `sample_s`: the length of its steps.
  void add(std::size_t slot, const Exciter& exciter, const ModeStep& position,
           double sample_s) noexcept;
  /// What the exciter would be had it not been here.
  void read(std::size_t slot, Exciter& exciter, double sample_s) const noexcept;
  /// Reads it and lets it go.
  void remove(std::size_t slot, Exciter& exciter, double sample_s) noexcept;
  /// Calls leave(slot) for each that a kernel has marked; it must remove() it. All marks are gone
  /// then.
  template <class Leave> void for_each_marked(const Leave& leave) noexcept {
    for (std::size_t b = blocks().size(); b-- > 0;) {
      const std::uint32_t marked = blocks_[b].needs_attention;
      blocks_[b].needs_attention = 0;
      // From behind: the last of all takes the place of one that goes.
      for (std::size_t lane = PressedBlock::kLanes; marked != 0 && lane-- > 0;)
        if ((marked >> lane & 1U) != 0 && lane < blocks_[b].used)
          leave(blocks_[b].slot[lane]);
    }
  }

private:
  static constexpr std::uint32_t kNone = ~0U;
  [[nodiscard]] static std::size_t lane(std::uint32_t at) noexcept {
    return at % PressedBlock::kLanes;
  }
  [[nodiscard]] std::size_t lane_of(std::size_t slot) const noexcept { return lane(at_[slot]); }
  [[nodiscard]] PressedBlock& block_of(std::size_t slot) noexcept {
    return blocks_[at_[slot] / PressedBlock::kLanes];
  }
  [[nodiscard]] const PressedBlock& block_of(std::size_t slot) const noexcept {
    return blocks_[at_[slot] / PressedBlock::kLanes];
  }
  static void clear(PressedBlock& block, std::size_t lane) noexcept;

  std::vector<PressedBlock> blocks_;
  std::vector<std::uint32_t> at_; ///< by slot: lane among all blocks'
  std::size_t count_ = 0;
};

} // namespace tactus::contact
