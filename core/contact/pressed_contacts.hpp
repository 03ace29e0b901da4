#pragma once

#include "core/contact/exciter.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::contact {

class BodyKernel;

/// State of four impacts in contact, stored by lane for vector instructions. Each impact acts alone
/// on one mode of the body, in steps of one sample. The members are those of Exciter and Impact. An
/// unused lane holds a contact without force that never changes.
struct PressedBlock {
  static constexpr std::size_t kLanes = 4;
  using Row = std::array<double, kLanes>;

  // Members of Exciter.
  alignas(64) Row depth{}, approach{}, mean_velocity{}, position{}, velocity{}, external_force{};
  Row force{}, level_energy{}, duration{}, impulse{}, peak{};
  Row own_mobility{}; ///< mobility of the mass, m/(N s)
  Row mobility{};     ///< mobility of mass and body, m/(N s)
  Row mass{};         ///< effective mass, kg
  // Members of Impact.
  Row psi{}, energy_account{}, gamma_scale{}, psi_scale{}, loss_scale{};
  Row power_value{}, power_inverse{}, power_limit{}, exponent{}; ///< members of TaylorPower
  std::array<Row, 6> power_term{};
  // The contact point, and the step of its mode.
  Row shape{}, pole_real{}, pole_imaginary{}, response_real{}, response_imaginary{}, mean_real{},
      mean_imaginary{}, displacement{}, decay_over_omega{};
  Row before{}, step_force{}; ///< depth before the last step, and the force in that step

  std::array<std::uint32_t, kLanes> mode{};
  std::array<std::size_t, kLanes> slot{};
  std::uint32_t used = 0;            ///< number of lanes in use, from the first
  std::uint32_t needs_attention = 0; ///< bit l: lane l must return to ExcitedBody::step_single()
};

/// The sustained impacts of an ExcitedBody that are kept in PressedBlocks, four to a vector. The
/// Exciter of an impact is updated when the impact is read or removed.
class PressedContacts {
public:
  explicit PressedContacts(std::size_t exciters);

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] bool holds(std::size_t slot) const noexcept { return at_[slot] != kNone; }
  [[nodiscard]] double force(std::size_t slot) const noexcept {
    return block_of(slot).force[lane_of(slot)];
  }
  /// Depth before the last step, m, and force in that step, N.
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

  /// The mode of a contact, its shape over sqrt(m), and the coefficients of a step of one sample
  /// (ModalBody).
  struct ModeStep {
    std::uint32_t mode = 0;
    double shape = 0, pole_real = 1, pole_imaginary = 0, response_real = 0, response_imaginary = 0,
           mean_real = 0, mean_imaginary = 0, displacement = 0, decay_over_omega = 0;
  };
  /// Adds an impact that is in contact and has no compliance; `sample_s`: its step length, s.
  void add(std::size_t slot, const Exciter& exciter, const ModeStep& mode,
           double sample_s) noexcept;
  /// Copies the state back to its exciter.
  void read(std::size_t slot, Exciter& exciter, double sample_s) const noexcept;
  /// Copies the state back to its exciter and frees the lane.
  void remove(std::size_t slot, Exciter& exciter, double sample_s) noexcept;
  /// Calls leave(slot) for each contact that a kernel has marked; leave must remove() it. Clears
  /// all marks.
  template <class Leave> void for_each_marked(const Leave& leave) noexcept {
    for (std::size_t b = blocks().size(); b-- > 0;) {
      const std::uint32_t marked = blocks_[b].needs_attention;
      blocks_[b].needs_attention = 0;
      // Backwards, because remove() moves the last contact into the freed lane.
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
  std::vector<std::uint32_t> at_; ///< by slot: index of its lane over all blocks, or kNone
  std::size_t count_ = 0;
};

} // namespace tactus::contact
