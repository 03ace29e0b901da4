#pragma once

#include "core/modal/bank/bank_kernel.hpp"
#include "core/modal/bank/glide.hpp"

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
  /// What a pick-up hears; its weights glide to the new ones, at whatever rate these come.
  void set_weight(std::size_t pickup, std::span<const std::complex<double>> weight) noexcept;
  /// The same for all pick-ups, in step: what one of them hears anew makes all glide.
  void set_weights(std::span<const std::vector<std::complex<double>>> weight) noexcept;
  /// The same at once.
  void jump_to_weight(std::size_t pickup, std::span<const std::complex<double>> weight) noexcept;

  /// The three weights that a pick-up glides between; at rest it hears the freshest.
  enum Part : std::size_t { kOld, kMiddle, kLatest };
  [[nodiscard]] const Glide& glide(std::size_t pickup) const noexcept {
    return pickups_[pickup].glide;
  }
  [[nodiscard]] std::complex<double> weight(std::size_t pickup, Part part,
                                            std::size_t mode) const noexcept;
  /// Takes over another bank's glide, its weights given: old, middle and fresh of all modes.
  void set_glide(std::size_t pickup, const Glide& glide,
                 const std::array<std::span<const std::complex<double>>, 3>& weight) noexcept;
  /// Grows with every change of the three weights.
  [[nodiscard]] std::uint64_t glide_version() const noexcept { return glide_version_; }
  /// Samples for which all pick-ups' three weights stay as they are.
  [[nodiscard]] std::size_t glide_left() const noexcept;

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
  /// All that rings goes on ringing apart and is faded out by half a cosine's turn within kRelease
  /// samples; the states are at rest.
  void release() noexcept;
  [[nodiscard]] std::size_t release_left() const noexcept { return release_left_; }
  /// What is being released, brought to the present; for a bank that another follows.
  void read_released(std::span<std::complex<double>> z) noexcept;
  void write_released(std::span<const std::complex<double>> z, std::size_t left) noexcept;
  /// Nothing rings: process() costs next to nothing and gives zeros while there is no force.
  [[nodiscard]] bool asleep() const noexcept { return active_count_ == 0 && release_left_ == 0; }
  /// Something besides what is being released.
  [[nodiscard]] bool rings() const noexcept { return active_count_ > 0; }
  /// Blocks of modes that are computed now, of kLanes modes each.
  [[nodiscard]] std::size_t active_blocks() const noexcept { return active_count_; }
  /// A mode whose part in every pick-up stays below this is put to rest.
  void set_floor(double level) noexcept { floor_ = level; }
  [[nodiscard]] std::size_t modes() const noexcept { return modes_; }
  /// Position in the grid of leaps, so that one bank can follow another at the same sample.
  [[nodiscard]] std::uint64_t clock() const noexcept { return clock_; }
  void set_clock(std::uint64_t clock) noexcept { clock_ = clock; }

  /// Time that another computed: nothing moves here but the clock and the glides. Settled before,
  /// and nothing is being released.
  void skip(std::size_t samples) noexcept;

  static constexpr std::size_t kRelease = 1024; ///< samples
  /// Half a cosine's turn from 1 to 0, so many samples before its end.
  [[nodiscard]] static double release_share(std::size_t left) noexcept;
  /// Modes of a block whose decay rates differ less than this from their mean, times a sample's
  /// length, are computed as if they decayed alike within a leap: an error below -65 dB.
  static constexpr double kMaxDecayMismatch = 1.2e-4;

