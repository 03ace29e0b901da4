#include "core/declaration_text.hpp"
#include "core/dsp/elementary.hpp"
#include "core/refusal.hpp"
#include "externals/footstep~/footstep~.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace tactus::footstep {
namespace {

constexpr std::array<std::string_view, 4> kPhases{"heel", "ball", "heel_up", "toe_off"};

/// Soft limiter: linear up to 0.7, then compressed to stay below 1.
double rounded(double x) noexcept {
  constexpr double kKnee = 0.7;
  const double size = std::abs(x);
  if (size <= kKnee)
    return x;
  const double over = (size - kKnee) / (1 - kKnee);
  return std::copysign(kKnee + (1 - kKnee) * over / (1 + over), x);
}

constexpr double kFullScale = 2;                      // Pa at gain 1
constexpr double kGainTime = 0.01, kFadeTime = 0.005; // s

/// Returns false unless all words are finite numbers.
bool numbers_of(std::span<const Atom> words, std::vector<double>& numbers) {
  for (const Atom& word : words) {
    if (word.is_word || !std::isfinite(word.number))
      return false;
    numbers.push_back(word.number);
  }
  return true;
}

} // namespace

Footstep::Footstep() : sides_(std::make_unique<std::array<Side, Gait::kFeet>>()) {
  for (Side& side : *sides_)
    side.first = side.second = store_.built_in("wood");
  prepare(48000, 64);
  set_seed(settings_.seed);
  update_grounds();
}

void Footstep::prepare(double sample_rate, std::size_t) {
  sample_rate_ = sample_rate;
  movements_.expire_all();
  gait_.prepare(sample_rate);
  for (Side& side : *sides_) {
    side.foot.prepare(sample_rate);
    side.sensor.prepare(sample_rate);
  }
  smoothed_gain_ = 1 - math::exp(-1 / (kGainTime * sample_rate));
  fade_.whole = kFadeTime * sample_rate;
  apply();
}

void Footstep::apply() noexcept {
  gait_.set({settings_.speed_m_per_s, settings_.weight_n, settings_.shoe, settings_.gait},
            settings_.variation);
  const ActuatorSignals::Settings drive{settings_.drive_gain, settings_.sensitivity_g,
                                        settings_.limit_g, settings_.delay_ms / 1000,
                                        settings_.common};
  for (Side& side : *sides_) {
    side.foot.set_weight(settings_.weight_n);
    side.foot.set_shoe(settings_.shoe);
    side.foot.set_room(settings_.room);
    side.foot.set_mix(settings_.mix);
    side.foot.drive().set(drive);
    side.sensor.set(settings_.weight_n);
  }
}

void Footstep::set_walk(bool on) noexcept {
  settings_.walk = on;
  gait_.walk(on);
}

void Footstep::set_run(bool on) noexcept {
  if (on || runs())
    settings_.gait = on ? Style::kRun : Style::kWalk;
  apply();
}

void Footstep::set_seed(unsigned value) noexcept {
  settings_.seed = value;
  gait_.seed(value);
  for (std::size_t i = 0; i < Gait::kFeet; ++i)
    (*sides_)[i].foot.seed(2 * std::uint64_t{value} + i);
}

void Footstep::update_grounds() noexcept {
  for (Side& side : *sides_)
    side.foot.set_grounds(side.first->id, side.first->recipe, side.second->id, side.second->recipe,
                          settings_.mix);
}

void Footstep::list_surfaces(Host& host) {
  std::vector<Atom> names{"surfaces"};
  for (const BuiltInSurface& surface : built_in_surfaces())
    names.emplace_back(surface.name);
  host.info(std::span<const Atom>(names));
}

void Footstep::reset() {
  fade_.from = fade_.last;
  fade_.left = fade_.whole;
  next_foot_ = 0;
  gait_.reset();
  for (Side& side : *sides_) {
    side.foot.reset();
    side.sensor.reset();
  }
  movements_ = {};
  set_seed(settings_.seed);
}

void Footstep::set_surface(std::span<const Atom> given, Host& host) {
  std::span<const Atom> arguments = given;
  std::size_t from = 0, to = Gait::kFeet;
  if (const auto side = side_named(arguments)) {
    from = *side;
    to = from + 1;
    arguments = arguments.subspan(1);
  }
  if (arguments.empty() || arguments.size() > 3)
    return host.error(refusal("surface", given, "one or two names, then a mix in 0..1"));
  std::array<std::shared_ptr<const Surface>, 2> found{};
  const std::size_t names = std::min<std::size_t>(arguments.size(), 2);
  for (std::size_t i = 0; i < names; ++i) {
    if (!arguments[i].is_word)
      return host.error(refusal("surface", given, "one or two names, then a mix in 0..1"));
    found[i] = store_.find(arguments[i].word, host);
    if (!found[i])
      return;
  }
  double mix = names == 2 ? settings_.mix : 0;
  if (arguments.size() == 3) {
    mix = arguments[2].number;
    if (arguments[2].is_word || !(mix >= 0 && mix <= 1))
      return host.error(refusal("surface", given, "a mix in 0..1"));
  }
  if (names == 2 || to - from == Gait::kFeet) // one foot on one ground needs no mix
    settings_.mix = mix;
  for (std::size_t i = from; i < to; ++i) {
    (*sides_)[i].first = found[0];
    (*sides_)[i].second = names == 2 ? found[1] : found[0];
  }
  update_grounds();
}

