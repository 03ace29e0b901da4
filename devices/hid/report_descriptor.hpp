#pragma once

#include <cstdint>
#include <span>
#include <vector>

/// Parses the report descriptor of a HID device, in which it describes its input reports: axes of
/// the generic desktop page and buttons. USB Device Class Definition for Human Interface
/// Devices 1.11, section 6.2.2.
namespace tactus::devices::hid {

constexpr std::uint16_t kDesktopPage = 0x01, kButtonPage = 0x09;
enum class Usage : std::uint16_t {
  kJoystick = 0x04,
  kGamepad = 0x05,
  kMultiAxis = 0x08,
  kX = 0x30,
  kY,
  kZ,
  kRx,
  kRy,
  kRz,
  kSlider,
  kDial,
  kWheel
};

/// A number inside an input report.
struct Field {
  std::uint8_t report = 0; ///< id, 0 when the device's reports have none
  std::uint32_t bit = 0;   ///< from the report's first byte, the id included
  std::uint8_t bits = 0;   ///< 1..32
  std::uint16_t page = 0, usage = 0;
  std::int32_t low = 0, high = 0; ///< logical range
  bool relative = false;
  bool nullable = false; ///< a value outside the range means "no value" (null state)
  bool choice = false;   ///< the value is the number of a pressed button, counted from `low`
};

struct ReportDescriptor {
  std::vector<Field> fields; ///< axes 0x30..0x38 of the desktop page, and buttons
  bool numbered = false;     ///< reports begin with their id
  bool complete = true;      ///< false if truncated; the fields before that are valid
  /// Usage of the first application collection, 0 when there is none.
  std::uint16_t page = 0, usage = 0;
};

/// Accepts any bytes: a truncated, contradictory or absurdly large item ends the reading.
[[nodiscard]] ReportDescriptor parse_report_descriptor(std::span<const std::uint8_t> bytes);

/// Reads the field's value from a report (with its id byte, if numbered). Returns false if the
/// report has another id or is too short. Also false for a value outside the logical range if the
/// field is a choice or has a null state (section 6.2.2.5); for any other field, such a value is
/// limited to the range.
[[nodiscard]] bool extract(std::span<const std::uint8_t> report, const Field& field,
                           std::int32_t& value) noexcept;

} // namespace tactus::devices::hid
