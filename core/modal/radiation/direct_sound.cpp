#include "core/modal/radiation/direct_sound.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {
namespace {

constexpr std::size_t kNodes = BandLimit::kNodes, kGauss = BandLimit::kGauss;
constexpr double kHighDecay = 0.3;    // Np per sample, smallest decay of modes too high for the
                                      // bank
constexpr double kSilentDecay = 9;    // Np after which a mode is cut off
constexpr std::size_t kHighTail = 30; // samples: kSilentDecay at kHighDecay

/// The Legendre polynomial of a degree up to 3.
double low_legendre(std::size_t degree, double x) noexcept {
  switch (degree) {
  case 0:
    return 1;
  case 1:
    return x;
  case 2:
    return 1.5 * x * x - 0.5;
  default:
    return (2.5 * x * x - 1.5) * x;
  }
}

/// int over 0..1 of P_j(2 v - 1) e^(s (1 - v)) dv, j = 0 ... 3.
std::array<Complex, kGauss> exponential_moments(Complex s) noexcept {
  constexpr std::size_t kPanels = 8; // s of a panel stays below 3 for all modes of a contact
  std::array<Complex, kGauss> sum{};
  for (std::size_t panel = 0; panel < kPanels; ++panel)
    for (std::size_t m = 0; m < kGauss; ++m) {
      const double v = (static_cast<double>(panel) + BandLimit::kNode[1 + m]) / kPanels;
      const Complex part = BandLimit::kGaussWeight[m] / kPanels * math::exp(s * (1 - v));
      for (std::size_t j = 0; j < kGauss; ++j)
        sum[j] += low_legendre(j, 2 * v - 1) * part;
    }
  if (math::abs(s) > 0.1) // the mean in closed form, which must cancel the bank's response to
                          // constant forces
    sum[0] = (math::exp(s) - 1.0) / s;
  return sum;
}

/// Displacement and velocity of a mode, time in samples: z = q' + alpha q + j omega q.
struct Motion {
  double q, v;
  Motion(Complex z, Complex s) noexcept : q(z.imag() / s.imag()), v(z.real() + s.real() * q) {}
};

} // namespace

namespace {

constexpr std::size_t kBandLimit = BandLimit::kLength + 2; // samples in addition to the arrivals'
                                                           // spread

} // namespace

std::size_t DirectKernels::max_spread(std::size_t modes, std::size_t vertices) noexcept {
  const std::size_t rows =
      std::max<std::size_t>(vertices > 0 ? std::min(modes, 3 * vertices) : modes, 1);
  const std::size_t taps = std::clamp<std::size_t>(kMaxNumbers / (2 * rows), 256, kMaxTaps);
  return std::min(Arrivals::kMaxSpread, taps / 2 - kBandLimit);
}

void DirectKernels::build(const Arrivals& arrivals, std::span<const Mode> modes, bool rigid,
                          double sample_rate, const SurfaceShapes& shapes) {
  const std::size_t arrived = arrivals.samples();
  const double spread = static_cast<double>(arrived);
  double tail = 0;
  for (const Mode& mode : modes) {
    const double decay = -mode.rate.real() / sample_rate;
    if (mode.part == Mode::Part::kTooHigh)
      tail = std::max(tail, static_cast<double>(kHighTail));
    else if (mode.part == Mode::Part::kRinging && decay * spread > kMaxDecay)
      tail = std::max(tail, kSilentDecay / decay);
  }
  const std::size_t vertices = shapes.vertices(), surface_rows = 3 * vertices;
  const std::size_t rows = vertices > 0 ? std::min(modes.size(), surface_rows) : modes.size();
  const std::size_t room = kMaxNumbers / (2 * std::max<std::size_t>(rows, 1));
  taps_ = std::min(arrived + static_cast<std::size_t>(tail) + 1,
                   std::max(std::min(kMaxTaps, room), arrived + 1));
  on_surface_ = vertices > 0 && modes.size() * taps_ > kMaxSummed &&
                std::uint64_t{3} * surface_rows * (taps_ + kTimeBlock) <= kMaxNumbers;
  if (on_surface_)
    taps_ = (taps_ + kTimeBlock - 1) / kTimeBlock * kTimeBlock;
  const std::size_t numbers = (on_surface_ ? surface_rows : modes.size()) * taps_;
  const std::uint64_t products = std::uint64_t{modes.size()} * numbers * (2 + kMaxMoments);
  const bool shaped = on_surface_
                          ? products <= kMaxProducts && (2 + kMaxMoments) * numbers <= kMaxNumbers
                          : numbers <= 8 * kMaxSummed;
  moment_count_ = shaped ? kMaxMoments : 1;
  weight_.clear();
  samples_.assign(numbers, 0);
  moments_.assign(moment_count_ * numbers, 0);
  pressure_.assign(taps_ * kNodes, 0);
  motion_.assign(taps_ + 1, 0);
  pulses_.assign(on_surface_ ? numbers : 0, 0);
  if (on_surface_) {
    sum_over_modes(arrivals, modes, sample_rate, shapes);
  } else {
    for (std::size_t k = 0; k < modes.size(); ++k)
      if (modes[k].part != Mode::Part::kInaudible)
        compute_mode(arrivals, modes[k], sample_rate, samples_.data() + k * taps_,
                     moments_.data() + k * moment_count_ * taps_);
  }
  if (rigid) {
    rigid_samples_.clear();
    rigid_moments_.clear();
    for (std::size_t r = 0; r < Arrivals::kRigid; ++r)
      add_rigid(arrivals, r, pressure_);
  }
  pressure_ = {};
  motion_ = {};
}

