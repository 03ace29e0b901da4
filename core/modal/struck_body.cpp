#include "core/modal/struck_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kMostForce = 1e6;   // N taken from the inlet
constexpr double kMostHeight = 10;   // m
constexpr double kUnreal = 1e12;     // N
constexpr double kQuietest = 1e-8;   // of full scale: a mode below it is put to rest
constexpr std::size_t kFade = 512;   // samples, of the sound of a body that is exchanged
constexpr double kGainSpeed = 0.005; // of the way, per sample

double sane(double x, double most) noexcept {
  return x > -most ? (x < most ? x : most) : (x <= -most ? -most : 0.0);
}

} // namespace

StruckBody::~StruckBody() {
  drop_retired();
  delete incoming_.load();
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
  for (DelayLine& line : delay_) {
    line.prepare(static_cast<std::size_t>(0.1 * sample_rate) + 1); // 34 m
    if (model_)
      line.set(model_->delay_s[static_cast<std::size_t>(&line - delay_.data())] * sample_rate,
               false, true);
  }
}

void StruckBody::publish(std::unique_ptr<BodyModel> model, bool same_body) {
  drop_retired();
  auto* next = new Handover{std::move(model), same_body, nullptr};
  delete incoming_.exchange(next, std::memory_order_acq_rel);
}

void StruckBody::adopt() noexcept {
  Handover* next = incoming_.exchange(nullptr, std::memory_order_acq_rel);
  if (!next)
    return;
  const bool goes_on = next->same_body && model_ && model_->loaded == next->model->loaded;
  const bool touched =
      goes_on && coupled_now_ && next->model->settings.sample_rate == model_->settings.sample_rate;
  if (!touched)
    leave_contact();
  if (touched) {
    next->model->continue_touched(*model_);
  } else if (goes_on) {
    next->model->continue_from(*model_);
  } else {
    blows_ = {};
    next_landing_ = kNever;
    left_over_ = last_;
    fade_left_ = kFade;
    pulses_ = {};
    recordings_ = {};
    if (model_)
      next->model->bank.set_clock(model_->bank.clock());
  }
  std::swap(model_, next->model);
  if (touched)
    take_over_contacts(*next->model);
  for (std::size_t l = 0; l < kMostListeners; ++l) {
    if (!goes_on)
      delay_[l].clear();
    delay_[l].set(model_->delay_s[l] * sample_rate_, options_.doppler, !goes_on);
  }
  if (!point_set_ || !goes_on) {
    const Surface& surface = model_->loaded->surface;
    if (!surface.empty()) {
      // Until a point is given: what lies nearest to the user.
      const Vec3 there = point_set_ ? point_.position
                                    : 0.5 * (surface.lowest() + surface.highest()) +
                                          Vec3{0, 0, surface.diagonal()};
      point_ = surface.nearest(there);
      point_direction_ = point_.normal;
    } else {
      point_ = {};
    }
  }
  renew_point();
  for (std::size_t i = model_->settings.voices; i < kMostContacts; ++i)
    blows_[i] = {};
  find_next_landing();
  for (std::size_t i = 0; i < pulses_.size(); ++i)
    pulses_[i].active = false;
  next->next = retired_.load(std::memory_order_relaxed);
  while (!retired_.compare_exchange_weak(next->next, next, std::memory_order_acq_rel)) {
  }
}

void StruckBody::renew_point() noexcept {
  if (!model_)
    return;
  model_->gains(point_, point_direction_, model_->scratch);
  model_->bank.set_gain(0, std::span<const double>(model_->scratch).first(model_->heard));
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->push_gain[0][k] = static_cast<float>(model_->scratch[k]);
}

void StruckBody::set_point(const SurfacePoint& place, const Vec3& direction) noexcept {
  point_ = place;
  point_direction_ = direction;
  point_set_ = true;
  if (model_)
    model_->solver.end(model_->settings.voices); // a hand lets go and comes down anew
  renew_point();
}

void StruckBody::take_over_contacts(BodyModel& before) noexcept {
  BodyModel& m = *model_;
  const std::size_t led = m.settings.voices, old_led = before.settings.voices;
  for (std::size_t i = 0; i < std::min(led, old_led); ++i) {
    if (!before.solver.contact(i).active)
      continue;
    const Hit& hit = blows_[i].hit;
    m.gains(hit.place, hit.direction, m.scratch);
    m.solver.take_over(i, before.solver, i, m.scratch, m.rigid_gains(hit.place, hit.direction));
  }
  if (before.solver.contact(old_led).active) {
    m.gains(point_, point_direction_, m.scratch);
    m.solver.take_over(led, before.solver, old_led, m.scratch,
                       m.rigid_gains(point_, point_direction_));
  }
}

