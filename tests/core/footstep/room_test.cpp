#include "core/footstep/room.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using tactus::footstep::Room;

namespace {

/// A tone of 20 ms under a raised cosine.
double burst(double t, double frequency_hz) {
  const double x = t / 0.02;
  if (x >= 1)
    return 0;
  return (1 - std::cos(2 * std::numbers::pi * x)) *
         std::sin(2 * std::numbers::pi * frequency_hz * t);
}

struct RoomResponse {
  double level_db, t60_s;
};

/// Energy of the answer over the burst's, and the slope of what is still to come (Schroeder 1965)
/// from 5 to 35 dB down.
RoomResponse room_response(const Room::Settings& settings, double rate, double frequency_hz) {
  Room room;
  room.prepare(rate);
  room.set(settings);
  std::vector<double> energy;
  double direct = 0;
  for (long n = 0; n < static_cast<long>(2 * settings.t60_s * rate); ++n) {
    const double x = burst(static_cast<double>(n) / rate, frequency_hz), y = room.next(x);
    direct += x * x;
    energy.push_back(y * y);
  }
  for (std::size_t n = energy.size() - 1; n-- > 0;)
    energy[n] += energy[n + 1];
  const auto fallen = [&](double db) {
    std::size_t n = 0;
    while (energy[n] > energy[0] * std::pow(10, -db / 10))
      ++n;
    return static_cast<double>(n) / rate;
  };
  return {10 * std::log10(energy[0] / direct), 2 * (fallen(35) - fallen(5))};
}

} // namespace

namespace {

/// A burst of 50 Hz width meets few resonances: the mean over 16 frequencies.
void check_room(double rate, double t60, double bright_hz, double lowest_hz, double expected_s) {
  double level = 0, time = 0;
  for (int i = 0; i < 16; ++i) {
    const RoomResponse a =
        room_response({-6, t60, bright_hz}, rate, lowest_hz + (lowest_hz > 1000 ? 25 : 37) * i);
    level += std::pow(10, a.level_db / 10) / 16;
    time += a.t60_s / 16;
  }
  CAPTURE(rate);
  CAPTURE(t60);
  if (lowest_hz < 1000)
    CHECK(std::abs(10 * std::log10(level) + 6) < 1);
  CHECK(time == doctest::Approx(expected_s).epsilon(0.1));
}

} // namespace

TEST_CASE("a room has the energy of its level and decays in its T60, half of it where bright") {
  for (const double t60 : {0.15, 0.4})
    check_room(22050, t60, 10000, 200, t60);
  check_room(22050, 0.6, 3000, 2800, 0.3);
}
TEST_CASE("rooms have their energy and T60 at any rate" * doctest::test_suite("slow")) {
  for (const double rate : {22050.0, 48000.0, 192000.0})
    for (const double t60 : {0.15, 0.4, 1.5})
      check_room(rate, t60, 10000, 200, t60);
}

TEST_CASE("a room without input falls silent, and one without level never sounds") {
  Room room;
  room.prepare(48000);
  room.set({0, 0.2, 4000});
  room.next(1);
  CHECK(!room.silent());
  double last = 0;
  for (int n = 0; n < 48000; ++n)
    last = room.next(0);
  CHECK(room.silent());
  CHECK(last == 0);
  room.set({});
  CHECK(room.next(1) == 0);
  CHECK(room.silent());
}

TEST_CASE("settings of a room are clamped to their ranges") {
  const auto response_of = [](const Room::Settings& settings) {
    Room room;
    room.prepare(16000);
    room.set(settings);
    std::vector<double> out;
    for (int n = 0; n < 3000; ++n)
      out.push_back(room.next(n == 0));
    return out;
  };
  struct Limit {
    double Room::Settings::*setting;
    double beyond, limit, within;
  };
  using S = Room::Settings;
  for (const Limit& l : {Limit{&S::t60_s, 0.001, 0.02, 0.03}, Limit{&S::t60_s, 99, 10, 9.5},
                         Limit{&S::bright_hz, 5, 100, 120}, Limit{&S::bright_hz, 15000, 7200, 7000},
                         Limit{&S::level_db, 90, 40, 39}}) {
    S beyond{0, 0.5, 3000}, limit = beyond, within = beyond;
    beyond.*l.setting = l.beyond;
    limit.*l.setting = l.limit;
    within.*l.setting = l.within;
    CHECK(response_of(beyond) == response_of(limit));
    CHECK(response_of(within) != response_of(limit));
  }
  double peak_amplitude = 0;
  for (const double x : response_of({-60, 0.5, 3000})) // none from there down
    peak_amplitude = std::max(peak_amplitude, std::abs(x));
  CHECK(peak_amplitude == 0);
  for (const double x : response_of({-59.9, 0.5, 3000}))
    peak_amplitude = std::max(peak_amplitude, std::abs(x));
  CHECK(peak_amplitude > 0);
}

TEST_CASE("no echo arrives before the shortest delay, 7 ms, and each line's echo at its delay") {
  Room room;
  room.prepare(48000);
  room.set({0, 1, 20000});
  std::vector<double> response;
  for (int n = 0; n < 4800; ++n)
    response.push_back(room.next(n == 0));
  std::size_t first = 0;
  while (std::abs(response[first]) < 1e-6)
    ++first;
  CHECK(static_cast<double>(first) / 48000 == doctest::Approx(0.00711).epsilon(0.005));
  // The eight first echoes, each alone; two later lines have the same sign as what fed them.
  for (const double delay : {0.00967, 0.01229, 0.01493, 0.01787, 0.02111, 0.02473, 0.02887}) {
    double peak = 0;
    for (int n = -3; n <= 3; ++n)
      peak = std::max(peak, std::abs(response[static_cast<std::size_t>(delay * 48000 + n)]));
    CHECK(peak > 0.5 * std::abs(response[first]) * std::pow(10, -3 * (delay - 0.00711)));
  }
}

TEST_CASE("a room stays stable and finite for any settings and input") {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const double odd[] = {0, -1, 1e300, -1e300, 1e-300, kInfinite, std::nan("")};
  for (const double value : odd) {
    Room room;
    room.prepare(44100);
    room.set({value, value, value});
    bool finite = true;
    for (int n = 0; n < 5000; ++n)
      finite = finite && std::isfinite(room.next(n % 7 ? 1 : value));
    CHECK(finite);
  }
  // The longest decay, fed with noise for as long: at most what so long a sound adds up to.
  Room room;
  room.prepare(22050);
  room.set({0, 10, 20000});
  double largest = 0;
  for (int n = 0; n < 10 * 22050; ++n)
    largest = std::max(largest, std::abs(room.next(n % 2 ? 1 : -1)));
  CHECK(largest < 100);
}
