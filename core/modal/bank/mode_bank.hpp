#pragma once

#include "core/dsp/complex.hpp"
#include "core/modal/bank/bank_kernel.hpp"
#include "core/modal/bank/glide.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

/// Thousands of damped oscillators (the modes of a body), driven by forces and summed to outputs.
///
/// Mode k has the complex rate s = -alpha + j omega_d (1/s) and follows
///   q'' + 2 alpha q' + (alpha^2 + omega_d^2) q = sum over drives of b F,   [q] = m sqrt(kg).
/// Its state is z = q' + alpha q + j omega_d q. A sample of force F adds b F T to z, and time t
/// multiplies it by exp(s t): impulse invariance, exact for impulses at the samples. The output of
/// a pick-up with complex weights w is the sum over the modes of Im(w z). States are in single
/// precision; rates and gains are computed in double.
///
/// Only the constructor allocates. The same input gives the same bits in blocks of any size.
class ModeBank {
public:
  /// `rate` holds s of each mode, in any order; modes of similar decay next to each other are
  /// computed fastest. |s| T should be below pi. At most 72 drives and 4 pick-ups are used.
  ModeBank(std::span<const Complex> rate, double sample_rate, std::size_t drives,
           std::size_t pickups, VectorSet widest = simd::kWidest);

  /// Sets the gains b of the modes, 1/sqrt(kg), at the point where a drive acts, at once.
  void set_gain(std::size_t drive, std::span<const double> gain) noexcept;
  /// Sets a pick-up's weights w; they glide to the new ones (Glide), however often they change.
  void set_weight(std::size_t pickup, std::span<const Complex> weight) noexcept;
  /// Sets the weights of all pick-ups in step: if one of them changes, all glide.
  void set_weights(std::span<const std::vector<Complex>> weight) noexcept;
  /// Sets a pick-up's weights without a glide.
  void jump_to_weight(std::size_t pickup, std::span<const Complex> weight) noexcept;

  /// The three weights that a pick-up glides between; at rest kLatest is used.
  enum Part : std::size_t { kOld, kMiddle, kLatest };
  [[nodiscard]] const Glide& glide(std::size_t pickup) const noexcept {
    return pickups_[pickup].glide;
  }
  [[nodiscard]] Complex weight(std::size_t pickup, Part part, std::size_t mode) const noexcept;
  /// Continues another bank's glide with these weights of all modes: old, middle and latest.
  void set_glide(std::size_t pickup, const Glide& glide,
                 const std::array<std::span<const Complex>, 3>& weight) noexcept;
  /// Increases with every change of the three weights.
  [[nodiscard]] std::uint64_t glide_version() const noexcept { return glide_version_; }
  /// Samples until the first pick-up exchanges its three weights.
  [[nodiscard]] std::size_t glide_left() const noexcept;

  /// Computes `frames` samples. force[i] points to the samples of drive i in N, which must be
  /// finite; out[i] is overwritten with the output of pick-up i. Either may be null.
  void process(std::span<const float* const> force, std::span<float* const> out,
               std::size_t frames) noexcept;

  /// Applies the pending part of a time block, so that states can be read and changed.
  void flush_pending() noexcept;
  [[nodiscard]] Complex state(std::size_t mode) const noexcept;
  void set_state(std::size_t mode, Complex z) noexcept;
  /// All states at once, after flush_pending().
  void read_states(std::span<Complex> z) noexcept;
  void write_states(std::span<const Complex> z) noexcept;
  void silence() noexcept;
  /// Fades out all vibration: the present states are copied, ring on separately, and fade within
  /// kRelease samples by half a period of a cosine. The states themselves become zero.
  void release() noexcept;
  [[nodiscard]] std::size_t release_left() const noexcept { return release_left_; }
  /// The states that are being faded out, to hand them to the bank of a new model.
  void read_released(std::span<Complex> z) noexcept;
  void write_released(std::span<const Complex> z, std::size_t left) noexcept;
  /// True if nothing rings: process() then costs almost nothing and gives zeros while there is no
  /// force.
  [[nodiscard]] bool idle() const noexcept { return active_count_ == 0 && release_left_ == 0; }
  /// True if modes ring besides those that are being faded out.
  [[nodiscard]] bool ringing() const noexcept { return active_count_ > 0; }
  /// Blocks of modes that are computed now, of kLanes modes each.
  [[nodiscard]] std::size_t active_blocks() const noexcept { return active_count_; }
  /// A mode whose part in every pick-up's output is below this level is set to zero.
  void set_audibility_floor(double level) noexcept { audibility_floor_ = level; }
  [[nodiscard]] std::size_t modes() const noexcept { return modes_; }
  /// Samples so far. They fix the grid of time blocks, so that a new bank can continue another
  /// one's.
  [[nodiscard]] std::uint64_t clock() const noexcept { return clock_; }
  void set_clock(std::uint64_t clock) noexcept { clock_ = clock; }

