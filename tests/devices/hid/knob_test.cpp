#include "devices/hid/knob.hpp"

#include <doctest/doctest.h>

#include <array>

using namespace tactus::devices::hid;

namespace {
using Bytes = std::vector<std::uint8_t>;
} // namespace

TEST_CASE("a SpaceMouse's reports bring three axes each in seven bytes, or all six in thirteen") {
  Decoder decoder = Decoder::space_mouse({});
  CHECK(decoder.axes() == 0x3fu);
  CHECK(decoder.has_buttons());
  const auto are = [&](std::array<int, 6> expected) {
    for (std::size_t axis = 0; axis < 6; ++axis)
      CHECK(decoder.knob().share[axis] * 350 == doctest::Approx(expected[axis]).epsilon(1e-12));
  };
  CHECK(decoder.decode(
      Bytes{0x01, 0x0a, 0x00, 0xec, 0xff, 0x1e, 0x00, 0xd8, 0xff, 0x32, 0x00, 0xc4, 0xff}));
  are({10, -20, 30, -40, 50, -60});
  CHECK(decoder.decode(Bytes{0x01, 0x5e, 0x01, 0xa2, 0xfe, 0x0a, 0x00}));
  are({350, -350, 10, -40, 50, -60});
  CHECK(decoder.decode(Bytes{0x02, 0x01, 0x00, 0xff, 0xff, 0x00, 0x01}));
  are({350, -350, 10, 1, -1, 256});
}

TEST_CASE("buttons, battery, and what is beyond full scale") {
  Decoder decoder = Decoder::space_mouse({});
  CHECK(decoder.decode(Bytes{0x03, 0x02, 0x01, 0x00, 0x80}));
  CHECK(decoder.knob().buttons == 0x80000102u);
  CHECK(decoder.decode(Bytes{0x03, 0x00}));
  CHECK(decoder.knob().buttons == 0);
  CHECK(decoder.knob().battery_percent == -1);
  CHECK(decoder.decode(Bytes{0x17, 0x2a, 0x00}));
  CHECK(decoder.knob().battery_percent == 42);
  CHECK(decoder.decode(Bytes{0x01, 0xff, 0x7f, 0x00, 0x80, 0x00, 0x00}));
  CHECK(decoder.knob().share[0] == 1);
  CHECK(decoder.knob().share[1] == -1);
  Bytes padded(15), other(40, 1);
  padded[0] = 0x01;
  CHECK(decoder.decode(padded));
  CHECK(decoder.knob().share[0] == 0);
  CHECK_FALSE(decoder.decode(other)); // of another kind, under the same id
  for (const Bytes& report : {Bytes{}, Bytes{0x01}, Bytes{0x01, 1, 2, 3, 4, 5}, Bytes{0x02, 0},
                              Bytes{0x03}, Bytes{0x17, 0xff}, Bytes{0x99, 1, 2, 3, 4, 5, 6}})
    CHECK_FALSE(decoder.decode(report));
}

TEST_CASE("a described device's axes are shares of their range around its middle") {
  const Bytes text{0x05, 0x01, 0x09, 0x05, 0xa1, 0x01, 0x15, 0x00, 0x26, 0xff, 0x00, 0x75, 0x08,
                   0x95, 0x02, 0x09, 0x30, 0x09, 0x36, 0x81, 0x02, 0x05, 0x09, 0x19, 0x01, 0x29,
                   0x03, 0x15, 0x01, 0x25, 0x03, 0x75, 0x08, 0x95, 0x02, 0x81, 0x00, 0xc0};
  Decoder decoder = Decoder::described(parse_report_descriptor(text));
  CHECK(decoder.axes() == 0x41u);
  CHECK(decoder.has_buttons());
  CHECK(decoder.step() == doctest::Approx(2.0 / 255));
  CHECK(decoder.decode(Bytes{0, 255, 3, 1}));
  CHECK(decoder.knob().share[0] == -1);
  CHECK(decoder.knob().share[6] == 1);
  CHECK(decoder.knob().buttons == 5); // two choices at once: buttons 3 and 1
  CHECK(decoder.decode(Bytes{0, 255, 0, 0}));
  CHECK(decoder.knob().buttons == 0);
  const Bytes y{0x05, 0x01, 0x09, 0x05, 0xa1, 0x01, 0x15, 0x00, 0x26, 0xff,
                0x00, 0x75, 0x08, 0x95, 0x01, 0x09, 0x31, 0x81, 0x02, 0xc0}; // Y alone, 8 bits
  Decoder without = Decoder::described(parse_report_descriptor(y));
  CHECK(without.axes() == 0x02u);
  CHECK_FALSE(without.has_buttons());
  CHECK(without.decode(Bytes{255}));
  CHECK(without.knob().share[1] == 1);
  CHECK(without.knob().share[0] == 0);
  // Without report numbers the first byte is the first axis, whatever its value.
  CHECK(decoder.decode(Bytes{9, 255, 2, 0}));
  CHECK(decoder.knob().buttons == 2);
  CHECK(decoder.decode(Bytes{9, 255, 0, 0}));
  CHECK(decoder.knob().buttons == 0);
}

TEST_CASE("a description's full scale is believed from 100 to 2000 counts, else it is 350") {
  for (const auto& [high, scale] :
       {std::pair{99, 350.0}, std::pair{100, 100.0}, std::pair{500, 500.0}, std::pair{2000, 2000.0},
        std::pair{2001, 350.0}, std::pair{0, 350.0}, std::pair{-5, 350.0}}) {
    ReportDescriptor description;
    Field field;
    field.page = kDesktopPage;
    field.usage = static_cast<std::uint16_t>(Usage::kX);
    const int maximum = high; // a copy, which INFO may capture
    field.low = -maximum;
    field.high = maximum;
    description.fields.push_back(field);
    Decoder decoder = Decoder::space_mouse(description);
    REQUIRE(decoder.decode(Bytes{0x01, 0x32, 0x00, 0x00, 0x00, 0x00, 0x00})); // 50 counts
    INFO("maximum " << maximum);
    CHECK(decoder.knob().share[0] == doctest::Approx(50 / scale));
    CHECK(decoder.step() == doctest::Approx(1 / scale));
  }
}
