#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kMostForce = 1e6;   // N taken from the inlet
constexpr double kMostHeight = 10;   // m
constexpr double kMostSpeed = 1e3;   // m/s of a surface that rubs
constexpr double kUnreal = 1e12;     // N
constexpr double kQuietest = 1e-8;   // of full scale: a mode below it is put to rest
constexpr double kGainSpeed = 0.005; // of the way, per sample

/// Within bounds, and zero for what is no number.
template <class S> void make_sane(std::span<const S> from, double most, float* to) noexcept {
  const S bound = static_cast<S>(most);
  for (std::size_t n = 0; n < from.size(); ++n) {
    S x = from[n];
    x = std::isnan(x) ? S{0} : x;
    x = x < bound ? x : bound;
    x = x > -bound ? x : -bound;
    to[n] = static_cast<float>(x);
  }
}

} // namespace

StruckBody::~StruckBody() {
  drop_retired();
  delete incoming_.load();
  for (Leaving& body : leaving_)
    retire(std::exchange(body.body, nullptr));
  for (Handover*& kept : kept_)
    retire(std::exchange(kept, nullptr));
  drop_retired();
}

void StruckBody::drop_retired() noexcept {
  Handover* old = retired_.exchange(nullptr, std::memory_order_acq_rel);
  while (old)
    delete std::exchange(old, old->next);
}

void StruckBody::prepare(double sample_rate) {
  if (sample_rate == sample_rate_ && turn_ > 0)
    return;
  sample_rate_ = sample_rate;
  turn_ = 1;
  events_.make_due();
  direct_.prepare(sample_rate);
  for (DelayLine& line : delay_) {
    line.prepare(static_cast<std::size_t>(0.1 * sample_rate) + 1); // 34 m
    if (model_)
      line.set(model_->delay_s[static_cast<std::size_t>(&line - delay_.data())] * sample_rate,
               false, true);
  }
  if (model_)
    settle_direct();
  for (Leaving& body : leaving_) {
    retire(std::exchange(body.body, nullptr));
    body.direct.prepare(sample_rate);
    for (DelayLine& line : body.delay)
      line.prepare(static_cast<std::size_t>(0.1 * sample_rate) + 1);
  }
}

void StruckBody::set_options(const Options& options) noexcept {
  options_ = options;
  if (silent_samples_ >= kSilence)
    smooth_gain_ = options_.gain;
}

void StruckBody::renew_point() noexcept {
  if (!model_)
    return;
  model_->gains(point_, point_direction_, model_->scratch);
  model_->bank.set_gain(0, std::span<const double>(model_->scratch).first(model_->heard));
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->push_gain[k] = static_cast<float>(model_->scratch[k]);
  model_->push_rigid = model_->recoils(point_) ? model_->rigid_gains(point_, point_direction_)
                                               : BodyModel::RigidGain{};
  point_aimed_ = false;
}

void StruckBody::set_point(const SurfacePoint& place, const Vec3& direction) noexcept {
  point_ = requested_point_ = place;
  point_direction_ = direction;
  point_set_ = true;
  if (model_)
    model_->solver.end(led_slot()); // a hand lets go and comes down anew
  renew_point();
}

void StruckBody::reset() noexcept {
  pulses_ = {};
  for (Recording& r : recordings_)
    r.released = true;
  blows_ = {};
  next_landing_ = kNever;
  if (!model_)
    return;
  leave_contact();
  model_->bank.release();
}

std::size_t StruckBody::contacts() const noexcept {
  std::size_t count = 0;
  for (const PulseBlow& pulse : pulses_)
    count += pulse.active ? 1 : 0;
  if (model_)
    for (std::size_t i = 0; i <= rub_slot(); ++i)
      count += model_->solver.contact(i).active ? 1 : 0;
  return count;
}

std::size_t StruckBody::flights() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(blows_.begin(), blows_.end(), [](const Blow& blow) { return blow.in_air; }));
}

void StruckBody::enter_contact() noexcept {
  if (coupled_now_)
    return;
  coupled_now_ = true;
  const auto states = std::span(model_->scratch_state).first(model_->heard);
  model_->bank.read_states(states);
  model_->solver.write_states(states);
  model_->bank.silence();
  if (rests())
    model_->solver.rest_rigid();
  begin_rests();
}

