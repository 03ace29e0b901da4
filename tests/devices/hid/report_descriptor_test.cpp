#include "devices/hid/report_descriptor.hpp"

#include "core/dsp/random.hpp"

#include <doctest/doctest.h>

#include <utility>
#include <vector>

using namespace tactus::devices::hid;

namespace {

using Bytes = std::vector<std::uint8_t>;

// Two axes of 12 bits in report 5, four buttons, and a choice of one of eight further buttons.
const Bytes kStick{0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x85, 0x05, // joystick, report 5
                   0x16, 0x00, 0xf8, 0x26, 0xff, 0x07, 0x75, 0x0c, // -2048..2047, 12 bits
                   0x95, 0x02, 0x09, 0x30, 0x09, 0x31, 0x81, 0x02, // X, Y
                   0xa4,                                           // remember
                   0x05, 0x09, 0x19, 0x01, 0x29, 0x04, 0x15, 0x00, // buttons 1..4
                   0x25, 0x01, 0x75, 0x01, 0x95, 0x04, 0x81, 0x02, //
                   0x19, 0x05, 0x29, 0x0c, 0x15, 0x01, 0x25, 0x08, // one of 5..12, as 1..8
                   0x75, 0x04, 0x95, 0x01, 0x81, 0x00,             //
                   0xb4, // back to 12 bits, the axes' range
                   0x95, 0x01, 0x0b, 0x36, 0x00, 0x01, 0x00, 0x81, 0x02, // slider, long usage
                   0xc0};

const Field* find(const ReportDescriptor& description, std::uint16_t page, std::uint16_t usage) {
  for (const Field& field : description.fields)
    if (field.page == page && field.usage == usage)
      return &field;
  return nullptr;
}

std::int32_t value(const Bytes& report, const Field* field) {
  std::int32_t number = -999999;
  REQUIRE(field);
  CHECK(extract(report, *field, number));
  return number;
}

} // namespace

TEST_CASE("axes and buttons are found where the description puts them") {
  const ReportDescriptor d = parse_report_descriptor(kStick);
  CHECK(d.complete);
  CHECK(d.numbered);
  CHECK(d.page == kDesktopPage);
  CHECK(d.usage == static_cast<std::uint16_t>(Usage::kJoystick));
  REQUIRE(d.fields.size() == 8); // two axes, four buttons, a choice, a slider
  // id, X = -2048 (0x800), Y = 5 (0x005), buttons 0b1010, choice 3, slider 2047 (0x7ff)
  const Bytes report{0x05, 0x00, 0x58, 0x00, 0x3a, 0xff, 0x07};
  CHECK(value(report, find(d, 1, 0x30)) == -2048);
  CHECK(value(report, find(d, 1, 0x31)) == 5);
  CHECK(value(report, find(d, 9, 1)) == 0);
  CHECK(value(report, find(d, 9, 2)) == 1);
  CHECK(value(report, find(d, 9, 4)) == 1);
  CHECK(value(report, find(d, 9, 5)) == 3);
  CHECK(value(report, find(d, 1, 0x36)) == 2047);
}

TEST_CASE("a value beyond the range is its end, or nothing where the field has a null state") {
  // HID 1.11, section 6.2.2.5: bit 6 of Input is the null state.
  for (const auto& [flags, said] : {std::pair{0x02, true}, {0x42, false}}) {
    const Bytes stick{0x05, 0x01, 0x09, 0x04, 0xa1, 0x01,
                      0x15, 0x81, 0x25, 0x7e, 0x75, 0x08,
                      0x95, 0x01, 0x09, 0x30, 0x81, static_cast<std::uint8_t>(flags),
                      0xc0};
    const ReportDescriptor d = parse_report_descriptor(stick); // -127..126
    REQUIRE(d.fields.size() == 1);
    for (const auto& [byte, edge] : {std::pair{0x80, -127}, {0x7f, 126}}) {
      std::int32_t number = 5;
      CHECK(extract(Bytes{static_cast<std::uint8_t>(byte)}, d.fields[0], number) == said);
      CHECK(number == (said ? edge : 5));
    }
  }
}

TEST_CASE("another report, a short one and a choice out of range say nothing") {
  const ReportDescriptor d = parse_report_descriptor(kStick);
  const Field* x = find(d, 1, 0x30);
  const Field* choice = find(d, 9, 5);
  REQUIRE(x);
  REQUIRE(choice);
  std::int32_t number = 0;
  CHECK_FALSE(extract(Bytes{0x06, 0, 0, 0, 0, 0, 0}, *x, number));
  CHECK_FALSE(extract(Bytes{0x05, 0}, *x, number));
  CHECK_FALSE(extract(Bytes{}, *x, number));
  CHECK_FALSE(extract(Bytes{0x05, 0, 0, 0, 0x0f, 0, 0}, *choice, number)); // 0: none is down
}

