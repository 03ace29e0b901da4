#pragma once

#include "core/reed/playability/playability.hpp"
#include "core/reed/playability/playability_rows.hpp"
#include "core/rows.hpp"
#include "externals/playability~/fftw_transform.hpp"

#include <array>
#include <cstddef>
#include <memory>

namespace tactus::reed {

/// [playability~]: an estimate in 0..1 of how well a reed plays, from the angle of its valve.
/// docs/playability.md.
struct PlayabilityObject {
  static const Declaration declaration;
  struct Rows;

  void prepare(double sample_rate, std::size_t) { estimator.prepare(sample_rate, transform); }

  [[nodiscard]] const PlayabilityParameters& parameters() const noexcept {
    return estimator.follower().parameters();
  }
  void take(const PlayabilityParameters& changed) noexcept { estimator.set(changed); }
  void reset() noexcept {
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

struct PlayabilityObject::Rows {
  using Self = PlayabilityObject;
  static constexpr auto parameters =
      joined(rows_of_field<&Self::parameters, &Self::take, kPlayabilityRows>(),
             std::array{
                 field<&Self::parameters, &Self::take, &PlayabilityParameters::mode>.row(
                     "mode", kPlayabilityModes,
                     "measure that lowers playability: zero crossings alone (paper), or also "
                     "aperiodicity (robust)"),
                 property<&Playability::analysis, &Playability::set_analysis, &Self::estimator>.row(
                     "analysis",
                     "switch: 1 sends periodicity and regime to outlets 5 and 6; `mode robust` "
                     "also analyses at 0",
                     1),
             });
  static constexpr std::array messages{
      realtime(action<&Self::reset>("reset", "", 0, 0, "restart envelope, crossings and analysis")),
      realtime(action<&Self::report>("bang", "", 0, 0,
                                     "send playability, envelope, crossings and variation now")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "angle", "rad", "angle of the valve, outlet theta of greed~"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "playability", "",
           "playability f_p from 0 to 1, after each block"},
      Port{Port::Kind::kControl, "envelope", "rad", "rectified mean of the oscillation"},
      Port{Port::Kind::kControl, "crossings", "Hz", "upward zero crossings per second"},
      Port{Port::Kind::kControl, "variation", "",
           "standard deviation / mean of the intervals between crossings"},
      Port{Port::Kind::kControl, "analysis", "",
           "list: f0 in Hz, periodicity 0..1, harmonic-to-noise ratio in dB, centroid in Hz"},
      Port{Port::Kind::kControl, "regime", "",
           "regime: 0 silent, 1 periodic, 2 quasi-periodic, 3 chaotic; with each analysis"},
  };
  static constexpr std::array arguments{CreationArgument{"mode"}};
};

inline constexpr Declaration PlayabilityObject::declaration{
    "playability~",
    "how well a reed plays, from its motion",
    "Measures how playable the state of a valve is, from its oscillation. Playability follows the "
    "envelope of the alternating part. It is lower if the number of zero crossings suddenly "
    "becomes very high (paper), and if the motion is not periodic (robust, the default). "
    "Differences between neighbouring states guide the hand.",
    "reed playability envelope zero-crossing periodicity chaos",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "greed~, playability_map, greed_gradient~",
    "how to use it: playability.md, the model: theory/playability.md"};

} // namespace tactus::reed
