#include "core/dsp/complex.hpp"
#include "core/footstep/drive.hpp"
#include "core/footstep/room.hpp"
#include "core/footstep/sole_sensor.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

using namespace tactus::footstep;

namespace {

/// Spectrum of the filter's impulse response at f.
tactus::Complex response(const std::vector<double>& impulse, double f, double rate) {
  const tactus::Complex turn = tactus::math::polar(1.0, -2 * std::numbers::pi * f / rate);
  tactus::Complex sum = 0;
  for (std::size_t n = impulse.size(); n-- > 0;) // Horner's rule
    sum = sum * turn + impulse[n];
  return sum;
}

std::vector<double> impulse_of_band(double rate) {
  HapticBand band;
  band.prepare(rate);
  std::vector<double> impulse(static_cast<std::size_t>(rate));
  for (std::size_t n = 0; n < impulse.size(); ++n)
    impulse[n] = band.next(HeelBall{n == 0 ? 1.0 : 0.0, 0})[0];
  return impulse;
}

double db(double ratio) { return 20 * std::log10(ratio); }

} // namespace

TEST_CASE("the drive's band is 50 to 500 Hz within 5 %, 40 dB down at 12 Hz and 2 kHz, and quick") {
  for (const double rate : {22050.0, 44100.0, 48000.0, 96000.0, 192000.0}) {
    const auto impulse = impulse_of_band(rate);
    const auto level = [&](double f) { return db(abs(response(impulse, f, rate))); };
    CHECK(level(0) < -80);
    CHECK(level(50 / 1.05) < -3);
    CHECK(level(50 * 1.05) > -3);
    CHECK(level(500 / 1.05) > -3);
    CHECK(level(500 * 1.05) < -3);
    CHECK(level(12) < -40);
    CHECK(level(2000) < -40);
    for (double f = 60; f < 450; f += 10)
      CHECK(std::abs(level(f)) < 0.5);
    const double turn = arg(response(impulse, 201, rate) / response(impulse, 199, rate));
    CHECK(-turn / (2 * std::numbers::pi * 2) < 0.002);
  }
}

TEST_CASE("of white noise less than -30 dB of the drive's power lies outside 40 to 600 Hz") {
  const auto impulse = impulse_of_band(48000);
  double outside = 0, whole = 0;
  for (double f = 2.5; f < 24000; f += f < 1000 ? 5 : 250) {
    const double power = norm(response(impulse, f, 48000)) * (f < 1000 ? 5 : 250);
    whole += power;
    if (f < 40 || f > 600)
      outside += power;
  }
  CHECK(10 * std::log10(outside / whole) < -30);
}

TEST_CASE("an acceleration of 3 g is never exceeded, for any sensitivity and level") {
  for (const double sensitivity : {0.5, 3.0, 12.0}) {
    ActuatorSignals drive;
    drive.prepare(48000);
    drive.set({50, sensitivity, 3, 0});
    double worst = 0;
    for (int n = 0; n < 96000; ++n) {
      const double x = 100 * std::sin(0.02 * n) * (n % 9000 < 4000 ? 1 : 1e-3);
      const ActuatorSignals::Pair pair = drive.next(x, 0, n % 3, 1);
      worst = std::max({worst, std::abs(pair.heel), std::abs(pair.ball)});
    }
    CHECK(worst * sensitivity <= 3 + 1e-12);
    CHECK(worst * sensitivity > 2.9);
  }
  ActuatorSignals usual; // an actuator of 3 g at full drive is limited to 3 g
  usual.prepare(48000);
  double largest = 0;
  for (int n = 0; n < 9600; ++n)
    largest = std::max(largest, usual.next(100 * std::sin(0.02 * n), 0, 1, 0).heel);
  CHECK(largest <= 1);
  CHECK(largest > 0.99);
}

