#pragma once
#include "core/geometry/vec3.hpp"
#include "fem/io/gmsh_elements.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tactus::fem {

/// The contents of an MSH file's sections, before nodes are looked up by their tags.
struct MshSections {
  struct Element {
    std::uint64_t tag;
    const GmshElement* type;
    int entity;        ///< tag of the model entity of the element's dimension
    int physical;      ///< physical group in MSH 2, 0 for none; MSH 4 stores it by entity
    std::size_t first; ///< its node tags are `uses[first .. first + type->nodes)`
  };
  using Group = std::pair<int, int>; ///< dimension and tag

  std::map<Group, std::string> group_names;
  std::map<Group, std::vector<int>> groups_of_entity; ///< physical tags of each entity in MSH 4
  std::vector<std::uint64_t> node_tags;
  std::vector<Vec3> nodes; ///< in the file's unit
  std::vector<Element> elements;
  std::vector<std::uint64_t> uses;
  std::string passed_over; ///< names of the first sections without mesh data
};

/// Reads MSH 2.0 to 2.2 and 4.1, text or binary, in both byte orders (gmsh reference manual, "MSH
/// file format"). Sections without mesh data are skipped. Memory and time are bounded by the number
/// of bytes; damaged files are refused with file, line or byte, section, value and expectation.
[[nodiscard]] MshSections read_msh_sections(const std::string& path, std::string bytes);

} // namespace tactus::fem
