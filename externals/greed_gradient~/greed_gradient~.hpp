#pragma once

#include "core/reed/playability/gradient.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/playability_rows.hpp"
#include "core/rows.hpp"
#include "externals/greed_gradient~/guide_updater.hpp"
#include "externals/greed~/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace tactus {

/// [greed_gradient~]: a sounding reed, the gradient of its playability at the hand's position and
/// the force on the hand (core/reed/playability/gradient.hpp, docs/guidance.md).
class GreedGradient {
public:
  /// Initial breath noise, relative to the mouth pressure. A hand raises the pressure slowly; with
  /// only greed~'s noise, notes near their threshold would take too long to start. In silence the
  /// noise is at -108 dB.
  static constexpr double kBreathNoise = 5e-4;
  static const Declaration declaration;
  enum Timer : std::size_t { kStoppedTimer, kGuideTimer };
  static constexpr std::size_t timers = 2;

  GreedGradient() { gradient_.set(parameters_); }

  void prepare(double sample_rate, std::size_t) {
    sample_rate_ = sample_rate;
    gradient_.prepare(sample_rate);
  }
  void report(Host& host);
  void tick(std::size_t timer, Host& host);
  void dump_first(Host& host) { greed::dump_preset(parameters_, host); }
  void dump(Host& host);

  template <class S> void process(const Block<S>& block) noexcept {
    std::array<double, reed::ReedGradient::kHandPeriod> sound;
    gradient_.set_guide(guide_.latest());
    for (std::size_t done = 0; done < block.frames;) {
      const auto hand = [&](std::size_t inlet) {
        return static_cast<double>(block.inputs[inlet][done]);
      };
      if (gradient_.samples_until_hand() == 0)
        gradient_.move(hand(0), hand(1), hand(2));
      const std::size_t left = gradient_.samples_until_hand() > 0 ? gradient_.samples_until_hand()
                                                                  : reed::ReedGradient::kHandPeriod;
      const std::size_t count = std::min(left, block.frames - done);
      gradient_.process(std::span(sound).first(count));
      for (std::size_t i = 0; i < count; ++i)
        block.outputs[0][done + i] = static_cast<S>(sound[i]);
      done += count;
    }
    unreported_ += block.frames;
  }

private:
  struct Rows;

  [[nodiscard]] const reed::Parameters& parameters() const noexcept { return parameters_; }
  void take(const reed::Parameters& changed) noexcept {
    parameters_ = changed;
    gradient_.set(parameters_);
  }
  [[nodiscard]] const reed::PlayabilityParameters& estimator() const noexcept { return estimator_; }
  void take_estimator(const reed::PlayabilityParameters& changed) noexcept {
    estimator_ = changed;
    gradient_.set(estimator_);
  }
  void take_preset(const Atom& name, Host& host);
  void take_range(std::span<const Atom> words, Host& host) {
    if (const auto range = greed::range_of(words, host))
      gradient_.set_range(*range);
  }

  static constexpr std::size_t kPlayabilityOutlet = 1, kGradientOutlet = 2, kForceOutlet = 4;

  reed::ReedGradient gradient_;
  reed::Parameters parameters_{.breath_noise = kBreathNoise};
  reed::PlayabilityParameters estimator_{};
  double sample_rate_ = 48000;
  bool background_ = true;
  std::size_t unreported_ = 0;
  reed::GuideUpdater guide_;
};

inline void GreedGradient::take_preset(const Atom& name, Host& host) {
  const auto preset = greed::preset_of(name, parameters_, host);
  if (!preset)
    return;
  take(*preset);
  gradient_.set_range(reed::range_for(parameters_));
}

/// After each block: sends force, gradient and playability. Allocates nothing.
inline void GreedGradient::report(Host& host) {
  const double seconds = static_cast<double>(unreported_) / sample_rate_;
  unreported_ = 0;
  if (gradient_.mode() != reed::ReedGradient::Mode::kReed &&
      guide_.needs_work(gradient_.plane(), seconds, background_ && host.real_time()))
    host.wake_in(kGuideTimer, 0);
  const reed::Gradient slope = gradient_.gradient();
  const reed::PlaneForce& force = gradient_.force();
  host.send(kForceOutlet, {force.y, force.z});
  host.send(kGradientOutlet, {slope.y, slope.z});
  host.send(kPlayabilityOutlet, {gradient_.playability()});
  host.wake_in(kStoppedTimer, std::max(100.0, 3000 * seconds));
}