void DirectKernels::sum_over_modes(const Arrivals& arrivals, std::span<const Mode> modes,
                                   double sample_rate, const SurfaceShapes& shapes) {
  constexpr std::size_t kBatch = 128;
  const std::size_t vertices = shapes.vertices(), row = moment_count_ * taps_;
  std::vector<float> samples(kBatch * taps_), moments(kBatch * row);
  std::vector<float> shape(3 * vertices * kBatch);
  for (std::size_t first = 0; first < modes.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, modes.size() - first);
    std::fill(samples.begin(), samples.end(), 0.0F);
    std::fill(moments.begin(), moments.end(), 0.0F);
    for (std::size_t i = 0; i < count; ++i) {
      const Mode& mode = modes[first + i];
      if (mode.part != Mode::Part::kInaudible)
        compute_mode(arrivals, mode, sample_rate, samples.data() + i * taps_,
                     moments.data() + i * row);
      for (std::size_t v = 0; v < vertices; ++v)
        for (std::size_t axis = 0; axis < 3; ++axis)
          shape[(3 * v + axis) * count + i] =
              shapes.shape[(v * shapes.modes + mode.motion) * 3 + axis];
    }
    shapes.kernel->accumulate(shape.data(), samples.data(), samples_.data(), 3 * vertices, count,
                              taps_);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t n = 0; n < taps_; ++n)
        samples[i * taps_ + n] *= static_cast<float>(modes[first + i].pulse_gain);
    shapes.kernel->accumulate(shape.data(), samples.data(), pulses_.data(), 3 * vertices, count,
                              taps_);
    shapes.kernel->accumulate(shape.data(), moments.data(), moments_.data(), 3 * vertices, count,
                              row);
  }
}

/// z' = s z + gamma, exact for the cubic through gamma at the Gauss nodes of every sample.
void DirectKernels::integrate_motion(Complex pole, const std::array<Complex, 4>& shape) noexcept {
  std::array<Complex, kGauss> response{};
  for (std::size_t m = 0; m < kGauss; ++m)
    for (std::size_t j = 0; j < kGauss; ++j)
      response[m] += static_cast<double>(2 * j + 1) * BandLimit::kGaussWeight[m] *
                     low_legendre(j, 2 * BandLimit::kNode[1 + m] - 1) * shape[j];
  motion_[0] = 0;
  for (std::size_t n = 0; n < taps_; ++n) {
    const double* gamma = pressure_.data() + n * kNodes + 1;
    Complex z = pole * motion_[n];
    for (std::size_t m = 0; m < kGauss; ++m)
      z += gamma[m] * response[m];
    motion_[n + 1] = z;
  }
}

