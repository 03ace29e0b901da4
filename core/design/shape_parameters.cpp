#include "core/design/shape_parameters.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

namespace tactus::design {

void displace(std::span<const DesignParameter> parameters, std::size_t control_point,
              const Vec3& by_m, std::span<double> displacement_m) noexcept {
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (const DesignParameter& parameter = parameters[p]; parameter.control_point == control_point)
      displacement_m[p] = std::clamp(by_m[parameter.axis], parameter.low_m, parameter.high_m);
}

Vec3 displacement_of(std::span<const DesignParameter> parameters, std::size_t control_point,
                     std::span<const double> displacement_m) noexcept {
  Vec3 by_m;
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (const DesignParameter& parameter = parameters[p]; parameter.control_point == control_point)
      by_m[parameter.axis] = displacement_m[p];
  return by_m;
}

std::string control_point_refusal(std::span<const DesignParameter> parameters, std::size_t count,
                                  double number) {
  const std::string named = "control point " + number_text(number);
  if (!(number >= 0 && number < static_cast<double>(count)) || number != std::floor(number))
    return named + ": expected 0.." + std::to_string(count - 1);
  const auto index = static_cast<std::size_t>(number);
  if (std::none_of(parameters.begin(), parameters.end(),
                   [index](const DesignParameter& p) { return p.control_point == index; }))
    return named + " is fixed in this table: expected control point " +
           std::to_string(parameters.front().control_point) + " or another movable one";
  return {};
}

} // namespace tactus::design