inline void GreedGradient::tick(std::size_t timer, Host& host) {
  if (timer == kStoppedTimer) { // no block for a while, so the audio has stopped
    gradient_.release_force();
    return host.send(kForceOutlet, {0.0, 0.0});
  }
  guide_.work();
  if (const std::string error = guide_.take_error(); !error.empty())
    host.error(error);
  if (guide_.progress_changed())
    host.info({"map", guide_.progress()});
}

inline void GreedGradient::dump(Host& host) {
  const reed::ControlRange& range = gradient_.range();
  host.info({"range", range.lowest_pressure, range.highest_pressure, range.lowest_frequency,
             range.highest_frequency});
  host.info({"P_M", reed::closing_pressure(gradient_.parameters())});
  host.info({"L", gradient_.ensemble().length()});
}

struct GreedGradient::Rows {
  using Self = GreedGradient;
  using Gradient = reed::ReedGradient;
  static constexpr std::array<std::string_view, 3> modes{"reed", "growth", "guide"};
  static constexpr auto parameters = joined(
      joined(
          greed::with_initial("noise", kBreathNoise,
                              rows_of_field<&Self::parameters, &Self::take, reed::kRows>()),
          std::array{
              property<&Gradient::delta, &Gradient::set_delta, &Self::gradient_>.row(
                  "delta", "", 0.01, 1e-3, 0.25,
                  "distance of the four neighbours, relative to a side of the plane"),
              property<&Gradient::mode, &Gradient::set_mode, &Self::gradient_>.row(
                  "mode", modes,
                  "source of the guidance: playability of five reeds, growth rate by linear "
                  "theory, or the nearest note",
                  0),
              property<&Gradient::ceiling, &Gradient::set_ceiling, &Self::gradient_>.row(
                  "ceiling", "N", 2, 0, 40,
                  "maximum force: per axis in modes reed and growth, of the vector in mode guide"),
              property<&Gradient::force_gain, &Gradient::set_force_gain, &Self::gradient_>.row(
                  "force_gain", "N", 0.3, 0, 100,
                  "force for a slope of 1 in modes reed and growth"),
              member<&Self::background_>.row("background",
                                             "switch: 1 computes maps in a thread; 0 in the host's "
                                             "time, 3000 nodes a second, as every render does",
                                             1),
          }),
      rows_of_field<&Self::estimator, &Self::take_estimator, reed::kPlayabilityRows>());
  static constexpr std::array messages{
      action<&Self::take_preset>(greed::kPresetMessage),
      action<&Self::take_range>(greed::kRangeMessage),
      realtime(action<&Self::gradient_, &Gradient::reset>("reset", "", 0, 0,
                                                          "stop all motion of valves and air")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "y", "", "hand's height 0..1: mouth pressure"},
      Port{Port::Kind::kSignal, "z", "", "hand's depth 0..1: reed frequency"},
      Port{Port::Kind::kSignal, "f_b", "Hz", "bore frequency; 0: from `own_length`"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "sound", "", "sound of the hand's reed, within +-1"},
      Port{Port::Kind::kControl, "f_p", "", "playability of the hand's reed"},
      Port{Port::Kind::kControl, "gradient", "", "slope g_y g_z per unit of y and of z"},
      Port{Port::Kind::kControl, "info", "", "answers, and map 0..1 while it computes"},
      Port{Port::Kind::kControl, "force", "N", "list F_y F_z on the hand"},
  };
};

inline constexpr Declaration GreedGradient::declaration{
    "greed_gradient~",
    "a reed and the slope of its playability in one object",
    "Five reeds of one instrument: one at the hand's point in the plane of mouth pressure and reed "
    "frequency, and one on each side of it. Differences in their playability are the slope that "
    "guides the hand. The object costs a third more than one greed~. In mode growth the slope "
    "comes from linear theory and also leads out of silence. In mode guide the force pulls to the "
    "nearest note and is zero there. Both modes need a map, which a thread computes after each "
    "change, while the old map stays in use: map 0..1 at the info outlet.",
    "reed lips haptic gradient playability guidance",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    greed::kArguments,
    "greed~, playability_map, reed_haptic.pd",
    "how to use it: guidance.md, the model: theory/guidance.md",
    "reed/adagio_room.wav: the clarinet of Mozart's Adagio, played by a hand"};

} // namespace tactus
