#include "core/stress/stress_table.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::stress {
namespace {

bool is_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

} // namespace

std::string check_base(const StressTable& table, const StressBase& base) {
  const std::size_t elements = table.elements(), parameters = table.parameters.size();
  const auto fits = [&](const StressField& field, bool needed) {
    return (!needed && field.stress.empty() && field.sensitivity.empty()) ||
           (field.stress.size() == elements && field.sensitivity.size() == elements * parameters);
  };
  if (base.displacement_m.size() != parameters || !fits(base.von_mises, true) ||
      !fits(base.max_shear, table.has_shear()))
    return "the re-solved stress has the wrong size: expected " + std::to_string(elements) +
           " elements and " + std::to_string(parameters) + " parameters";
  for (const StressField* field : {&base.von_mises, &base.max_shear}) {
    if (!is_finite(field->sensitivity))
      return "the re-solved stress: not a finite number";
    if (!std::all_of(field->stress.begin(), field->stress.end(),
                     [](float s) { return s >= 0 && s <= kMaxStress_pa; }))
      return "the re-solved stress holds values outside 0..1e+15 Pa";
  }
  return {};
}

} // namespace tactus::stress
