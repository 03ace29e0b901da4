#include "core/footstep/foot.hpp"
#include "tests/core/footstep/plain_ground.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

// A foot between grounds: shares, fades, rooms, and what of it the drives get. Feet of one seed
// hear the same noise, so that their quotient is what the foot does with it.

using namespace tactus::footstep;
using tactus::test::recipe_of;

namespace {

constexpr double kRate = 48000;
constexpr double kPi = std::numbers::pi;

/// A rustle as long as load comes; `more` begins before any section.
Recipe noise(const std::string& room = "") {
  return recipe_of("radiation 1\n[rustle]\nheel 0\nball 0\nload 1\nvary_frequency 0\n"
                   "vary_decay 0\nvary_level 0\n" +
                   room);
}
Recipe silence(const std::string& room = "") {
  return recipe_of("level 0\n[rustle]\nload 1\n" + room);
}

/// One mode that rings for long after the heel's landing.
Recipe bell() { return recipe_of("radiation 1\n[solid]\nmodes 1\nfrequency 500\nt60 20\n"); }

std::unique_ptr<Foot> new_foot(std::uint64_t seed = 3) {
  auto foot = std::make_unique<Foot>();
  foot->prepare(kRate);
  foot->seed(seed);
  return foot;
}

SoleState loaded() {
  SoleState sole;
  sole.heel_n = 700;
  sole.heel_slope = 3500;
  return sole;
}

SoleState landing() {
  SoleState sole = loaded();
  sole.heel_landing = 0.5;
  return sole;
}

std::vector<Foot::Out> run_foot(Foot& foot, int samples, const SoleState& sole = loaded()) {
  std::vector<Foot::Out> out;
  out.reserve(static_cast<std::size_t>(samples));
  for (int n = 0; n < samples; ++n)
    out.push_back(foot.next(sole));
  return out;
}

/// Largest difference of `a` and `by` times `b`, relative to the loudest of b.
double difference(const std::vector<Foot::Out>& a, const std::vector<Foot::Out>& b, double by,
                  double Foot::Out::*part = &Foot::Out::pressure_pa) {
  double max_difference = 0, size = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    max_difference = std::max(max_difference, std::abs(a[n].*part - by * b[n].*part));
    size = std::max(size, std::abs(b[n].*part));
  }
  CHECK(size > 0);
  return max_difference / size;
}

} // namespace

TEST_CASE("of two grounds each has its share at once, cosine and sine of the mix") {
  const Recipe sound = noise(), none = silence();
  const auto all_a = new_foot(), all_b = new_foot();
  all_a->set_grounds(1, sound, 2, none, 0);
  all_b->set_grounds(1, none, 2, sound, 1);
  const auto a = run_foot(*all_a, 2000), b = run_foot(*all_b, 2000);
  for (const double mix : {-3.0, 0.0, 0.2, 0.5, 0.9, 1.0, 7.0}) {
    CAPTURE(mix);
    const double angle = 0.5 * kPi * std::clamp(mix, 0.0, 1.0);
    const auto first = new_foot(), second = new_foot();
    first->set_grounds(1, sound, 2, none, mix);
    second->set_grounds(1, none, 2, sound, mix);
    const auto x = run_foot(*first, 2000), y = run_foot(*second, 2000);
    for (const auto part : {&Foot::Out::pressure_pa, &Foot::Out::heel_drive}) {
      CHECK(difference(x, a, std::cos(angle), part) < 1e-9);
      CHECK(difference(y, b, std::sin(angle), part) < 1e-9);
    }
  }
  // One ground alone is all there is, whatever the mix.
  const auto alone = new_foot();
  alone->set_grounds(1, sound, 1, sound, 0.5);
  CHECK(difference(run_foot(*alone, 2000), a, 1) == 0);
}