private:
  static constexpr std::size_t kMaxDrives = 72, kMaxPickups = kMaxPickupParts / 3;
  static constexpr std::uint64_t kAudibilityPeriod =
      1024; ///< samples between looks at what still rings

  struct LaneIndex {
    std::size_t block, lane;
  };
  [[nodiscard]] static LaneIndex lane_index(std::size_t mode) noexcept {
    return {mode / kLanes, mode % kLanes};
  }
  struct Pickup {
    std::array<std::vector<ComplexLane>, 3> weight; ///< by Part
    std::vector<ComplexLane> target;                ///< that waits
    Glide glide;
  };
  /// What is heard within a leap of the leap's own forces: sum over modes of Im(w b T p^m).
  using Echo = std::array<float, 2 * kLeap>; // kLeap zeros, then m = 0 ...
  struct KnownEcho {
    Echo echo;
    bool known = false;
  };
  [[nodiscard]] KnownEcho& echo(std::size_t drive, std::size_t pickup, std::size_t part) noexcept {
    return echo_[(drive * pickups_.size() + pickup) * 3 + part];
  }
  [[nodiscard]] std::complex<double> entry(const ComplexLane& lanes,
                                           std::size_t lane) const noexcept {
    return {static_cast<double>(lanes.real.v[lane]), static_cast<double>(lanes.imaginary.v[lane])};
  }
  void write_weight(std::vector<ComplexLane>& to,
                    std::span<const std::complex<double>> weight) noexcept;
  [[nodiscard]] bool is_target(std::size_t pickup,
                               std::span<const std::complex<double>> weight) const noexcept;
  void glide_to(std::size_t pickup, std::span<const std::complex<double>> weight) noexcept;
  void exchange(std::size_t pickup, Glide::Exchange exchange, bool had_target) noexcept;
  void advance_glides(std::size_t samples) noexcept;
  void compute_echo(std::size_t drive, std::size_t pickup, std::size_t part) noexcept;
  void read(const std::vector<ComplexLane>& from, std::span<std::complex<double>> z) const noexcept;
  void list_released() noexcept;
  void mix_released() noexcept;
  void wake(std::size_t drive) noexcept;
  void make_poles(std::span<const std::complex<double>> rate);
  void list_active() noexcept;
  /// At most kMaxSamples, up to the next multiple of that on the clock.
  void process_chunk(std::size_t frames) noexcept;
  [[nodiscard]] std::size_t find_driving() noexcept;
  std::size_t list_pickup_parts(std::size_t at) noexcept;
  void process_whole_leaps(std::size_t at, std::size_t leaps) noexcept;
  void process_partial_leap(std::size_t at, std::size_t count, bool ends) noexcept;
  void add_echo(std::size_t drive, std::size_t from, std::size_t to, std::size_t at) noexcept;
  void mix() noexcept;
  void deactivate_inaudible() noexcept;
  [[nodiscard]] BankView view() noexcept;
  [[nodiscard]] BankView released_view() noexcept;

  std::size_t modes_, blocks_;
  double sample_rate_;
  const BankKernel* kernel_;
  std::vector<PoleBlock> poles_;
  std::vector<CommonDecay> decays_;
  std::vector<ComplexLane> state_;
  std::vector<std::vector<Lane>> gain_; // [drive][block], b T
  std::vector<Pickup> pickups_;
  std::vector<KnownEcho> echo_;
  std::uint64_t glide_version_ = 0;
  std::vector<std::uint32_t> active_;
  std::vector<unsigned char> is_active_;
  std::size_t active_count_ = 0;
  std::vector<ComplexLane> released_;
  std::vector<std::uint32_t> released_active_;
  std::size_t released_count_ = 0, release_left_ = 0; // blocks, samples
  double floor_ = 0;

  std::uint64_t clock_ = 0;                       // samples
  std::size_t phase_ = 0;                         // samples of the leap at hand that are over
  std::vector<std::array<float, kLeap>> history_; // [drive], their forces
  // Of the chunk at hand.
  struct PickupPart {
    std::size_t pickup, part;
  };
  std::size_t frames_ = 0, driving_count_ = 0, pickup_part_count_ = 0;
  std::array<const float*, kMaxDrives> force_{};
  std::array<std::uint32_t, kMaxDrives> driving_{};
  std::array<float*, kMaxPickups> out_{};
  std::array<PickupPart, kMaxPickupParts> pickup_parts_{};
  std::array<BankDrive, kMaxDrives> kernel_drives_{};
  std::array<BankPickup, kMaxPickupParts> kernel_pickups_{};
  std::array<std::array<float, kMaxSamples>, kMaxPickupParts> output_{}, released_output_{};
};

} // namespace tactus::modal
