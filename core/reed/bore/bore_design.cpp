#include "core/reed/bore/bore_design.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/radiation.hpp"
#include "core/reed/bore/wall_loss.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using std::numbers::pi;
constexpr double kMinLength = 5e-3; // m
// Nepers per section. The limit keeps the poles apart, by a factor of two or more in frequency. A
// bore so long and narrow that it would need a larger attenuation reflects nothing audible.
constexpr double kMaxAttenuation = 2;
constexpr double kLowestPole = 3, kHighestPole = 20e3; // Hz
// Weights of G h/pi sqrt(q_k) in the sections: non-negative least squares of their sum and a delay
// to the complex sqrt(s) from 12 Hz to 11 kHz, at each of these rates. The first and the last
// weight also represent the integral beyond them.
using SectionWeights = std::array<double, RoundTrip::kLossSections>;
struct SectionWeightsAt {
  double rate; // Hz
  SectionWeights share;
};
constexpr std::array<SectionWeightsAt, 4> kSectionWeights{
    {{44100, {2.780, 0.545, 1.094, 0.974, 0.998, 1.035, 0.865, 1.701}},
     {48000, {2.744, 0.562, 1.091, 0.973, 1.001, 1.026, 0.885, 1.663}},
     {96000, {2.727, 0.569, 1.091, 0.969, 1.009, 1.007, 0.950, 1.334}},
     {192000, {2.727, 0.568, 1.092, 0.969, 1.010, 1.006, 0.956, 1.306}}}};

/// The weights at any rate, interpolated linearly over 1/rate.
SectionWeights section_weights_at(double rate) {
  rate = std::clamp(rate, kSectionWeights.front().rate, kSectionWeights.back().rate);
  std::size_t i = 1;
  while (kSectionWeights[i].rate < rate)
    ++i;
  const SectionWeightsAt &low = kSectionWeights[i - 1], &high = kSectionWeights[i];
  const double part = (1 / low.rate - 1 / rate) / (1 / low.rate - 1 / high.rate);
  SectionWeights share = low.share;
  for (std::size_t k = 0; k < share.size(); ++k)
    share[k] += part * (high.share[k] - low.share[k]);
  return share;
}

/// A section gain * (1 + excess z^-1/(1 - pole z^-1)): (1 + s/zero)/(1 + s/pole) with pole and zero
/// mapped to exp(-pole T) and exp(-zero T).
struct Section {
  double gain, pole, excess;
};
/// zero and pole are times T.
Section section(double zero, double pole) {
  const double pole_minus_one = math::expm1(-pole), zero_minus_one = math::expm1(-zero);
  return {pole_minus_one / zero_minus_one, 1 + pole_minus_one, pole_minus_one - zero_minus_one};
}

} // namespace

RoundTrip RoundTrip::interpolate(const RoundTrip& from, const RoundTrip& to,
                                 double share) noexcept {
  RoundTrip trip = to;
  const auto blend = [share](double& value, double start) {
    value = start + share * (value - start);
  };
  for (std::size_t k = 0; k < kLossSections; ++k) {
    blend(trip.loss_pole[k], from.loss_pole[k]);
    blend(trip.loss_residue[k], from.loss_residue[k]);
  }
  blend(trip.incident_gain, from.incident_gain);
  for (std::size_t k = 0; k < trip.end.pole.size(); ++k) {
    blend(trip.end.pole[k], from.end.pole[k]);
    blend(trip.end.input[k], from.end.input[k]);
  }
  blend(trip.end.direct, from.end.direct);
  return trip;
}

int max_delay(double internal_rate) noexcept {
  // The cone's round trip at the lowest frequency is one period; the filters need a little more.
  return static_cast<int>(internal_rate / BoreDesign::kLowestFrequency * 1.05) + 16;
}

void BoreDesign::set_geometry(const Parameters& parameters) noexcept {
  parameters_ = parameters;
  rate_ = 0;
  air_ = air_at(parameters.temperature);
  impedance_ =
      air_.density * air_.sound_speed / (pi * parameters.input_radius * parameters.input_radius);
}

void BoreDesign::set(const Parameters& parameters, double internal_rate) noexcept {
  set_geometry(parameters);
  rate_ = internal_rate;
  const double low = 2 * pi * kLowestPole;
  const double high = 2 * pi * std::min(0.4 * rate_, kHighestPole);
  spacing_ = math::log(high / low) / (RoundTrip::kLossSections - 1);
  const SectionWeights share = section_weights_at(rate_);
  for (std::size_t k = 0; k < frequency_.size(); ++k) {
    const double q = low * math::exp(spacing_ * static_cast<double>(k));
    frequency_[k] = q;
    weight_[k] = share[k] * spacing_ / pi * std::sqrt(q);
  }
  open_end_ = DigitalOpenEnd::of(parameters.end_radius / air_.sound_speed * rate_, 1 / rate_);
  set_end(end_);
}

