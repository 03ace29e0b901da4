#include "core/modal/bank/mode_bank.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
namespace {

constexpr float kMinState = 1e-25F; // smaller states are set to zero, which avoids denormals
constexpr std::array<float, kMaxSamples> kZeros{};

/// A complex product without std::complex's handling of infinities.
Complex product(Complex a, Complex b) noexcept {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

} // namespace

ModeBank::ModeBank(std::span<const Complex> rate, double sample_rate, std::size_t drives,
                   std::size_t pickups, VectorSet widest)
    : modes_(rate.size()), blocks_((rate.size() + kLanes - 1) / kLanes), sample_rate_(sample_rate),
      kernel_(bank_kernel(widest)), poles_(blocks_), state_(blocks_),
      gain_(std::min(drives, kMaxDrives), std::vector<Lane>(blocks_)),
      pickups_(std::min(pickups, kMaxPickups)), feedthrough_(gain_.size() * pickups_.size() * 3),
      active_(blocks_), is_active_(blocks_, 0), released_(blocks_), released_active_(blocks_),
      history_(gain_.size()) {
  for (Pickup& pickup : pickups_) {
    for (auto& weight : pickup.weight)
      weight.resize(blocks_);
    pickup.target.resize(blocks_);
  }
  make_poles(rate);
}

void ModeBank::make_poles(std::span<const Complex> rate) {
  const auto put = [](ComplexLane& to, std::size_t lane, Complex value) {
    to.real.v[lane] = static_cast<float>(value.real());
    to.imaginary.v[lane] = static_cast<float>(value.imag());
  };
  double min_decay = 0, max_decay = 0; // Np per sample, of the blocks that share the last decay
  for (std::size_t b = 0; b < blocks_; ++b) {
    const std::size_t first = b * kLanes, last = std::min(first + kLanes, modes_);
    double low = 1e300, high = 0;
    for (std::size_t k = first; k < last; ++k) {
      low = std::min(low, -rate[k].real() / sample_rate_);
      high = std::max(high, -rate[k].real() / sample_rate_);
    }
    PoleBlock& poles = poles_[b];
    // The state at the middle of a time block must give the one at its beginning without losing
    // digits.
    poles.shares_decay = high - low <= 2 * kMaxDecayMismatch && high * kHalfTimeBlock < 1;
    if (poles.shares_decay) {
      if (decays_.empty() ||
          std::max(max_decay, high) - std::min(min_decay, low) > 2 * kMaxDecayMismatch) {
        decays_.emplace_back();
        min_decay = low;
        max_decay = high;
      }
      min_decay = std::min(min_decay, low);
      max_decay = std::max(max_decay, high);
      poles.decay_index = static_cast<std::uint32_t>(decays_.size() - 1);
      for (std::size_t m = 0; m < kHalfTimeBlock; ++m) {
        const double nepers = 0.5 * (min_decay + max_decay) * (static_cast<double>(m) + 0.5);
        decays_.back().fall[m] = static_cast<float>(math::exp(-nepers));
        decays_.back().rise[m] = static_cast<float>(math::exp(nepers));
      }
    }
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t lane = k - first;
      const auto power = [&](double samples) {
        return math::exp(rate[k] * (samples / sample_rate_));
      };
      if (!poles.shares_decay) {
        for (std::size_t m = 0; m < kTimeBlock; ++m)
          put(poles.power[m], lane, power(static_cast<double>(m) + 1));
        continue;
      }
      for (std::size_t m = 0; m < kHalfTimeBlock; ++m)
        put(poles.power[m], lane,
            math::polar(1.0, rate[k].imag() * (static_cast<double>(m) + 0.5) / sample_rate_));
      constexpr double kCentre = kHalfTimeBlock + 0.5;
      put(poles.power[PoleBlock::kWholeTimeBlock], lane, power(kTimeBlock));
      put(poles.power[PoleBlock::kToMiddle], lane, power(kCentre));
      put(poles.power[PoleBlock::kFromMiddle], lane, power(-kCentre));
      put(poles.power[PoleBlock::kOneSample], lane, power(1));
    }
  }
}

void ModeBank::set_gain(std::size_t drive, std::span<const double> gain) noexcept {
  if (drive >= gain_.size())
    return;
  flush_pending();
  for (std::size_t k = 0; k < std::min(modes_, gain.size()); ++k) {
    const auto [block, lane] = lane_index(k);
    gain_[drive][block].v[lane] = static_cast<float>(gain[k] / sample_rate_);
  }
  for (std::size_t i = 0; i < pickups_.size(); ++i)
    for (const std::size_t part : {kOld, kMiddle, kLatest})
      feedthrough(drive, i, part).valid = false;
}