void StruckBody::reset() noexcept {
  pulses_ = {};
  recordings_ = {};
  blows_ = {};
  next_landing_ = kNever;
  left_over_ = last_;
  fade_left_ = kFade;
  for (DelayLine& line : delay_)
    line.clear();
  if (!model_)
    return;
  leave_contact();
  model_->bank.silence();
}

std::size_t StruckBody::contacts() const noexcept {
  std::size_t count = 0;
  for (const Pulse& pulse : pulses_)
    count += pulse.active ? 1 : 0;
  if (model_)
    for (std::size_t i = 0; i <= model_->settings.voices; ++i)
      count += model_->solver.contact(i).active ? 1 : 0;
  return count;
}

std::size_t StruckBody::flights() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(blows_.begin(), blows_.end(), [](const Blow& blow) { return blow.in_air; }));
}

ContactLaw StruckBody::law(const Striker& striker, double speed) const noexcept {
  ContactLaw law;
  law.exponent = 1.5;
  law.stiffness = hertz_stiffness(striker.radius_m, striker.youngs_modulus_pa, striker.poisson,
                                  model_->youngs_modulus_pa, model_->poisson);
  if (striker.stiffness > 0) {
    law.stiffness = striker.stiffness;
    law.exponent = striker.exponent;
    law.loss_s_per_m = striker.loss_s_per_m;
  }
  if (striker.restitution < 1)
    law.loss_s_per_m = loss_for_restitution(striker.restitution, speed);
  return law;
}

std::size_t StruckBody::free_slot() noexcept {
  const std::size_t voices = model_->settings.voices;
  std::size_t oldest = 0;
  for (std::size_t i = 0; i < voices; ++i) {
    if (!pulses_[i].active && !recordings_[i].active && !model_->solver.contact(i).active &&
        !blows_[i].in_air)
      return i;
    if (begun_[i] < begun_[oldest])
      oldest = i;
  }
  model_->solver.end(oldest);
  blows_[oldest] = {};
  find_next_landing();
  pulses_[oldest].active = recordings_[oldest].active = false;
  return oldest;
}

bool StruckBody::hit(const Hit& hit) noexcept {
  if (!model_ || !(hit.speed_m_per_s > 0))
    return false;
  const std::size_t slot = free_slot();
  begun_[slot] = ++turn_;
  if (model_->plays_raw)
    strike_raw(slot, hit);
  else if (options_.coupled || hit.falls)
    strike_coupled(slot, hit, striker_);
  else
    strike_pulse(slot, hit);
  return true;
}

void StruckBody::strike_coupled(std::size_t slot, const Hit& hit, const Striker& striker) noexcept {
  enter_contact();
  blows_[slot] = {hit, striker, hit.falls, false, 0, 0};
  ContactSolver::Contact contact;
  contact.law = law(striker, hit.speed_m_per_s);
  contact.striker_mass_kg = striker.mass_kg;
  contact.speed_m_per_s = hit.speed_m_per_s;
  contact.fall_m_per_s2 = hit.falls ? kGravity : 0;
  contact.compliance_m_per_n = model_->left_out(hit.place);
  model_->gains(hit.place, hit.direction, model_->scratch);
  model_->solver.begin(slot, contact, model_->scratch,
                       model_->rigid_gains(hit.place, hit.direction));
}

/// Contacts have ended: who falls is in the air now, unless it lies.
void StruckBody::let_go() noexcept {
  for (std::size_t i = 0; i < model_->settings.voices; ++i)
    if (blows_[i].bounces && !blows_[i].in_air && !model_->solver.contact(i).active)
      take_off(i);
}

void StruckBody::take_off(std::size_t slot) noexcept {
  Blow& blow = blows_[slot];
  const ContactSolver::Contact& contact = model_->solver.contact(slot);
  // The body's supports hold it where it was: the way down ends at its resting surface.
  const double up = -contact.speed_m_per_s;
  const double height = std::max(model_->solver.height(slot), 0.0);
  const double landing_speed = std::sqrt(up * up + 2 * kGravity * height);
  const double time = (up + landing_speed) / kGravity;
  // A ball that is back before a contact would be over does not leave at all.
  const bool leaves = !contact.lies && std::isfinite(time) && landing_speed > 0 &&
                      time > contact.law.duration(contact.striker_mass_kg, landing_speed);
  blow.bounces = blow.in_air = leaves;
  if (leaves) {
    blow.landing_speed_m_per_s = landing_speed;
    blow.landing = now_ + static_cast<std::uint64_t>(std::clamp(time * sample_rate_, 1.0, 1e12));
  }
  find_next_landing();
}