void StruckBody::leave_contact() noexcept {
  if (!coupled_now_ || !model_)
    return;
  const bool settled = has_settled();
  coupled_now_ = false;
  BodyModel& m = *model_;
  for (std::size_t i = 0; i < m.rest_slot() + m.rests.size(); ++i)
    m.solver.end(i);
  for (Blow& blow : blows_)
    blow.bounces = blow.in_air;
  const auto states = std::span(m.scratch_state).first(m.heard);
  m.solver.read_states(states);
  if (settled)
    std::fill(states.begin(), states.end(), 0.0);
  if (!m.bank.asleep()) {
    m.bank.read_states(m.bank_state);
    for (std::size_t k = 0; k < m.heard; ++k)
      states[k] += m.bank_state[k];
  }
  double loudest = 0;
  for (std::size_t k = 0; k < m.heard; ++k) { // squares of what is heard
    m.scratch[k] = m.loudness[k] * m.loudness[k] * std::norm(states[k]);
    loudest = std::max(loudest, m.scratch[k]);
  }
  const double least = loudest * std::pow(10, -options_.cull_db / 10);
  culled_ = 0;
  for (std::size_t k = 0; k < m.heard; ++k)
    if (m.scratch[k] < least) {
      ++culled_;
      states[k] = 0;
    }
  m.bank.write_states(states);
}

std::vector<double> StruckBody::levels(std::size_t most) {
  std::vector<std::pair<double, double>> found;
  if (!model_)
    return {};
  model_->bank.settle();
  for (std::size_t k = 0; k < model_->heard; ++k) {
    const double heard = model_->loudest_weight(k);
    const double size = std::abs(coupled_now_ ? model_->solver.state(k) : model_->bank.state(k));
    found.emplace_back(std::abs(model_->rate[k]),
                       std::max(20 * std::log10(size * heard * options_.gain + 1e-12), -120.0));
  }
  std::sort(found.begin(), found.end());
  std::vector<double> levels;
  for (std::size_t k = 0; k < std::min(most, found.size()); ++k)
    levels.push_back(found[k].second);
  return levels;
}

void StruckBody::begin_led() noexcept {
  enter_contact();
  ContactSolver::Strike hand;
  hand.law = law(striker_, 1, point_);
  hand.law.compliance_m_per_n = model_->left_out(point_);
  hand.held = true;
  hand.place_m = -last_height_;
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->scratch[k] = static_cast<double>(model_->push_gain[k]);
  model_->solver.begin(led_slot(), hand, model_->scratch,
                       model_->rigid_gains(point_, point_direction_));
  aim_contact(led_slot(), point_, point_direction_);
}

/// What is released and what pulses excite rings in the bank beside a contact, which does not feel
/// it; the sum is exact for all else.
void StruckBody::ring_beside(std::size_t from, std::size_t to) noexcept {
  BodyModel& m = *model_;
  std::array<const float*, 1 + kMostContacts> force{};
  bool rings = !m.bank.asleep();
  for (std::size_t i = 0; i < m.settings.voices; ++i)
    if (pulses_[i].active) {
      force[1 + i] = chunk_.pulse[i].data() + from;
      rings = true;
    }
  if (!rings)
    return m.bank.skip(to - from);
  std::array<float*, kMaxListeners> out{};
  for (std::size_t l = 0; l < m.settings.listeners; ++l)
    out[l] = chunk_.released[l].data();
  m.bank.process(std::span<const float* const>(force.data(), 1 + m.settings.voices), out,
                 to - from);
  for (std::size_t l = 0; l < m.settings.listeners; ++l)
    for (std::size_t n = from; n < to; ++n)
      chunk_.heard[l][n] += chunk_.released[l][n - from];
}