void BoreDesign::set_end(const Termination* end) noexcept {
  end_ = end;
  if (!(rate_ > 0))
    return;
  const double ratio = air_.sound_speed / air_at(20).sound_speed;
  const bool same = end == digital_source_ && rate_ == digital_rate_ && ratio == digital_ratio_;
  // Stored even if null, because the termination at that address may have changed when it is set
  // again.
  digital_source_ = end;
  if (end == nullptr || same)
    return;
  digital_rate_ = rate_, digital_ratio_ = ratio;
  digital_end_.set(end->reflection, end->dc_value, rate_, ratio, 1);
}

Complex BoreDesign::end_reflection(Complex s) const noexcept {
  if (end_ == nullptr)
    return OpenEnd::reflection(s * parameters_.end_radius / air_.sound_speed);
  return end_->reflectance(s * (air_at(20).sound_speed / air_.sound_speed)).value *
         math::exp(-2.0 * s * end_->extra_length / air_.sound_speed);
}

double BoreDesign::end_correction() const noexcept {
  return end_ != nullptr ? end_->length_correction()
                         : OpenEnd::kLengthCorrection * parameters_.end_radius;
}

double BoreDesign::ideal_frequency(double length) const noexcept {
  const double acoustic = length + end_correction();
  return parameters_.shape == BoreShape::kCone
             ? air_.sound_speed / (2 * (acoustic + parameters_.apex_distance))
             : air_.sound_speed / (4 * acoustic);
}

double BoreDesign::length_for(double bore_frequency) const noexcept {
  const double correction = end_correction();
  const double length =
      parameters_.shape == BoreShape::kCone
          ? air_.sound_speed / (2 * bore_frequency) - parameters_.apex_distance - correction
          : air_.sound_speed / (4 * bore_frequency) - correction;
  return std::clamp(length, kMinLength, max_length());
}

double BoreDesign::max_length() const noexcept { return 0.5 * air_.sound_speed / kLowestFrequency; }

/// Sets losses and open end of the filters; loss is G, s^(1/2).
void BoreDesign::set_losses(RoundTrip& trip, double loss) const noexcept {
  std::array<Section, RoundTrip::kLossSections> row;
  trip.incident_gain = 1;
  for (std::size_t k = 0; k < row.size(); ++k) {
    const double attenuation = std::min(loss * weight_[k], kMaxAttenuation);
    const double spread = math::exp(attenuation / 2);
    const double normalised_frequency = frequency_[k] / rate_;
    row[k] = section(normalised_frequency * spread, normalised_frequency / spread);
    trip.incident_gain *= row[k].gain;
  }
  for (std::size_t k = 0; k < row.size(); ++k) {
    trip.loss_pole[k] = row[k].pole;
    trip.loss_residue[k] = row[k].excess;
    for (std::size_t j = 0; j < row.size(); ++j)
      if (j != k)
        trip.loss_residue[k] *= 1 + row[j].excess / (row[k].pole - row[j].pole);
  }
  if (end_ == nullptr)
    trip.end = open_end_;
}

BoreDesign::Parts BoreDesign::parts(const RoundTrip& whole, double length,
                                    double position) const noexcept {
  Parts parts{whole, whole};
  const double above = wall_loss(parameters_, position, air_.sound_speed);
  set_losses(parts.above, above);
  set_losses(parts.below, std::max(0.0, wall_loss(parameters_, length, air_.sound_speed) - above));
  parts.above.delay = 2 * position / air_.sound_speed * rate_;
  parts.below.delay = whole.delay - parts.above.delay;
  return parts;
}

RoundTrip BoreDesign::round_trip(double length) const noexcept {
  RoundTrip trip;
  double transit = 2 * length / air_.sound_speed;
  if (parameters_.scalar_reflection > 0) {
    trip.end.direct = -parameters_.scalar_reflection;
    trip.delay = std::clamp(transit * rate_, 3.0, static_cast<double>(max_delay(rate_)));
    return trip;
  }
  const double loss = wall_loss(parameters_, length, air_.sound_speed);
  set_losses(trip, loss);
  if (end_ != nullptr)
    transit += 2 * end_->extra_length / air_.sound_speed;

  // The delay corrects the phase of the filters at the lowest resonance.
  const double omega = 2 * pi * std::min(ideal_frequency(length), 0.1 * rate_);
  const Complex s(0, omega), back = math::exp(-s / rate_);
  Complex filters = 1;
  for (std::size_t k = 0; k < trip.loss_pole.size(); ++k)
    filters += trip.loss_residue[k] * back / (1.0 - trip.loss_pole[k] * back);
  filters *= trip.incident_gain;
  if (end_ == nullptr)
    filters *= open_end_.at(back);
  else
    filters *= digital_end_.at(back) * math::exp(-2.0 * s * end_->extra_length / air_.sound_speed);
  const Complex target = math::exp(-loss * math::sqrt(s)) * end_reflection(s);
  const double phase_lead = math::arg(filters / target);
  trip.delay = std::clamp((transit + phase_lead / omega) * rate_, 3.0,
                          static_cast<double>(max_delay(rate_)));
  return trip;
}

} // namespace tactus::reed
