#include "core/footstep/creaking_boards.hpp"

#include "core/dsp/elementary.hpp"
#include "core/footstep/floor_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::footstep {
namespace {

constexpr double kReferenceRate = 10; // reference weights per second
constexpr double kWobbleTime = 0.02;  // s
// s, shortest time in which the joint opens. A foot unloads more slowly than this, apart from the
// peak of its impact. A joint that opened within one sample would release the bent boards with a
// bang.
constexpr double kUnloadingTime = 0.05;
constexpr double kSilenceTime = 0.06; // s without sound after which the boards rest
constexpr double kInaudible = 1e-6;   // share of the peak
constexpr double kMinLoad = 0.01;     // reference weights; below it the joint is open

} // namespace

CreakingBoards::CreakingBoards() : body_(kModes + kJoint, 1, 1) {}

void CreakingBoards::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  body_.prepare(sample_rate);
  wobble_pole_ = math::exp(-1 / (kWobbleTime * sample_rate));
  unloading_ = 1 / (kUnloadingTime * sample_rate);
}

void CreakingBoards::seed(std::uint64_t value) noexcept {
  random_.seed(value);
  body_.seed(0, random_.next());
}

void CreakingBoards::reset() noexcept {
  body_.reset();
  body_.rub(0, 0, 0);
  wobble_ = load_ = peak_load_ = bending_ = 0;
  silent_samples_ = peak_ = 0;
  active_ = false;
}

void CreakingBoards::set(const FrictionRecipe& friction) noexcept {
  body_.set_friction(0, friction.law);
}

void CreakingBoards::scale_modes(const FrictionRecipe& friction, std::span<const double> detune,
                                 double frequency, double decay) noexcept {
  const std::array<contact::Mode, kJoint> joint{
      contact::Mode{friction.joint_hz * frequency, friction.joint_t60_s, friction.joint_kg}};
  set_body_modes(body_, friction.modes, detune.first(std::min(detune.size(), kModes)), frequency,
                 decay, joint);
}

void CreakingBoards::draw_contact_position(const FrictionRecipe& friction) noexcept {
  std::array<double, kModes + kJoint> shape{};
  const auto mode_shares = draw_mode_shape(friction.modes, random_);
  shape[0] = 1;
  std::copy_n(mode_shares.begin(), kModes, shape.begin() + kJoint);
  body_.set_contact_shape(0, shape);
  speed_factor_ = lognormal_factor(friction.scatter.level, random_);
}

double CreakingBoards::next(const FrictionRecipe& friction, double load, double bending) noexcept {
  const double slowest = load_ - unloading_ * peak_load_;
  if (load < slowest) // the load falls faster than the joint may open: limits the rate of the
                      // bending as well
    bending = bending_ * slowest / load_;
  load_ = std::max(load, slowest);
  bending_ = bending;
  peak_load_ = load_ > 0 ? std::max(peak_load_, load_) : 0;
  if (load_ > kMinLoad) {
    wobble_ =
        wobble_pole_ * wobble_ + std::sqrt(1 - wobble_pole_ * wobble_pole_) * random_.normal();
    const double uneven = std::max(0.0, 1 + friction.wobble * wobble_);
    body_.rub(0, (friction.preload_n + friction.load_n * load_) * uneven,
              friction.slip_m_per_s * speed_factor_ * bending / kReferenceRate * uneven);
    active_ = true;
    silent_samples_ = 0;
  } else if (active_) {
    body_.rub(0, friction.preload_n, 0);
    if (++silent_samples_ > kSilenceTime * sample_rate_) {
      active_ = false;
      peak_ = 0;
    }
  }
  if (!active_)
    return 0;
  body_.step();
  const double sound = body_.pickup_velocity(0), size = std::abs(sound);
  peak_ = std::max(peak_, size);
  if (size > kInaudible * peak_)
    silent_samples_ = 0;
  return sound;
}

} // namespace tactus::footstep
