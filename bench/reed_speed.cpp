// The cost of a reed: One greed~ in silence and playing, its parts, eight reeds with their
// playability in vector lanes ([greed_gradient~]), and STK's Clarinet, a reed without memory,
// beside them.
//
//   bench_reed_speed --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
//
// prints nanoseconds a sample. The last lines, ratios of rounds that were run in turn within
// milliseconds of each other, are what to trust on a shared machine.
#include "bench/paired.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/radiation_path.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/bore/tone_hole_end.hpp"
#include "core/reed/instrument/instrument.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/valve_bore_step.hpp"
#include "core/reed/playability/gradient.hpp"
#include "core/reed/playability/playability_follower.hpp"

#include <benchmark/benchmark.h>
#ifdef TACTUS_HAS_STK
#include <stk/Clarinet.h>
#endif

#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <span>
#include <string>
#include <tuple>

namespace {

using namespace tactus::reed;
using namespace tactus::bench;

constexpr double kRate = 48000;

/// One greed~ that has played for a second.
class Scalar {
public:
  struct ControlInput {
    bool moving_reed = false, moving_bore = false; // f_r, f_b always on their way
    bool tune = false;
    float note = 262;
    bool holes = true; // of presets that have them
  };
  Scalar(std::string_view preset, double pressure) : Scalar(preset, pressure, ControlInput{}) {}
  Scalar(std::string_view preset, double pressure, const ControlInput& gesture)
      : gesture_(gesture) {
    Parameters parameters = *find_preset(preset);
    parameters.tune = gesture.tune;
    parameters.end = gesture.holes ? parameters.end : BoreEnd::kOpen;
    instrument_.set(parameters);
    note_ = gesture.note;
    instrument_.prepare(kRate, kBlock);
    mouth_.fill(pressure);
    if (gesture.tune || gesture.moving_bore)
      bore_.fill(note_);
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    if (gesture_.moving_reed) {
      lip_ = lip_ < 2600 ? lip_ + 0.1F : 2500;
      reed_.fill(lip_);
    }
    if (gesture_.moving_bore) {
      note_ = note_ < 300 ? note_ + 0.01F : 262;
      bore_.fill(note_);
    }
    instrument_.process<float>({mouth_, reed_, bore_}, {sound_, angle_, pressure_, flow_});
    benchmark::DoNotOptimize(sound_);
  }

private:
  using Signal = std::array<float, kBlock>;
  struct Filled : Signal {
    void fill(double x) { Signal::fill(static_cast<float>(x)); }
  };
  Instrument instrument_;
  ControlInput gesture_;
  float lip_ = 2500, note_ = 262;
  Filled mouth_{};
  Filled reed_{}, bore_{};
  Signal sound_{}, angle_{}, pressure_{}, flow_{};
};

/// One greed~ with `tune`, its f_b still or in a vibrato of 50 cents at 6 Hz, that has played for a
/// second.
class Tuned {
public:
  Tuned(std::string_view preset, double pressure, double note, bool vibrato)
      : note_(note), vibrato_(vibrato) {
    Parameters p = *find_preset(preset);
    p.tune = true;
    instrument_.set(p);
    instrument_.prepare(kRate, kBlock);
    mouth_.fill(static_cast<float>(pressure));
    bore_.fill(static_cast<float>(note));
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    if (vibrato_)
      for (float& f : bore_) {
        // The benchmark is not to pay for a sine: a parabola, upside down every half period.
        phase_ = phase_ < 1 ? phase_ + 12 / kRate : -1;
        f = static_cast<float>(note_ * (1 + 0.0293 * 4 * phase_ * (1 - std::abs(phase_))));
      }
    instrument_.process<float>({mouth_, reed_, bore_}, {sound_, angle_, pressure_, flow_});
    benchmark::DoNotOptimize(sound_);
  }

private:
  using Signal = std::array<float, kBlock>;
  Instrument instrument_;
  double note_, phase_ = 0;
  bool vibrato_;
  Signal mouth_{}, reed_{}, bore_{}, sound_{}, angle_{}, pressure_{}, flow_{};
};

/// One greed_gradient~ that has played for a second.
class Lanes {
public:
  Lanes(std::string_view preset, double pressure, tactus::simd::VectorSet widest,
        bool moving = false)
      : gradient_(widest), moving_(moving) {
    const Parameters p = *find_preset(preset);
    gradient_.set(p);
    gradient_.set_range({0, 2 * pressure + 1, 0.5 * p.reed_frequency, 2 * p.reed_frequency});
    gradient_.prepare(kRate);
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    for (std::size_t done = 0; done < kBlock; done += ReedGradient::kHandPeriod) {
      if (moving_)
        phase_ = phase_ < 0.51 ? phase_ + 1e-5 : 0.5;
      gradient_.move(0.5, phase_, 0);
      gradient_.process(std::span(sound_).subspan(done, ReedGradient::kHandPeriod));
    }
    benchmark::DoNotOptimize(gradient_.gradient());
    benchmark::DoNotOptimize(sound_);
  }

private:
  ReedGradient gradient_;
  bool moving_;
  double phase_ = 0.5;
  std::array<double, kBlock> sound_{};
};

/// The parts of the scalar reed, fed with what a played reed gives.
class Parts {
public:
  Parts() {
    parameters_ = *find_preset("clarinet");
    design_.set(parameters_, kRate);
    constants_ = ValveConstants::from(parameters_, design_, kRate);
    trip_ = design_.round_trip(parameters_.length);
    coefficients_ = ReedCoefficients<double>::at(constants_, 2 * 3.14159265 * 2500);
    mouth_.fill(2000);
    for (std::size_t n = 0; n < kBlock; ++n)
      wave_[n] = source_[n] = n % 32 < 16 ? 700.0 : -700.0;
    line_.prepare(max_delay(kRate));
    path_.prepare(kRate);
    end_.set(kRate, 1, parameters_.input_radius);
    end_.finger(fingering_for(BoreEnd::kClarinet, 175));
    path_.set(RadiationConstants::from(parameters_, design_, kRate));
  }
  void valve() {
    const ValveSignals<double> signal{mouth_.data(), nullptr,      wave_.data(),
                                      angle_.data(), bore_.data(), flow_.data()};
    wave_ = source_;
    step_valve<false, false, true>(constants_, &coefficients_, 0, state_, signal,
                                   static_cast<int>(kBlock));
    benchmark::DoNotOptimize(wave_);
  }
  void filters() {
    RoundTripFilter<double>::BlockFilter filter(filter_, trip_, 0);
    for (std::size_t n = 0; n < kBlock; ++n)
      wave_[n] = filter(source_[n], radiated_[n]);
    benchmark::DoNotOptimize(wave_);
  }
  void delay() {
    constexpr auto kCount = static_cast<int>(kBlock);
    double* wave = line_.next(); // blocks of 64 always fit in one piece
    line_.read(trip_.delay, 1e-20, wave, kCount);
    benchmark::DoNotOptimize(*wave);
    line_.advance(kCount);
  }
  void holes() {
    wave_ = radiated_ = source_;
    end_.reflect(wave_.data(), static_cast<int>(kBlock));
    end_.radiate(radiated_.data(), static_cast<int>(kBlock));
    benchmark::DoNotOptimize(wave_);
    benchmark::DoNotOptimize(radiated_);
  }
  void radiation() {
    radiated_ = source_;
    path_.run(radiated_.data(), static_cast<int>(kBlock), parameters_.length);
    benchmark::DoNotOptimize(radiated_);
  }
  void playability() {
    follower_.prepare(kRate);
    for (const double x : source_)
      follower_.tick(1e-5 * x);
    benchmark::DoNotOptimize(follower_.playability());
  }

private:
  using Signal = std::array<double, kBlock>;
  Parameters parameters_;
  BoreDesign design_;
  ValveConstants constants_;
  RoundTrip trip_;
  ReedCoefficients<double> coefficients_;
  ValveState<double> state_;
  RoundTripFilter<double> filter_;
  PlayabilityFollower<double> follower_;
  Signal mouth_{}, source_{}, wave_{}, radiated_{}, angle_{}, bore_{}, flow_{};
  BoreLine<double, static_cast<int>(kBlock)> line_;
  RadiationPath path_;
  ToneHoleEnd<double> end_;
};

#ifdef TACTUS_HAS_STK
class Peer {
public:
  Peer() : clarinet_(8.0) {
    stk::Stk::setSampleRate(kRate);
    clarinet_.noteOn(175, 0.8);
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    for (double& x : sound_)
      x = clarinet_.tick();
    benchmark::DoNotOptimize(sound_);
  }

private:
  stk::Clarinet clarinet_;
  std::array<double, kBlock> sound_{};
};
#endif

/// A member function of Parts as a player.
struct Part {
  Parts& parts;
  void (Parts::*work)();
  void block() { (parts.*work)(); }
};

} // namespace

