#include "fem/io/inp.hpp"

#include "fem/io/text.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>

namespace tactus::fem {
namespace {

/// C3D10 and its variants (C3D10M, C3D20R, ...) by their first letters and number.
std::optional<Shape> shape_of(const std::string& type) {
  static constexpr std::pair<const char*, Shape> kTypes[]{{"c3d10", Shape::tet10},
                                                          {"c3d20", Shape::hex20},
                                                          {"c3d15", Shape::wedge15},
                                                          {"c3d4", Shape::tet4},
                                                          {"c3d8", Shape::hex8}};
  for (const auto& [name, shape] : kTypes)
    if (type.starts_with(name))
      return shape;
  return std::nullopt;
}

std::string option(const std::vector<std::string>& cells, const std::string& key) {
  for (const std::string& cell : cells)
    if (lower(cell).starts_with(key + "="))
      return cell.substr(key.size() + 1);
  return "";
}

} // namespace

Mesh read_inp(const std::string& path, double unit) {
  std::ifstream file(path);
  if (!file)
    throw InputError("cannot read " + path);
  Mesh mesh;
  mesh.regions.clear();
  std::map<int, int> number_of; // not hashed: a file chooses its numbers
  enum class Block { none, nodes, elements, set } block = Block::none;
  Shape shape = Shape::tet10;
  std::string set;
  bool generate = false;
  std::size_t in_sets = 0;
  int region = 0, line_number = 0;
  std::vector<int> pending; // an element's numbers may run over several lines
  const auto location = [&] { return path + " line " + std::to_string(line_number); };
  const auto node = [&](int id) {
    const auto at = number_of.find(id);
    if (at == number_of.end())
      throw InputError(location() + ": node " + std::to_string(id) + " is not defined");
    return at->second;
  };
  for (std::string line; std::getline(file, line);) {
    ++line_number;
    auto cells = split(line, ',');
    if (line.starts_with("**") || (cells.size() == 1 && cells[0].empty()))
      continue;
    if (line.starts_with("*")) {
      if (!pending.empty())
        throw InputError(location() + ": element " + std::to_string(pending[0]) + " ends early");
      const std::string key = lower(cells[0]);
      block = Block::none;
      if (key == "*node") {
        block = Block::nodes;
      } else if (key == "*element") {
        const std::string type = option(cells, "type");
        const auto known = shape_of(lower(type));
        if (!known) // surface and line elements carry no volume
          continue;
        shape = *known;
        block = Block::elements;
        const std::string name = option(cells, "elset").empty() ? "body" : option(cells, "elset");
        const auto at = std::find(mesh.regions.begin(), mesh.regions.end(), name);
        region = static_cast<int>(at - mesh.regions.begin());
        if (at == mesh.regions.end())
          mesh.regions.push_back(name);
      } else if (key == "*nset") {
        block = Block::set;
        set = option(cells, "nset");
        generate = std::any_of(cells.begin(), cells.end(),
                               [](const std::string& c) { return lower(c) == "generate"; });
      }
      continue;
    }
    if (block == Block::none)
      continue;
    if (!cells.empty() && cells.back().empty())
      cells.pop_back();
    if (block == Block::nodes) {
      const auto id = to_integer(cells[0]);
      Vector3 p;
      bool good = id && cells.size() >= 4;
      for (int k = 0; good && k < 3; ++k) {
        const auto value = to_number(cells[static_cast<std::size_t>(k) + 1]);
        good = value.has_value();
        p[k] = unit * value.value_or(0);
      }
      if (!good)
        throw InputError(location() + ": " + printable(line, 60) + ", expected number,x,y,z");
      if (!number_of.try_emplace(*id, static_cast<int>(mesh.nodes.size())).second)
        throw InputError(location() + ": node " + cells[0] + " is defined twice");
      mesh.nodes.push_back(p);
      continue;
    }
    std::vector<int> ids;
    for (const std::string& cell : cells) {
      const auto id = to_integer(cell);
      if (!id && block == Block::set) // a set of sets
        continue;
      if (!id)
        throw InputError(location() + ": " + printable(cell, 60) + " is no number");
      ids.push_back(*id);
    }
    if (block == Block::set) {
      auto& nodes = mesh.node_sets[set];
      const std::size_t before = nodes.size();
      if (generate && ids.size() >= 2) {
        const std::int64_t step = ids.size() > 2 ? std::max(1, ids[2]) : 1;
        for (std::int64_t i = ids[0]; i <= ids[1]; i += step)
          nodes.push_back(node(static_cast<int>(i)));
      } else {
        for (const int id : ids)
          nodes.push_back(node(id));
      }
      // A line that names a range is short: without a limit a small file could ask for any amount.
      in_sets += nodes.size() - before;
      if (in_sets > 1000 + 100 * mesh.nodes.size())
        throw InputError(
            location() + ": " + std::to_string(in_sets) + " entries in sets, expected " +
            std::to_string(1000 + 100 * mesh.nodes.size()) + " at most (a hundred for each node)");
      continue;
    }
    pending.insert(pending.end(), ids.begin(), ids.end());
    const auto needed = static_cast<std::size_t>(node_count(shape)) + 1;
    if (pending.size() > needed)
      throw InputError(location() + ": element " + std::to_string(pending[0]) + " has more than " +
                       std::to_string(needed - 1) + " nodes");
    if (pending.size() == needed) {
      std::vector<int> nodes;
      for (std::size_t i = 1; i < pending.size(); ++i)
        nodes.push_back(node(pending[i]));
      mesh.add(shape, nodes, region);
      pending.clear();
    }
  }
  if (mesh.elements.empty())
    throw InputError(path + " holds no volume element: expected C3D10, C3D15 or C3D20");
  drop_unused_nodes(mesh);
  return mesh;
}

} // namespace tactus::fem