void StruckBody::find_next_landing() noexcept {
  next_landing_ = kNever;
  for (const Blow& blow : blows_)
    if (blow.in_air)
      next_landing_ = std::min(next_landing_, blow.landing);
}

void StruckBody::land() noexcept {
  for (std::size_t i = 0; i < model_->settings.voices; ++i) {
    const Blow blow = blows_[i];
    if (!blow.in_air || blow.landing > now_)
      continue;
    Hit hit = blow.hit;
    hit.speed_m_per_s = blow.landing_speed_m_per_s;
    strike_coupled(i, hit, blow.striker);
  }
  find_next_landing();
}

void StruckBody::strike_pulse(std::size_t slot, const Hit& hit) noexcept {
  leave_contact();
  double mobility = 1 / striker_.mass_kg;
  for (const double b : model_->rigid_gains(hit.place, hit.direction))
    mobility += b * b;
  const ContactLaw contact = law(striker_, hit.speed_m_per_s);
  Pulse& pulse = pulses_[slot];
  pulse = {(1 + striker_.restitution) * hit.speed_m_per_s / mobility,
           contact.duration(1 / mobility, hit.speed_m_per_s), 0, true};
  std::vector<double>& gain = model_->scratch;
  model_->gains(hit.place, hit.direction, gain);
  // A mode that the ear would not find beside the loudest one is left out. The spectrum is a half
  // sine's.
  double loudest = 0;
  const auto level = [&](std::size_t k) {
    const double turns = model_->rate[k].imag() / (2 * std::numbers::pi) * pulse.duration_s;
    const double denominator = 1 - 4 * turns * turns;
    const double part = std::abs(denominator) > 1e-6
                            ? std::cos(std::numbers::pi * turns) / denominator
                            : std::numbers::pi / 4;
    double heard = 0;
    for (const auto& weight : model_->weight)
      heard = std::max(heard, std::abs(weight[k]));
    return std::abs(gain[k] * part) * heard * model_->ear[k];
  };
  for (std::size_t k = 0; k < model_->heard; ++k)
    loudest = std::max(loudest, level(k));
  const double least = loudest * std::pow(10, -options_.cull_db / 20);
  culled_ = 0;
  for (std::size_t k = 0; k < model_->heard; ++k)
    if (level(k) < least) {
      gain[k] = 0;
      ++culled_;
    }
  model_->bank.set_gain(1 + slot, std::span<const double>(gain).first(model_->heard));
  for (std::size_t k = 0; k < gain.size(); ++k)
    model_->push_gain[1 + slot][k] = static_cast<float>(gain[k]);
}

void StruckBody::strike_raw(std::size_t slot, const Hit& hit) noexcept {
  const RawTable& table = model_->loaded->table.raw;
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < table.hits; ++i)
    if (const double distance = norm(table.hit_m[i] - hit.place.position); distance < least) {
      least = distance;
      nearest = i;
    }
  recordings_[slot] = {nearest, hit.speed_m_per_s, 0, true};
}

void StruckBody::play_raw(std::size_t frames) noexcept {
  const RawTable& table = model_->loaded->table.raw;
  for (Recording& r : recordings_) {
    if (!r.active)
      continue;
    for (std::size_t n = 0; n < frames; ++n) {
      for (std::size_t l = 0; l < model_->settings.listeners; ++l)
        chunk_.heard[l][n] +=
            static_cast<float>(r.speed_m_per_s * model_->raw[l].pressure(table, r.hit, r.age_s));
      r.age_s += 1 / sample_rate_;
    }
    r.active = r.age_s < model_->raw[0].end_s(table);
  }
}

void StruckBody::enter_contact() noexcept {
  if (coupled_now_)
    return;
  coupled_now_ = true;
  model_->bank.settle();
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->solver.set_state(k, k < model_->heard ? model_->bank.state(k) : 0.0);
  model_->bank.silence();
}

void StruckBody::leave_contact() noexcept {
  if (!coupled_now_ || !model_)
    return;
  coupled_now_ = false;
  BodyModel& m = *model_;
  for (std::size_t i = 0; i <= m.settings.voices; ++i)
    m.solver.end(i);
  for (Blow& blow : blows_)
    blow.bounces = blow.in_air;
  double loudest = 0;
  for (std::size_t k = 0; k < m.heard; ++k) {
    double heard = 0;
    for (const auto& weight : m.weight)
      heard = std::max(heard, std::abs(weight[k]));
    m.scratch[k] = heard * std::abs(m.solver.state(k)) * m.ear[k];
    loudest = std::max(loudest, m.scratch[k]);
  }
  const double least = loudest * std::pow(10, -options_.cull_db / 20);
  culled_ = 0;
  for (std::size_t k = 0; k < m.heard; ++k) {
    const bool audible = m.scratch[k] >= least;
    culled_ += audible ? 0 : 1;
    m.bank.set_state(k, audible ? m.solver.state(k) : 0.0);
  }
}

