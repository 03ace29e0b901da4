#include "core/command.hpp"
#include "core/sentence.hpp"
#include "max/shell/block_clock.hpp"
#include "max/shell/output.hpp"
#include "max/shell/signal_inlets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

/// Parts of the Max shell that know no Max.
namespace {

using namespace tactus;
using tactus::max::BlockClock;
using tactus::max::SignalInlets;

constexpr double kBlock_ms = 1e3 * 64 / 48000;

struct TwoInlets {
  static constexpr std::array kInlets{Port{Port::Kind::kSignal, "left", "", ""},
                                      Port{Port::Kind::kControl, "middle", "", ""},
                                      Port{Port::Kind::kSignal, "right", "", ""}};
  static constexpr Declaration declaration{"two~", "", "", "", kInlets, {}, {}};
};

} // namespace

TEST_CASE("blocks follow each other exactly while the scheduler's clock jitters") {
  BlockClock clock;
  double last = clock.next(1000, kBlock_ms);
  CHECK(last == 1000);
  for (int i = 1; i < 10000; ++i) {
    const double jitter_ms = 5 * std::sin(0.37 * i);
    const double now = clock.next(1000 + i * kBlock_ms + jitter_ms, kBlock_ms);
    CHECK(now - last == doctest::Approx(kBlock_ms).epsilon(1e-9));
    last = now;
  }
}

TEST_CASE("blocks jump to the scheduler's time when audio has paused or the clocks have drifted") {
  BlockClock clock;
  static_cast<void>(clock.next(0, kBlock_ms));
  CHECK(clock.next(500, kBlock_ms) == 500);
  double furthest = 0;
  for (int i = 1; i < 200000; ++i) { // sound card faster by 1 in 1000
    const double scheduler = 500 + i * kBlock_ms * 0.999;
    furthest = std::max(furthest, std::abs(clock.next(scheduler, kBlock_ms) - scheduler));
  }
  CHECK(furthest < 25);
  CHECK(furthest > 15); // not at every block
}

TEST_CASE("an inlet without a signal holds the last number, for blocks of any length") {
  SignalInlets inlets(TwoInlets::declaration);
  CHECK(inlets.set(0, 0.25));
  CHECK(inlets.set(2, -3));
  CHECK_FALSE(inlets.set(1, 9)); // a control inlet
  CHECK_FALSE(inlets.set(7, 9));
  std::vector<double> left(2048, 7), middle(2048, 8), right(2048, 9);
  const std::array<double*, 3> from_max{left.data(), middle.data(), right.data()};
  const std::array<short, 3> none{0, 0, 0}, first{1, 1, 0};
  inlets.connect(none);
  CHECK(inlets.samples(from_max, 0)[0][2047] == 0.25);
  CHECK(inlets.samples(from_max, 0)[1][0] == -3);
  inlets.connect(first);
  left[100] = 5;
  CHECK(inlets.samples(from_max, 100)[0][0] == 5);
  CHECK(inlets.samples(from_max, 100)[1][0] == -3);
  CHECK(inlets.set(2, 4));
  CHECK(inlets.samples(from_max, 0)[1][2047] == 4);
}

TEST_CASE(
    "outputs of audio come in their order, or are refused, however often the ring is passed") {
  max::OutputRing ring;
  const std::string text(1000, 'x');
  std::size_t sent = 0, received = 0;
  int refused = 0;
  const auto receive = [&](const max::Output& output) {
    CHECK(output.outlet == received);
    CHECK(output.atoms.at(0).word == std::string_view(text).substr(0, received % 997));
    CHECK(output.atoms.at(1).number == static_cast<double>(received));
    ++received;
  };
  while (sent < 5000) {
    const std::array<Atom, 2> atoms{std::string_view(text).substr(0, sent % 997),
                                    static_cast<double>(sent)};
    if (ring.add(max::Output::Kind::kOutlet, sent, atoms))
      ++sent;
    else {
      ++refused;
      for (int i = 0; i < 50; ++i)
        CHECK(ring.deliver_one(receive));
    }
  }
  while (ring.deliver_one(receive))
    continue;
  CHECK(received == sent);
  CHECK(ring.empty());
  CHECK(refused > 10);
}

TEST_CASE("a sentence that is too long is cut off") {
  Sentence sentence("begin ");
  for (int i = 0; i < 1000; ++i)
    sentence += "word ";
  const std::string_view text = sentence;
  CHECK(text.substr(0, 11) == "begin word ");
  CHECK(text.size() < 500);
}

TEST_CASE("a message may name a file by a word like a path, or where its declaration says so") {
  const Message plain{"surface", "", 0, 9, ""}, load = Message(plain).with_name_behind("*"),
                                                path = Message(plain).with_name_behind("array");
  const auto names = [](const Message& message, std::initializer_list<Atom> words) {
    return names_file(message, {words.begin(), words.size()});
  };
  CHECK(names(plain, {1.5, "snow.txt"}));
  CHECK(names(plain, {"grounds/snow"}));
  CHECK_FALSE(names(plain, {1.5, "snow"}));
  CHECK(names(load, {"plate"}));
  CHECK_FALSE(names(load, {1.5}));
  CHECK(names(path, {"array", "x"}));
  CHECK_FALSE(names(path, {"line", 0.5}));
}