TEST_CASE("an unsigned maximum that was written as a negative number is understood") {
  const Bytes pad{0x05, 0x01, 0x09, 0x05, 0xa1, 0x01, 0x15, 0x00, 0x25, 0xff,
                  0x75, 0x08, 0x95, 0x01, 0x09, 0x30, 0x81, 0x02, 0xc0};
  const ReportDescriptor d = parse_report_descriptor(pad);
  REQUIRE(d.fields.size() == 1);
  CHECK_FALSE(d.numbered);
  CHECK(d.fields[0].high == 255);
  CHECK(value({200}, d.fields.data()) == 200);
}

TEST_CASE("a field is relative when its description says so, and constant ones are filling") {
  // HID 1.11, section 6.2.2.5: bit 0 constant, bit 1 variable, bit 2 relative.
  for (const int flags : {0x02, 0x06}) {
    const Bytes one{
        0x05, 0x01, 0x09, 0x08, 0xa1, 0x01, 0x15, 0x81, 0x25, 0x7f,
        0x75, 0x08, 0x95, 0x01, 0x81, 0x03, 0x09, 0x30, 0x81, static_cast<std::uint8_t>(flags),
        0xc0};
    const ReportDescriptor d = parse_report_descriptor(one);
    REQUIRE(d.fields.size() == 1);
    CHECK(d.fields[0].relative == (flags == 0x06));
    CHECK(d.fields[0].bit == 8); // after the filling
    CHECK(d.fields[0].low == -127);
    CHECK(d.fields[0].high == 127);
    CHECK_FALSE(d.fields[0].choice);
  }
}

TEST_CASE("designators and strings of a field are no usages, and a range ends where it says") {
  // Local items 3 to 9 (section 6.2.2.8) between and before the usages.
  const Bytes stick{0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x15, 0x00, 0x25, 0x7f, 0x75,
                    0x08, 0x95, 0x02, 0x39, 0x32, 0x49, 0x01, 0x59, 0x31, 0x09, 0x30,
                    0x79, 0x33, 0x89, 0x01, 0x99, 0x35, 0x09, 0x31, 0x81, 0x02, 0x95,
                    0x04, 0x19, 0x33, 0x29, 0x35, 0x81, 0x02,       // three usages for four fields
                    0x95, 0x01, 0x19, 0x35, 0x29, 0x34, 0x81, 0x02, // a range that goes backwards
                    0xc0};
  const ReportDescriptor d = parse_report_descriptor(stick);
  CHECK(d.complete);
  std::vector<int> usages;
  for (const Field& field : d.fields)
    usages.push_back(field.usage);
  // Where usages run out the last one is every further field's (section 6.2.2.8).
  CHECK(usages == std::vector<int>{0x30, 0x31, 0x33, 0x34, 0x35, 0x35});
  for (std::size_t i = 0; i < d.fields.size(); ++i)
    CHECK(d.fields[i].bit == 8 * i);
}

TEST_CASE("descriptions that are cut short or absurd end the reading and keep what came before") {
  for (std::size_t length = 0; length < kStick.size(); ++length) {
    const ReportDescriptor d =
        parse_report_descriptor(std::span<const std::uint8_t>(kStick).first(length));
    CHECK(d.fields.size() <= 8);
  }
  Bytes endless{0x05, 0x01, 0x09, 0x30, 0x15, 0x00, 0x25, 0x01, 0x75, 0x20};
  endless.insert(endless.end(), {0x97, 0xff, 0xff, 0xff, 0xff, 0x81, 0x02}); // 4e9 fields
  CHECK_FALSE(parse_report_descriptor(endless).complete);
  CHECK(parse_report_descriptor(endless).fields.empty());
  CHECK_FALSE(parse_report_descriptor(Bytes(1000, 0xa4)).complete); // a thousand pushes
  CHECK_FALSE(parse_report_descriptor(Bytes{0xb4}).complete);       // a pop of nothing
  CHECK_FALSE(parse_report_descriptor(Bytes{0x85, 0x00}).complete); // report 0
  CHECK_FALSE(parse_report_descriptor(Bytes{0xfe, 0x50}).complete); // a long item cut short
  CHECK(parse_report_descriptor(Bytes{0xfe, 0x01, 0x00, 0x55}).complete);
}

TEST_CASE("broken descriptions of real form are only ever data") {
  tactus::Random random(21);
  for (int round = 0; round < 5000; ++round) {
    Bytes mutant = kStick;
    for (std::uint64_t i = 0; i < 1 + random.next() % 6; ++i)
      mutant[random.next() % mutant.size()] = static_cast<std::uint8_t>(random.next());
    const ReportDescriptor d = parse_report_descriptor(mutant);
    CHECK(d.fields.size() <= 256);
    Bytes report(random.next() % 17);
    for (auto& byte : report)
      byte = static_cast<std::uint8_t>(random.next());
    for (const Field& field : d.fields) {
      std::int32_t number = field.low;
      if (extract(report, field, number) && (number < field.low || number > field.high))
        FAIL("out of range");
    }
  }
}