TEST_CASE("a new mix is reached with a time constant of 20 ms") {
  const Recipe sound = noise(), none = silence();
  const auto stays = new_foot(), moves = new_foot();
  for (Foot* foot : {stays.get(), moves.get()}) {
    foot->set_grounds(1, sound, 2, none, 0);
    run_foot(*foot, 500);
  }
  moves->set_mix(1);
  const auto still = run_foot(*stays, 24000), gone = run_foot(*moves, 24000);
  for (const int n : {10, 480, 960, 3000})
    CHECK(gone[static_cast<std::size_t>(n)].pressure_pa /
              still[static_cast<std::size_t>(n)].pressure_pa ==
          doctest::Approx(std::exp(-(n + 1) / (0.02 * kRate))).epsilon(1e-6));
  CHECK(gone.back().pressure_pa == 0); // not a hundred thousandth for ever
  CHECK(gone[12000].pressure_pa == 0); // 11.5 times 20 ms
  moves->set_mix(0);
  run_foot(*stays, 12000);
  run_foot(*moves, 12000);
  CHECK(difference(run_foot(*moves, 500), run_foot(*stays, 500), 1) >
        0); // grounds without a share do not run
}

TEST_CASE(
    "a ground that is left fades in 0.3 s without load, and continues when the foot returns") {
  const Recipe none = silence(), ring = bell();
  const auto stays = new_foot(), leaves = new_foot();
  for (Foot* foot : {stays.get(), leaves.get()}) {
    foot->set_grounds(1, ring, 1, ring, 0);
    foot->next(landing());
    run_foot(*foot, 4800, {});
  }
  leaves->set_grounds(2, none, 2, none, 0);
  const auto still = run_foot(*stays, 9600, {}), left = run_foot(*leaves, 9600, landing());
  for (const int n : {100, 4800, 9599})
    CHECK(left[static_cast<std::size_t>(n)].pressure_pa /
              still[static_cast<std::size_t>(n)].pressure_pa ==
          doctest::Approx(std::exp(-(n + 1) / (0.3 * kRate))).epsilon(1e-6));
  // Met again it is the same ground: it comes back in 20 ms and rings on.
  leaves->set_grounds(1, recipe_of("level 0\n[solid]\n"), 1, ring, 0);
  const auto on = run_foot(*stays, 14400, {}), back = run_foot(*leaves, 14400, {});
  const double share = std::exp(-9600 / (0.3 * kRate));
  for (const int n : {0, 480, 2000})
    CHECK(back[static_cast<std::size_t>(n)].pressure_pa /
              on[static_cast<std::size_t>(n)].pressure_pa ==
          doctest::Approx(1 - (1 - share) * std::exp(-(n + 1) / (0.02 * kRate))).epsilon(1e-6));
  CHECK(back.back().pressure_pa == on.back().pressure_pa);
}

TEST_CASE("four grounds sound at once; a fifth replaces the one left longest ago") {
  const Recipe none = silence(), ring = bell();
  const auto rings_after = [&](std::initializer_list<std::uint64_t> numbers) {
    const auto foot = new_foot();
    for (const std::uint64_t id : numbers) {
      foot->set_grounds(id, id == 1 ? ring : none, id, none, 0);
      foot->next(id == 1 ? landing() : SoleState{});
      run_foot(*foot, 300, {});
    }
    double peak_amplitude = 0;
    for (const Foot::Out& out : run_foot(*foot, 500, {}))
      peak_amplitude = std::max(peak_amplitude, std::abs(out.pressure_pa));
    return peak_amplitude > 0;
  };
  CHECK(rings_after({1, 2, 3, 4}));
  CHECK_FALSE(rings_after({1, 2, 3, 4, 5}));
  CHECK(rings_after({2, 1, 3, 4, 5}));
  CHECK_FALSE(rings_after({2, 1, 3, 4, 5, 6}));
  CHECK(rings_after({2, 3, 1, 4, 5, 6}));
  // Two at a time: neither of them is taken for the other.
  const auto foot = new_foot();
  foot->set_grounds(1, ring, 2, none, 0);
  foot->next(landing());
  foot->set_grounds(3, none, 4, none, 0.5);
  CHECK(std::abs(run_foot(*foot, 50, {}).back().pressure_pa) > 0);
  foot->set_grounds(4, none, 1, ring, 1);
  CHECK(std::abs(run_foot(*foot, 5000, {}).back().pressure_pa) > 0);
}