  /// Advances the clock and the glides only, without computing. Call flush_pending() first, and
  /// only while nothing is being faded out.
  void skip(std::size_t samples) noexcept;

  static constexpr std::size_t kRelease = 1024; ///< samples
  /// The gain of the fade-out, from 1 to 0, with `left` samples to go.
  [[nodiscard]] static double release_share(std::size_t left) noexcept;
  /// A block whose modes' decay rates times T differ from their mean by less than this shares one
  /// decay within a time block: an error below -65 dB.
  static constexpr double kMaxDecayMismatch = 1.2e-4;

private:
  static constexpr std::size_t kMaxDrives = 72, kMaxPickups = kMaxPickupParts / 3;
  /// Samples between the checks for modes that have become inaudible.
  static constexpr std::uint64_t kAudibilityPeriod = 1024;

  struct LaneIndex {
    std::size_t block, lane;
  };
  [[nodiscard]] static LaneIndex lane_index(std::size_t mode) noexcept {
    return {mode / kLanes, mode % kLanes};
  }
  struct Pickup {
    std::array<std::vector<ComplexLane>, 3> weight; ///< weights by Part
    std::vector<ComplexLane> target;                ///< the waiting one
    Glide glide;
  };
  /// The output of forces within their own time block: kTimeBlock zeros, then the sum over the
  /// modes of Im(w b T p^m), m = 0 ... kTimeBlock - 1.
  using Response = std::array<float, 2 * kTimeBlock>;
  struct CachedResponse {
    Response response;
    bool valid = false;
  };
  [[nodiscard]] CachedResponse& feedthrough(std::size_t drive, std::size_t pickup,
                                            std::size_t part) noexcept {
    return feedthrough_[(drive * pickups_.size() + pickup) * 3 + part];
  }
  [[nodiscard]] Complex entry(const ComplexLane& lanes, std::size_t lane) const noexcept {
    return {static_cast<double>(lanes.real.v[lane]), static_cast<double>(lanes.imaginary.v[lane])};
  }
  void write_weight(std::vector<ComplexLane>& to, std::span<const Complex> weight) noexcept;
  [[nodiscard]] bool is_target(std::size_t pickup, std::span<const Complex> weight) const noexcept;
  void glide_to(std::size_t pickup, std::span<const Complex> weight) noexcept;
  void exchange(std::size_t pickup, Glide::Exchange exchange, bool had_target) noexcept;
  void advance_glides(std::size_t samples) noexcept;
  void compute_feedthrough(std::size_t drive, std::size_t pickup, std::size_t part) noexcept;
  void read(const std::vector<ComplexLane>& from, std::span<Complex> z) const noexcept;
  void list_released() noexcept;
  void mix_released() noexcept;
  void activate_driven(std::size_t drive) noexcept;
  void make_poles(std::span<const Complex> rate);
  void list_active() noexcept;
  /// Processes at most kMaxSamples, up to the next multiple of kMaxSamples on the clock.
  void process_chunk(std::size_t frames) noexcept;
  [[nodiscard]] std::size_t find_driving() noexcept;
  std::size_t list_pickup_parts(std::size_t at) noexcept;
  void process_whole_time_blocks(std::size_t at, std::size_t time_blocks) noexcept;
  void process_partial_time_block(std::size_t at, std::size_t count, bool ends) noexcept;
  void add_feedthrough(std::size_t drive, std::size_t from, std::size_t to,
                       std::size_t at) noexcept;
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
  std::vector<CachedResponse> feedthrough_;
  std::uint64_t glide_version_ = 0;
  std::vector<std::uint32_t> active_;
  std::vector<unsigned char> is_active_;
  std::size_t active_count_ = 0;
  std::vector<ComplexLane> released_;
  std::vector<std::uint32_t> released_active_;
  std::size_t released_count_ = 0, release_left_ = 0; // blocks, samples
  double audibility_floor_ = 0;

  std::uint64_t clock_ = 0;                            // samples
  std::size_t phase_ = 0;                              // samples into the present time block
  std::vector<std::array<float, kTimeBlock>> history_; // [drive], forces of the present time block
  // Data of the present chunk.
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
