#include "fem/io/msh.hpp"

#include "fem/io/msh_sections.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

namespace tactus::fem {
namespace {

/// Finds nodes by their tags. Tags may be sparse, so they are sorted and not used as indices.
class NodeIndex {
public:
  NodeIndex(const std::string& path, const std::vector<std::uint64_t>& tags) {
    if (tags.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw InputError(path + format(" has %zu nodes, expected 2147483647 at most", tags.size()));
    sorted_.reserve(tags.size());
    for (std::size_t i = 0; i < tags.size(); ++i)
      sorted_.emplace_back(tags[i], static_cast<int>(i));
    if (!std::is_sorted(sorted_.begin(), sorted_.end()))
      std::sort(sorted_.begin(), sorted_.end());
    const auto twice =
        std::adjacent_find(sorted_.begin(), sorted_.end(),
                           [](const auto& a, const auto& b) { return a.first == b.first; });
    if (twice != sorted_.end())
      throw InputError(path + ": node " + std::to_string(twice->first) +
                       " is defined twice, expected once");
  }

  /// -1 if no node has this tag.
  [[nodiscard]] int find(std::uint64_t tag) const noexcept {
    const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(tag, 0));
    return at != sorted_.end() && at->first == tag ? at->second : -1;
  }

private:
  std::vector<std::pair<std::uint64_t, int>> sorted_;
};

/// The node indices of all elements.
std::vector<int> resolve(const std::string& path, const MshSections& file) {
  const NodeIndex index(path, file.node_tags);
  std::vector<int> nodes(file.uses.size());
  for (const auto& e : file.elements)
    for (std::size_t i = 0; i < static_cast<std::size_t>(e.type->nodes); ++i) {
      const int node = index.find(file.uses[e.first + i]);
      if (node < 0)
        throw InputError(path + ": element " + std::to_string(e.tag) + " (" + e.type->name +
                         ") uses node " + std::to_string(file.uses[e.first + i]) +
                         ", expected one that $Nodes defines");
      nodes[e.first + i] = node;
    }
  return nodes;
}

/// For each element, whether an earlier one of the same type and entity has the same nodes and a
/// higher or equal group: MSH 2 writes an element once for each of its groups.
std::vector<bool> repeated(const MshSections& file) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < file.elements.size(); ++i)
    if (file.elements[i].type->dimension == 3)
      order.push_back(i);
  const auto nodes = [&](std::size_t i) {
    const auto* const first = file.uses.data() + file.elements[i].first;
    return std::span(first, static_cast<std::size_t>(file.elements[i].type->nodes));
  };
  const auto compare = [&](std::size_t a, std::size_t b) { // below, equal to or above 0
    const auto& x = file.elements[a];
    const auto& y = file.elements[b];
    if (x.entity != y.entity)
      return x.entity < y.entity ? -1 : 1;
    if (x.type != y.type)
      return x.type < y.type ? -1 : 1;
    const auto p = nodes(a), q = nodes(b);
    const auto [at, other] = std::mismatch(p.begin(), p.end(), q.begin());
    return at == p.end() ? 0 : *at < *other ? -1 : 1;
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const int c = compare(a, b);
    return c != 0 ? c < 0 : file.elements[a].physical > file.elements[b].physical;
  });
  std::vector<bool> result(file.elements.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i)
    result[order[i]] = compare(order[i - 1], order[i]) == 0;
  return result;
}

/// The physical groups of an element.
std::vector<int> groups_of(const MshSections& file, const MshSections::Element& e) {
  if (e.physical != 0)
    return {e.physical};
  const auto at = file.groups_of_entity.find({e.type->dimension, e.entity});
  return at == file.groups_of_entity.end() ? std::vector<int>{} : at->second;
}

std::string group_name(const MshSections& file, int dimension, int tag) {
  const auto at = file.group_names.find({dimension, tag});
  if (at != file.group_names.end() && !at->second.empty())
    return at->second;
  return (dimension == 3 ? "region" : "set") + std::to_string(tag);
}

} // namespace

Mesh read_msh(const std::string& path, double unit,
              const std::function<void(const std::string&)>& notify) {
  const MshSections file = read_msh_sections(path, read_bytes(path));
  if (notify && !file.passed_over.empty())
    notify("ignored in the file: " + file.passed_over);
  const std::vector<int> nodes = resolve(path, file);
  Mesh mesh;
  mesh.regions.clear();
  mesh.nodes.reserve(file.nodes.size());
  for (const Vec3& p : file.nodes)
    mesh.nodes.push_back(unit * p);

  std::vector<std::size_t> solids; // sorted by entity, in the order of the regions
  std::set<int> volumes;
  const std::vector<bool> repeats = repeated(file);
  for (std::size_t i = 0; i < file.elements.size(); ++i) {
    const auto& e = file.elements[i];
    if (e.type->dimension == 3) {
      volumes.insert(e.entity);
      if (!repeats[i])
        solids.push_back(i);
      continue;
    }
    for (const int group : groups_of(file, e)) {
      auto& set = mesh.node_sets[group_name(file, e.type->dimension, group)];
      const auto first = nodes.begin() + static_cast<std::ptrdiff_t>(e.first);
      set.insert(set.end(), first, first + e.type->nodes);
    }
  }
  for (auto& [name, set] : mesh.node_sets) {
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
  }
  for (const auto& [entity, groups] : file.groups_of_entity)
    if (entity.first == 3)
      volumes.insert(entity.second);
  std::stable_sort(solids.begin(), solids.end(), [&](std::size_t a, std::size_t b) {
    return file.elements[a].entity < file.elements[b].entity;
  });
  std::map<std::string, int> region_of;
  for (const std::size_t i : solids) {
    const auto& e = file.elements[i];
    const std::vector<int> groups = groups_of(file, e);
    const std::string name =
        !groups.empty()       ? group_name(file, 3, *std::max_element(groups.begin(), groups.end()))
        : volumes.size() == 1 ? "body"
                              : "volume" + std::to_string(e.entity);
    const auto [at, added] = region_of.try_emplace(name, static_cast<int>(mesh.regions.size()));
    if (added)
      mesh.regions.push_back(name);
    std::array<int, 20> own{};
    const auto count = static_cast<std::size_t>(e.type->nodes);
    for (std::size_t k = 0; k < count; ++k)
      own[k] = nodes[e.first + static_cast<std::size_t>(e.type->from[k])];
    mesh.add(*e.type->shape, std::span(own).first(count), at->second);
  }
  if (mesh.elements.empty())
    throw InputError(path + " holds no volume element: expected tet10, wedge15 or hex20");
  drop_unused_nodes(mesh);
  return mesh;
}

} // namespace tactus::fem
