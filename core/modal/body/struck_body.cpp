#include "core/modal/body/struck_body.hpp"

#include "core/dsp/soft_clip.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kMaxForce = 1e6;         // N, of the external force
constexpr double kMaxHeight = 10;         // m
constexpr double kMaxSpeed = 1e3;         // m/s, of the rubbing surface
constexpr double kDivergedForce = 1e12;   // N, beyond which the motion is reset
constexpr double kAudibilityFloor = 1e-8; // of full scale: quieter modes are set to zero
constexpr double kGainSpeed = 0.005;      // of the remaining change, per sample

/// Clamps to +-limit; NaN becomes 0.
template <class S> void limit_inputs(std::span<const S> from, double limit, float* to) noexcept {
  const S bound = static_cast<S>(limit);
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
  for (FadingBody& body : fading_)
    retire(std::exchange(body.body, nullptr));
  for (Handover*& previous : previous_models_)
    retire(std::exchange(previous, nullptr));
  drop_retired();
}

void StruckBody::drop_retired() noexcept {
  Handover* old = retired_.exchange(nullptr, std::memory_order_acq_rel);
  while (old)
    delete std::exchange(old, old->next);
}

void StruckBody::prepare(double sample_rate) {
  if (sample_rate == sample_rate_ && strike_count_ > 0)
    return;
  sample_rate_ = sample_rate;
  strike_count_ = 1;
  events_.expire_all();
  direct_.prepare(sample_rate);
  hand_steps_.prepare(sample_rate);
  for (DelayLine& line : delay_) {
    line.prepare(static_cast<std::size_t>(0.1 * sample_rate) + 1); // 34 m
    if (model_)
      line.set(model_->delay_s[static_cast<std::size_t>(&line - delay_.data())] * sample_rate,
               false, true);
  }
  if (model_)
    use_current_kernels();
  for (FadingBody& body : fading_) {
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

void StruckBody::update_point_gains() noexcept {
  if (!model_)
    return;
  model_->gains(point_, point_direction_, model_->scratch);
  model_->bank.set_gain(0, std::span<const double>(model_->scratch).first(model_->audible_modes));
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->force_gain[k] = static_cast<float>(model_->scratch[k]);
  model_->force_rigid = model_->recoils(point_) ? model_->rigid_gains(point_, point_direction_)
                                                : BodyModel::RigidGain{};
  point_kernels_valid_ = false;
}

void StruckBody::set_point(const SurfacePoint& point, const Vec3& direction) noexcept {
  point_ = requested_point_ = point;
  point_direction_ = direction;
  point_set_ = true;
  if (model_)
    model_->solver.end(driven_slot()); // a hand begins a new contact at the new point
  update_point_gains();
}

void StruckBody::reset() noexcept {
  pulses_ = {};
  for (Recording& r : recordings_)
    r.released = true;
  impacts_ = {};
  next_landing_ = kNever;
  if (!model_)
    return;
  leave_contact();
  model_->bank.release();
}

std::size_t StruckBody::contacts() const noexcept {
  std::size_t count = 0;
  for (const PulseImpact& pulse : pulses_)
    count += pulse.active ? 1 : 0;
  if (model_)
    for (std::size_t i = 0; i <= rub_slot(); ++i)
      count += model_->solver.contact(i).active ? 1 : 0;
  return count;
}

std::size_t StruckBody::flights() const noexcept {
  return static_cast<std::size_t>(std::count_if(
      impacts_.begin(), impacts_.end(), [](const CoupledImpact& impact) { return impact.in_air; }));
}

void StruckBody::enter_contact() noexcept {
  if (in_solver_)
    return;
  in_solver_ = true;
  const auto states = std::span(model_->scratch_state).first(model_->audible_modes);
  model_->bank.read_states(states);
  model_->solver.write_states(states);
  model_->bank.silence();
  if (has_resting_contacts())
    model_->solver.reset_rigid();
  begin_resting_contacts();
}

void StruckBody::leave_contact() noexcept {
  if (!in_solver_ || !model_)
    return;
  const bool settled = has_settled();
  in_solver_ = false;
  BodyModel& m = *model_;
  for (std::size_t i = 0; i < m.resting_slot() + m.resting_contacts.size(); ++i)
    m.solver.end(i);
  for (CoupledImpact& impact : impacts_)
    impact.bounces = impact.in_air;
  const auto states = std::span(m.scratch_state).first(m.audible_modes);
  m.solver.read_states(states);
  if (settled)
    std::fill(states.begin(), states.end(), 0.0);
  if (!m.bank.idle()) {
    m.bank.read_states(m.bank_state);
    for (std::size_t k = 0; k < m.audible_modes; ++k)
      states[k] += m.bank_state[k];
  }
  double loudest = 0, liveliest = 0;
  for (std::size_t k = 0; k < m.audible_modes; ++k) { // squared loudness
    m.scratch[k] = m.loudness[k] * m.loudness[k] * std::norm(states[k]);
    loudest = std::max(loudest, m.scratch[k]);
    liveliest = std::max(liveliest, std::norm(states[k]));
  }
  // What the listeners do not hear, the next striker may still meet.
  const double share = std::pow(10, -options_.cull_db / 10);
  culled_ = 0;
  for (std::size_t k = 0; k < m.audible_modes; ++k)
    if (m.scratch[k] < share * loudest && std::norm(states[k]) < share * liveliest) {
      ++culled_;
      states[k] = 0;
    }
  m.bank.write_states(states);
}

std::vector<double> StruckBody::levels(std::size_t limit) {
  std::vector<std::pair<double, double>> found;
  if (!model_)
    return {};
  model_->bank.flush_pending();
  for (std::size_t k = 0; k < model_->audible_modes; ++k) {
    const double output = model_->loudest_weight(k);
    const double size = std::abs(in_solver_ ? model_->solver.state(k) : model_->bank.state(k));
    found.emplace_back(std::abs(model_->rate[k]),
                       std::max(20 * std::log10(size * output * options_.gain + 1e-12), -120.0));
  }
  std::sort(found.begin(), found.end());
  std::vector<double> levels;
  for (std::size_t k = 0; k < std::min(limit, found.size()); ++k)
    levels.push_back(found[k].second);
  return levels;
}

void StruckBody::begin_driven() noexcept {
  enter_contact();
  hand_scale_ = 1;
  ContactSolver::Strike hand;
  hand.law = law(striker_, 1, point_);
  hand.law.compliance_m_per_n = model_->residual_compliance(point_);
  hand.held = true;
  hand.position_m = -last_height_;
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->scratch[k] = static_cast<double>(model_->force_gain[k]);
  model_->solver.begin(driven_slot(), hand, model_->scratch,
                       model_->rigid_gains(point_, point_direction_));
  build_contact_kernels(driven_slot(), point_, point_direction_);
}

/// Runs the bank while the body is in the solver: sound that fades out, and modes excited by
/// pulses. The contacts do not feel this motion; by linearity the sum of the sounds is exact.
void StruckBody::run_bank_beside_contact(std::size_t from, std::size_t to) noexcept {
  BodyModel& m = *model_;
  std::array<const float*, 1 + kMaxContacts> force{};
  bool rings = !m.bank.idle();
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
      chunk_.output[l][n] += chunk_.released[l][n - from];
}

/// The solver's outputs at a sample, blended as the weights glide.
void StruckBody::mix_coupled_output(std::size_t segment_begin, std::size_t sample) noexcept {
  BodyModel& m = *model_;
  for (std::size_t l = 0; l < m.settings.listeners; ++l)
    chunk_.output[l][sample] = 0;
  for (std::size_t e = 0; e < m.listener_part_count; ++e) {
    const auto [listener, part] = m.listener_parts[e];
    const Glide& glide = m.bank.glide(listener);
    double output = m.solver.output(e);
    if (glide.moving()) {
      const Glide::Blend blend = glide.blend(sample - segment_begin);
      output *= part == ModeBank::kOld      ? blend.old
                : part == ModeBank::kMiddle ? blend.middle
                                            : blend.latest;
    }
    chunk_.output[listener][sample] += static_cast<float>(output);
  }
}

/// Runs coupled contacts sample by sample, until nothing touches or a glide exchanges its weights.
/// Returns the sample where it stopped.
std::size_t StruckBody::run_coupled(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  const std::size_t hand = driven_slot();
  std::size_t n = from;
  m.refresh_listener_weights();
  frames = std::min(frames, from + m.bank.glide_left());
  for (; n < frames && m.solver.touching(); ++n) {
    if (now_ >= next_landing_)
      begin_landed_contacts();
    const auto height = static_cast<double>(chunk_.height[n]);
    const bool driven = options_.driven && options_.spring_n_per_m == 0;
    if (driven && height < 0 && !m.solver.contact(hand).active)
      begin_driven();
    if (m.solver.contact(hand).active)
      m.solver.set_held_position(hand, -height * hand_scale_);
    drive_rub(n);
    if (!m.solver.touching())
      break;
    const std::size_t before = m.solver.active();
    double force = m.solver.step();
    if (std::abs(force) < kDivergedForce) {
      add_direct_contacts(n - from);
    } else { // beyond any physical body: start again from rest
      m.solver.silence();
      impacts_ = {};
      force = 0;
    }
    add_direct_samples(n - from, n);
    ++now_;
    if (m.solver.active() < before)
      start_flights();
    last_height_ = height;
    if (m.solver.contact(hand).active && (!driven || (height >= 0 && force == 0)))
      m.solver.end(hand);
    chunk_.contact[n] += static_cast<float>(force);
    chunk_.friction[n] = static_cast<float>(m.solver.contact(rub_slot()).exciter.force_n);
    if (chunk_.force[n] != 0) {
      const double impulse = static_cast<double>(chunk_.force[n]) / sample_rate_;
      m.solver.apply_impulse(m.force_gain, impulse);
      m.solver.apply_rigid_impulse(m.force_rigid, impulse);
    }
    mix_coupled_output(from, n);
  }
  run_bank_beside_contact(from, n);
  if (!m.solver.touching() || has_settled())
    leave_contact();
  return n;
}

/// Runs the bank alone, until a contact begins or a glide exchanges its weights. Returns the sample
/// where it stopped.
std::size_t StruckBody::run_uncoupled(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  if (has_resting_contacts() && m.bank.ringing()) { // a board has been placed under a ringing body
    enter_contact();
    return from;
  }
  frames = std::min(frames, from + m.bank.glide_left());
  // Contacts begin when a hand or a rubbing surface touches, or a force moves a body on a board.
  const bool driven = options_.driven && options_.spring_n_per_m == 0;
  const auto begins = [&](std::size_t n) {
    return (driven && chunk_.height[n] < 0) || chunk_.normal[n] > 0 ||
           (has_resting_contacts() && chunk_.force[n] != 0);
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
    std::array<const float*, 1 + kMaxContacts> force{};
    force[0] = chunk_.force.data() + from;
    for (std::size_t i = 0; i < m.settings.voices; ++i)
      force[1 + i] = pulses_[i].active ? chunk_.pulse[i].data() + from : nullptr;
    std::array<float*, kMaxListeners> out{};
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      out[l] = chunk_.output[l].data() + from;
    m.bank.process(std::span<const float* const>(force.data(), 1 + m.settings.voices), out,
                   to - from);
    now_ += to - from;
    last_height_ = static_cast<double>(chunk_.height[to - 1]);
  }
  if (lands)
    begin_landed_contacts();
  else if (to < frames && driven && chunk_.height[to] < 0)
    begin_driven();
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
    chunk_.output[l].fill(0); // all others are overwritten
  if (sounds) {
    model_->bank.set_audibility_floor(kAudibilityFloor / std::max(options_.gain, 1e-6));
    make_pulses(frames);
    for (std::size_t n = 0; n < frames;) {
      const std::size_t from = n;
      const Glide glide = model_->bank.glide(0);
      n = in_solver_ ? run_coupled(n, frames) : run_uncoupled(n, frames);
      finish_direct(from, n, glide);
    }
    if (model_->uses_recordings)
      play_recordings(*model_, recordings_, frames, chunk_.output);
    for (PulseImpact& impact : std::span(pulses_).first(model_->settings.voices))
      impact.active = impact.active && impact.age_s < impact.pulse.duration_s;
  }
  if (options_.driven && options_.spring_n_per_m > 0)
    for (std::size_t n = 0; n < frames; ++n)
      chunk_.contact[n] += static_cast<float>(
          options_.spring_n_per_m * std::max(-static_cast<double>(chunk_.height[n]), 0.0));
  finish(frames);
}

void StruckBody::finish(std::size_t frames) noexcept {
  const std::size_t listeners = model_ ? model_->settings.listeners : kMaxListeners;
  add_fading_before_delay(frames);
  for (std::size_t l = 0; l < listeners; ++l)
    delay_[l].run(chunk_.output[l].data(), frames);
  add_fading(listeners, frames);
  const double start = smooth_gain_;
  std::size_t silent = silent_samples_ + frames;
  for (std::size_t l = 0; l < listeners; ++l) {
    auto& sound = chunk_.output[l];
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
      sound[n] = sound[n] - sound[n] == 0 ? sound[n] : 0; // NaN and infinity become 0
    if (options_.soft_limit)
      for (n = 0; n < frames; ++n)
        sound[n] = static_cast<float>(soft_clip(static_cast<double>(sound[n])));
  }
  silent_samples_ = std::min(silent, kSilence);
  if (listeners == 1) // both channels
    chunk_.output[1] = chunk_.output[0];
}

template <class S>
void StruckBody::process(std::span<const S> force, std::span<const S> height,
                         std::span<const std::span<S>> out, std::span<S> force_out,
                         const Rubbing<S>& rubbing) noexcept {
  adopt();
  const std::size_t frames = force_out.size();
  for (std::size_t begin = 0, count = 0; begin < frames; begin += count) {
    apply_due_events();
    count = std::min(kChunk, frames - begin);
    const std::int64_t next = events_.next();
    if (next < clock_ + static_cast<std::int64_t>(count))
      count = static_cast<std::size_t>(next - clock_);
    clock_ += static_cast<std::int64_t>(count);
    limit_inputs(force.subspan(begin, count), kMaxForce, chunk_.force.data());
    if (options_.driven) {
      limit_inputs(height.subspan(begin, count), kMaxHeight, chunk_.height.data());
      if (!(options_.spring_n_per_m > 0))
        hand_steps_.run(std::span(chunk_.height).first(count));
    } else {
      chunk_.height.fill(0); // a hand begins at the surface
      hand_steps_.reset();
    }
    if (rubbing.normal_force.empty() || (model_ && model_->uses_recordings)) {
      chunk_.normal.fill(0);
    } else {
      limit_inputs(rubbing.normal_force.subspan(begin, count), kMaxForce, chunk_.normal.data());
      limit_inputs(rubbing.velocity.subspan(begin, count), kMaxSpeed, chunk_.velocity.data());
    }
    run(count);
    const auto pass_on = [&](const auto& from, std::span<S> to) {
      for (std::size_t n = 0; n < count; ++n)
        to[n] = static_cast<S>(from[n]);
    };
    for (std::size_t l = 0; l < out.size(); ++l)
      pass_on(chunk_.output[std::min(l, kMaxListeners - 1)], out[l].subspan(begin, count));
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
