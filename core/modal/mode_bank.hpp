#pragma once

#include "core/modal/bank_kernel.hpp"

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

/// Many damped oscillators under common forces, heard at common places.
///
/// Mode k has the complex rate s = -alpha + j omega_d (1/s) and follows
///   q'' + 2 alpha q' + (alpha^2 + omega_d^2) q = sum over drives of b F,   [q] = m sqrt(kg)
/// as z = q' + alpha q + j omega_d q, which a sample of force F changes by b F T and time by
/// exp(s t): impulse-invariant, exact for impulses at the samples. A pick-up with complex weight w
/// hears sum over modes of Im(w z). Single precision; rates and gains are worked out in double.
///
/// Everything but the constructor allocates nothing. The same input gives the same bits however it
/// is cut into blocks.
class ModeBank {
public:
  /// Rates as above, in any order (modes of like decay side by side are computed fastest); |s|
  /// times the sample's length should be below pi.
  ModeBank(std::span<const std::complex<double>> rate, double sample_rate, std::size_t drives,
           std::size_t pickups, VectorSet set = best_vector_set());

  /// Gains b of the modes, 1/sqrt(kg), at the place of a drive; takes effect at once.
  void set_gain(std::size_t drive, std::span<const double> gain) noexcept;
  /// What a pick-up hears; the old weights give way to the new ones within kFade samples.
  void set_weight(std::size_t pickup, std::span<const std::complex<double>> weight) noexcept;
  /// The same without a fade.
  void jump_to_weight(std::size_t pickup, std::span<const std::complex<double>> weight) noexcept;

  /// Adds up `frames` samples. force[i] are the samples of drive i in N, finite, or null; out[i] is
  /// overwritten with what pick-up i hears, or null.
  void process(std::span<const float* const> force, std::span<float* const> out,
               std::size_t frames) noexcept;

  /// Brings all states to the present, so that they can be read and changed.
  void settle() noexcept;
  [[nodiscard]] std::complex<double> state(std::size_t mode) const noexcept;
  void set_state(std::size_t mode, std::complex<double> z) noexcept;
  /// All states at once, brought to the present.
  void read_states(std::span<std::complex<double>> z) noexcept;
  void write_states(std::span<const std::complex<double>> z) noexcept;
  void silence() noexcept;
  /// Nothing rings: process() costs next to nothing and gives zeros while there is no force.
  [[nodiscard]] bool asleep() const noexcept { return active_count_ == 0; }
  /// Blocks of modes that are computed now, of kLanes modes each.
  [[nodiscard]] std::size_t active_blocks() const noexcept { return active_count_; }
  /// A mode whose part in every pick-up stays below this is put to rest.
  void set_floor(double level) noexcept { floor_ = level; }
  [[nodiscard]] std::size_t modes() const noexcept { return modes_; }
  /// Position in the grid of leaps, so that one bank can follow another at the same sample.
  [[nodiscard]] std::uint64_t clock() const noexcept { return clock_; }
  void set_clock(std::uint64_t clock) noexcept { clock_ = clock; }

  /// Time that another computed: nothing moves here but the clock and the fades. Settled before.
  void skip(std::size_t samples) noexcept;
  /// Samples that a pick-up's old weights still have.
  [[nodiscard]] std::size_t fade_left(std::size_t pickup) const noexcept {
    return pickups_[pickup].fade_left;
  }

  static constexpr std::size_t kFade = 512; ///< samples
  /// Modes of a block whose decay rates differ less than this from their mean, times a sample's
  /// length, are computed as if they decayed alike within a leap: an error below -65 dB.
  static constexpr double kUnlike = 1.2e-4;

private:
  static constexpr std::size_t kMostDrives = 72, kMostPickups = kMostEars / 2;
  static constexpr std::uint64_t kRestPeriod = 1024; ///< samples between looks at what still rings

  struct Place {
    std::size_t block, lane;
  };
  [[nodiscard]] static Place place(std::size_t mode) noexcept {
    return {mode / kLanes, mode % kLanes};
  }
  struct Pickup {
    std::vector<ComplexLane> weight, old_weight;
    std::size_t fade_left = 0;
  };
  /// What is heard within a leap of the leap's own forces: sum over modes of Im(w b T p^m).
  using Echo = std::array<float, 2 * kLeap>; // kLeap zeros, then m = 0 ...
  [[nodiscard]] Echo& echo(std::size_t drive, std::size_t pickup, bool old) noexcept {
    return echo_[(drive * pickups_.size() + pickup) * 2 + (old ? 1 : 0)];
  }
  [[nodiscard]] std::complex<double> entry(const ComplexLane& lanes,
                                           std::size_t lane) const noexcept {
    return {static_cast<double>(lanes.real.v[lane]), static_cast<double>(lanes.imaginary.v[lane])};
  }
  void write_weight(std::vector<ComplexLane>& to,
                    std::span<const std::complex<double>> weight) noexcept;
  void work_out_echo(std::size_t drive, std::size_t pickup) noexcept;
  void wake(std::size_t drive) noexcept;
  void make_poles(std::span<const std::complex<double>> rate);
  void list_active() noexcept;
  /// At most kMostSamples, up to the next multiple of that on the clock.
  void chunk(std::size_t frames) noexcept;
  [[nodiscard]] std::size_t find_pushing() noexcept;
  std::size_t make_ears(std::size_t at) noexcept;
  void whole_leaps(std::size_t at, std::size_t leaps) noexcept;
  void part_of_leap(std::size_t at, std::size_t count, bool ends) noexcept;
  void add_echo(std::size_t drive, std::size_t from, std::size_t to, std::size_t at) noexcept;
  void mix() noexcept;
  void rest() noexcept;
  [[nodiscard]] BankView view() noexcept;

  std::size_t modes_, blocks_;
  double sample_rate_;
  const BankKernel* kernel_;
  std::vector<PoleBlock> poles_;
  std::vector<CommonDecay> decays_;
  std::vector<ComplexLane> state_;
  std::vector<std::vector<Lane>> gain_; // [drive][block], b T
  std::vector<Pickup> pickups_;
  std::vector<Echo> echo_;
  std::vector<unsigned char> echo_stale_;
  std::vector<std::uint32_t> active_;
  std::vector<unsigned char> is_active_;
  std::size_t active_count_ = 0;
  double floor_ = 0;

  std::uint64_t clock_ = 0;                       // samples
  std::size_t phase_ = 0;                         // samples of the leap at hand that are over
  std::vector<std::array<float, kLeap>> history_; // [drive], their forces
  // Of the chunk at hand.
  struct Ear {
    std::size_t pickup;
    bool old; ///< with the weights that fade away
  };
  std::size_t frames_ = 0, pushing_count_ = 0, ear_count_ = 0;
  std::array<const float*, kMostDrives> force_{};
  std::array<std::uint32_t, kMostDrives> pushing_{};
  std::array<float*, kMostPickups> out_{};
  std::array<Ear, 2 * kMostPickups> ears_{};
  std::array<BankDrive, kMostDrives> kernel_drives_{};
  std::array<BankPickup, 2 * kMostPickups> kernel_pickups_{};
  std::array<std::array<float, kMostSamples>, 2 * kMostPickups> heard_{};
};

} // namespace tactus::modal