TEST_CASE("the equaliser passes through its table and refuses an invalid one") {
  const std::array<double, 8> table{60, 6, 120, -3, 250, 4, 450, -8};
  for (const double rate : {22050.0, 48000.0, 192000.0}) {
    ActuatorEqualiser equaliser;
    equaliser.prepare(rate);
    REQUIRE(equaliser.set(table));
    std::vector<double> impulse(static_cast<std::size_t>(rate));
    for (std::size_t n = 0; n < impulse.size(); ++n)
      impulse[n] = equaliser.next(n == 0 ? 1 : 0);
    for (std::size_t i = 0; i < table.size(); i += 2)
      CHECK(std::abs(db(abs(response(impulse, table[i], rate))) - table[i + 1]) < 0.2);
  }
  ActuatorEqualiser equaliser;
  equaliser.prepare(48000);
  CHECK_FALSE(equaliser.set(std::array<double, 4>{100, 3, 90, 3}));
  CHECK_FALSE(equaliser.set(std::array<double, 2>{100, 300}));
  CHECK_FALSE(equaliser.set(std::array<double, 2>{std::nan(""), 3}));
  CHECK(equaliser.set({}));
  // 20 to 2000 Hz, 24 dB up and down, 16 pairs; what is refused changes nothing.
  for (const auto& [f, g] : {std::pair{20., 24.}, {2000., -24.}, {20., 0.}})
    CHECK(equaliser.set(std::array<double, 2>{f, g}));
  REQUIRE(equaliser.set(std::array<double, 2>{100, 24}));
  const auto response_to_one = [&] {
    equaliser.reset();
    std::array<double, 64> drive_output{};
    for (std::size_t n = 0; n < drive_output.size(); ++n)
      drive_output[n] = equaliser.next(n == 0);
    return drive_output;
  };
  const auto before = response_to_one();
  for (const auto& [f, g] : {std::pair{19.9, 3.}, {2001., 3.}, {100., 24.1}, {100., -24.1}})
    CHECK_FALSE(equaliser.set(std::array<double, 2>{f, g}));
  CHECK_FALSE(equaliser.set(std::array<double, 3>{100, 3, 200}));
  CHECK_FALSE(equaliser.set(std::array<double, 4>{100, 3, 100, 3}));
  std::vector<double> many;
  for (int i = 0; i < 17; ++i)
    many.insert(many.end(), {100. + 20 * i, 0.});
  CHECK_FALSE(equaliser.set(many));
  CHECK(response_to_one() == before);
  many.resize(32);
  CHECK(equaliser.set(many));
  CHECK(response_to_one()[0] == doctest::Approx(1));
}

TEST_CASE("settings of a drive are clamped: delays to 0..0.2 s, sensitivity to at least 0.001 g") {
  const auto drive_output = [](const ActuatorSignals::Settings& settings) {
    ActuatorSignals drive;
    drive.prepare(8000);
    drive.set(settings);
    std::vector<double> out;
    for (int n = 0; n < 4000; ++n)
      out.push_back(drive.next(n == 0, 0, 1, 0).heel);
    return out;
  };
  const auto straight = drive_output({1, 3, 3, 0}), late = drive_output({1, 3, 3, 0.01});
  for (std::size_t n = 0; n + 80 < late.size(); ++n) // to match a slower path
    REQUIRE(late[n + 80] == straight[n]);
  CHECK(drive_output({1, 3, 3, -1}) == straight);
  CHECK(drive_output({1, 3, 3, 9}) == drive_output({1, 3, 3, 0.2}));
  CHECK(drive_output({1, 3, 3, 0.19}) != drive_output({1, 3, 3, 0.2}));
  CHECK(drive_output({1, 0, 1e-6, 0}) == drive_output({1, 1e-3, 1e-6, 0}));
  CHECK(drive_output({1, -4, 1e-6, 0}) == drive_output({1, 1e-3, 1e-6, 0}));
  CHECK(drive_output({1, 2e-3, 1e-6, 0}) != drive_output({1, 1e-3, 1e-6, 0}));
  const auto half = drive_output({0.5, 3, 3, 0});
  for (std::size_t n = 0; n < half.size(); n += 7)
    CHECK(half[n] == doctest::Approx(0.5 * straight[n]));
}