/// Sample by sample until nothing touches any more; returns where it stopped.
std::size_t StruckBody::in_contact(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  const std::size_t hand = led_slot();
  std::size_t n = from;
  m.refresh_ears();
  frames = std::min(frames, from + m.bank.glide_left());
  for (; n < frames && m.solver.touching(); ++n) {
    if (now_ >= next_landing_)
      land();
    const auto height = static_cast<double>(chunk_.height[n]);
    const bool led = options_.led && options_.spring_n_per_m == 0;
    if (led && height < 0 && !m.solver.contact(hand).active)
      begin_led();
    if (m.solver.contact(hand).active)
      m.solver.lead(hand, -height);
    drive_rub(n);
    if (!m.solver.touching())
      break;
    const std::size_t before = m.solver.active();
    double force = m.solver.step();
    if (std::abs(force) < kUnreal) {
      add_direct_contacts(n - from);
    } else { // no body stands that: begin again from rest
      m.solver.silence();
      blows_ = {};
      force = 0;
    }
    add_direct_samples(n - from, n);
    ++now_;
    if (m.solver.active() < before)
      let_go();
    last_height_ = height;
    if (m.solver.contact(hand).active && (!led || (height >= 0 && force == 0)))
      m.solver.end(hand);
    chunk_.contact[n] += static_cast<float>(force);
    chunk_.friction[n] = static_cast<float>(m.solver.contact(rub_slot()).exciter.force_n);
    if (chunk_.force[n] != 0) {
      const double impulse = static_cast<double>(chunk_.force[n]) / sample_rate_;
      m.solver.kick(m.push_gain, impulse);
      m.solver.kick_rigid(m.push_rigid, impulse);
    }
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      chunk_.heard[l][n] = 0;
    for (std::size_t e = 0; e < m.ear_count; ++e) {
      const auto [listener, part] = m.ears[e];
      const Glide& glide = m.bank.glide(listener);
      double heard = m.solver.hear(e);
      if (glide.moving()) {
        const Glide::Blend blend = glide.blend(n - from);
        heard *= part == ModeBank::kOld      ? blend.old
                 : part == ModeBank::kMiddle ? blend.middle
                                             : blend.fresh;
      }
      chunk_.heard[listener][n] += static_cast<float>(heard);
    }
  }
  ring_beside(from, n);
  if (!m.solver.touching() || has_settled())
    leave_contact();
  return n;
}

/// Nothing touches: the bank alone, up to where the led striker comes down.
std::size_t StruckBody::in_flight(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  if (rests() && m.bank.rings()) { // it has come to rest on a board while it rang
    enter_contact();
    return from;
  }
  frames = std::min(frames, from + m.bank.glide_left());
  // Up to where a hand or a surface that rubs comes down, or a force moves a body on a board.
  const bool led = options_.led && options_.spring_n_per_m == 0;
  const auto begins = [&](std::size_t n) {
    return (led && chunk_.height[n] < 0) || chunk_.normal[n] > 0 ||
           (rests() && chunk_.force[n] != 0);
  };
  std::size_t to = from;
  while (to < frames && !begins(to))
    ++to;
  const bool lands = next_landing_ < now_ + (to - from);
  if (lands)
    to = from + static_cast<std::size_t>(next_landing_ - std::min(now_, next_landing_));
  if (to > from) {
    for (std::size_t n = from; n < to; ++n)
      add_direct_samples(n - from, n); // while the glide is as it was
    std::array<const float*, 1 + kMostContacts> force{};
    force[0] = chunk_.force.data() + from;
    for (std::size_t i = 0; i < m.settings.voices; ++i)
      force[1 + i] = pulses_[i].active ? chunk_.pulse[i].data() + from : nullptr;
    std::array<float*, kMaxListeners> out{};
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      out[l] = chunk_.heard[l].data() + from;
    m.bank.process(std::span<const float* const>(force.data(), 1 + m.settings.voices), out,
                   to - from);
    now_ += to - from;
    last_height_ = static_cast<double>(chunk_.height[to - 1]);
  }
  if (lands)
    land();
  else if (to < frames && led && chunk_.height[to] < 0)
    begin_led();
  else if (to < frames && chunk_.normal[to] > 0)
    begin_rub();
  else if (to < frames)
    enter_contact();
  return to;
}

void StruckBody::run(std::size_t frames) noexcept {
  chunk_.contact.fill(0);
  chunk_.friction.fill(0);
  const bool sounds = model_ && model_->settings.sample_rate == sample_rate_;
  for (std::size_t l = sounds ? model_->settings.listeners : 0; l < kMaxListeners; ++l)
    chunk_.heard[l].fill(0); // all others are overwritten
  if (sounds) {
    model_->bank.set_floor(kQuietest / std::max(options_.gain, 1e-6));
    make_pulses(frames);
    for (std::size_t n = 0; n < frames;) {
      const std::size_t from = n;
      const Glide glide = model_->bank.glide(0);
      n = coupled_now_ ? in_contact(n, frames) : in_flight(n, frames);
      finish_direct(from, n, glide);
    }
    if (model_->plays_raw)
      play_raw(*model_, recordings_, frames, chunk_.heard);
    for (PulseBlow& blow : std::span(pulses_).first(model_->settings.voices))
      blow.active = blow.active && blow.age_s < blow.pulse.duration_s;
  }
  if (options_.led && options_.spring_n_per_m > 0)
    for (std::size_t n = 0; n < frames; ++n)
      chunk_.contact[n] += static_cast<float>(
          options_.spring_n_per_m * std::max(-static_cast<double>(chunk_.height[n]), 0.0));
  finish(frames);
}