// One piece: a list of the benchmarks, one after the other.
int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  Scalar clarinet("clarinet", 2000), silence("clarinet", 0), trumpet("trumpet", 4000);
  Lanes lanes("clarinet", 2000, tactus::simd::kWidest);
  Lanes lip_lanes("trumpet", 4000, tactus::simd::kWidest);
  Lanes silent_lanes("clarinet", 0, tactus::simd::kWidest);
  Lanes plain("clarinet", 2000, tactus::simd::VectorSet::kBaseline);
  Lanes moved("clarinet", 2000, tactus::simd::kWidest, true);
  Scalar holed("clarinet", 2000, {.tune = true, .note = 175});
  Scalar open("clarinet", 2000, {.tune = true, .note = 175, .holes = false});
  Scalar moving_reed("clarinet", 2000, {.moving_reed = true});
  Scalar moving_bore("clarinet", 2000, {.moving_bore = true});
  Scalar tuned_trumpet("trumpet", 4000, {.tune = true});
  Scalar moving_tuned("trumpet", 4000, {.moving_bore = true, .tune = true});
  Parts parts;
  Part valve{parts, &Parts::valve}, filters{parts, &Parts::filters}, delay{parts, &Parts::delay},
      radiation{parts, &Parts::radiation}, holes{parts, &Parts::holes},
      playability{parts, &Parts::playability};
  add("greed~ clarinet, playing", clarinet);
  add("greed~ clarinet, tune 1, open end", open);
  add("greed~ clarinet, tune 1, tone holes", holed);
  add("greed~ clarinet, silent", silence);
  add("greed~ trumpet, playing", trumpet);
  struct Pair {
    std::string preset;
    Tuned still, moving;
  };
  std::deque<Pair> pairs;
  using Note = std::tuple<const char*, double, double>; // preset, Pa, Hz
  for (const auto& [preset, pressure, note] :
       {Note{"clarinet", 2500, 175}, Note{"sax", 2500, 175}, Note{"oboe", 2000, 330},
        Note{"trumpet", 4000, 233}, Note{"trombone", 2000, 147}, Note{"voice", 2500, 147},
        Note{"syrinx", 600, 880}})
    pairs.push_back(
        {preset, Tuned(preset, pressure, note, false), Tuned(preset, pressure, note, true)});
  for (Pair& pair : pairs) {
    add("greed~ " + pair.preset + ", tuned, f_b still", pair.still);
    add("greed~ " + pair.preset + ", tuned, vibrato", pair.moving);
  }
  add("part: valve and jet", valve);
  add("part: bore filters", filters);
  add("part: delay line", delay);
  add("part: bell", radiation);
  add("part: tone holes, inside and outside", holes);
  add("playability~ without analysis", playability);
  add("greed_gradient~ clarinet, playing", lanes);
  add("greed_gradient~ clarinet, silent", silent_lanes);
  add("greed_gradient~ trumpet, playing", lip_lanes);
  add("greed_gradient~ clarinet, SSE2", plain);
