#include "core/reed/instrument/presets.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace tactus::reed {
namespace {

using namespace test;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Everything moves, the bore from 0.1 s on.
Controls moving(const Parameters& p, std::size_t size) {
  Controls in;
  for (std::size_t n = 0; n < size; ++n) {
    const double t = static_cast<double>(n) / 48000;
    in.pressure.push_back(1500 + 1200 * std::sin(9 * t));
    in.reed.push_back(p.reed_frequency * (1 + 0.2 * std::sin(25 * t)));
    in.bore.push_back(t < 0.1 ? 0 : 180 * std::exp2(std::sin(6 * t)));
  }
  return in;
}

Recording in_blocks(const Parameters& p, const Controls& in, std::size_t block) {
  Instrument instrument = make_instrument(p);
  return play(instrument, in, 48000, block);
}

int denormals(const Recording& r) {
  int count = 0;
  for (const auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
    for (const double value : *signal)
      count += std::fpclassify(value) == FP_SUBNORMAL;
  return count;
}

void check_fading(double seconds) {
  for (const Preset& preset : presets()) {
    Instrument instrument = make_instrument(preset.parameters);
    play(instrument, ramp(2000, 0.5, 48000), 48000);
    const auto silence = static_cast<std::size_t>(seconds * 48000);
    const Recording r = play(instrument, std::vector<double>(silence, 0.0), 48000);
    CAPTURE(preset.name);
    CHECK(denormals(r) == 0);
    // Of the flow only the jet's own loss is left, u' = -u^2/(2 lambda): it dies as 1/t.
    CHECK(std::abs(r.flow.back()) < 2e-5 / seconds);
    CHECK(std::abs(r.bore_pressure.back()) < 0.02 / seconds);
    CHECK(std::abs(r.sound.back()) < 2e-5 / seconds);
    CHECK(r.theta.back() == doctest::Approx(preset.parameters.rest_angle));
  }
}

void check_random_instruments(int trials) {
  std::mt19937 random(12);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, uniform(0, 1));
  };
  Instrument instrument;
  instrument.prepare(48000, 64);
  int outliers = 0;
  double highest = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Parameters p;
    p.type = static_cast<ValveType>(random() % 3);
    p.rest_angle = uniform(-0.5, 0.5);
    p.arm_length = between(1e-4, 0.1);
    p.mass = between(1e-9, 1e-2);
    p.reed_frequency = between(1, 18000);
    p.quality = between(0.1, 1000);
    p.width = between(1e-5, 0.1);
    p.mouth_length = between(1e-5, 0.1);
    p.bore_length = between(1e-5, 0.1);
    p.flow_length = trial % 2 ? 0 : between(1e-5, 0.05);
    p.channel_length = between(1e-7, 0.1);
    p.leak_area = trial % 3 ? 0 : between(1e-9, 1e-4);
    p.restitution = uniform(0, 1);
    p.displacement_limit = between(1e-5, 0.05);
    p.sweep = trial % 5 != 0;
    p.shape = trial % 2 ? BoreShape::kCone : BoreShape::kCylinder;
    p.length_override = trial % 7 ? between(0.005, 20) : 0;
    p.input_radius = between(5e-4, 0.1);
    p.end_radius = between(5e-4, 0.3);
    p.apex_distance = between(1e-3, 10);
    p.cup_volume = trial % 3 ? between(1e-9, 1e-3) : 0;
    p.wall_loss = between(1e-3, 100);
    p.scalar_reflection = trial % 11 ? 0 : uniform(0.1, 1);
    p.oversampling = static_cast<int>(random() % 5);
    p.flow = trial % 4 ? FlowMethod::kImplicit : FlowMethod::kPaper;
    p.breath_noise = trial % 6 ? 0 : uniform(0, 1);
    p.tune = trial % 3 == 0;
    instrument.set(p);
    if (trial % 4 != 0) // else the change itself is what is tried, and silent for the most part
      instrument.reset();
    for (int stretch = 0; stretch < 10; ++stretch) {
      const Recording r = play(instrument, std::vector<double>(300, uniform(-20e3, 50e3)), 48000,
                               between(1, 18000), between(5, 5000));
      for (std::size_t n = 0; n < r.sound.size(); ++n) {
        outliers += !(std::abs(r.sound[n]) <= 1) || !std::isfinite(r.theta[n]) ||
                    !std::isfinite(r.bore_pressure[n]) || !std::isfinite(r.flow[n]);
        highest = std::max(highest, std::abs(r.bore_pressure[n]));
      }
    }
  }
  CHECK(outliers == 0);
  CHECK(highest < 2e9); // Pa: beyond 1e9 (before decimation) the model starts anew
}

} // namespace

