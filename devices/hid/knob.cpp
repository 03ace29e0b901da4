#include "devices/hid/knob.hpp"

#include <algorithm>

namespace tactus::devices::hid {
namespace {

constexpr std::uint8_t kTranslation = 1, kRotation = 2, kButtons = 3, kBattery = 0x17;
constexpr std::size_t kThreeAxes = 7, kSixAxes = 13; // bytes, the id included
constexpr std::size_t kMaxPadded = 16;               // bytes, with padding
constexpr double kMinScale = 100, kMaxScale = 2000;  // descriptions with another scale are ignored

double number(std::span<const std::uint8_t> report, std::size_t at) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(report[at] | report[at + 1] << 8));
}

bool is_axis(const Field& field) noexcept { return field.page == kDesktopPage; }

std::size_t axis_of(const Field& field) noexcept {
  return std::size_t{field.usage} - static_cast<std::size_t>(Usage::kX);
}

} // namespace

Decoder Decoder::space_mouse(const ReportDescriptor& description) {
  Decoder decoder;
  decoder.space_mouse_ = decoder.buttons_ = true;
  decoder.axes_ = 0x3f;
  for (const Field& field : description.fields)
    if (is_axis(field) && field.high >= kMinScale && field.high <= kMaxScale)
      decoder.full_scale_ = field.high;
  decoder.step_ = 1 / decoder.full_scale_;
  return decoder;
}

Decoder Decoder::described(const ReportDescriptor& description) {
  Decoder decoder;
  decoder.fields_ = description.fields;
  decoder.step_ = 0;
  for (const Field& field : decoder.fields_) {
    if (!is_axis(field)) {
      decoder.buttons_ = true;
      continue;
    }
    decoder.axes_ |= 1u << axis_of(field);
    if (axis_of(field) < 3)
      decoder.step_ = std::max(
          decoder.step_, 2 / (static_cast<double>(field.high) - static_cast<double>(field.low)));
  }
  return decoder;
}

bool Decoder::decode(std::span<const std::uint8_t> report) noexcept {
  if (report.empty())
    return false;
  return space_mouse_ ? decode_space_mouse(report) : decode_described(report);
}

bool Decoder::decode_space_mouse(std::span<const std::uint8_t> report) noexcept {
  const auto set = [&](std::size_t first, std::size_t count) {
    for (std::size_t axis = 0; axis < count; ++axis)
      knob_.share[first + axis] = std::clamp(number(report, 1 + 2 * axis) / full_scale_, -1.0, 1.0);
    return true;
  };
  switch (report[0]) {
  case kTranslation:
    if (report.size() > kMaxPadded) // another kind of report under that id
      return false;
    if (report.size() >= kSixAxes)
      return set(0, 6);
    return report.size() >= kThreeAxes && set(0, 3);
  case kRotation:
    return report.size() >= kThreeAxes && report.size() < kSixAxes && set(3, 3);
  case kButtons: {
    std::uint32_t down = 0;
    for (std::size_t i = 1; i < std::min<std::size_t>(report.size(), 5); ++i)
      down |= static_cast<std::uint32_t>(report[i]) << 8 * (i - 1);
    knob_.buttons = down;
    return report.size() > 1;
  }
  case kBattery:
    if (report.size() < 2 || report[1] > 100)
      return false;
    knob_.battery_percent = report[1];
    return true;
  default:
    return false;
  }
}

bool Decoder::decode_described(std::span<const std::uint8_t> report) noexcept {
  bool updated = false, has_choices = false;
  std::uint32_t chosen = 0;
  for (const Field& field : fields_) {
    const bool matches = field.report == 0 || field.report == report[0];
    has_choices = has_choices || (field.choice && matches);
    std::int32_t value = 0;
    if (!extract(report, field, value))
      continue;
    updated = true;
    if (is_axis(field)) {
      const double middle = (static_cast<double>(field.low) + field.high) / 2;
      knob_.share[axis_of(field)] =
          (value - middle) / ((static_cast<double>(field.high) - field.low) / 2);
      continue;
    }
    // Buttons count from 1.
    const std::int64_t button =
        field.choice ? std::int64_t{field.usage} + value - field.low : std::int64_t{field.usage};
    if (button < 1 || button > 32)
      continue;
    const std::uint32_t bit = 1u << (button - 1);
    if (field.choice)
      chosen |= bit;
    else
      knob_.buttons = value ? knob_.buttons | bit : knob_.buttons & ~bit;
  }
  if (has_choices)
    knob_.buttons = chosen;
  return updated;
}

} // namespace tactus::devices::hid
