#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <cmath>

/// StruckBody: computes a block in pieces, divided at events, at contacts and where the glide
/// exchanges its weights.
namespace tactus::modal {
namespace {

constexpr double kMaxForce = 1e6;         // N, of the external force
constexpr double kMaxHeight = 10;         // m
constexpr double kMaxSpeed = 1e3;         // m/s, of the rubbing surface
constexpr double kDivergedForce = 1e12;   // N, beyond which the motion is reset
constexpr double kAudibilityFloor = 1e-8; // share of full scale: quieter modes are set to zero

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

template <class S>
void StruckBody::process(std::span<const S> force, std::span<const S> height,
                         std::span<const std::span<S>> out, std::span<S> force_out,
                         const Rubbing<S>& rubbing) noexcept {
  adopt();
  const std::size_t frames = force_out.size();
  for (std::size_t begin = 0, count = 0; begin < frames; begin += count) {
    while (const auto event = schedule_.take_due(clock_, model_.get()))
      apply(*event);
    count = std::min(kChunk, frames - begin);
    const std::int64_t next = schedule_.next();
    if (next < clock_ + static_cast<std::int64_t>(count))
      count = static_cast<std::size_t>(next - clock_);
    clock_ += static_cast<std::int64_t>(count);
    limit_inputs(force.subspan(begin, count), kMaxForce, chunk_.force.data());
    if (options_.driven) {
      limit_inputs(height.subspan(begin, count), kMaxHeight, chunk_.height.data());
      if (!(options_.spring_n_per_m > 0))
        hand_.join(std::span(chunk_.height).first(count));
    } else {
      chunk_.height.fill(0); // a hand begins at the surface
      hand_.leave();
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

/// Computes a chunk: the sound of the body, then the sound at the listeners.
void StruckBody::run(std::size_t frames) noexcept {
  chunk_.contact.fill(0);
  chunk_.friction.fill(0);
  const bool sounds = model_ && model_->settings.sample_rate == sample_rate_;
  for (std::size_t l = sounds ? model_->settings.listeners : 0; l < kMaxListeners; ++l)
    chunk_.output[l].fill(0); // all others are overwritten
  if (sounds) {
    BodyModel& m = *model_;
    m.bank.set_audibility_floor(kAudibilityFloor / std::max(options_.gain, 1e-6));
    strikers_.pulses().begin_chunk(m, std::span(chunk_.contact).first(frames));
    for (std::size_t n = 0; n < frames;) {
      const std::size_t from = n;
      const Glide glide = m.bank.glide(0);
      n = m.in_solver ? run_coupled(n, frames) : run_uncoupled(n, frames);
      direct_.finish(chunk_.output, chunk_.force, from, n, glide);
    }
    if (m.uses_recordings)
      strikers_.recordings().play(m, frames, chunk_.output);
    strikers_.pulses().end_chunk(m);
  }
  if (options_.driven && options_.spring_n_per_m > 0)
    for (std::size_t n = 0; n < frames; ++n)
      chunk_.contact[n] += static_cast<float>(
          options_.spring_n_per_m * std::max(-static_cast<double>(chunk_.height[n]), 0.0));
  const std::size_t listeners = model_ ? model_->settings.listeners : kMaxListeners;
  fading_.add_before_delay(chunk_.output, listeners, frames);
  output_.delay(chunk_.output, listeners, frames);
  fading_.add_after_delay(chunk_.output, listeners, frames);
  output_.amplify(chunk_.output, listeners, frames, options_.soft_limit);
  if (listeners == 1) // both channels get its sound
    chunk_.output[1] = chunk_.output[0];
}

/// Runs coupled contacts sample by sample, until nothing touches or a glide exchanges its weights.
/// Returns the sample where it stopped.
std::size_t StruckBody::run_coupled(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  std::size_t n = from;
  m.refresh_listener_weights();
  frames = std::min(frames, from + m.bank.glide_left());
  for (; n < frames && m.solver.touching(); ++n) {
    if (strikers_.landing_in() == 0)
      strikers_.land(m, direct_);
    hand_.press(static_cast<double>(chunk_.height[n]), hand_touches(), striker_, point_, m,
                direct_);
    rub_.press(static_cast<double>(chunk_.normal[n]), static_cast<double>(chunk_.velocity[n]),
               point_, m, direct_);
    if (!m.solver.touching())
      break;
    step_contacts(from, n);
  }
  run_bank_beside_contact(from, n);
  if (!m.solver.touching() || m.has_settled(options_.gain))
    leave_contact();
  return n;
}

/// Advances the solver by a sample, in a segment that begins at `from`.
void StruckBody::step_contacts(std::size_t from, std::size_t sample) noexcept {
  BodyModel& m = *model_;
  const std::size_t before = m.solver.active();
  double force = m.solver.step();
  if (std::abs(force) < kDivergedForce) {
    direct_.add_contacts(sample - from);
  } else { // beyond any physical body: start again from rest
    m.solver.silence();
    strikers_.drop_contacts();
    force = 0;
  }
  add_direct_samples(sample - from, sample);
  strikers_.advance(1);
  if (m.solver.active() < before)
    strikers_.lift_off(m);
  hand_.lift(static_cast<double>(chunk_.height[sample]), hand_touches(), force, m);
  chunk_.contact[sample] += static_cast<float>(force);
  chunk_.friction[sample] = static_cast<float>(m.solver.contact(m.rub_slot()).exciter.force_n);
  if (chunk_.force[sample] != 0) {
    const double impulse = static_cast<double>(chunk_.force[sample]) / sample_rate_;
    m.solver.apply_impulse(m.force_gain, impulse);
    m.solver.apply_rigid_impulse(m.force_rigid, impulse);
  }
  mix_coupled_output(from, sample);
}

/// Mixes the solver's outputs at a sample, blended as the weights glide.
void StruckBody::mix_coupled_output(std::size_t from, std::size_t sample) noexcept {
  BodyModel& m = *model_;
  for (std::size_t l = 0; l < m.settings.listeners; ++l)
    chunk_.output[l][sample] = 0;
  for (std::size_t e = 0; e < m.listener_part_count; ++e) {
    const auto [listener, part] = m.listener_parts[e];
    const Glide& glide = m.bank.glide(listener);
    double output = m.solver.output(e);
    if (glide.moving()) {
      const Glide::Blend blend = glide.blend(sample - from);
      output *= part == ModeBank::kOld      ? blend.old
                : part == ModeBank::kMiddle ? blend.middle
                                            : blend.latest;
    }
    chunk_.output[listener][sample] += static_cast<float>(output);
  }
}

/// Runs the bank while the body is in the solver: sound that fades out, and modes excited by
/// pulses. The contacts do not feel this motion; by linearity the sum of the sounds is exact.
void StruckBody::run_bank_beside_contact(std::size_t from, std::size_t to) noexcept {
  BodyModel& m = *model_;
  if (m.bank.idle() && strikers_.pulses().count() == 0)
    return m.bank.skip(to - from);
  ChannelBlock sound;
  run_bank(from, to, nullptr, sound, 0);
  for (std::size_t l = 0; l < m.settings.listeners; ++l)
    for (std::size_t n = from; n < to; ++n)
      chunk_.output[l][n] += sound[l][n - from];
}

/// Runs the bank from one sample of the chunk to another, with the external force (null: none) and
/// all pulses.
void StruckBody::run_bank(std::size_t from, std::size_t to, const float* force, ChannelBlock& out,
                          std::size_t out_from) noexcept {
  BodyModel& m = *model_;
  std::array<const float*, 1 + kMaxContacts> drive{force};
  for (std::size_t i = 0; i < m.settings.voices; ++i)
    if (const float* const pulse = strikers_.pulses().force(i))
      drive[1 + i] = pulse + from;
  std::array<float*, kMaxListeners> to_listener{};
  for (std::size_t l = 0; l < m.settings.listeners; ++l)
    to_listener[l] = out[l].data() + out_from;
  m.bank.process(std::span<const float* const>(drive.data(), 1 + m.settings.voices), to_listener,
                 to - from);
}

/// Runs the bank alone, until a contact begins or a glide exchanges its weights. Returns the sample
/// where it stopped.
std::size_t StruckBody::run_uncoupled(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  if (m.rests() && m.bank.ringing()) { // a board has been placed under a ringing body
    m.enter_contact();
    return from;
  }
  frames = std::min(frames, from + m.bank.glide_left());
  // Contacts begin when a hand or a rubbing surface touches, or a force moves a body on a board.
  const bool driven = hand_touches();
  const auto begins = [&](std::size_t n) {
    return (driven && chunk_.height[n] < 0) || chunk_.normal[n] > 0 ||
           (m.rests() && chunk_.force[n] != 0);
  };
  std::size_t to = from;
  while (to < frames && !begins(to))
    ++to;
  const bool lands = strikers_.landing_in() < to - from;
  if (lands)
    to = from + static_cast<std::size_t>(strikers_.landing_in());
  if (to > from) {
    for (std::size_t n = from; n < to; ++n)
      add_direct_samples(n - from, n); // before the glide changes
    run_bank(from, to, chunk_.force.data() + from, chunk_.output, from);
    strikers_.advance(to - from);
    hand_.pass(static_cast<double>(chunk_.height[to - 1]));
  }
  if (lands)
    strikers_.land(m, direct_);
  else if (to < frames && driven && chunk_.height[to] < 0)
    hand_.begin(striker_, point_, m, direct_);
  else if (to < frames && chunk_.normal[to] > 0)
    rub_.begin(point_, m, direct_);
  else if (to < frames)
    m.enter_contact();
  return to;
}

/// Adds the direct sound of the external force and the pulses at a sample of the chunk.
void StruckBody::add_direct_samples(std::size_t at, std::size_t sample) noexcept {
  direct_.add_force(at, chunk_.force[sample]);
  for (std::size_t i = 0; i < model_->settings.voices; ++i)
    if (const float* const pulse = strikers_.pulses().force(i))
      direct_.add_pulse(i, at, pulse[sample]);
}

} // namespace tactus::modal
