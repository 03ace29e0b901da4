#include "devices/hid/axis_table.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace tactus::devices::hid {
namespace {

constexpr std::array<std::string_view, 6> kTargets{"x", "y", "z", "rx", "ry", "rz"};
constexpr std::array<std::string_view, kAxes> kSources{"X",  "Y",      "Z",    "Rx",   "Ry",
                                                       "Rz", "Slider", "Dial", "Wheel"};
constexpr int kSlider = 6;

template <std::size_t N>
int index_of(const std::array<std::string_view, N>& names, std::string_view name) noexcept {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

double share(const Knob& knob, const AxisTable::Source& source) noexcept {
  return source.axis < 0 ? 0.0 : source.sign * knob.share[static_cast<std::size_t>(source.axis)];
}

} // namespace

AxisTable AxisTable::default_for(std::uint32_t axes, bool early) noexcept {
  AxisTable table;
  if (early) {
    table.rows = {{{0, 1}, {1, 1}, {2, -1}, {3, 1}, {4, 1}, {5, -1}}};
    return table;
  }
  table.rows = {{{0, 1}, {2, -1}, {1, 1}, {3, 1}, {5, -1}, {4, 1}}};
  if (!(axes >> 2 & 1u) && (axes >> kSlider & 1u))
    table.rows[1] = {kSlider, 1};
  return table;
}

std::string AxisTable::read(std::string_view text) {
  AxisTable fresh = *this;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string target, source, more;
    if (!(words >> target))
      continue;
    const int row = index_of(kTargets, target);
    Source read;
    const bool named = static_cast<bool>(words >> source) && !(words >> more);
    if (named && source != "none") {
      read.sign = source.front() == '-' ? -1 : 1;
      read.axis = index_of(kSources, std::string_view(source).substr(read.sign < 0 ? 1 : 0));
    }
    if (row < 0 || !named || (source != "none" && read.axis < 0))
      return "line " + std::to_string(number) + " of the axis table: expected " +
             "x, y, z, rx, ry or rz, then X, Y, Z, Rx, Ry, Rz, Slider, Dial or Wheel (with - to "
             "reverse it) or none";
    fresh.rows[static_cast<std::size_t>(row)] = read;
  }
  *this = fresh;
  return {};
}

Vec3 AxisTable::position(const Knob& knob) const noexcept {
  return {share(knob, rows[0]), share(knob, rows[1]), share(knob, rows[2])};
}

Vec3 AxisTable::rotation(const Knob& knob) const noexcept {
  return {share(knob, rows[3]), share(knob, rows[4]), share(knob, rows[5])};
}

double apply_dead_zone(double share, double dead_zone) noexcept {
  const double size = std::abs(share);
  if (!(size > dead_zone) || !(dead_zone < 1))
    return 0;
  return std::copysign(std::min((size - dead_zone) / (1 - dead_zone), 1.0), share);
}

} // namespace tactus::devices::hid
