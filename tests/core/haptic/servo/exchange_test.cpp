#include "core/dsp/mailbox.hpp"
#include "core/dsp/ring.hpp"
#include "core/haptic/servo/statistics.hpp"

#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <thread>

using namespace tactus::haptic;
using tactus::Mailbox;
using tactus::Ring;

TEST_CASE("the mailbox gives the newest value once") {
  Mailbox<int> box;
  CHECK_FALSE(box.read());
  box.write(1);
  box.write(2);
  CHECK(box.read());
  CHECK(box.latest() == 2);
  CHECK_FALSE(box.read());
  CHECK(box.latest() == 2);
  box.write(3);
  CHECK(box.read());
  CHECK(box.latest() == 3);
}

TEST_CASE("between two threads the mailbox never tears a value nor goes back") {
  struct Wide {
    std::array<unsigned, 64> all{};
  };
  Mailbox<Wide> box;
  constexpr unsigned kLast = 200000;
  std::thread writer([&box] {
    for (unsigned i = 1; i <= kLast; ++i) {
      Wide wide;
      wide.all.fill(i);
      box.write(wide);
    }
  });
  unsigned previous = 0, torn = 0, backwards = 0;
  while (previous < kLast) {
    if (!box.read())
      continue;
    const Wide& wide = box.latest();
    for (const unsigned value : wide.all)
      torn += value != wide.all[0];
    backwards += wide.all[0] <= previous;
    previous = wide.all[0];
  }
  writer.join();
  CHECK(torn == 0);
  CHECK(backwards == 0);
}

TEST_CASE("a full ring drops and counts, and gives back what it took in order") {
  Ring<int, 4> ring;
  for (int i = 0; i < 7; ++i)
    CHECK(ring.push(i) == (i < 4));
  CHECK(ring.dropped() == 3);
  int value = -1;
  for (int i = 0; i < 4; ++i) {
    REQUIRE(ring.pop(value));
    CHECK(value == i);
  }
  CHECK_FALSE(ring.pop(value));
}

TEST_CASE("quantiles of the histogram are right to its bin") {
  DurationHistogram histogram;
  CHECK(histogram.quantile_s(0.5) == 0.0);
  for (int i = 1; i <= 10000; ++i)
    histogram.add(i * 1e-6);
  CHECK(histogram.count() == 10000);
  CHECK(histogram.mean_s() == tactus::test::approx(5000.5e-6));
  CHECK(histogram.quantile_s(0.5) == tactus::test::approx(5e-3).epsilon(0.026));
  CHECK(histogram.quantile_s(0.99) == tactus::test::approx(9.9e-3).epsilon(0.026));
  CHECK(histogram.quantile_s(1) <= histogram.max_s());
  CHECK(histogram.max_s() == 0.01);
  histogram.add(-1);
  histogram.add(1e300);
  histogram.add(std::nan(""));
  CHECK(histogram.count() == 10002);
}
