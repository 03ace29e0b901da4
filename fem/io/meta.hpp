#pragma once

#include "fem/material/material.hpp"
#include "fem/mesh/mesh.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tactus::fem {

/// SHA-256 (FIPS 180-4), 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::span<const std::byte>);

/// Fragments of the JSON text `meta` of tables: a list of words, a list of numbers (nine digits), a
/// region's material with its constants in SI. files::quoted_json() writes a string.
[[nodiscard]] std::string list(const std::vector<std::string>& words);
[[nodiscard]] std::string list(std::span<const double> values);
[[nodiscard]] std::string json_of(const Material&, const std::string& region);

/// The beginning of the object: format ("modal-table"), program, date if there is one, `units`, the
/// body under `name`, mesh and materials; ends within the list of materials, before its bracket.
struct MetaHead {
  const char *format, *program, *units, *name;
  const std::string &created, &body_name;
};
[[nodiscard]] std::string meta_head(const MetaHead&, const Mesh&, std::span<const Material>);

/// The coordinates of points, x y z, for an array.
[[nodiscard]] std::vector<double> coordinates(std::span<const Vec3> points);

/// SHA-256 of the nodes' coordinates and the elements' nodes.
[[nodiscard]] std::string mesh_hash(const Mesh&);

} // namespace tactus::fem