void ModeBank::write_weight(std::vector<ComplexLane>& to,
                            std::span<const Complex> weight) noexcept {
  for (std::size_t k = 0; k < std::min(modes_, weight.size()); ++k) {
    const auto [block, lane] = lane_index(k);
    to[block].real.v[lane] = static_cast<float>(weight[k].real());
    to[block].imaginary.v[lane] = static_cast<float>(weight[k].imag());
  }
}

void ModeBank::compute_feedthrough(std::size_t drive, std::size_t pickup,
                                   std::size_t part) noexcept {
  CachedResponse& found = feedthrough(drive, pickup, part);
  if (found.valid)
    return;
  found.valid = true;
  found.response.fill(0);
  kernel_->impulse_response(poles_.data(), gain_[drive].data(),
                            pickups_[pickup].weight[part].data(), blocks_,
                            found.response.data() + kTimeBlock);
}

BankView ModeBank::view() noexcept {
  return {poles_.data(), decays_.data(), state_.data(), std::span(active_).first(active_count_)};
}

BankView ModeBank::released_view() noexcept {
  return {poles_.data(), decays_.data(), released_.data(),
          std::span(released_active_).first(released_count_)};
}

void ModeBank::activate_driven(std::size_t drive) noexcept {
  if (active_count_ == blocks_)
    return;
  bool more = false;
  for (std::size_t b = 0; b < blocks_; ++b)
    if (!is_active_[b] && std::any_of(std::begin(gain_[drive][b].v), std::end(gain_[drive][b].v),
                                      [](float x) { return x != 0; })) {
      is_active_[b] = 1;
      more = true;
    }
  if (more)
    list_active();
}

void ModeBank::list_active() noexcept {
  active_count_ = 0;
  for (std::size_t b = 0; b < blocks_; ++b)
    if (is_active_[b])
      active_[active_count_++] = static_cast<std::uint32_t>(b);
}

void ModeBank::process(std::span<const float* const> force, std::span<float* const> out,
                       std::size_t frames) noexcept {
  std::size_t done = 0;
  while (done < frames) {
    const std::size_t to_grid = kMaxSamples - static_cast<std::size_t>(clock_ % kMaxSamples);
    const std::size_t count = std::min({frames - done, to_grid, glide_left()});
    for (std::size_t d = 0; d < gain_.size(); ++d)
      force_[d] = d < force.size() && force[d] ? force[d] + done : nullptr;
    for (std::size_t i = 0; i < pickups_.size(); ++i)
      out_[i] = i < out.size() && out[i] ? out[i] + done : nullptr;
    process_chunk(count);
    done += count;
  }
}

std::size_t ModeBank::find_driving() noexcept {
  std::size_t count = 0;
  for (std::size_t d = 0; d < gain_.size(); ++d) {
    const auto nonzero = [](float f) { return f != 0; };
    const bool now = force_[d] && std::any_of(force_[d], force_[d] + frames_, nonzero);
    if (now)
      activate_driven(d);
    else
      force_[d] = kZeros.data();
    // The history holds forces of the present time block only.
    if (now || (phase_ > 0 && std::any_of(history_[d].begin(), history_[d].end(), nonzero)))
      driving_[count++] = static_cast<std::uint32_t>(d);
  }
  return count;
}

void ModeBank::process_chunk(std::size_t frames) noexcept {
  frames_ = frames;
  driving_count_ = find_driving();
  pickup_part_count_ = 0;
  for (std::size_t i = 0; i < pickups_.size(); ++i) {
    if (!out_[i])
      continue;
    const Glide& glide = pickups_[i].glide;
    const std::size_t first = pickup_part_count_;
    if (glide.moving())
      pickup_parts_[pickup_part_count_++] = {i, kMiddle};
    if (glide.moving() && glide.has_old())
      pickup_parts_[pickup_part_count_++] = {i, kOld};
    if (!glide.moving() || glide.has_latest())
      pickup_parts_[pickup_part_count_++] = {i, kLatest};
    for (std::size_t n = 0; n < driving_count_; ++n)
      for (std::size_t e = first; e < pickup_part_count_; ++e)
        compute_feedthrough(driving_[n], i, pickup_parts_[e].part);
  }
  for (std::size_t done = 0; done < frames;) {
    const std::size_t to_grid = kTimeBlock - static_cast<std::size_t>(clock_ % kTimeBlock);
    std::size_t count = std::min(frames - done, to_grid);
    if (phase_ == 0 && count == kTimeBlock) {
      count = (frames - done) / kTimeBlock * kTimeBlock;
      process_whole_time_blocks(done, count / kTimeBlock);
    } else {
      process_partial_time_block(done, count, count == to_grid);
    }
    clock_ += count;
    done += count;
  }
  mix();
  advance_glides(frames);
  if (clock_ % kAudibilityPeriod == 0)
    deactivate_inaudible();
}

