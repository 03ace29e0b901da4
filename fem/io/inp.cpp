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

/// Reads the file line by line into a mesh. The last line with `*` says what data lines mean.
class InpReader {
public:
  InpReader(const std::string& path, double unit) : path_(path), unit_(unit) {
    mesh_.regions.clear();
  }
  [[nodiscard]] Mesh read() {
    std::ifstream file(path_);
    if (!file)
      throw InputError("cannot read " + path_);
    for (std::string line; std::getline(file, line);) {
      ++line_number_;
      auto cells = split(line, ',');
      if (line.starts_with("**") || (cells.size() == 1 && cells[0].empty()))
        continue;
      if (line.starts_with("*"))
        read_keyword(cells);
      else if (block_ != Block::none)
        read_data(line, cells);
    }
    if (mesh_.elements.empty())
      throw InputError(path_ + " holds no volume element: expected C3D10, C3D15 or C3D20");
    drop_unused_nodes(mesh_);
    return std::move(mesh_);
  }

private:
  enum class Block { none, nodes, elements, set };

  [[nodiscard]] std::string location() const {
    return path_ + " line " + std::to_string(line_number_);
  }
  [[nodiscard]] int node(int id) const {
    const auto at = number_of_.find(id);
    if (at == number_of_.end())
      throw InputError(location() + ": node " + std::to_string(id) + " is not defined");
    return at->second;
  }
  void read_keyword(const std::vector<std::string>& cells) {
    if (!pending_.empty())
      throw InputError(location() + ": element " + std::to_string(pending_[0]) + " ends early");
    const std::string key = lower(cells[0]);
    block_ = Block::none;
    if (key == "*node") {
      block_ = Block::nodes;
    } else if (key == "*element") {
      begin_elements(cells);
    } else if (key == "*nset") {
      block_ = Block::set;
      set_ = option(cells, "nset");
      generate_ = std::any_of(cells.begin(), cells.end(),
                              [](const std::string& c) { return lower(c) == "generate"; });
    }
  }
  void begin_elements(const std::vector<std::string>& cells) {
    const auto known = shape_of(lower(option(cells, "type")));
    if (!known) // surface and line elements carry no volume
      return;
    shape_ = *known;
    block_ = Block::elements;
    const std::string name = option(cells, "elset").empty() ? "body" : option(cells, "elset");
    const auto at = std::find(mesh_.regions.begin(), mesh_.regions.end(), name);
    region_ = static_cast<int>(at - mesh_.regions.begin());
    if (at == mesh_.regions.end())
      mesh_.regions.push_back(name);
  }
  void read_data(const std::string& line, std::vector<std::string>& cells) {
    if (!cells.empty() && cells.back().empty())
      cells.pop_back();
    if (block_ == Block::nodes)
      add_node(line, cells);
    else if (const std::vector<int> ids = integers(cells); block_ == Block::set)
      add_to_set(ids);
    else
      add_to_element(ids);
  }
  void add_node(const std::string& line, const std::vector<std::string>& cells) {
    const auto id = to_integer(cells[0]);
    Vector3 p;
    bool good = id && cells.size() >= 4;
    for (int k = 0; good && k < 3; ++k) {
      const auto value = to_number(cells[static_cast<std::size_t>(k) + 1]);
      good = value.has_value();
      p[k] = unit_ * value.value_or(0);
    }
    if (!good)
      throw InputError(location() + ": " + printable(line, 60) + ", expected number,x,y,z");
    if (!number_of_.try_emplace(*id, static_cast<int>(mesh_.nodes.size())).second)
      throw InputError(location() + ": node " + cells[0] + " is defined twice");
    mesh_.nodes.push_back(p);
  }
  [[nodiscard]] std::vector<int> integers(const std::vector<std::string>& cells) const {
    std::vector<int> ids;
    for (const std::string& cell : cells) {
      const auto id = to_integer(cell);
      if (!id && block_ == Block::set) // a set of sets
        continue;
      if (!id)
        throw InputError(location() + ": " + printable(cell, 60) + " is no number");
      ids.push_back(*id);
    }
    return ids;
  }
  void add_to_set(const std::vector<int>& ids) {
    auto& nodes = mesh_.node_sets[set_];
    const std::size_t before = nodes.size();
    if (generate_ && ids.size() >= 2) {
      const std::int64_t step = ids.size() > 2 ? std::max(1, ids[2]) : 1;
      for (std::int64_t i = ids[0]; i <= ids[1]; i += step)
        nodes.push_back(node(static_cast<int>(i)));
    } else {
      for (const int id : ids)
        nodes.push_back(node(id));
    }
    // A line that names a range is short: without a limit a small file could ask for any amount.
    in_sets_ += nodes.size() - before;
    if (in_sets_ > 1000 + 100 * mesh_.nodes.size())
      throw InputError(
          location() + ": " + std::to_string(in_sets_) + " entries in sets, expected " +
          std::to_string(1000 + 100 * mesh_.nodes.size()) + " at most (a hundred for each node)");
  }
  void add_to_element(const std::vector<int>& ids) {
    pending_.insert(pending_.end(), ids.begin(), ids.end());
    const auto needed = static_cast<std::size_t>(node_count(shape_)) + 1;
    if (pending_.size() > needed)
      throw InputError(location() + ": element " + std::to_string(pending_[0]) + " has more than " +
                       std::to_string(needed - 1) + " nodes");
    if (pending_.size() < needed)
      return;
    std::vector<int> nodes;
    for (std::size_t i = 1; i < pending_.size(); ++i)
      nodes.push_back(node(pending_[i]));
    mesh_.add(shape_, nodes, region_);
    pending_.clear();
  }

  const std::string& path_;
  double unit_; ///< metres a unit of the file
  Mesh mesh_;
  std::map<int, int> number_of_; ///< not hashed: a file chooses its numbers
  int line_number_ = 0;
  Block block_ = Block::none;
  Shape shape_ = Shape::tet10; ///< of *ELEMENT
  int region_ = 0;
  std::vector<int> pending_; ///< an element's numbers may run over several lines
  std::string set_;          ///< of *NSET
  bool generate_ = false;
  std::size_t in_sets_ = 0;
};

} // namespace

Mesh read_inp(const std::string& path, double unit) { return InpReader(path, unit).read(); }

} // namespace tactus::fem