void Footstep::calibrate(std::span<const Atom> arguments, Host& host) {
  const bool ball = arguments[0].is_word && arguments[0].word == "ball";
  std::vector<double> numbers;
  if (!arguments[0].is_word || (!ball && arguments[0].word != "heel") ||
      !numbers_of(arguments.subspan(1), numbers))
    return host.error(
        refusal("calibrate", arguments, "heel or ball, then pairs of reading and newtons"));
  Calibration table;
  if (!numbers.empty() && !table.set(numbers))
    return host.error(
        refusal("calibrate", arguments, "5 to 32 ascending pairs of reading and newtons"));
  for (Side& side : *sides_)
    (ball ? side.sensor.ball_calibration() : side.sensor.heel_calibration()) = table;
}

void Footstep::equalise(std::span<const Atom> arguments, Host& host) {
  std::vector<double> numbers;
  ActuatorEqualiser trial;
  if (!numbers_of(arguments, numbers) || !trial.set(numbers))
    return host.error(refusal("equalise", arguments,
                              "up to 16 pairs of ascending Hz in 20..2000 and dB in -24..24"));
  for (Side& side : *sides_)
    static_cast<void>(side.foot.drive().equalise(numbers));
}

void Footstep::record_events(std::size_t foot, const SoleState& sole) noexcept {
  const auto add = [&](Phase phase, double speed) {
    if (event_count_ < kMaxEvents)
      events_[event_count_++] = {foot, phase, speed};
  };
  if (sole.heel_landing > 0)
    add(Phase::kHeelDown, sole.heel_landing);
  if (sole.ball_landing > 0)
    add(Phase::kBallDown, sole.ball_landing);
  if (sole.heel_up)
    add(Phase::kHeelUp, 0);
  if (sole.toe_off)
    add(Phase::kToeOff, 0);
}

std::array<double, 8> Footstep::next(const std::array<double, 4>& in) noexcept {
  std::array<SoleState, Gait::kFeet> soles{};
  const std::size_t feet = settings_.feet >= 1.5 ? 2 : 1;
  const std::array<double, Gait::kFeet> share{1, second_foot_share(feet == 2)};
  const std::size_t sounding = share[1] > 0 ? 2 : 1;
  if (!settings_.sensors) {
    gait_.next(soles);
  } else {
    const double unit = settings_.in_weights ? settings_.weight_n : 1;
    for (std::size_t i = 0; i < sounding; ++i)
      soles[i] = (*sides_)[i].sensor.next(in[2 * i] * unit, in[2 * i + 1] * unit);
  }
  std::array<double, 8> out{};
  measured_ += 1;
  gain_ += smoothed_gain_ * (settings_.gain - gain_);
  bool sounds = false;
  for (std::size_t i = 0; i < sounding; ++i) {
    const SoleState& sole = soles[i];
    if (i < feet)
      record_events(i, sole);
    Foot::Out made = (*sides_)[i].foot.next(sole);
    made.heel_drive *= share[i];
    made.ball_drive *= share[i];
    out[4 * i] = share[i] * rounded(gain_ / kFullScale * made.pressure_pa);
    sounds = sounds || made.pressure_pa != 0;
    out[4 * i + 1] = made.heel_drive;
    out[4 * i + 2] = made.ball_drive;
    (*sides_)[i].heel_squares += made.heel_drive * made.heel_drive;
    (*sides_)[i].ball_squares += made.ball_drive * made.ball_drive;
    if (i < feet)
      out[4 * i + 3] = sole.heel_n + sole.ball_n;
  }
  if (!sounds) // in silence a new gain takes effect at once
    gain_ = settings_.gain;
  if (fade_.left > 0)
    fade(out);
  fade_.last = out;
  return out;
}

/// Gain of the second foot's sound: it fades out when the foot is switched off; then the foot is
/// reset.
double Footstep::second_foot_share(bool on) noexcept {
  const double step = 1 / fade_.whole;
  if (on) {
    second_foot_ = second_foot_ > 0 ? std::min(second_foot_ + step, 1.0) : 1;
  } else if (second_foot_ > 0) {
    second_foot_ = second_foot_ > step ? second_foot_ - step : 0;
    if (second_foot_ == 0) {
      (*sides_)[1].foot.reset();
      (*sides_)[1].sensor.reset();
    }
  }
  if (second_foot_ == 0 || second_foot_ == 1)
    return second_foot_;
  return 0.5 - 0.5 * math::cos(std::numbers::pi * second_foot_);
}

/// After a reset the last output fades to 0 along half a cosine; forces jump to 0.
void Footstep::fade(std::array<double, 8>& out) noexcept {
  const double part =
      0.5 - 0.5 * math::cos(std::numbers::pi * std::max(fade_.left, 0.0) / fade_.whole);
  const double max_drive = std::min(settings_.limit_g / settings_.sensitivity_g, 1.0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double bound = i % 4 == 0 ? 1 : max_drive;
    if (i % 4 != 3)
      out[i] = std::clamp(out[i] + part * fade_.from[i], -bound, bound);
  }
  fade_.left -= 1;
}

void Footstep::report(Host& host) {
  for (std::size_t i = 0; i < event_count_; ++i) {
    const Event& event = events_[i];
    const auto phase = kPhases[static_cast<std::size_t>(event.phase)];
    if (event.speed > 0)
      host.info({"step", kSideNames[event.foot], phase, event.speed});
    else
      host.info({"step", kSideNames[event.foot], phase});
  }
  event_count_ = 0;
}

void Footstep::dump(Host& host) {
  const auto& [left, right] = *sides_;
  const auto send_levels = [&](const Side& side, auto... foot) {
    host.info({"surface", foot..., std::string_view(side.first->name),
               std::string_view(side.second->name), settings_.mix});
  };
  if (left.first == right.first && left.second == right.second)
    return send_levels(left);
  send_levels(left, kSideNames[0]);
  send_levels(right, kSideNames[1]);
}

} // namespace tactus::footstep
