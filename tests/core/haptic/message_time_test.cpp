#include "core/message_time.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

using namespace tactus;

TEST_CASE(
    "a message's time is that of the clock to half a step of a single float, after days too, and "
    "differences are right where the count begins again") {
  for (const double start_ms : {-5.0, 0.0, 65530.0, 3.6e6, 8.64e7, 1e10})
    for (int k = 0; k < 1000; ++k) {
      const double ms = start_ms + 0.013 * k, later_ms = ms + 0.7;
      const auto sent = static_cast<double>(static_cast<float>(message_time(ms)));
      const auto next = static_cast<double>(static_cast<float>(message_time(later_ms)));
      CHECK(sent >= 0);
      CHECK(sent < 65536);
      const double laps = (ms - sent) / 65536;
      CHECK(std::abs(laps - std::round(laps)) * 65536 < 1.01 / 512);
      CHECK(std::abs(message_time_since(next, sent) - 0.7) < 1.01 / 256);
      CHECK(std::abs(message_time_since(sent, next) + 0.7) < 1.01 / 256);
    }
}
