#include "core/reed/instrument/presets.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tactus::reed {
namespace {

using namespace test;

/// Moving controls for a second.
struct Controls {
  std::vector<double> pressure, reed, bore;
};

Controls controls(const Parameters& p, std::size_t size) {
  Controls g;
  for (std::size_t n = 0; n < size; ++n) {
    const double t = static_cast<double>(n) / 48000;
    g.pressure.push_back(1500 + 1200 * std::sin(9 * t));
    g.reed.push_back(p.reed_frequency * (1 + 0.2 * std::sin(25 * t)));
    g.bore.push_back(t < 0.3 ? 0 : 180 * std::exp2(std::sin(6 * t)));
  }
  return g;
}

Recording in_blocks(const Parameters& p, const Controls& g, std::size_t block) {
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(48000, block);
  Recording r;
  const std::size_t size = g.pressure.size();
  for (auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
    signal->resize(size);
  for (std::size_t at = 0; at < size; at += block) {
    const std::size_t count = std::min(block, size - at);
    const auto in = [&](const std::vector<double>& x) {
      return std::span<const double>(x).subspan(at, count);
    };
    const auto out = [&](std::vector<double>& x) { return std::span(x).subspan(at, count); };
    instrument.process<double>({in(g.pressure), in(g.reed), in(g.bore)},
                               {out(r.sound), out(r.theta), out(r.bore_pressure), out(r.flow)});
  }
  return r;
}

TEST_CASE("the same bits come out however the stream is cut into blocks") {
  for (const Preset& preset : presets()) {
    Parameters p = preset.parameters;
    p.breath_noise = 0.02;
    p.tune = true;
    const Controls g = controls(p, 24000);
    const Recording whole = in_blocks(p, g, 24000);
    for (const std::size_t block : {1u, 7u, 64u, 1000u, 4096u}) {
      const Recording cut = in_blocks(p, g, block);
      CAPTURE(preset.name);
      CAPTURE(block);
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
  const Controls g = controls(p, 9600);
  const Recording apart = in_blocks(p, g, 9600);
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(48000, 64);
  Controls own = g;
  std::vector<double> flow(9600);
  instrument.process<double>({own.pressure, own.reed, own.bore},
                             {own.bore, own.pressure, own.reed, flow});
  CHECK(own.bore == apart.sound);
  CHECK(own.pressure == apart.theta);
  CHECK(own.reed == apart.bore_pressure);
}

TEST_CASE("single-precision hosts hear the same instrument") {
  const Parameters p = find_preset("clarinet").value();
  Instrument wide, narrow;
  std::vector<float> pressure(9600), zero(9600), sound(9600), theta(9600), bore(9600), flow(9600);
  const std::vector<double> exact = ramp(2000, 0.2, 48000);
  for (std::size_t n = 0; n < exact.size(); ++n)
    pressure[n] = static_cast<float>(exact[n]);
  const std::vector<double> rounded(pressure.begin(), pressure.end());
  for (Instrument* instrument : {&wide, &narrow}) {
    instrument->set(p);
    instrument->prepare(48000, 64);
  }
  const Recording r = play(wide, rounded, 48000);
  narrow.process<float>({pressure, zero, zero}, {sound, theta, bore, flow});
  for (std::size_t n = 0; n < exact.size(); ++n)
    CHECK(static_cast<double>(bore[n]) == doctest::Approx(r.bore_pressure[n]).epsilon(1e-6));
}

TEST_CASE("preparing again with the same rate goes on with the sound") {
  const Parameters p = find_preset("sax").value();
  const std::vector<double> pressure = ramp(2000, 1, 48000);
  Instrument whole, rebuilt;
  for (Instrument* instrument : {&whole, &rebuilt}) {
    instrument->set(p);
    instrument->prepare(48000, 64);
  }
  const Recording expected = play(whole, pressure, 48000);
  const std::span<const double> all(pressure);
  const Recording first = play(rebuilt, all.first(24000), 48000);
  rebuilt.prepare(48000, 1024);
  const Recording second = play(rebuilt, all.last(24000), 48000);
  CHECK(std::equal(first.sound.begin(), first.sound.end(), expected.sound.begin()));
  CHECK(std::equal(second.sound.begin(), second.sound.end(), expected.sound.begin() + 24000));
  rebuilt.prepare(96000, 64); // another rate: anew, and bounded
  const Recording third = play(rebuilt, ramp(2000, 1, 96000), 96000);
  CHECK(rms(part(third, third.bore_pressure, 0.5, 1)) > 1000);
}

TEST_CASE("after a change of rate, however large, a reed plays as a new one") {
  for (const double before : {8000.0, 192000.0})
    for (const double after : {8000.0, 44100.0}) {
      Instrument used, fresh;
      for (Instrument* instrument : {&used, &fresh})
        instrument->set(find_preset("clarinet").value());
      used.prepare(before, 64);
      (void)play(used, ramp(2500, 0.3, before), before);
      if (before == after)
        used.reset();
      used.prepare(after, 64);
      fresh.prepare(after, 64);
      const std::vector<double> pressure = ramp(2500, 0.2, after);
      CHECK(play(used, pressure, after).sound == play(fresh, pressure, after).sound);
    }
}

TEST_CASE("reset brings back the first sample") {
  Parameters p = find_preset("clarinet").value();
  p.breath_noise = 0.1;
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(48000, 64);
  const std::vector<double> pressure = ramp(2500, 0.2, 48000);
  const Recording first = play(instrument, pressure, 48000);
  instrument.reset();
  const Recording second = play(instrument, pressure, 48000);
  CHECK(first.sound == second.sound);
}

TEST_CASE("no number on any inlet, and no absurd value, breaks the sound") {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array bad{nan, infinity, -infinity, 1e300, -1e300, 1e-310, 0.0, -1.0};
  for (const Preset& preset : presets()) {
    Instrument instrument;
    instrument.set(preset.parameters);
    instrument.prepare(48000, 64);
    std::mt19937 random(1);
    std::vector<double> pressure = ramp(2000, 2, 48000), reed(96000), bore(96000);
    for (std::size_t n = 0; n < 48000; ++n) {
      if (random() % 50 == 0)
        pressure[n] = bad[random() % bad.size()];
      if (random() % 50 == 0)
        reed[n] = bad[random() % bad.size()];
      if (random() % 50 == 0)
        bore[n] = bad[random() % bad.size()];
    }
    Recording r;
    for (auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
      signal->resize(96000);
    instrument.process<double>({pressure, reed, bore}, {r.sound, r.theta, r.bore_pressure, r.flow});
    double loudest = 0;
    bool finite = true;
    for (std::size_t n = 0; n < 96000; ++n) {
      finite = finite && std::isfinite(r.sound[n]) && std::isfinite(r.theta[n]) &&
               std::isfinite(r.bore_pressure[n]) && std::isfinite(r.flow[n]);
      loudest = std::max(loudest, std::abs(r.sound[n]));
    }
    CAPTURE(preset.name);
    CHECK(finite);
    CHECK(loudest <= 1);
    // And afterwards it plays as if nothing had been.
    const Recording clean = play(preset.parameters, 2000, 2);
    const double expected = rms(part(clean, clean.bore_pressure, 1.5, 2));
    CHECK(std::abs(rms(part(r, r.bore_pressure, 1.5, 2)) - expected) < 0.05 * expected + 1);
  }
}

TEST_CASE("a frequency that is no number leaves the last good one") {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const char* name : {"clarinet", "trumpet"}) {
    Controls held{ramp(2200, 1, 48000), {}, {}}, broken = held;
    for (std::size_t n = 0; n < 48000; ++n) {
      const bool late = n > 20000;
      const double reed = late ? 400 : 380, bore = late ? 240 : 233;
      held.reed.push_back(reed);
      held.bore.push_back(bore);
      const std::array bad{nan, infinity, -infinity};
      // The first of all is good; so is the first after the change, looked at every 32 samples.
      const bool good = n < 32 || (late && n < 20064);
      broken.reed.push_back(good ? reed : bad[n % 3]);
      broken.bore.push_back(good ? bore : bad[(n / 7) % 3]);
    }
    Parameters p = find_preset(name).value();
    p.tune = true;
    CAPTURE(name);
    CHECK(in_blocks(p, broken, 64).sound == in_blocks(p, held, 64).sound);
    // Zero and below are numbers: they ask for the preset's own again.
    Controls own = held, negative = held;
    own.reed.assign(48000, 0);
    own.bore.assign(48000, 0);
    negative.reed.assign(48000, -3);
    negative.bore.assign(48000, -1e300);
    CHECK(in_blocks(p, own, 64).sound == in_blocks(p, negative, 64).sound);
    CHECK(in_blocks(p, own, 64).sound != in_blocks(p, held, 64).sound);
  }
}

TEST_CASE("a mouth pressure that is no number is the one before it, others are within 50 kPa") {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Parameters p = find_preset("clarinet").value();
  std::mt19937 random(4);
  Controls given, expected;
  for (std::size_t n = 0; n < 9600; ++n) {
    const double good = 1800 + 0.05 * static_cast<double>(n);
    const auto draw = random() % 40;
    // Often at the first sample of a block, where the pressure before is that of the last block.
    const bool none = n > 0 && (draw < 2 || n % 64 == 0 || n % 64 == 1);
    given.pressure.push_back(none ? nan : draw == 2 ? infinity : draw == 3 ? -6e4 : good);
    expected.pressure.push_back(none        ? expected.pressure.back()
                                : draw == 2 ? 50000
                                : draw == 3 ? -50000
                                            : good);
  }
  given.reed = given.bore = expected.reed = expected.bore = std::vector<double>(9600, 0.0);
  CHECK(in_blocks(p, given, 64).sound == in_blocks(p, expected, 64).sound);
  CHECK(in_blocks(p, given, 50).bore_pressure == in_blocks(p, expected, 50).bore_pressure);
}

TEST_CASE("a thousand random instruments with jumping controls stay finite and bounded") {
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
  for (int trial = 0; trial < 1000; ++trial) {
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
    std::array<double, 300> pressure{}, reed{}, bore{}, sound{}, theta{}, inside{}, flow{};
    for (int stretch = 0; stretch < 10; ++stretch) {
      pressure.fill(uniform(-20e3, 50e3));
      reed.fill(between(1, 18000));
      bore.fill(between(5, 5000));
      instrument.process<double>({pressure, reed, bore}, {sound, theta, inside, flow});
      for (std::size_t n = 0; n < sound.size(); ++n) {
        if (!(std::abs(sound[n]) <= 1) || !std::isfinite(theta[n]) || !std::isfinite(inside[n]) ||
            !std::isfinite(flow[n]))
          ++outliers;
        highest = std::max(highest, std::abs(inside[n]));
      }
    }
  }
  CHECK(outliers == 0);
  CAPTURE(highest);
  CHECK(highest < 2e9); // Pa: beyond 1e9 (before decimation) the model starts anew
}

TEST_CASE("a sweep of the bore from 50 to 2000 Hz in half a second is smooth") {
  const Parameters p = find_preset("clarinet").value();
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(48000, 64);
  std::vector<double> pressure = ramp(2200, 1, 48000), reed(48000), bore(48000);
  for (std::size_t n = 0; n < bore.size(); ++n) {
    const double t = std::clamp((static_cast<double>(n) / 48000 - 0.3) / 0.5, 0.0, 1.0);
    bore[n] = 50 * std::pow(40.0, t);
  }
  Recording r;
  for (auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
    signal->resize(48000);
  instrument.process<double>({pressure, reed, bore}, {r.sound, r.theta, r.bore_pressure, r.flow});
  for (std::size_t n = 0; n < 48000; ++n) {
    CHECK_UNARY(std::abs(r.sound[n]) <= 1);
    CHECK_UNARY(std::abs(r.bore_pressure[n]) < 3 * 2200);
  }
}

TEST_CASE("after the breath ends every outlet falls towards nothing, without denormals") {
  for (const Preset& preset : presets()) {
    Instrument instrument;
    instrument.set(preset.parameters);
    instrument.prepare(48000, 64);
    play(instrument, ramp(2000, 1, 48000), 48000);
    const Recording r = play(instrument, std::vector<double>(48000 * 20, 0.0), 48000);
    CAPTURE(preset.name);
    int denormal = 0;
    for (const auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
      for (const double value : *signal)
        denormal += std::fpclassify(value) == FP_SUBNORMAL;
    CHECK(denormal == 0);
    // Of the flow only the jet's own loss is left, u' = -u^2/(2 lambda): it dies as 1/t.
    CHECK(std::abs(r.flow.back()) < 1e-6);
    CHECK(std::abs(r.bore_pressure.back()) < 1e-3);
    CHECK(std::abs(r.sound.back()) < 1e-6);
    CHECK(r.theta.back() == doctest::Approx(preset.parameters.rest_angle));
  }
}

TEST_CASE("ten minutes of silence make no denormals") {
  constexpr double kRate = 8000; // what decays slowly does so in seconds, not in samples
  Instrument instrument;
  instrument.set(find_preset("clarinet").value());
  instrument.prepare(kRate, 64);
  play(instrument, ramp(2000, 1, kRate), kRate);
  for (int minute = 0; minute < 10; ++minute) {
    const Recording r = play(instrument, std::vector<double>(480000, 0.0), kRate);
    int denormal = 0;
    for (const auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
      for (const double value : *signal)
        denormal += std::fpclassify(value) == FP_SUBNORMAL;
    CHECK(denormal == 0);
  }
}

TEST_CASE("breath noise follows its seed and the jet") {
  Parameters p = find_preset("clarinet").value();
  p.breath_noise = 0.05;
  const Recording first = play(p, 800, 1); // below the threshold: only noise sounds
  const Recording again = play(p, 800, 1);
  CHECK(first.sound == again.sound);
  p.seed = 2;
  const Recording other = play(p, 800, 1);
  CHECK(other.sound != first.sound);
  const double level = rms(part(first, first.bore_pressure, 0.5, 1));
  CHECK(std::abs(rms(part(other, other.bore_pressure, 0.5, 1)) / level - 1) < 0.3);
  const double half = rms(part(first, first.bore_pressure, 0.5, 1));
  p.breath_noise = 0.1;
  const Recording twice = play(p, 800, 1);
  CHECK(std::abs(rms(part(twice, twice.bore_pressure, 0.5, 1)) / half / 2 - 1) < 0.3);
  const Recording closed = play(p, 9000, 1); // the reed is closed: no jet, no noise
  CHECK(rms(part(closed, closed.bore_pressure, 0.9, 1)) < 1e-3);
}

TEST_CASE("the type's sign of the rest angle wins") {
  Parameters p;
  p.type = ValveType::kOpen;
  p.rest_angle = -0.02;
  CHECK(clamped(p).rest_angle == 0.02);
  p.type = ValveType::kClosed;
  p.rest_angle = 0.02;
  CHECK(clamped(p).rest_angle == -0.02);
  p.type = ValveType::kSwinging;
  CHECK(clamped(p).rest_angle == 0.02);
  p.mass = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isfinite(clamped(p).mass));
}

TEST_CASE("the presets close, or open, at the pressures of their table") {
  CHECK(closing_pressure(find_preset("clarinet").value()) == doctest::Approx(3943).epsilon(1e-3));
  CHECK(closing_pressure(find_preset("sax").value()) == doctest::Approx(3626).epsilon(1e-3));
  CHECK(closing_pressure(find_preset("oboe").value()) == doctest::Approx(4061).epsilon(1e-3));
  CHECK(presets().size() == 7);
  CHECK_FALSE(find_preset("kazoo"));
}

} // namespace
} // namespace tactus::reed
