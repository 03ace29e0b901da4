#include "core/stress/stress_picture.hpp"

#include "core/haptic/scene/pose.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactus::stress {

namespace {

constexpr double kEdgeOn = 1e-3; // cosine between normal and view below which a face is not seen

/// Assigns consecutive indices to numbers, in the order of their first use.
class Numbering {
public:
  explicit Numbering(std::size_t count) : number_(count, kNone) {}
  /// Index of a number, and whether it is new.
  std::pair<std::size_t, bool> of(std::size_t item) {
    const bool is_new = number_[item] == kNone;
    if (is_new)
      number_[item] = count_++;
    return {number_[item], is_new};
  }

private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> number_;
  std::size_t count_ = 0;
};

} // namespace

StressPicture::StressPicture(const StressTable& table) {
  const auto& nodes = table.surface_node_m;
  const auto at = [&](std::int32_t node) { return nodes[static_cast<std::size_t>(node)]; };
  std::vector<std::pair<double, std::array<std::int32_t, 3>>> visible;
  for (const auto& triangle : table.surface_triangle) {
    const Vec3 a = at(triangle[0]), b = at(triangle[1]), c = at(triangle[2]);
    const Vec3 normal = cross(b - a, c - a);
    if (normal.z > kEdgeOn * norm(normal))
      visible.emplace_back(a.z + b.z + c.z, triangle);
  }
  std::stable_sort(visible.begin(), visible.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Numbering vertex_number(nodes.size()), element_number(table.elements());
  for (const auto& [depth, triangle] : visible) {
    auto& face = faces_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = static_cast<std::size_t>(triangle[k]);
      const auto [vertex, is_new] = vertex_number.of(node);
      face[k] = vertex;
      if (!is_new)
        continue;
      const auto element = static_cast<std::size_t>(table.surface_node_element[node]);
      const auto [index, is_new_element] = element_number.of(element);
      if (is_new_element)
        elements_.push_back(element);
      vertices_.push_back({triangle[k], index});
    }
  }
  double left_m = 0, right_m = 0;
  for (const Vertex& vertex : vertices_) {
    const double x = at(vertex.node).x;
    left_m = &vertex == vertices_.data() ? x : std::min(left_m, x);
    right_m = &vertex == vertices_.data() ? x : std::max(right_m, x);
  }
  width_m_ = right_m - left_m;
  const auto& stress = table.base.von_mises.stress;
  for (const auto& face : faces_) {
    double sum = 0;
    for (const std::size_t vertex : face)
      sum += static_cast<double>(stress[elements_[vertices_[vertex].element]]);
    stress_scale_pa_ = std::max(stress_scale_pa_, sum / 3);
  }
}

std::shared_ptr<const Picture> StressPicture::draw(const StressModel& model,
                                                   std::span<const double> displacement_m) const {
  const StressTable& table = model.table();
  std::vector<double> stress_pa(elements_.size());
  model.stress_of(elements_, displacement_m, stress_pa);
  std::vector<Vec3> position_m;
  position_m.reserve(vertices_.size());
  const auto& weights = table.surface_weight;
  const std::size_t points = table.control_point_m.size();
  for (const Vertex& vertex : vertices_) {
    const auto node = static_cast<std::size_t>(vertex.node);
    Vec3 position = table.surface_node_m[node];
    for (std::size_t p = 0; !weights.empty() && p < table.parameters.size(); ++p) {
      const DesignParameter& parameter = table.parameters[p];
      if (std::isfinite(displacement_m[p]))
        position[parameter.axis] +=
            static_cast<double>(weights[node * points + parameter.control_point]) *
            displacement_m[p];
    }
    position_m.push_back(position);
  }
  Picture picture;
  picture.stress_scale_pa = stress_scale_pa_;
  picture.width_m = width_m_;
  picture.faces.reserve(faces_.size());
  for (const auto& corners : faces_) {
    PictureFace& face = picture.faces.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      face.stress_pa += stress_pa[vertices_[corners[k]].element] / 3;
      face.corner_m[2 * k] = position_m[corners[k]].x;
      face.corner_m[2 * k + 1] = position_m[corners[k]].y;
    }
  }
  return std::make_shared<const Picture>(std::move(picture));
}

} // namespace tactus::stress
