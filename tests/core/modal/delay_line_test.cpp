#include "core/modal/delay_line.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

using tactus::modal::DelayLine;

TEST_CASE("a delay line gives the same bits sample by sample and in blocks of any size") {
  for (const double delay : {0.0, 0.3, 1.0, 1.7, 2.0, 63.2, 64.9, 500.25, 4799.0})
    for (const std::size_t block : {1UL, 5UL, 64UL, 100UL, 4096UL}) {
      CAPTURE(delay);
      CAPTURE(block);
      DelayLine one, other;
      for (DelayLine* line : {&one, &other}) {
        line->prepare(4801);
        line->set(1.5 * delay, false, true);
        line->set(delay, false, false); // a fade first
      }
      std::vector<float> in(12000);
      for (std::size_t n = 0; n < in.size(); ++n)
        in[n] = static_cast<float>(std::sin(0.3 * static_cast<double>(n)) +
                                   std::sin(1e-4 * static_cast<double>(n * n)));
      std::vector<float> single = in, cut = in;
      for (float& x : single)
        x = one.step(x);
      for (std::size_t n = 0; n < cut.size(); n += block)
        other.run(cut.data() + n, std::min(block, cut.size() - n));
      CHECK(single == cut);
    }
}

TEST_CASE("a delayed tone is the tone at that earlier time, within the cubic's error") {
  constexpr double kTurn = 2 * std::numbers::pi / 40; // a 40th of the sample rate
  for (const double delay : {1.0, 7.25, 100.5, 1000.9}) {
    DelayLine line;
    line.prepare(2000);
    line.set(delay, false, true);
    std::vector<float> sound(4000);
    for (std::size_t n = 0; n < sound.size(); ++n)
      sound[n] = static_cast<float>(std::sin(kTurn * static_cast<double>(n)));
    line.run(sound.data(), sound.size());
    // Lagrange's remainder of the cubic: at most 9/16 h^4/24 of the fourth derivative.
    const double error = 9.0 / 16 / 24 * std::pow(kTurn, 4) + 1e-6;
    for (std::size_t n = 1010; n < sound.size(); ++n)
      CHECK(std::abs(static_cast<double>(sound[n]) -
                     std::sin(kTurn * (static_cast<double>(n) - delay))) < error);
  }
}