std::size_t ModeBank::list_pickup_parts(std::size_t at) noexcept {
  for (std::size_t e = 0; e < pickup_part_count_; ++e) {
    const Pickup& pickup = pickups_[pickup_parts_[e].pickup];
    kernel_pickups_[e] = {pickup.weight[pickup_parts_[e].part].data(), output_[e].data() + at};
  }
  return pickup_part_count_;
}

void ModeBank::process_whole_time_blocks(std::size_t at, std::size_t time_blocks) noexcept {
  for (std::size_t n = 0; n < driving_count_; ++n)
    kernel_drives_[n] = {gain_[driving_[n]].data(), force_[driving_[n]] + at};
  kernel_->run(view(), time_blocks, std::span(kernel_drives_).first(driving_count_),
               std::span(kernel_pickups_).first(list_pickup_parts(at)));
  for (std::size_t n = 0; n < driving_count_; ++n)
    for (std::size_t e = 0; e < pickup_part_count_; ++e)
      kernel_->feedthrough(
          force_[driving_[n]] + at,
          feedthrough(driving_[n], pickup_parts_[e].pickup, pickup_parts_[e].part).response.data(),
          time_blocks, output_[e].data() + at);
  if (release_left_ == 0)
    return;
  for (std::size_t e = 0; e < pickup_part_count_; ++e)
    kernel_pickups_[e].out = released_output_[e].data() + at;
  kernel_->run(released_view(), time_blocks, {},
               std::span(kernel_pickups_).first(pickup_part_count_));
}

void ModeBank::process_partial_time_block(std::size_t at, std::size_t count, bool ends) noexcept {
  kernel_->output_samples(view(), phase_, count,
                          std::span(kernel_pickups_).first(list_pickup_parts(at)));
  if (release_left_ > 0) {
    for (std::size_t e = 0; e < pickup_part_count_; ++e)
      kernel_pickups_[e].out = released_output_[e].data() + at;
    kernel_->output_samples(released_view(), phase_, count,
                            std::span(kernel_pickups_).first(pickup_part_count_));
  }
  for (std::size_t d = 0; d < gain_.size(); ++d)
    std::copy_n(force_[d] + at, count, history_[d].begin() + static_cast<std::ptrdiff_t>(phase_));
  for (std::size_t n = 0; n < driving_count_; ++n)
    add_feedthrough(driving_[n], phase_, phase_ + count, at);
  phase_ += count;
  if (ends)
    flush_pending();
}

void ModeBank::flush_pending() noexcept {
  if (phase_ == 0)
    return;
  std::size_t count = 0;
  for (std::size_t d = 0; d < gain_.size(); ++d)
    if (std::any_of(history_[d].begin(), history_[d].end(), [](float f) { return f != 0; }))
      kernel_drives_[count++] = {gain_[d].data(), history_[d].data()};
  kernel_->advance(view(), phase_, std::span(kernel_drives_).first(count));
  if (release_left_ > 0)
    kernel_->advance(released_view(), phase_, {});
  for (auto& history : history_)
    history.fill(0);
  phase_ = 0;
}

/// For samples `from` to `to` of the present time block.
void ModeBank::add_feedthrough(std::size_t drive, std::size_t from, std::size_t to,
                               std::size_t at) noexcept {
  for (std::size_t e = 0; e < pickup_part_count_; ++e) {
    std::array<float, kTimeBlock> sum{};
    kernel_->feedthrough(
        history_[drive].data(),
        feedthrough(drive, pickup_parts_[e].pickup, pickup_parts_[e].part).response.data(), 1,
        sum.data());
    for (std::size_t i = from; i < to; ++i)
      output_[e][at + i - from] += sum[i];
  }
}