void StruckBody::finish(std::size_t frames) noexcept {
  const std::size_t listeners = model_ ? model_->settings.listeners : kMaxListeners;
  add_leaving_ahead(frames);
  for (std::size_t l = 0; l < listeners; ++l)
    delay_[l].run(chunk_.heard[l].data(), frames);
  add_leaving(listeners, frames);
  const double start = smooth_gain_;
  std::size_t silent = silent_samples_ + frames;
  for (std::size_t l = 0; l < listeners; ++l) {
    auto& sound = chunk_.heard[l];
    for (std::size_t n = frames; n > 0 && frames - n < silent; --n)
      if (sound[n - 1] != 0)
        silent = frames - n;
    smooth_gain_ = start;
    std::size_t n = 0;
    for (; n < frames && smooth_gain_ != options_.gain; ++n) {
      smooth_gain_ += kGainSpeed * (options_.gain - smooth_gain_);
      if (std::abs(smooth_gain_ - options_.gain) <= 1e-6 * options_.gain)
        smooth_gain_ = options_.gain;
      sound[n] *= static_cast<float>(smooth_gain_);
    }
    const auto steady = static_cast<float>(smooth_gain_);
    for (; n < frames; ++n)
      sound[n] *= steady;
    for (n = 0; n < frames; ++n)
      sound[n] = sound[n] - sound[n] == 0 ? sound[n] : 0; // what is not finite
  }
  silent_samples_ = std::min(silent, kSilence);
  if (listeners == 1) // is heard on both sides
    chunk_.heard[1] = chunk_.heard[0];
}

template <class S>
void StruckBody::process(std::span<const S> force, std::span<const S> height,
                         std::span<const std::span<S>> out, std::span<S> force_out,
                         const Rubbing<S>& rubbing) noexcept {
  adopt();
  const std::size_t frames = force_out.size();
  for (std::size_t begin = 0, count = 0; begin < frames; begin += count) {
    carry_out_due();
    count = std::min(kChunk, frames - begin);
    const std::int64_t next = events_.next();
    if (next < clock_ + static_cast<std::int64_t>(count))
      count = static_cast<std::size_t>(next - clock_);
    clock_ += static_cast<std::int64_t>(count);
    make_sane(force.subspan(begin, count), kMostForce, chunk_.force.data());
    if (options_.led)
      make_sane(height.subspan(begin, count), kMostHeight, chunk_.height.data());
    else
      chunk_.height.fill(0); // a hand that begins to lead begins at the surface
    if (rubbing.normal_force.empty() || (model_ && model_->plays_raw)) {
      chunk_.normal.fill(0);
    } else {
      make_sane(rubbing.normal_force.subspan(begin, count), kMostForce, chunk_.normal.data());
      make_sane(rubbing.velocity.subspan(begin, count), kMostSpeed, chunk_.velocity.data());
    }
    run(count);
    const auto pass_on = [&](const auto& from, std::span<S> to) {
      for (std::size_t n = 0; n < count; ++n)
        to[n] = static_cast<S>(from[n]);
    };
    for (std::size_t l = 0; l < out.size(); ++l)
      pass_on(chunk_.heard[std::min(l, kMaxListeners - 1)], out[l].subspan(begin, count));
    pass_on(chunk_.contact, force_out.subspan(begin, count));
    if (!rubbing.friction.empty())
      pass_on(chunk_.friction, rubbing.friction.subspan(begin, count));
  }
}

template void StruckBody::process<float>(std::span<const float>, std::span<const float>,
                                         std::span<const std::span<float>>, std::span<float>,
                                         const Rubbing<float>&) noexcept;
template void StruckBody::process<double>(std::span<const double>, std::span<const double>,
                                          std::span<const std::span<double>>, std::span<double>,
                                          const Rubbing<double>&) noexcept;

} // namespace tactus::modal