TEST_CASE("a ground is left without a click, by a fifth ground too, and no mix brings an old sound "
          "back") {
  const Recipe none = silence(), ring = bell();
  const auto foot = new_foot();
  foot->set_grounds(1, ring, 1, ring, 0);
  foot->next(landing());
  const std::vector<Foot::Out> before = run_foot(*foot, 500);
  double last = before.back().pressure_pa, peak = 0, step = 0;
  for (const Foot::Out& out : before)
    peak = std::max(peak, std::abs(out.pressure_pa));
  for (std::uint64_t id = 2; id <= 5; ++id) {
    foot->set_grounds(id, none, id, none, 0);
    for (const Foot::Out& out : run_foot(*foot, 13)) {
      step = std::max(step, std::abs(out.pressure_pa - std::exchange(last, out.pressure_pa)));
    }
  }
  CHECK(step < 2 * kPi * 500 / kRate * peak);
  const auto mixed = new_foot();
  mixed->set_grounds(1, ring, 2, none, 0);
  mixed->next(landing());
  mixed->set_mix(1);
  run_foot(*mixed, 24000);
  mixed->set_mix(0);
  for (const Foot::Out& out : run_foot(*mixed, 4800))
    CHECK(out.pressure_pa == 0);
}

TEST_CASE("a ground that has faded out is removed without a gap in the others") {
  const Recipe none = silence(), rustle = noise();
  const auto foot = new_foot();
  foot->set_grounds(1, none, 1, none, 0);
  run_foot(*foot, 100);
  foot->set_grounds(2, rustle, 2, rustle, 0);
  run_foot(*foot, 4800);
  for (int n = 0; n < 48000 * 5; ++n) // the first is inaudible after 3.5 s
    REQUIRE(foot->next(loaded()).pressure_pa != 0);
}

namespace {

const std::string kChurch = "[room]\nlevel -6\nt60 2\nbright 2000\n",
                  kCloset = "[room]\nlevel -6\nt60 0.1\nbright 8000\n";

/// The sound of a foot between two grounds, of which either may have a room.
std::vector<Foot::Out> in_room(double factor, const Recipe& a, const Recipe& b, double mix) {
  const auto foot = new_foot();
  foot->set_room(factor);
  foot->set_grounds(1, a, 2, b, mix);
  return run_foot(*foot, 6000);
}

/// `wet` is `dry` with what a room of so many times 0.5 (-6 dB) sends back.
void check_reverberation(const std::vector<Foot::Out>& wet, const std::vector<Foot::Out>& dry,
                         const Room::Settings& room, double factor = 1) {
  Room alone;
  alone.prepare(kRate);
  alone.set(room);
  double max_difference = 0, size = 0;
  for (std::size_t n = 0; n < dry.size(); ++n) {
    const double sent_back = factor * alone.next(std::pow(10, -6. / 20) * dry[n].pressure_pa);
    size = std::max(size, std::abs(sent_back));
    max_difference =
        std::max(max_difference, std::abs(wet[n].pressure_pa - dry[n].pressure_pa - sent_back));
    REQUIRE(wet[n].heel_drive == dry[n].heel_drive); // a room is not felt
  }
  CHECK(size > 0);
  CHECK(max_difference < 1e-9 * size);
}

} // namespace