TEST_CASE("under the ball alone the drive is what it is under the heel alone, at any rate") {
  for (const double rate : {22050.0, 48000.0, 192000.0}) {
    ActuatorSignals heel, ball;
    double difference = 0, peak_amplitude = 0;
    for (ActuatorSignals* drive : {&heel, &ball}) {
      drive->prepare(rate);
      drive->set({1, 3, 0.3, 0.002}); // a limit of 0.1
    }
    for (int n = 0; n < 0.3 * rate; ++n) { // too loud, then recovering
      const double t = n / rate,
                   x = (t < 0.1 ? 5 : 0.05) * std::sin(2 * std::numbers::pi * 200 * t);
      const ActuatorSignals::Pair a = heel.next(x, 0, 700, 0), b = ball.next(0, x, 0, 700);
      difference =
          std::max({difference, std::abs(a.heel - b.ball), std::abs(a.ball), std::abs(b.heel)});
      peak_amplitude = std::max(peak_amplitude, std::abs(a.heel));
    }
    CHECK(difference == 0);
    CHECK(peak_amplitude == doctest::Approx(0.1));
  }
}

TEST_CASE("a delay that is switched on begins with silence, not with old samples") {
  ActuatorSignals drive;
  drive.prepare(48000);
  const auto play = [&](double delay_s, double amplitude, int samples) {
    drive.set({.gain = 1, .delay_s = delay_s});
    double largest = 0;
    for (int n = 0; n < samples; ++n) {
      const ActuatorSignals::Pair out = drive.next(amplitude * std::sin(0.03 * n), 0, 1, 0);
      largest = std::max(largest, std::abs(out.heel));
    }
    return largest;
  };
  CHECK(play(0.1, 0.5, 24000) > 0.1);
  play(0, 0, 24000); // band and equaliser ring out
  CHECK(play(0.1, 0, 9600) < 1e-6);
  CHECK(play(0.1, 0.5, 4800) < 1e-6);
  CHECK(play(0.1, 0.5, 4800) > 0.1);
}

TEST_CASE("a drive falls silent once band and delay have decayed, and wakes unchanged") {
  ActuatorSignals drive, fresh;
  for (ActuatorSignals* one : {&drive, &fresh}) {
    one->prepare(8000);
    one->set({1, 3, 3, 0.1, 1});
  }
  double last = 1;
  for (int n = 0; n < 8000 * 3; ++n)
    last = drive.next(n == 0, 0, 1, 3).ball;
  CHECK(last == 0); // 2.2 s
  const auto again = [](ActuatorSignals& one) {
    std::vector<double> out;
    for (int n = 0; n < 4000; ++n) { // nobody presses: the last shares stay, 1 to 3
      const ActuatorSignals::Pair pair = one.next(n == 0, 0, 0, 0);
      out.insert(out.end(), {pair.heel, pair.ball});
    }
    return out;
  };
  fresh.next(0, 0, 1, 3);
  const auto a = again(drive), b = again(fresh);
  double difference = 0, size = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    difference = std::max(difference, std::abs(a[n] - b[n]));
    size = std::max(size, std::abs(a[n]));
  }
  CHECK(size > 0);
  CHECK(difference < 1e-12 * size);
  for (std::size_t n = 0; n < a.size(); n += 2)
    CHECK(a[n + 1] == doctest::Approx(3 * a[n]));
}

