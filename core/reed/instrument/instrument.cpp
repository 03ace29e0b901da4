#include "core/reed/instrument/instrument.hpp"

#include "core/dsp/soft_clip.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

/// Converts to the host's precision; numbers that would be denormal there become 0.
template <class S> void copy_output(const double* value, S* out, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i)
    out[i] = static_cast<S>(std::abs(value[i]) < 1e-30 ? 0.0 : value[i]);
}

constexpr double kHighestFrequency = 1e6; // Hz, above the range of every parameter

/// A control that is not finite leaves the last good value. All values below 0 have the same
/// meaning.
void update_control(double& last_good, double value) noexcept {
  if (std::isfinite(value))
    last_good = std::clamp(value, 0.0, kHighestFrequency);
}

} // namespace

/// One step of a linear ramp to the parameters' gain within ParameterGlide::kTime. Before the first
/// sample the gain is set at once.
void Instrument::update_gain() noexcept {
  const Parameters& p = bank_.parameters();
  const double target_gain = p.tune ? p.gain * p.played_gain : p.gain;
  if (gain_unset_) {
    gain_ = target_gain;
    gain_unset_ = false;
  }
  if (bank_.fades_out()) { // the old instrument keeps its gain
    gain_step_ = 0;
    return;
  }
  if (target_gain != target_gain_) {
    target_gain_ = target_gain;
    gain_rate_ = (target_gain - gain_) / gain_periods_;
  }
  const double remaining = target_gain - gain_;
  gain_step_ = std::abs(remaining) > 1.5 * std::abs(gain_rate_) ? gain_rate_ : remaining;
  gain_ = gain_step_ == remaining ? target_gain : gain_ + gain_step_;
}

void Instrument::prepare(double sample_rate, std::size_t) {
  sample_rate = std::clamp(sample_rate, 1000.0, 1e6);
  bank_.prepare(sample_rate);
  gain_periods_ = ParameterGlide::kTime * sample_rate / kBlock + 1;
}

bool Instrument::finger_holes(std::span<const double> closed) noexcept {
  for (const double hole : closed)
    if (!(hole >= 0 && hole <= 1))
      return false;
  if (closed.empty())
    return false;
  const Termination* const found = fingerings_->find(bank_.parameters().end, closed.subspan(1));
  if (found == nullptr)
    return false;
  bank_.finger(found, 1 - closed[0]);
  return true;
}

void Instrument::reset() noexcept {
  bank_.reset();
  gain_unset_ = true;
  last_pressure_ = reed_frequency_ = bore_frequency_ = 0;
}

/// Clamps mouth pressures; NaN becomes the pressure before.
void Instrument::read_mouth_pressure(double* mouth, std::size_t count) noexcept {
  bool usable = true;
  for (std::size_t i = 0; i < count; ++i)
    usable &= std::abs(mouth[i]) <= kHighestPressure;
  if (!usable)
    for (std::size_t i = 0; i < count; ++i) {
      const double previous = i == 0 ? last_pressure_ : mouth[i - 1];
      mouth[i] = mouth[i] == mouth[i] ? std::clamp(mouth[i], -kHighestPressure, kHighestPressure)
                                      : previous;
    }
  last_pressure_ = mouth[count - 1];
}

/// Converts the pressure at 1 m (Pa) to the sound, in place.
void Instrument::apply_gain(double* radiated, std::size_t count) const noexcept {
  if (gain_step_ != 0) {
    const auto left = static_cast<double>(bank_.until_control());
    for (std::size_t i = 0; i < count; ++i)
      radiated[i] *= gain_ - gain_step_ * (left + static_cast<double>(count - 1 - i)) / kBlock;
  } else {
    for (std::size_t i = 0; i < count; ++i)
      radiated[i] *= gain_;
  }
  bool loud = false;
  for (std::size_t i = 0; i < count; ++i)
    loud |= std::abs(radiated[i]) > kLinearLimit;
  if (loud)
    for (std::size_t i = 0; i < count; ++i)
      radiated[i] = soft_clip(radiated[i]);
}

template <class S> void Instrument::process(const Controls<S>& in, const Outputs<S>& out) noexcept {
  std::array<double, kBlock> mouth, radiated, angle, bore, flow;
  const std::size_t size = in.mouth_pressure.size();
  for (std::size_t done = 0; done < size;) {
    if (bank_.until_control() == 0) {
      update_control(reed_frequency_, static_cast<double>(in.reed_frequency[done]));
      update_control(bore_frequency_, static_cast<double>(in.bore_frequency[done]));
      // The lips' tension follows the mouth pressure before the tongue closes the channel.
      bank_.control(reed_frequency_, bore_frequency_, std::max(0.0, last_pressure_));
      update_gain();
    }
    const std::size_t count =
        std::min(size - done, static_cast<std::size_t>(bank_.until_control()));
    for (std::size_t i = 0; i < count; ++i)
      mouth[i] = static_cast<double>(in.mouth_pressure[done + i]);
    read_mouth_pressure(mouth.data(), count);
    bank_.run(mouth.data(), {radiated.data(), angle.data(), bore.data(), flow.data()},
              static_cast<int>(count));
    apply_gain(radiated.data(), count);
    copy_output(radiated.data(), out.sound.data() + done, count);
    copy_output(angle.data(), out.theta.data() + done, count);
    copy_output(bore.data(), out.bore_pressure.data() + done, count);
    copy_output(flow.data(), out.flow.data() + done, count);
    done += count;
  }
}

template void Instrument::process(const Controls<float>&, const Outputs<float>&) noexcept;
template void Instrument::process(const Controls<double>&, const Outputs<double>&) noexcept;

} // namespace tactus::reed
