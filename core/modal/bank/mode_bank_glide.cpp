#include "core/dsp/complex.hpp"
#include "core/modal/bank/mode_bank.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

/// The glides of a ModeBank's weights, and its fade-out.
namespace tactus::modal {

void ModeBank::set_weight(std::size_t pickup, std::span<const Complex> weight) noexcept {
  if (pickup < pickups_.size() && !is_target(pickup, weight))
    glide_to(pickup, weight);
}

void ModeBank::set_weights(std::span<const std::vector<Complex>> weight) noexcept {
  const std::size_t count = std::min(pickups_.size(), weight.size());
  bool same = modes_ > 0; // without modes equal weights do not mean that nothing has changed
  for (std::size_t i = 0; i < count && same; ++i)
    same = is_target(i, weight[i]);
  for (std::size_t i = 0; i < count && !same; ++i)
    glide_to(i, weight[i]);
}

/// True if `weight` equals the newest target.
bool ModeBank::is_target(std::size_t pickup, std::span<const Complex> weight) const noexcept {
  const Pickup& at = pickups_[pickup];
  const auto& last = at.glide.has_target() ? at.target : at.weight[kLatest];
  bool same = true;
  for (std::size_t k = 0; k < std::min(modes_, weight.size()) && same; ++k) {
    const auto [block, lane] = lane_index(k);
    same = last[block].real.v[lane] == static_cast<float>(weight[k].real()) &&
           last[block].imaginary.v[lane] == static_cast<float>(weight[k].imag());
  }
  return same;
}

void ModeBank::glide_to(std::size_t pickup, std::span<const Complex> weight) noexcept {
  flush_pending();
  write_weight(pickups_[pickup].target, weight);
  exchange(pickup, pickups_[pickup].glide.start(), true);
}

void ModeBank::jump_to_weight(std::size_t pickup, std::span<const Complex> weight) noexcept {
  if (pickup >= pickups_.size())
    return;
  flush_pending();
  pickups_[pickup].glide.stop();
  write_weight(pickups_[pickup].weight[kLatest], weight);
  for (std::size_t d = 0; d < gain_.size(); ++d)
    feedthrough(d, pickup, kLatest).valid = false;
  ++glide_version_;
}

void ModeBank::set_glide(std::size_t pickup, const Glide& glide,
                         const std::array<std::span<const Complex>, 3>& weight) noexcept {
  if (pickup >= pickups_.size())
    return;
  flush_pending();
  Pickup& at = pickups_[pickup];
  at.glide = glide;
  at.glide.clear_target();
  for (const std::size_t part : {kOld, kMiddle, kLatest}) {
    write_weight(at.weight[part], weight[part]);
    for (std::size_t d = 0; d < gain_.size(); ++d)
      feedthrough(d, pickup, part).valid = false;
  }
  ++glide_version_;
}

/// Exchanges the weights as the glide requires, and with them the cached responses.
void ModeBank::exchange(std::size_t pickup, Glide::Exchange exchange, bool had_target) noexcept {
  if (exchange == Glide::Exchange::kNone)
    return;
  ++glide_version_;
  auto& weight = pickups_[pickup].weight;
  const auto move_weights = [&](Part from, Part to) {
    std::swap(weight[from], weight[to]);
    for (std::size_t d = 0; d < gain_.size(); ++d)
      std::swap(feedthrough(d, pickup, from), feedthrough(d, pickup, to));
  };
  if (exchange == Glide::Exchange::kRotate)
    move_weights(kMiddle, kOld);
  move_weights(kLatest, kMiddle);
  const auto& latest = had_target ? pickups_[pickup].target : weight[kMiddle];
  std::copy(latest.begin(), latest.end(), weight[kLatest].begin());
  for (std::size_t d = 0; d < gain_.size(); ++d)
    if (had_target)
      feedthrough(d, pickup, kLatest).valid = false;
    else
      feedthrough(d, pickup, kLatest) = feedthrough(d, pickup, kMiddle);
}

void ModeBank::advance_glides(std::size_t samples) noexcept {
  for (std::size_t i = 0; i < pickups_.size(); ++i) {
    const bool had_target = pickups_[i].glide.has_target();
    exchange(i, pickups_[i].glide.advance(samples), had_target);
  }
}

std::size_t ModeBank::glide_left() const noexcept {
  std::size_t left = Glide::kSegment;
  for (const Pickup& pickup : pickups_)
    if (pickup.glide.moving())
      left = std::min(left, pickup.glide.left());
  return left;
}

Complex ModeBank::weight(std::size_t pickup, Part part, std::size_t mode) const noexcept {
  const auto [block, lane] = lane_index(mode);
  return entry(pickups_[pickup].weight[part][block], lane);
}

void ModeBank::read_released(std::span<Complex> z) noexcept {
  flush_pending();
  read(released_, z);
}

void ModeBank::write_released(std::span<const Complex> z, std::size_t left) noexcept {
  write_states(z);
  release();
  release_left_ = std::min(left, kRelease);
}

double ModeBank::release_share(std::size_t left) noexcept {
  const double u = static_cast<double>(kRelease - left) / kRelease;
  return 0.5 + 0.5 * math::cos(std::numbers::pi * u);
}

void ModeBank::release() noexcept {
  flush_pending();
  const auto share = static_cast<float>(release_share(release_left_));
  for (std::size_t b = 0; b < blocks_; ++b)
    for (std::size_t i = 0; i < kLanes; ++i) {
      float& real = released_[b].real.v[i];
      float& imaginary = released_[b].imaginary.v[i];
      real = share * real + state_[b].real.v[i];
      imaginary = share * imaginary + state_[b].imaginary.v[i];
    }
  silence();
  list_released();
  release_left_ = released_count_ > 0 ? kRelease : 0;
}

void ModeBank::list_released() noexcept {
  released_count_ = 0;
  for (std::size_t b = 0; b < blocks_; ++b) {
    bool rings = false;
    for (std::size_t i = 0; i < kLanes; ++i)
      rings = rings || released_[b].real.v[i] != 0 || released_[b].imaginary.v[i] != 0;
    if (rings)
      released_active_[released_count_++] = static_cast<std::uint32_t>(b);
  }
}

/// Adds the output of the states that are being faded out, times release_share().
void ModeBank::mix_released() noexcept {
  const std::size_t count = std::min(frames_, release_left_);
  for (std::size_t n = 0; n < count; ++n) {
    const auto share = static_cast<float>(release_share(release_left_ - n));
    for (std::size_t e = 0; e < pickup_part_count_; ++e)
      output_[e][n] += share * released_output_[e][n];
  }
  release_left_ -= count;
  if (release_left_ > 0)
    return;
  std::fill(released_.begin(), released_.end(), ComplexLane{});
  released_count_ = 0;
}

} // namespace tactus::modal