TEST_CASE("each actuator plays the vibration under it, and a common share of the whole foot's") {
  const auto drives = [](double common, double heel_vibration, double ball_vibration) {
    ActuatorSignals drive;
    drive.prepare(48000);
    drive.set({1, 3, 3, 0, common});
    std::vector<double> heel, ball;
    for (int n = 0; n < 2400; ++n) {
      const double x = std::sin(2 * std::numbers::pi * 150 * n / 48000);
      const ActuatorSignals::Pair pair =
          drive.next(heel_vibration * x, ball_vibration * x, 500, 300);
      heel.push_back(pair.heel);
      ball.push_back(pair.ball);
    }
    return std::pair(heel, ball);
  };
  const auto alone = drives(0, 0.2, 0);
  const std::vector<double>&heel = alone.first, &none = alone.second;
  CHECK(*std::max_element(heel.begin(), heel.end()) > 0.15);
  CHECK(std::all_of(none.begin(), none.end(), [](double x) { return x == 0; }));
  const auto [of_heel, of_ball] = drives(0.4, 0.2, 0.1);
  const auto expected = [&](std::size_t n, double own, double share) {
    return heel[n] / 0.2 * (0.6 * own + 0.4 * share * 0.3);
  };
  double difference = 0;
  for (std::size_t n = 0; n < heel.size(); ++n)
    difference = std::max({difference, std::abs(of_heel[n] - expected(n, 0.2, 0.625)),
                           std::abs(of_ball[n] - expected(n, 0.1, 0.375))});
  CHECK(difference < 1e-12);
}

TEST_CASE("a limiter acts at once and releases within 50 ms") {
  PeakLimit limit;
  limit.prepare(48000);
  CHECK(limit.next(.5, 1) == .5);
  CHECK(limit.next(4, 1) == doctest::Approx(1));
  // The gain fell to 1/4 and rises by 1 - e^(-t/50 ms) of what is missing.
  for (const double passed : {.02, .05}) {
    limit.reset();
    limit.next(4, 1);
    double y = 0;
    for (int n = 0; n < passed * 48000; ++n)
      y = limit.next(.1, 1);
    CHECK(y == doctest::Approx(.1 * (1 - .75 * std::exp(-passed / .05))).epsilon(1e-3));
  }
  CHECK(limit.next(-9, 1) == doctest::Approx(-1));
  limit.reset();
  CHECK(limit.next(1, 1) == 1);
}

TEST_CASE("sensors, rooms and drives respond after a reset as when new") {
  SoleSensor used, fresh;
  Room used_room, fresh_room;
  ActuatorSignals used_drive, fresh_drive;
  for (SoleSensor* sensor : {&used, &fresh})
    sensor->prepare(48000);
  for (Room* room : {&used_room, &fresh_room}) {
    room->prepare(48000);
    room->set({-3, .4, 3000});
  }
  for (ActuatorSignals* drive : {&used_drive, &fresh_drive}) {
    drive->prepare(48000);
    drive->set({1, 3, .3, .01, .2});
    const std::array<double, 4> table{100, 6, 300, -4};
    CHECK(drive->equalise(table));
  }
  const auto force = [](int n) { return 300 + 300 * std::sin(.001 * n); };
  for (int n = 0; n < 20011; ++n) {
    used.next(force(n), 20);
    used_room.next(std::sin(.3 * n));
    used_drive.next(30 * std::sin(.02 * n), 9 * std::cos(.02 * n), 0, 5);
  }
  CHECK_FALSE(used_room.silent());
  used.reset();
  used_room.reset();
  used_drive.reset();
  CHECK(used_room.silent());
  CHECK_FALSE(used.in_stance());
  bool same = true;
  for (int n = 0; n < 20011; ++n) {
    const SoleState a = used.next(force(n), 200), b = fresh.next(force(n), 200);
    same = same && std::abs(a.heel_n - b.heel_n) < 1e-9 && a.heel_landing == b.heel_landing &&
           std::abs(a.heel_slope - b.heel_slope) < 1e-6 && a.toe_off == b.toe_off;
    const double x = n < 4000 ? std::sin(.3 * n) : 0;
    same = same && std::abs(used_room.next(x) - fresh_room.next(x)) < 1e-12;
    const ActuatorSignals::Pair c = used_drive.next(x, -x, 0, 0), d = fresh_drive.next(x, -x, 0, 0);
    same = same && std::abs(c.heel - d.heel) < 1e-12 && std::abs(c.ball - d.ball) < 1e-12;
  }
  CHECK(same);
}