TEST_CASE("a foot's sound is the ground's plus its reverberation at the room's level") {
  const Recipe ground = noise(kCloset), none = silence();
  const auto dry = in_room(0, ground, none, 0);
  for (const double factor : {1., 2.5})
    check_reverberation(in_room(factor, ground, none, 0), dry, {0, 0.1, 8000}, factor);
  CHECK(difference(in_room(-1, ground, none, 0), dry, 1) == 0);
  CHECK(difference(in_room(NAN, ground, none, 0), dry, 1) == 0);
  CHECK(difference(in_room(1, noise(), none, 0), dry, 1) == 0); // a recipe without a room
}

TEST_CASE("between two rooms the times lie between, by ratio; with one room it is that one") {
  const auto check = [](const Recipe& a, const Recipe& b, double mix, double t60, double bright) {
    CAPTURE(mix);
    check_reverberation(in_room(1, a, b, mix), in_room(0, a, b, mix), {0, t60, bright});
  };
  const Recipe church = noise(kChurch), closet = silence(kCloset);
  for (const double mix : {0., 0.25, 0.6})
    check(church, closet, mix, 2 * std::pow(0.05, mix), 2000 * std::pow(4, mix));
  check(church, silence(), 0.4, 2, 2000);
  check(silence(), noise(kCloset), 0.7, 0.1, 8000);
}

TEST_CASE("forces count in newtons, landings by the weight of the body") {
  const Recipe sound = noise();
  const auto run_foot_with = [&](double weight, const SoleState& sole) {
    const auto foot = new_foot();
    foot->set_weight(weight);
    foot->set_grounds(1, sound, 1, sound, 0);
    return run_foot(*foot, 1000, sole);
  };
  SoleState twice = loaded();
  twice.heel_n *= 2;
  twice.heel_slope *= 2;
  const auto usual = run_foot_with(700, loaded());
  CHECK(difference(run_foot_with(2800, loaded()), usual, 0.5) < 1e-12); // energy as its root
  CHECK(difference(run_foot_with(700, twice), usual, 2) < 1e-12);
  // A foot has its weight before and after it stands on a ground.
  const Recipe ring = bell();
  const auto land_with = [&](double before, double after) {
    const auto foot = new_foot();
    foot->set_weight(before);
    foot->set_grounds(1, ring, 1, ring, 0);
    foot->set_weight(after);
    foot->next(landing());
    return run_foot(*foot, 1000, {});
  };
  CHECK(difference(land_with(350, 1000), land_with(1000, 1000), 1) == 0);
  CHECK(difference(land_with(350, 1000), land_with(350, 350), 1) > 0.1);
  for (const double none : {0.0, -5.0})
    for (const auto& out : land_with(700, none))
      REQUIRE(out.pressure_pa == 0);
}

TEST_CASE("shoe and ground can be set in any order, and a reset foot keeps its ground") {
  const Recipe ring = bell(), none = silence();
  const auto sound_of = [&](double before, double after) {
    const auto foot = new_foot();
    foot->set_shoe(before);
    foot->set_grounds(1, ring, 1, ring, 0);
    foot->set_shoe(after);
    foot->next(landing());
    return run_foot(*foot, 1000, {});
  };
  CHECK(difference(sound_of(0.4, 1), sound_of(1, 1), 1) == 0);
  CHECK(difference(sound_of(0.4, 1), sound_of(0.4, 0.4), 1) > 0.01);
  const auto used = new_foot(), fresh = new_foot();
  used->set_grounds(1, ring, 2, none, 0);
  used->next(landing());
  run_foot(*used, 100);
  used->set_mix(0.5); // under way
  run_foot(*used, 10);
  used->reset();
  used->seed(8);
  fresh->seed(8);
  fresh->set_grounds(1, ring, 2, none, 0.5);
  const auto a = run_foot(*used, 1, landing()), b = run_foot(*fresh, 1, landing());
  CHECK(a[0].pressure_pa == b[0].pressure_pa);
  CHECK(difference(run_foot(*used, 2000, {}), run_foot(*fresh, 2000, {}), 1) < 1e-9);
}