void DirectKernels::compute_mode(const Arrivals& arrivals, const Mode& mode, double sample_rate,
                                 float* samples, float* moments) {
  std::vector<double>& pressure = pressure_;
  std::vector<Complex>& motion = motion_;
  const std::size_t arrived = arrivals.samples();
  std::fill(pressure.begin(), pressure.end(), 0);
  arrivals.find(mode.motion, std::span(pressure).first(arrived * kNodes));
  const bool in_bank = mode.part == Mode::Part::kRinging;
  Complex s = mode.rate / sample_rate;
  const double square = math::norm(s);
  if (!in_bank && -s.real() < kHighDecay) // its own oscillation is inaudible
    s = {-kHighDecay, std::sqrt(std::max(square - kHighDecay * kHighDecay, 1e-3))};
  const double alpha = -s.real(), omega = s.imag(), stiffness = math::norm(s);
  const Complex pole = math::exp(s);
  const auto shape = exponential_moments(s);
  integrate_motion(pole, shape);
  Complex weight = 0;
  if (in_bank && alpha * static_cast<double>(arrived) <= kMaxDecay)
    weight = s * s / omega * motion[arrived] * math::exp(-s * static_cast<double>(arrived));
  if (in_bank)
    weight_.push_back(weight * sample_rate);
  Complex ring = weight;
  double residual = 0; // residual of the response to a constant sampled force
  std::size_t loudest = 0;
  for (std::size_t n = 0; n < taps_; ++n) {
    const Motion a(motion[n], s), b(motion[n + 1], s);
    double mean = 0;
    for (std::size_t m = 0; m < kGauss; ++m)
      mean += BandLimit::kGaussWeight[m] * pressure[n * kNodes + 1 + m];
    const double change = b.v - a.v;
    const double displacement = (mean - 2 * alpha * (b.q - a.q) - change) / stiffness;
    // int over the sample of q'' P_j, by parts.
    const std::array<double, kMaxMoments> acceleration{
        change, b.v + a.v - 2 * (b.q - a.q), change - 6 * (b.q + a.q) + 12 * displacement};
    for (std::size_t j = 0; j < moment_count_; ++j) {
      const double sign = j == 1 ? -1 : 1; // e^(s v) instead of e^(s (1 - v))
      moments[j * taps_ + n] = static_cast<float>(
          static_cast<double>(2 * j + 1) * (acceleration[j] - (ring * sign * shape[j]).imag()));
    }
    const double sampled = pressure[n * kNodes] - 2 * alpha * a.v - stiffness * a.q - ring.imag();
    samples[n] = static_cast<float>(sampled);
    residual += sampled;
    if (std::abs(pressure[n * kNodes]) > std::abs(pressure[loudest * kNodes]))
      loudest = n;
    ring *= pole;
  }
  // The response to a constant force must cancel that of the bank. The remainder, which the band
  // limit passes at the sample rate (1e-4 of the direct sound), is subtracted at the loudest tap.
  residual += (weight / (1.0 - pole)).imag();
  samples[loudest] -= static_cast<float>(residual);
}

void DirectKernels::add_rigid(const Arrivals& arrivals, std::size_t motion,
                              std::vector<double>& pressure) {
  std::fill(pressure.begin(), pressure.end(), 0);
  arrivals.find(arrivals.modes() + motion, std::span(pressure).first(arrivals.samples() * kNodes));
  for (std::size_t n = 0; n < taps_; ++n)
    rigid_samples_.push_back(static_cast<float>(pressure[n * kNodes]));
  for (std::size_t j = 0; j < moment_count_; ++j)
    for (std::size_t n = 0; n < taps_; ++n) {
      double sum = 0;
      for (std::size_t m = 0; m < kGauss; ++m)
        sum += BandLimit::kGaussWeight[m] * low_legendre(j, 2 * BandLimit::kNode[1 + m] - 1) *
               pressure[n * kNodes + 1 + m];
      rigid_moments_.push_back(static_cast<float>(static_cast<double>(2 * j + 1) * sum));
    }
}

void DirectKernels::build_velocity(std::span<const Mode> modes, std::span<const Complex> weight,
                                   double sample_rate) {
  taps_ = 1;
  on_surface_ = false;
  weight_.assign(weight.begin(), weight.end());
  samples_.assign(modes.size(), 0);
  moment_count_ = 1;
  moments_.assign(modes.size(), 0);
  for (std::size_t k = 0; k < weight.size(); ++k)
    samples_[k] = static_cast<float>(
        -(weight[k] / (1.0 - math::exp(modes[k].rate / sample_rate))).imag() / sample_rate);
}

namespace {

void combine(std::span<const double> gain, const std::vector<float>& rows,
             std::span<float> out) noexcept {
  const std::size_t length = out.size();
  std::fill(out.begin(), out.end(), 0.0F);
  const std::size_t count = length > 0 ? std::min(gain.size(), rows.size() / length) : 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto b = static_cast<float>(gain[k]);
    const float* const row = rows.data() + k * length;
    for (std::size_t i = 0; i < length; ++i)
      out[i] += b * row[i];
  }
}