std::vector<double> StruckBody::levels(std::size_t most) {
  std::vector<std::pair<double, double>> found;
  if (!model_)
    return {};
  model_->bank.settle();
  for (std::size_t k = 0; k < model_->heard; ++k) {
    double heard = 0;
    for (const auto& weight : model_->weight)
      heard = std::max(heard, std::abs(weight[k]));
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

void StruckBody::make_pulses(std::size_t frames) noexcept {
  if (!model_)
    return;
  for (std::size_t i = 0; i < model_->settings.voices; ++i) {
    Pulse& pulse = pulses_[i];
    if (!pulse.active)
      continue;
    // Each sample holds the mean force of its time, so that the impulse is exact.
    const auto passed = [&](double t) {
      return 0.5 * (1 - std::cos(std::numbers::pi * std::min(t / pulse.duration_s, 1.0)));
    };
    for (std::size_t n = 0; n < frames; ++n) {
      const double next = pulse.age_s + 1 / sample_rate_;
      chunk_.pulse[i][n] =
          static_cast<float>(pulse.impulse * sample_rate_ * (passed(next) - passed(pulse.age_s)));
      pulse.age_s = next;
      chunk_.contact[n] += chunk_.pulse[i][n];
    }
  }
}

void StruckBody::begin_led() noexcept {
  enter_contact();
  ContactSolver::Contact contact;
  contact.law = law(striker_, 1);
  contact.led = true;
  contact.place_m = -last_height_;
  contact.compliance_m_per_n = model_->left_out(point_);
  for (std::size_t k = 0; k < model_->mode.size(); ++k)
    model_->scratch[k] = static_cast<double>(model_->push_gain[0][k]);
  model_->solver.begin(model_->settings.voices, contact, model_->scratch,
                       model_->rigid_gains(point_, point_direction_));
}

/// Sample by sample until nothing touches any more; returns where it stopped.
std::size_t StruckBody::in_contact(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  const std::size_t led_slot = m.settings.voices;
  std::size_t n = from;
  for (; n < frames && m.solver.touching(); ++n) {
    if (now_ >= next_landing_)
      land();
    const auto height = static_cast<double>(chunk_.height[n]);
    const bool led = options_.led && options_.spring_n_per_m == 0;
    if (led && height < 0 && !m.solver.contact(led_slot).active)
      begin_led();
    if (m.solver.contact(led_slot).active)
      m.solver.lead(led_slot, -height);
    const std::size_t before = m.solver.active();
    double force = m.solver.step();
    ++now_;
    if (!(std::abs(force) < kUnreal)) { // no body stands that: begin again from rest
      m.solver.silence();
      blows_ = {};
      force = 0;
    }
    if (m.solver.active() < before)
      let_go();
    last_height_ = height;
    if (m.solver.contact(led_slot).active && (!led || (height >= 0 && force == 0)))
      m.solver.end(led_slot);
    chunk_.contact[n] += static_cast<float>(force);
    if (chunk_.force[n] != 0)
      m.solver.kick(m.push_gain[0], static_cast<double>(chunk_.force[n]) / sample_rate_);
    for (std::size_t i = 0; i < m.settings.voices; ++i)
      if (pulses_[i].active && chunk_.pulse[i][n] != 0)
        m.solver.kick(m.push_gain[1 + i], static_cast<double>(chunk_.pulse[i][n]) / sample_rate_);
    for (std::size_t l = 0; l < m.settings.listeners; ++l) {
      double heard = m.solver.hear(l);
      if (const std::size_t left = m.bank.fade_left(l); left > 0)
        heard += static_cast<double>(left) / static_cast<double>(ModeBank::kFade) *
                 (m.solver.hear(m.old_weight[l]) - heard);
      chunk_.heard[l][n] = static_cast<float>(heard);
    }
    m.bank.skip(1);
  }
  if (!m.solver.touching())
    leave_contact();
  return n;
}

/// Nothing touches: the bank alone, up to where the led striker comes down.
std::size_t StruckBody::in_flight(std::size_t from, std::size_t frames) noexcept {
  BodyModel& m = *model_;
  std::size_t to = frames;
  if (options_.led && options_.spring_n_per_m == 0)
    for (std::size_t n = from; n < frames; ++n)
      if (chunk_.height[n] < 0) {
        to = n;
        break;
      }
  const bool lands = next_landing_ < now_ + (to - from);
  if (lands)
    to = from + static_cast<std::size_t>(next_landing_ - std::min(now_, next_landing_));
  if (to > from) {
    std::array<const float*, 1 + kMostContacts> force{};
    force[0] = chunk_.force.data() + from;
    for (std::size_t i = 0; i < m.settings.voices; ++i)
      force[1 + i] = pulses_[i].active ? chunk_.pulse[i].data() + from : nullptr;
    std::array<float*, kMostListeners> out{};
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      out[l] = chunk_.heard[l].data() + from;
    m.bank.process(std::span<const float* const>(force.data(), 1 + m.settings.voices), out,
                   to - from);
    now_ += to - from;
    last_height_ = static_cast<double>(chunk_.height[to - 1]);
  }
  if (lands)
    land();
  else if (to < frames)
    begin_led();
  return to;
}

void StruckBody::run(std::size_t frames) noexcept {
  chunk_.contact.fill(0);
  for (auto& heard : chunk_.heard)
    heard.fill(0);
  if (model_ && model_->settings.sample_rate == sample_rate_) {
    model_->bank.set_floor(kQuietest / std::max(options_.gain, 1e-6));
    make_pulses(frames);
    for (std::size_t n = 0; n < frames;)
      n = coupled_now_ ? in_contact(n, frames) : in_flight(n, frames);
    if (model_->plays_raw)
      play_raw(frames);
    for (Pulse& pulse : pulses_)
      pulse.active = pulse.active && pulse.age_s < pulse.duration_s;
  }
  if (options_.led && options_.spring_n_per_m > 0)
    for (std::size_t n = 0; n < frames; ++n)
      chunk_.contact[n] += static_cast<float>(
          options_.spring_n_per_m * std::max(-static_cast<double>(chunk_.height[n]), 0.0));
  finish(frames);
}

void StruckBody::finish(std::size_t frames) noexcept {
  const std::size_t listeners = model_ ? model_->settings.listeners : kMostListeners;
  const double start = smooth_gain_;
  const std::size_t fade = fade_left_;
  for (std::size_t l = 0; l < listeners; ++l) {
    auto& sound = chunk_.heard[l];
    delay_[l].run(sound.data(), frames);
    smooth_gain_ = start;
    fade_left_ = fade;
    for (std::size_t n = 0; n < frames; ++n) {
      if (smooth_gain_ != options_.gain) {
        smooth_gain_ += kGainSpeed * (options_.gain - smooth_gain_);
        if (std::abs(smooth_gain_ - options_.gain) <= 1e-6 * options_.gain)
          smooth_gain_ = options_.gain;
      }
      sound[n] *= static_cast<float>(smooth_gain_);
      if (fade_left_ > 0)
        sound[n] += left_over_[l] * static_cast<float>(fade_left_--) / static_cast<float>(kFade);
      if (!std::isfinite(sound[n]))
        sound[n] = 0;
    }
    last_[l] = sound[frames - 1];
  }
  for (std::size_t l = listeners; l < kMostListeners; ++l) { // one listener is heard on both sides
    chunk_.heard[l] = chunk_.heard[0];
    last_[l] = last_[0];
  }
}

template <class S>
void StruckBody::process(std::span<const S> force, std::span<const S> height,
                         std::span<const std::span<S>> out, std::span<S> force_out) noexcept {
  adopt();
  const std::size_t frames = force_out.size();
  for (std::size_t begin = 0; begin < frames; begin += kChunk) {
    const std::size_t count = std::min(kChunk, frames - begin);
    for (std::size_t n = 0; n < count; ++n) {
      chunk_.force[n] = static_cast<float>(sane(static_cast<double>(force[begin + n]), kMostForce));
      chunk_.height[n] =
          static_cast<float>(sane(static_cast<double>(height[begin + n]), kMostHeight));
    }
    run(count);
    for (std::size_t n = 0; n < count; ++n) {
      for (std::size_t l = 0; l < out.size(); ++l)
        out[l][begin + n] = static_cast<S>(chunk_.heard[std::min(l, kMostListeners - 1)][n]);
      force_out[begin + n] = static_cast<S>(chunk_.contact[n]);
    }
  }
}

template void StruckBody::process<float>(std::span<const float>, std::span<const float>,
                                         std::span<const std::span<float>>,
                                         std::span<float>) noexcept;
template void StruckBody::process<double>(std::span<const double>, std::span<const double>,
                                          std::span<const std::span<double>>,
                                          std::span<double>) noexcept;

} // namespace tactus::modal
