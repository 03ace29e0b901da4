#pragma once

#include "devices/hid/report_descriptor.hpp"

#include <array>
#include <cstdint>
#include <span>

/// Converts input reports to the deflections of six axes.
namespace tactus::devices::hid {

constexpr std::size_t kAxes = 9; ///< X Y Z Rx Ry Rz Slider Dial Wheel, in the order of their usages

/// The newest known state of the axes and buttons.
struct Knob {
  std::array<double, kAxes> share{}; ///< relative to full deflection, -1..1
  std::uint32_t buttons = 0;
  int battery_percent = -1; ///< -1: not reported
};

/// Decodes the reports of one device.
class Decoder {
public:
  /// For the SpaceMouse family: the length of a report determines its content, since devices
  /// deviate from their descriptors. The full scale is taken from the descriptor if it has one.
  [[nodiscard]] static Decoder space_mouse(const ReportDescriptor& description);
  /// For all other devices, decoded by their description.
  [[nodiscard]] static Decoder described(const ReportDescriptor& description);

  /// True if the report changed the knob's state.
  bool decode(std::span<const std::uint8_t> report) noexcept;
  [[nodiscard]] const Knob& knob() const noexcept { return knob_; }
  /// Bit n: the device has axis n.
  [[nodiscard]] std::uint32_t axes() const noexcept { return axes_; }
  [[nodiscard]] bool has_buttons() const noexcept { return buttons_; }
  /// The largest resolution step of X, Y, Z, relative to full deflection.
  [[nodiscard]] double step() const noexcept { return step_; }

private:
  bool decode_space_mouse(std::span<const std::uint8_t> report) noexcept;
  bool decode_described(std::span<const std::uint8_t> report) noexcept;

  Knob knob_;
  bool space_mouse_ = false, buttons_ = false;
  double full_scale_ = 350, step_ = 1.0 / 350;
  std::uint32_t axes_ = 0;
  std::vector<Field> fields_;
};

} // namespace tactus::devices::hid