void combine(const DirectKernels::SurfaceGain& gain, const std::vector<float>& rows,
             std::span<float> out) noexcept {
  const std::size_t length = out.size();
  std::fill(out.begin(), out.end(), 0.0F);
  for (const auto& [vertex, share] : gain)
    for (int axis = 0; axis < 3; ++axis) {
      const auto b = static_cast<float>(share[axis]);
      const std::size_t begin = (3 * vertex + static_cast<std::size_t>(axis)) * length;
      if (b == 0 || begin + length > rows.size())
        continue;
      const float* const row = rows.data() + begin;
      for (std::size_t i = 0; i < length; ++i)
        out[i] += b * row[i];
    }
}

} // namespace

void DirectKernels::assemble_samples(const SurfaceGain& gain, std::span<float> out) const noexcept {
  combine(gain, samples_, out);
}

void DirectKernels::assemble_pulse(const SurfaceGain& gain, std::span<float> out) const noexcept {
  combine(gain, pulses_, out);
}

void DirectKernels::assemble_moments(const SurfaceGain& gain, std::span<float> out) const noexcept {
  combine(gain, moments_, out);
}

void DirectKernels::assemble_samples(std::span<const double> gain,
                                     std::span<float> out) const noexcept {
  combine(gain, samples_, out);
}

void DirectKernels::assemble_moments(std::span<const double> gain,
                                     std::span<float> out) const noexcept {
  combine(gain, moments_, out);
}

void DirectKernels::assemble_rigid_samples(const std::array<double, Arrivals::kRigid>& gain,
                                           std::span<float> out) const noexcept {
  combine(gain, rigid_samples_, out);
}

void DirectKernels::assemble_rigid_moments(const std::array<double, Arrivals::kRigid>& gain,
                                           std::span<float> out) const noexcept {
  combine(gain, rigid_moments_, out);
}

void DirectSound::prepare(double sample_rate) {
  for (Lines& lines : lines_)
    for (Line& line : lines) {
      line.elastic.assign(DirectKernels::kMaxTaps + kChunk, 0);
      line.rigid.assign(DirectKernels::kMaxTaps + kChunk, 0);
      line.end = 0;
    }
  // Bilinear transform.
  const double k = math::tan(std::numbers::pi * kSuspensionHz / sample_rate);
  const double scale = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  suspension_ = {scale, -2 * scale, scale, 2 * (k * k - 1) * scale,
                 (1 - std::numbers::sqrt2 * k + k * k) * scale};
  suspension_state_ = {};
}

void DirectSound::clear() noexcept {
  for (Lines& lines : lines_)
    for (Line& line : lines)
      clear(line);
  suspension_state_ = {};
}

void DirectSound::clear_from(std::size_t listener) noexcept {
  for (std::size_t l = listener; l < lines_.size(); ++l) {
    for (Line& line : lines_[l])
      clear(line);
    suspension_state_[l] = {};
  }
}

void DirectSound::clear(Line& line) noexcept {
  const auto end = static_cast<std::ptrdiff_t>(line.end);
  std::fill(line.elastic.begin(), line.elastic.begin() + end, 0.0F);
  std::fill(line.rigid.begin(), line.rigid.begin() + end, 0.0F);
  line.end = 0;
}

void DirectSound::copy(const Line& from, Line& to) noexcept {
  clear(to);
  const auto end = static_cast<std::ptrdiff_t>(from.end);
  std::copy(from.elastic.begin(), from.elastic.begin() + end, to.elastic.begin());
  std::copy(from.rigid.begin(), from.rigid.begin() + end, to.rigid.begin());
  to.end = from.end;
}

void DirectSound::add(Line& line, std::size_t at, const ForceKernel& kernel, std::size_t taps,
                      std::span<const float> force) noexcept {
  if (line.elastic.empty())
    return;
  const auto spread = [&](const std::vector<float>& from, std::vector<float>& to) {
    for (std::size_t j = 0; j < force.size(); ++j) {
      const float f = force[j];
      const float* const k = from.data() + j * taps;
      float* const out = to.data() + at;
      if (f != 0)
        for (std::size_t i = 0; i < taps; ++i)
          out[i] += f * k[i];
    }
  };
  spread(kernel.elastic, line.elastic);
  if (!kernel.rigid.empty())
    spread(kernel.rigid, line.rigid);
  line.end = std::max(line.end, at + taps);
}

void DirectSound::add_sample(std::size_t listener, ModeBank::Part part, std::size_t at,
                             const ForceKernel& kernel, std::size_t taps, double force) noexcept {
  const auto f = static_cast<float>(force);
  add(lines_[listener][part], at, kernel, taps, {&f, 1});
}