TEST_CASE("the same bits come out however the stream is cut into blocks") {
  for (const Preset& preset : presets()) {
    Parameters p = preset.parameters;
    p.breath_noise = 0.02;
    p.tune = true;
    const Controls in = moving(p, 9600);
    const Recording whole = in_blocks(p, in, 0);
    for (const std::size_t block : {1u, 7u, 64u, 1000u}) {
      const Recording cut = in_blocks(p, in, block);
      INFO(std::string(preset.name), " in blocks of ", block);
      CHECK(cut.sound == whole.sound);
      CHECK(cut.theta == whole.theta);
      CHECK(cut.bore_pressure == whole.bore_pressure);
      CHECK(cut.flow == whole.flow);
    }
    CHECK(rms(whole.sound) > 1e-4);
  }
}

TEST_CASE("outlets may overwrite inlets") {
  const Parameters p = find_preset("trumpet").value();
  Controls own = moving(p, 9600);
  const Recording apart = in_blocks(p, own, 9600);
  Instrument instrument = make_instrument(p);
  std::vector<double> flow(9600);
  instrument.process<double>({own.pressure, own.reed, own.bore},
                             {own.bore, own.pressure, own.reed, flow});
  CHECK(own.bore == apart.sound);
  CHECK(own.pressure == apart.theta);
  CHECK(own.reed == apart.bore_pressure);
}

TEST_CASE("the same rate again goes on with the sound; another, or reset, plays as a new reed") {
  Parameters p = find_preset("sax").value();
  p.breath_noise = 0.1;
  const std::vector<double> pressure = ramp(2000, 0.2, 48000);
  Instrument whole = make_instrument(p);
  const std::vector<double> first = play(whole, pressure, 48000).sound;
  const std::vector<double> second = play(whole, pressure, 48000).sound;
  Instrument used = make_instrument(p);
  CHECK(play(used, pressure, 48000).sound == first);
  used.prepare(48000, 1024);
  CHECK(play(used, pressure, 48000).sound == second);
  used.reset();
  CHECK(play(used, pressure, 48000).sound == first);
  for (const double rate : {192000.0, 8000.0, 44100.0}) { // by large steps
    used.prepare(rate, 64);
    Instrument fresh = make_instrument(p, rate);
    CHECK(play(used, ramp(2500, 0.2, rate), rate).sound ==
          play(fresh, ramp(2500, 0.2, rate), rate).sound);
  }
}

TEST_CASE(
    "a number that is changed while a note sounds plays as if it had been there from the start") {
  const Parameters from = find_preset("clarinet").value();
  Parameters to = from;
  to.rest_angle *= 0.6;
  const auto level = [](const Recording& r, double begin) {
    return rms(part(r, r.bore_pressure, begin, begin + 0.5));
  };
  Instrument changed = make_instrument(from);
  const double before = level(play(changed, ramp(2000, 1, 48000), 48000), 0.5);
  changed.set(to);
  const double after = level(play(changed, std::vector<double>(48000, 2000.0), 48000), 0.5);
  CHECK(after == doctest::Approx(level(play(to, 2000, 1.5), 1)).epsilon(1e-3));
  CHECK(std::abs(after / before - 1) > 0.02);
}

TEST_CASE("a number that is changed glides: a reed that rests under little pressure moves evenly") {
  const Parameters from = find_preset("clarinet").value();
  Parameters to = from;
  to.rest_angle *= 0.6;
  Instrument changed = make_instrument(from);
  const double before = play(changed, ramp(200, 1, 48000), 48000).theta.back();
  changed.set(to);
  const std::vector<double> theta = play(changed, std::vector<double>(4800, 200.0), 48000).theta;
  const double after = theta.back();
  REQUIRE(std::abs(after / before - 1) > 0.1);
  double largest_step = 0, last = before;
  for (const double now : theta) {
    largest_step = std::max(largest_step, std::abs(now - last));
    last = now;
  }
  CHECK(largest_step < 0.03 * std::abs(after - before)); // 0.24 where the number leaps
}

TEST_CASE("all that a valve, bore or breath has in numbers glides, words and switches do not") {
  Parameters from, to;
  to.breath_noise = 2 * from.breath_noise;
  to.temperature = from.temperature + 10;
  to.wall_loss = 2;
  to.seed = 7;
  to.sweep = false;
  const Parameters between = interpolate(from, to, 0.5);
  CHECK(between.breath_noise == doctest::Approx(1.5 * from.breath_noise).epsilon(1e-12));
  CHECK(between.temperature == from.temperature + 5);
  CHECK(between.wall_loss == 1.5);
  CHECK(between.seed == 7);
  CHECK(!between.sweep);
}

