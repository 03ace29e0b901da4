#include "core/stress/stress_table.hpp"

#include "core/table/table_arrays.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::stress {
namespace {

using table::Json;
using table::NpzArray;
using table::NpzFile;
using table::TableArrays;

constexpr double kMaxSize_m = 1e4;
constexpr float kMaxStress_pa = 1e15F; // a thousand times the stiffest material's modulus

std::string text(double value) {
  std::string digits = std::to_string(value);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.')
    digits.pop_back();
  return digits;
}

void read_description(TableArrays& arrays, StressTable& table) {
  const Json json = arrays.description("stress-table");
  if (!arrays.good())
    return;
  table.name = json.text_or("name", json.text_or("body_name", ""));
  if (const Json* material = json.find("material"))
    table.material =
        material->kind == Json::Kind::kText ? material->text : material->text_or("name", "");
  if (const Json* loads = json.find("loads"))
    table.loads = loads->kind == Json::Kind::kText ? loads->text : loads->text_or("name", "");
  const Json* units = json.find("units");
  if (!units)
    return;
  const auto check = [&](std::string_view quantity, std::string_view expected) {
    if (const std::string unit = units->text_or(quantity, expected); unit != expected)
      arrays.refuse("meta says that " + std::string(quantity) + " is in " + unit + ": expected " +
                    std::string(expected));
  };
  check("stress", "Pa");
  check("length", "m");
}

void read_control_points(TableArrays& arrays, const NpzFile& file, StressTable& table) {
  if (const NpzArray* found = file.find("control_points");
      found && !found->shape.empty() && found->shape[0] > kMaxControlPoints)
    return arrays.refuse("array 'control_points' has " + std::to_string(found->shape[0]) +
                         " points: expected at most " + std::to_string(kMaxControlPoints));
  const auto points = arrays.reals("control_points", {TableArrays::kAny, 3}, true);
  const auto rows = arrays.reals("parameters", {TableArrays::kAny, 4}, true);
  const auto trust = arrays.reals("trust", {}, true);
  if (!arrays.good())
    return;
  if (std::any_of(points.begin(), points.end(), [](double x) { return std::abs(x) > kMaxSize_m; }))
    return arrays.refuse("array 'control_points' reaches beyond 10 km: are its units metres?");
  const std::size_t count = points.size() / 3;
  for (std::size_t c = 0; c < count; ++c)
    table.control_point_m.push_back({points[3 * c], points[3 * c + 1], points[3 * c + 2]});
  if (rows.empty() || rows.size() / 4 > 3 * count)
    return arrays.refuse("array 'parameters' has " + std::to_string(rows.size() / 4) +
                         " rows: expected 1.." + std::to_string(3 * count) +
                         ", three for each control point at most");
  std::vector<bool> taken(3 * count);
  for (std::size_t p = 0; p < rows.size() / 4; ++p) {
    const double* row = rows.data() + 4 * p;
    const std::string named = "array 'parameters' row " + std::to_string(p) + ": ";
    if (!(row[0] >= 0 && row[0] < static_cast<double>(count)) || row[0] != std::floor(row[0]))
      return arrays.refuse(named + "control point " + text(row[0]) + ": expected 0.." +
                           std::to_string(count - 1));
    if (row[1] != 0 && row[1] != 1 && row[1] != 2)
      return arrays.refuse(named + "axis " + text(row[1]) + ": expected 0, 1 or 2");
    if (!(row[2] <= 0 && row[3] >= 0 && row[2] < row[3] && -row[2] <= kMaxSize_m &&
          row[3] <= kMaxSize_m))
      return arrays.refuse(named + "bounds " + text(row[2]) + ".." + text(row[3]) +
                           " m: expected displacements low <= 0 <= high");
    const DesignParameter parameter{static_cast<std::size_t>(row[0]), static_cast<int>(row[1]),
                                    row[2], row[3]};
    const std::size_t slot = 3 * parameter.control_point + static_cast<std::size_t>(parameter.axis);
    if (taken[slot])
      return arrays.refuse(named + "control point " + text(row[0]) + " has axis " + text(row[1]) +
                           " twice");
    taken[slot] = true;
    table.parameters.push_back(parameter);
  }
  table.trust_m = trust[0];
  if (!(trust[0] > 0 && trust[0] <= kMaxSize_m))
    arrays.refuse("array 'trust' is " + text(trust[0]) + " m: expected more than 0");
}

/// One field; the number of elements follows from the first one that is read.
StressField read_field(TableArrays& arrays, const NpzFile& file, std::string_view stress,
                       std::string_view sensitivity, std::size_t elements, std::size_t parameters) {
  StressField field;
  if (const NpzArray* found = file.find(stress);
      found && !found->shape.empty() && elements == TableArrays::kAny &&
      (found->shape[0] > kMaxElements || found->shape[0] > kMaxSensitivities / parameters))
    arrays.refuse("array '" + std::string(stress) + "' has " + std::to_string(found->shape[0]) +
                  " elements for " + std::to_string(parameters) + " parameters: expected at most " +
                  std::to_string(std::min(kMaxElements, kMaxSensitivities / parameters)));
  field.stress = arrays.singles(stress, {elements}, true);
  if (arrays.good() && field.stress.empty())
    arrays.refuse("array '" + std::string(stress) + "' is empty: expected an element or more");
  if (!std::all_of(field.stress.begin(), field.stress.end(),
                   [](float s) { return s >= 0 && s <= kMaxStress_pa; }))
    arrays.refuse("array '" + std::string(stress) + "' has values outside 0..1e+15 Pa");
  field.sensitivity = arrays.singles(sensitivity, {parameters, field.stress.size()}, true);
  return field;
}

void read_surface(TableArrays& arrays, StressTable& table) {
  if (!arrays.has("surface_nodes"))
    return;
  const auto nodes = arrays.reals("surface_nodes", {TableArrays::kAny, 3}, true);
  const std::size_t count = nodes.size() / 3;
  const auto corners = arrays.reals("surface_triangles", {TableArrays::kAny, 3}, true);
  const auto elements = arrays.reals("surface_node_element", {count}, true);
  if (!arrays.good())
    return;
  const auto outside = [](const std::vector<double>& values, std::size_t limit) {
    return std::find_if(values.begin(), values.end(), [limit](double x) {
      return !(x >= 0 && x < static_cast<double>(limit)) || x != std::floor(x);
    });
  };
  if (const auto bad = outside(corners, count); bad != corners.end())
    return arrays.refuse("array 'surface_triangles' has a corner " + text(*bad) + " of " +
                         std::to_string(count) + " nodes");
  if (const auto bad = outside(elements, table.elements()); bad != elements.end())
    return arrays.refuse("array 'surface_node_element' has element " + text(*bad) + " of " +
                         std::to_string(table.elements()));
  for (std::size_t v = 0; v < count; ++v) {
    table.surface_node_m.push_back({nodes[3 * v], nodes[3 * v + 1], nodes[3 * v + 2]});
    table.surface_node_element.push_back(static_cast<std::int32_t>(elements[v]));
  }
  for (std::size_t t = 0; t < corners.size() / 3; ++t)
    table.surface_triangle.push_back({static_cast<std::int32_t>(corners[3 * t]),
                                      static_cast<std::int32_t>(corners[3 * t + 1]),
                                      static_cast<std::int32_t>(corners[3 * t + 2])});
}

bool is_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

} // namespace

