#include "files/tables.hpp"

#include "core/declaration_text.hpp"
#include "files/json.hpp"
#include "files/table_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactus::files {
namespace {

using stress::kMaxElements;
using stress::kMaxSensitivities;
using stress::kMaxStress_pa;
using stress::StressField;
using stress::StressTable;

void read_description(TableArrays& arrays, StressTable& table) {
  const Json json = arrays.description("stress-table");
  if (!arrays.ok())
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
  field.stress = arrays.floats(stress, {elements}, true);
  if (arrays.ok() && field.stress.empty())
    arrays.refuse("array '" + std::string(stress) + "' is empty: expected an element or more");
  if (!std::all_of(field.stress.begin(), field.stress.end(),
                   [](float s) { return s >= 0 && s <= kMaxStress_pa; }))
    arrays.refuse("array '" + std::string(stress) + "' has values outside 0..1e+15 Pa");
  field.sensitivity = arrays.floats(sensitivity, {parameters, field.stress.size()}, true);
  return field;
}

void read_surface(TableArrays& arrays, StressTable& table) {
  if (!arrays.has("surface_nodes"))
    return;
  const auto nodes = arrays.doubles("surface_nodes", {TableArrays::kAny, 3}, true);
  const std::size_t count = nodes.size() / 3;
  const auto corners = arrays.doubles("surface_triangles", {TableArrays::kAny, 3}, true);
  const auto elements = arrays.doubles("surface_node_element", {count}, true);
  const std::size_t points = table.control_point_m.size();
  table.surface_weight = arrays.floats("surface_weights", {count, points}, false);
  if (!arrays.ok())
    return;
  const auto outside = [](const std::vector<double>& values, std::size_t limit) {
    return std::find_if(values.begin(), values.end(), [limit](double x) {
      return !(x >= 0 && x < static_cast<double>(limit)) || x != std::floor(x);
    });
  };
  if (const auto bad = outside(corners, count); bad != corners.end())
    return arrays.refuse("array 'surface_triangles' has a corner " + number_text(*bad) + " of " +
                         std::to_string(count) + " nodes");
  if (const auto bad = outside(elements, table.elements()); bad != elements.end())
    return arrays.refuse("array 'surface_node_element' has element " + number_text(*bad) + " of " +
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

} // namespace

std::string read_stress_table(std::span<const std::byte> file, StressTable& table) {
  NpzFile archive;
  if (std::string refusal = archive.open(file); !refusal.empty())
    return refusal;
  TableArrays arrays(archive);
  StressTable read;
  read_description(arrays, read);
  if (arrays.ok()) {
    design::ShapeParameters shape;
    read_shape_parameters(arrays, archive, shape);
    read.parameters = std::move(shape.parameters);
    read.control_point_m = std::move(shape.control_point_m);
    read.trust_m = shape.trust_m;
  }
  if (arrays.ok())
    read.base.von_mises =
        read_field(arrays, archive, "s0", "S", TableArrays::kAny, read.parameters.size());
  if (arrays.ok() && (arrays.has("shear0") || arrays.has("S_shear")))
    read.base.max_shear =
        read_field(arrays, archive, "shear0", "S_shear", read.elements(), read.parameters.size());
  read.base.displacement_m.assign(read.parameters.size(), 0);
  if (arrays.ok())
    read.weight = arrays.floats("weights", {read.elements()}, false);
  if (!std::all_of(read.weight.begin(), read.weight.end(),
                   [](float w) { return w > 0 && w <= 1e12F; }))
    arrays.refuse("array 'weights' has values outside 0..1e+12 m^3: expected volumes");
  if (arrays.ok())
    read_surface(arrays, read);
  read.has_mesh = arrays.has("mesh");
  if (arrays.ok())
    table = std::move(read);
  return arrays.refusal();
}

} // namespace tactus::files