TEST_CASE("no number on any inlet, and no absurd value, breaks the sound or stays in it") {
  const std::array bad{kNan, kInfinity, -kInfinity, 1e300, -1e300, 1e-310, 0.0, -1.0};
  for (const char* name : {"clarinet", "trumpet", "syrinx"}) {
    const Parameters p = find_preset(name).value();
    Instrument instrument = make_instrument(p);
    std::mt19937 random(1);
    Controls in{std::vector<double>(24000, 2000.0), std::vector<double>(24000),
                std::vector<double>(24000)};
    for (std::size_t n = 0; n < 24000; ++n)
      for (auto* signal : {&in.pressure, &in.reed, &in.bore})
        if (random() % 50 == 0)
          (*signal)[n] = bad[random() % bad.size()];
    const Recording r = play(instrument, in);
    for (const auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
      CHECK(std::all_of(signal->begin(), signal->end(), [](double x) { return std::isfinite(x); }));
    CHECK(std::all_of(r.sound.begin(), r.sound.end(), [](double x) { return std::abs(x) <= 1; }));
    // And afterwards it plays as if nothing had been.
    const Recording after = play(instrument, std::vector<double>(72000, 2000.0), 48000);
    const Recording clean = play(p, 2000, 1.5);
    const double expected = rms(part(clean, clean.bore_pressure, 1, 1.5));
    CAPTURE(name);
    CHECK(std::abs(rms(part(after, after.bore_pressure, 1, 1.5)) - expected) < 0.05 * expected + 1);
  }
}

TEST_CASE("a frequency that is no number leaves the last good one") {
  for (const char* name : {"clarinet", "trumpet"}) {
    Controls held{ramp(2200, 0.5, 48000), {}, {}}, broken = held;
    for (std::size_t n = 0; n < 24000; ++n) {
      const bool late = n > 10000;
      held.reed.push_back(late ? 400 : 380);
      held.bore.push_back(late ? 240 : 233);
      const std::array bad{kNan, kInfinity, -kInfinity};
      // The first of all is good; so is the first after the change, looked at every 32 samples.
      const bool good = n < 32 || (late && n < 10064);
      broken.reed.push_back(good ? held.reed[n] : bad[n % 3]);
      broken.bore.push_back(good ? held.bore[n] : bad[(n / 7) % 3]);
    }
    const Parameters p = with_player(name);
    CAPTURE(name);
    CHECK(in_blocks(p, broken, 64).sound == in_blocks(p, held, 64).sound);
    // Zero and below are numbers: they ask for the preset's own again.
    Controls own = held, negative = held;
    own.reed.assign(24000, 0);
    own.bore.assign(24000, 0);
    negative.reed.assign(24000, -3);
    negative.bore.assign(24000, -1e300);
    CHECK(in_blocks(p, own, 64).sound == in_blocks(p, negative, 64).sound);
    CHECK(in_blocks(p, own, 64).sound != in_blocks(p, held, 64).sound);
  }
}

TEST_CASE("a mouth pressure that is no number is the one before it, others are within 50 kPa") {
  const Parameters p = find_preset("clarinet").value();
  std::mt19937 random(4);
  Controls given, expected;
  for (std::size_t n = 0; n < 9600; ++n) {
    const double good = 1800 + 0.05 * static_cast<double>(n);
    const auto draw = random() % 40;
    // Often at the first sample of a block, where the pressure before is that of the last block.
    const bool none = n > 0 && (draw < 2 || n % 64 == 0 || n % 64 == 1);
    given.pressure.push_back(none ? kNan : draw == 2 ? kInfinity : draw == 3 ? -6e4 : good);
    expected.pressure.push_back(none        ? expected.pressure.back()
                                : draw == 2 ? 50000
                                : draw == 3 ? -50000
                                            : good);
  }
  given.reed = given.bore = expected.reed = expected.bore = std::vector<double>(9600, 0.0);
  CHECK(in_blocks(p, given, 64).sound == in_blocks(p, expected, 64).sound);
  CHECK(in_blocks(p, given, 50).bore_pressure == in_blocks(p, expected, 50).bore_pressure);
}

TEST_CASE("random instruments with jumping controls stay finite and bounded") {
  check_random_instruments(100);
}

TEST_CASE("a thousand random instruments with jumping controls stay finite and bounded" *
          doctest::test_suite("slow")) {
  check_random_instruments(1000);
}

TEST_CASE("after the breath ends every outlet falls towards nothing, without denormals") {
  check_fading(2);
}

TEST_CASE("20 s after the breath's end every outlet is near nothing, without denormals" *
          doctest::test_suite("slow")) {
  check_fading(20);
}

TEST_CASE("ten minutes of silence make no denormals" * doctest::test_suite("slow")) {
  constexpr double kRate = 8000; // what decays slowly does so in seconds, not in samples
  Instrument instrument = make_instrument(find_preset("clarinet").value(), kRate);
  play(instrument, ramp(2000, 1, kRate), kRate);
  for (int minute = 0; minute < 10; ++minute)
    CHECK(denormals(play(instrument, std::vector<double>(480000, 0.0), kRate)) == 0);
}

TEST_CASE("breath noise follows its seed and the jet") {
  Parameters p = find_preset("clarinet").value();
  const auto level = [](const Recording& r) { return rms(part(r, r.bore_pressure, 0.5, 1)); };
  p.breath_noise = 0.05;
  const Recording first = play(p, 800, 1); // below the threshold: only noise sounds
  CHECK(play(p, 800, 1).sound == first.sound);
  p.seed = 2;
  const Recording other = play(p, 800, 1);
  CHECK(other.sound != first.sound);
  CHECK(std::abs(level(other) / level(first) - 1) < 0.3);
  p.breath_noise = 0.1;
  CHECK(std::abs(level(play(p, 800, 1)) / level(first) / 2 - 1) < 0.3);
  const Recording closed = play(p, 9000, 1); // the reed is closed: no jet, no noise
  CHECK(rms(part(closed, closed.bore_pressure, 0.9, 1)) < 1e-3);
}

TEST_CASE("the type's sign of the rest angle wins, and what is no number is not taken") {
  Parameters p;
  p.type = ValveType::kOpen;
  p.rest_angle = -0.02;
  CHECK(clamped(p).rest_angle == 0.02);
  p.type = ValveType::kClosed;
  p.rest_angle = 0.02;
  CHECK(clamped(p).rest_angle == -0.02);
  p.type = ValveType::kSwinging;
  CHECK(clamped(p).rest_angle == 0.02);
  p.mass = kNan;
  CHECK(std::isfinite(clamped(p).mass));
}

TEST_CASE("the presets close, or open, at the pressures of their table") {
  CHECK(closing_pressure(find_preset("clarinet").value()) == doctest::Approx(3943).epsilon(1e-3));
  CHECK(closing_pressure(find_preset("sax").value()) == doctest::Approx(3626).epsilon(1e-3));
  CHECK(closing_pressure(find_preset("oboe").value()) == doctest::Approx(4061).epsilon(1e-3));
  CHECK(presets().size() == 7);
  CHECK_FALSE(find_preset("kazoo"));
}

TEST_CASE("without breath no change of note, fingering, lips or preset makes a sound") {
  for (const Preset& preset : presets()) {
    CAPTURE(preset.name);
    Instrument instrument = make_instrument(with_player(std::string(preset.name).c_str()));
    const double lowest = instrument.parameters().lowest_note;
    double loudest = 0;
    for (int key = 0; key < 30; ++key) {
      const double note = std::max(lowest, 100.0) * std::exp2(key * 7 % 24 / 12.0);
      Parameters moved = instrument.parameters();
      if (key % 5 == 4)
        moved.rest_angle *= 1.2;
      instrument.set(moved);
      const Recording r = play(instrument, std::vector<double>(2400, 0.0), 48000, 0, note);
      for (const double sample : r.sound)
        loudest = std::max(loudest, std::abs(sample));
    }
    CHECK(loudest == 0);
  }
}

TEST_CASE("a note whose breath has ended dies away, lips that let go add nothing") {
  for (const char* preset : {"clarinet", "sax", "oboe", "trumpet", "trombone"}) {
    CAPTURE(preset);
    Instrument instrument = make_instrument(with_player(preset));
    constexpr std::size_t kEnd = 24000, kWindow = 2400;
    Controls in;
    for (std::size_t n = 0; n < 60000; ++n) {
      in.pressure.push_back(n < kEnd ? 3000
                                     : std::max(0.0, 3000.0 - static_cast<double>(n - kEnd)));
      in.reed.push_back(0);
      in.bore.push_back(hertz(60));
    }
    const Recording r = play(instrument, in);
    double before = 1e9;
    for (std::size_t at = kEnd + 4800; at + kWindow <= r.sound.size(); at += kWindow) {
      double loudest = 1e-9;
      for (std::size_t n = at; n < at + kWindow; ++n)
        loudest = std::max(loudest, std::abs(r.sound[n]));
      CAPTURE(at);
      CHECK(loudest < 1.1 * before);
      before = loudest;
    }
  }
}

} // namespace tactus::reed
