#pragma once

#include "core/object.hpp"
#include "core/reed/playability/playability.hpp"
#include "externals/playability~/fftw_transform.hpp"

#include <array>
#include <cstddef>
#include <memory>

namespace tactus::reed {

/// [playability~]: an estimate in 0..1 of how well a reed plays, from the angle of its valve.
/// docs/playability.md.
struct PlayabilityObject {
  static constexpr std::array<std::string_view, 2> kModes{"paper", "robust"};
  static constexpr std::array kParameters{
      Parameter{"attack", "ms", 5, 0.1, 5000, "time in which the envelope rises"},
      Parameter{"release", "ms", 80, 0.1, 5000, "time in which the envelope falls"},
      Parameter{"hp", "Hz", 10, 0.1, 1000, "high-pass that takes away where the valve rests"},
      Parameter{"ref", "rad", 0.03, 1e-6, 10, "amplitude that counts as half playable"},
      Parameter{"window", "ms", 50, 5, 250, "time over which zero crossings are counted"},
      Parameter{"hyst", "", 0.2, 0, 0.9, "hysteresis of the count, relative to the envelope"},
      Parameter{
          "mode", "", 1, 0, 1,
          "what lowers playability: zero crossings alone (paper), or aperiodicity too (robust)",
          kModes},
      Parameter{"analysis", "", 1, 0, 1,
                "1: outlets 5 and 6 tell periodicity and regime; robust analyses with 0 as well"},
  };
  static constexpr std::array kInlets{
      Port{Port::Kind::kSignal, "angle", "rad", "angle of the valve, outlet theta of greed~"},
  };
  static constexpr std::array kOutlets{
      Port{Port::Kind::kControl, "playability", "", "f_p from 0 to 1, after each block"},
      Port{Port::Kind::kControl, "envelope", "rad", "rectified mean of the oscillation"},
      Port{Port::Kind::kControl, "crossings", "Hz", "upward zero crossings a second"},
      Port{Port::Kind::kControl, "variation", "",
           "deviation over mean of the crossings' intervals"},
      Port{Port::Kind::kControl, "analysis", "",
           "list: f0 in Hz, periodicity 0..1, harmonics to noise in dB, centroid in Hz"},
      Port{Port::Kind::kControl, "regime", "",
           "0 silent, 1 periodic, 2 quasi-periodic, 3 chaotic; with each analysis"},
  };
  static constexpr std::array kMessages{
      realtime(Message{"reset", "", 0, 0, "start anew: envelope, crossings and analysis"}),
      realtime(Message{"bang", "", 0, 0, "send playability, envelope, crossings, variation now"}),
  };
  enum MessageIndex : std::size_t { kReset, kBang };
  static constexpr std::array kArguments{CreationArgument{"mode"}};
  static constexpr Declaration declaration{
      "playability~",
      "how well a reed plays, from its motion",
      "Follows the oscillation of a valve and says how playable its state is: the envelope of the "
      "alternating part, lowered when zero crossings suddenly jump to a very high number (paper) "
      "and when the motion is not periodic (robust, the default). Differences of this number "
      "between neighbouring states guide the hand.",
      "reed playability envelope zero-crossing periodicity chaos",
      kInlets,
      kOutlets,
      kParameters,
      kMessages,
      kArguments,
      "greed~, playability_map, greed_gradient~",
      "the model: playability.md"};

  void prepare(double sample_rate, std::size_t) { estimator.prepare(sample_rate, transform); }

  void set(std::size_t parameter, double value) noexcept {
    PlayabilityParameters p = estimator.follower().parameters();
    switch (parameter) {
    case 0:
      p.attack_s = 1e-3 * value;
      break;
    case 1:
      p.release_s = 1e-3 * value;
      break;
    case 2:
      p.highpass_hz = value;
      break;
    case 3:
      p.reference_rad = value;
      break;
    case 4:
      p.window_s = 1e-3 * value;
      break;
    case 5:
      p.hysteresis = value;
      break;
    case 6:
      p.mode =
          value > 0 ? PlayabilityParameters::Mode::kRobust : PlayabilityParameters::Mode::kPaper;
      break;
    default:
      estimator.set_analysis(value >= 0.5);
      break;
    }
    estimator.set(p);
  }

  [[nodiscard]] double get(std::size_t parameter) const noexcept {
    const PlayabilityParameters& p = estimator.follower().parameters();
    switch (parameter) {
    case 0:
      return 1e3 * p.attack_s;
    case 1:
      return 1e3 * p.release_s;
    case 2:
      return p.highpass_hz;
    case 3:
      return p.reference_rad;
    case 4:
      return 1e3 * p.window_s;
    case 5:
      return p.hysteresis;
    case 6:
      return p.mode == PlayabilityParameters::Mode::kRobust ? 1 : 0;
    default:
      return estimator.analysis() ? 1 : 0;
    }
  }

  void message(std::size_t index, std::span<const Atom>, Host& host) {
    if (index == kBang)
      return report(host);
    estimator.reset();
    reported = 0;
  }

  template <class S> void process(const Block<S>& block) noexcept {
    for (const S angle : block.in(0))
      estimator.tick(static_cast<double>(angle));
  }

  void report(Host& host) {
    if (estimator.analysis() && estimator.frames() != reported) {
      reported = estimator.frames();
      const Periodicity& p = estimator.periodicity();
      host.send(5, {static_cast<double>(estimator.regime())});
      host.send(4, {p.frequency_hz, p.periodicity, p.harmonicity_db, p.centroid_hz});
    }
    host.send(3, {estimator.follower().interval_variation()});
    host.send(2, {estimator.follower().crossing_rate()});
    host.send(1, {estimator.follower().envelope()});
    host.send(0, {estimator.playability()});
  }

  Playability estimator;
  std::shared_ptr<RealTransform> transform = std::make_shared<FftwTransform>();
  std::size_t reported = 0;
};

} // namespace tactus::reed