std::string read_stress_table(std::span<const std::byte> file, StressTable& table) {
  NpzFile archive;
  if (std::string refusal = archive.open(file); !refusal.empty())
    return refusal;
  TableArrays arrays(archive);
  StressTable read;
  read_description(arrays, read);
  if (arrays.good())
    read_control_points(arrays, archive, read);
  if (arrays.good())
    read.base.von_mises =
        read_field(arrays, archive, "s0", "S", TableArrays::kAny, read.parameters.size());
  if (arrays.good() && (arrays.has("shear0") || arrays.has("S_shear")))
    read.base.max_shear =
        read_field(arrays, archive, "shear0", "S_shear", read.elements(), read.parameters.size());
  read.base.displacement_m.assign(read.parameters.size(), 0);
  if (arrays.good())
    read.weight = arrays.singles("weights", {read.elements()}, false);
  if (!std::all_of(read.weight.begin(), read.weight.end(),
                   [](float w) { return w > 0 && w <= 1e12F; }))
    arrays.refuse("array 'weights' has values outside 0..1e+12 m^3: expected volumes");
  if (arrays.good())
    read_surface(arrays, read);
  if (arrays.good())
    table = std::move(read);
  return arrays.refusal();
}

std::string check_base(const StressTable& table, const StressBase& base) {
  const std::size_t elements = table.elements(), parameters = table.parameters.size();
  const auto fits = [&](const StressField& field, bool needed) {
    return (!needed && field.stress.empty() && field.sensitivity.empty()) ||
           (field.stress.size() == elements && field.sensitivity.size() == elements * parameters);
  };
  if (base.displacement_m.size() != parameters || !fits(base.von_mises, true) ||
      !fits(base.max_shear, table.has_shear()))
    return "the re-solved stress has another size: expected " + std::to_string(elements) +
           " elements and " + std::to_string(parameters) + " parameters";
  for (const StressField* field : {&base.von_mises, &base.max_shear})
    if (!is_finite(field->stress) || !is_finite(field->sensitivity))
      return "the re-solved stress holds numbers that are not finite";
  return {};
}

} // namespace tactus::stress