void DirectSound::add_moments(std::size_t listener, ModeBank::Part part, std::size_t at,
                              const ForceKernel& kernel, std::size_t taps,
                              std::span<const double> force) noexcept {
  std::array<float, DirectKernels::kMaxMoments> f{};
  const std::size_t count = std::min(force.size(), f.size());
  for (std::size_t j = 0; j < count; ++j)
    f[j] = static_cast<float>(force[j]);
  add(lines_[listener][part], at, kernel, taps, std::span(f).first(count));
}

void DirectSound::add_history(std::size_t listener, const ForceKernel& kernel, std::size_t taps,
                              std::span<const double> force) noexcept {
  Line& line = lines_[listener][ModeBank::kLatest];
  if (line.elastic.empty())
    return;
  const auto spread = [&](const std::vector<float>& from, std::vector<float>& to) {
    for (std::size_t j = 0; j < force.size(); ++j) {
      const float* const k = from.data() + j * taps;
      double residual = 0; // response still to come of forces before now
      for (std::size_t i = taps; i-- > 1;) {
        residual += force[j] * static_cast<double>(k[i]);
        to[i - 1] += static_cast<float>(residual);
      }
    }
  };
  spread(kernel.elastic, line.elastic);
  if (!kernel.rigid.empty())
    spread(kernel.rigid, line.rigid);
  line.end = std::max(line.end, taps);
}

void DirectSound::start() noexcept {
  for (Lines& lines : lines_)
    copy(lines[ModeBank::kLatest], lines[ModeBank::kMiddle]);
}

void DirectSound::rotate(const Glide& before, const Glide& after) noexcept {
  for (Lines& lines : lines_) {
    if (before.has_latest()) {
      std::swap(lines[ModeBank::kOld], lines[ModeBank::kMiddle]);
      std::swap(lines[ModeBank::kMiddle], lines[ModeBank::kLatest]);
    }
    if (!after.has_old())
      clear(lines[ModeBank::kOld]);
    copy(lines[ModeBank::kMiddle], lines[ModeBank::kLatest]);
    if (!after.moving())
      clear(lines[ModeBank::kMiddle]);
  }
}

void DirectSound::merge_parts(const Glide& glide) noexcept {
  const Glide::Blend blend = glide.blend(0);
  for (auto& [old, middle, latest] : lines_) {
    if (glide.moving()) {
      const std::size_t end = std::max({old.end, middle.end, latest.end});
      const auto mix = [&](const auto& one, const auto& two, auto& three) {
        for (std::size_t i = 0; i < end; ++i)
          three[i] = static_cast<float>(blend.old * one[i] + blend.middle * two[i] +
                                        blend.latest * three[i]);
      };
      mix(old.elastic, middle.elastic, latest.elastic);
      mix(old.rigid, middle.rigid, latest.rigid);
      latest.end = end;
    }
    copy(latest, old);
    copy(latest, middle);
  }
}

void DirectSound::shift(Line& line, std::size_t frames) noexcept {
  if (line.end == 0)
    return;
  const std::size_t left = line.end > frames ? line.end - frames : 0;
  for (std::vector<float>* const v : {&line.elastic, &line.rigid}) {
    const auto begin = v->begin(), from = begin + static_cast<std::ptrdiff_t>(line.end - left);
    const auto last = begin + static_cast<std::ptrdiff_t>(line.end);
    std::fill(std::copy(from, last, begin), last, 0.0F);
  }
  line.end = left;
}

void DirectSound::finish(std::size_t listener, std::span<float> sound,
                         const Glide& glide) noexcept {
  auto& [old, middle, latest] = lines_[listener];
  auto& [one, two] = suspension_state_[listener];
  const std::size_t frames = sound.size();
  if (old.end == 0 && middle.end == 0 && latest.end == 0 && one == 0 && two == 0)
    return;
  for (std::size_t n = 0; n < frames; ++n) {
    double elastic = latest.elastic[n], rigid = latest.rigid[n];
    if (glide.moving()) {
      const Glide::Blend blend = glide.blend(n);
      elastic =
          blend.old * old.elastic[n] + blend.middle * middle.elastic[n] + blend.latest * elastic;
      rigid = blend.old * old.rigid[n] + blend.middle * middle.rigid[n] + blend.latest * rigid;
    }
    const double y = suspension_.b0 * rigid + one;
    one = suspension_.b1 * rigid - suspension_.a1 * y + two;
    two = suspension_.b2 * rigid - suspension_.a2 * y;
    sound[n] += static_cast<float>(elastic + y);
    if (std::abs(one) < 1e-15 &&
        std::abs(two) < 1e-15) // at each sample, so that block sizes make no difference
      one = two = 0;
  }
  shift(old, frames);
  shift(middle, frames);
  shift(latest, frames);
}

} // namespace tactus::modal
