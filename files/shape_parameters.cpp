#include "files/table_arrays.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace tactus::files {
namespace {

using design::DesignParameter;
using design::kMaxControlPoints;
using design::ShapeParameters;

constexpr double kMaxSize_m = 1e4;

} // namespace

void read_shape_parameters(TableArrays& arrays, const NpzFile& file, ShapeParameters& shape) {
  if (const NpzArray* found = file.find("control_points");
      found && !found->shape.empty() && found->shape[0] > kMaxControlPoints)
    return arrays.refuse("array 'control_points' has " + std::to_string(found->shape[0]) +
                         " points: expected at most " + std::to_string(kMaxControlPoints));
  const auto points = arrays.doubles("control_points", {TableArrays::kAny, 3}, true);
  const auto rows = arrays.doubles("parameters", {TableArrays::kAny, 4}, true);
  const auto trust = arrays.doubles("trust", {}, true);
  if (!arrays.ok())
    return;
  if (std::any_of(points.begin(), points.end(), [](double x) { return std::abs(x) > kMaxSize_m; }))
    return arrays.refuse("array 'control_points' reaches beyond 10 km: are its units metres?");
  const std::size_t count = points.size() / 3;
  for (std::size_t c = 0; c < count; ++c)
    shape.control_point_m.push_back({points[3 * c], points[3 * c + 1], points[3 * c + 2]});
  if (rows.empty() || rows.size() / 4 > 3 * count)
    return arrays.refuse("array 'parameters' has " + std::to_string(rows.size() / 4) +
                         " rows: expected 1.." + std::to_string(3 * count) +
                         ", at most three for each control point");
  std::vector<bool> taken(3 * count);
  for (std::size_t p = 0; p < rows.size() / 4; ++p) {
    const double* row = rows.data() + 4 * p;
    const std::string named = "array 'parameters' row " + std::to_string(p) + ": ";
    if (!(row[0] >= 0 && row[0] < static_cast<double>(count)) || row[0] != std::floor(row[0]))
      return arrays.refuse(named + "control point " + number_text(row[0]) + ": expected 0.." +
                           std::to_string(count - 1));
    if (row[1] != 0 && row[1] != 1 && row[1] != 2)
      return arrays.refuse(named + "axis " + number_text(row[1]) + ": expected 0, 1 or 2");
    if (!(row[2] <= 0 && row[3] >= 0 && row[2] < row[3] && -row[2] <= kMaxSize_m &&
          row[3] <= kMaxSize_m))
      return arrays.refuse(named + "bounds " + number_text(row[2]) + ".." + number_text(row[3]) +
                           " m: expected displacements low <= 0 <= high");
    const DesignParameter parameter{static_cast<std::size_t>(row[0]), static_cast<int>(row[1]),
                                    row[2], row[3]};
    const std::size_t slot = 3 * parameter.control_point + static_cast<std::size_t>(parameter.axis);
    if (taken[slot])
      return arrays.refuse(named + "control point " + number_text(row[0]) + " has axis " +
                           number_text(row[1]) + " twice");
    taken[slot] = true;
    shape.parameters.push_back(parameter);
  }
  shape.trust_m = trust[0];
  if (!(trust[0] > 0 && trust[0] <= kMaxSize_m))
    arrays.refuse("array 'trust' is " + number_text(trust[0]) + " m: expected more than 0");
}

} // namespace tactus::files