#ifdef TACTUS_HAS_STK
  Peer peer;
  add("STK Clarinet, playing", peer);
#endif
  benchmark::RunSpecifiedBenchmarks();

  std::printf("\nratio, median of paired rounds\n");
  for (Pair& pair : pairs)
    print_ratio(("greed~ vibrato / f_b still, " + pair.preset).c_str(), pair.moving, pair.still);
  print_ratio("greed_gradient~ / greed~, clarinet (at most 1.3)", lanes, clarinet);
  print_ratio("greed_gradient~ / greed~, trumpet", lip_lanes, trumpet);
  print_ratio("greed_gradient~ / greed~, clarinet, f_r always moving", moved, moving_reed);
  print_ratio("greed_gradient~ with SSE2 only / greed~, clarinet", plain, clarinet);
  print_ratio("greed~ trumpet / clarinet (cone, cup, steepening)", trumpet, clarinet);
  print_ratio("greed~ clarinet, f_b moving / still (at most 2)", moving_bore, clarinet);
  print_ratio("greed~ trumpet, tune 1 / 0", tuned_trumpet, trumpet);
  print_ratio("greed~ trumpet, tune 1, f_b moving / still (at most 2)", moving_tuned,
              tuned_trumpet);
  print_ratio("greed~ silent / playing, clarinet", silence, clarinet);
  print_ratio("greed~ with tone holes / with an open end, clarinet, tune 1", holed, open);
  print_ratio("greed_gradient~ silent / playing, clarinet", silent_lanes, lanes);
#ifdef TACTUS_HAS_STK
  print_ratio("greed~ / STK Clarinet (at most 2, aim 1)", clarinet, peer);
  print_ratio("greed_gradient~ / STK Clarinet", lanes, peer);
#endif
}