void ModeBank::mix() noexcept {
  if (release_left_ > 0)
    mix_released();
  for (std::size_t i = 0; i < pickups_.size(); ++i)
    if (out_[i])
      std::fill_n(out_[i], frames_, 0.0F);
  for (std::size_t e = 0; e < pickup_part_count_; ++e) {
    const auto [pickup, part] = pickup_parts_[e];
    const Glide& glide = pickups_[pickup].glide;
    float* const out = out_[pickup];
    if (!glide.moving()) {
      std::copy_n(output_[e].begin(), frames_, out);
      continue;
    }
    for (std::size_t n = 0; n < frames_; ++n) {
      const Glide::Blend blend = glide.blend(n);
      const double share = part == kOld ? blend.old : part == kMiddle ? blend.middle : blend.latest;
      out[n] += static_cast<float>(share) * output_[e][n];
    }
  }
}

void ModeBank::deactivate_inaudible() noexcept {
  std::size_t kept = 0;
  for (std::size_t n = 0; n < active_count_; ++n) {
    const std::size_t b = active_[n];
    bool rings = false;
    // Uses the block's largest weights, because a mode on a nodal line of this listener may be
    // audible at the next listener.
    float loudest = 0;
    for (const Pickup& pickup : pickups_)
      for (std::size_t i = 0; i < kLanes; ++i)
        loudest = std::max({loudest, std::abs(pickup.weight[kLatest][b].real.v[i]),
                            std::abs(pickup.weight[kLatest][b].imaginary.v[i])});
    for (std::size_t i = 0; i < kLanes; ++i) {
      float& real = state_[b].real.v[i];
      float& imaginary = state_[b].imaginary.v[i];
      const float size = std::abs(real) + std::abs(imaginary);
      if (size < kMinState || static_cast<double>(size * loudest) < audibility_floor_)
        real = imaginary = 0;
      else
        rings = true;
    }
    if (rings)
      active_[kept++] = static_cast<std::uint32_t>(b);
    else
      is_active_[b] = 0;
  }
  active_count_ = kept;
}

Complex ModeBank::state(std::size_t mode) const noexcept {
  const auto [block, lane] = lane_index(mode);
  const Complex z = entry(state_[block], lane);
  return poles_[block].shares_decay ? z * entry(poles_[block].power[PoleBlock::kFromMiddle], lane)
                                    : z;
}

void ModeBank::set_state(std::size_t mode, Complex z) noexcept {
  const auto [block, lane] = lane_index(mode);
  if (poles_[block].shares_decay)
    z *= entry(poles_[block].power[PoleBlock::kToMiddle], lane);
  state_[block].real.v[lane] = static_cast<float>(z.real());
  state_[block].imaginary.v[lane] = static_cast<float>(z.imag());
  if (is_active_[block] || (z.real() == 0 && z.imag() == 0))
    return;
  is_active_[block] = 1;
  list_active();
}

void ModeBank::read(const std::vector<ComplexLane>& from, std::span<Complex> z) const noexcept {
  for (std::size_t b = 0; b < blocks_; ++b) {
    const std::size_t first = b * kLanes,
                      last = std::min(first + kLanes, std::min(modes_, z.size()));
    const ComplexLane* rotation =
        poles_[b].shares_decay ? &poles_[b].power[PoleBlock::kFromMiddle] : nullptr;
    for (std::size_t k = first; k < last; ++k) {
      const auto value = entry(from[b], k - first);
      z[k] = rotation ? product(value, entry(*rotation, k - first)) : value;
    }
  }
}

void ModeBank::read_states(std::span<Complex> z) noexcept {
  flush_pending();
  read(state_, z);
}

void ModeBank::write_states(std::span<const Complex> z) noexcept {
  silence();
  for (std::size_t b = 0; b < blocks_; ++b) {
    const std::size_t first = b * kLanes,
                      last = std::min(first + kLanes, std::min(modes_, z.size()));
    const ComplexLane* rotation =
        poles_[b].shares_decay ? &poles_[b].power[PoleBlock::kToMiddle] : nullptr;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t lane = k - first;
      const auto value = rotation ? product(z[k], entry(*rotation, lane)) : z[k];
      state_[b].real.v[lane] = static_cast<float>(value.real());
      state_[b].imaginary.v[lane] = static_cast<float>(value.imag());
      if (value.real() != 0 || value.imag() != 0)
        is_active_[b] = 1;
    }
  }
  list_active();
}

void ModeBank::skip(std::size_t samples) noexcept {
  clock_ += samples;
  while (samples > 0) {
    const std::size_t part = std::min(samples, glide_left());
    advance_glides(part);
    samples -= part;
  }
}

void ModeBank::silence() noexcept {
  flush_pending();
  std::fill(state_.begin(), state_.end(), ComplexLane{});
  std::fill(is_active_.begin(), is_active_.end(), static_cast<unsigned char>(0));
  active_count_ = 0;
}

} // namespace tactus::modal
