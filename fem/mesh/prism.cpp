#include "fem/mesh/prism.hpp"

#include "fem/mesh/cad_solids.hpp"

#include <algorithm>
#include <cmath>
#include <gmsh.h>

namespace tactus::fem {
namespace {

constexpr double kParallel = 1e-6; ///< directions whose angle has a smaller sine are parallel
constexpr double kEqual = 1e-6;    ///< relative difference of lengths, areas, volumes

struct FlatFace {
  int tag;
  Vec3 normal, point;
  double area;
};

/// Normals of a face at 3 x 3 points of its parameters.
std::vector<Vec3> normals_of(int face, Vec3* point) {
  std::vector<double> low, high, at, xyz, normals;
  gmsh::model::getParametrizationBounds(2, face, low, high);
  for (const double u : {.1, .5, .9})
    for (const double v : {.1, .5, .9}) {
      at.push_back(low[0] + u * (high[0] - low[0]));
      at.push_back(low[1] + v * (high[1] - low[1]));
    }
  gmsh::model::getNormal(face, at, normals);
  gmsh::model::getValue(2, face, {at[0], at[1]}, xyz);
  *point = {xyz[0], xyz[1], xyz[2]};
  std::vector<Vec3> out;
  for (std::size_t i = 0; i + 2 < normals.size(); i += 3)
    out.push_back({normals[i], normals[i + 1], normals[i + 2]});
  return out;
}

/// The prism along a direction, if the faces form one.
std::optional<Prism> along(const Vec3& direction, const std::vector<FlatFace>& flat,
                           const std::vector<std::vector<Vec3>>& curved, double volume) {
  std::vector<const FlatFace*> ends;
  for (const FlatFace& f : flat) {
    if (length(cross(f.normal, direction)) < kParallel)
      ends.push_back(&f);
    else if (std::abs(dot(f.normal, direction)) > kParallel)
      return {};
  }
  for (const auto& normals : curved)
    for (const Vec3& n : normals)
      if (!(std::abs(dot(n, direction)) < 1e3 * kParallel))
        return {};
  if (ends.size() < 2)
    return {};
  const auto level = [&](const FlatFace* f) { return dot(f->point, direction); };
  const auto [lowest, highest] =
      std::minmax_element(ends.begin(), ends.end(), [&](const FlatFace* a, const FlatFace* b) {
        return level(a) < level(b);
      });
  const double low = level(*lowest), height = level(*highest) - low;
  Prism prism;
  prism.direction = direction;
  prism.height = height;
  double below = 0, above = 0;
  for (const FlatFace* f : ends) {
    const double share = (level(f) - low) / height;
    if (std::abs(share) < kEqual) {
      prism.base.push_back(f->tag);
      below += f->area;
    } else if (std::abs(share - 1) < kEqual) {
      above += f->area;
    } else {
      return {}; // a stepped body
    }
  }
  const auto equal = [](double a, double b) { return std::abs(a - b) < 10 * kEqual * b; };
  if (!(height > 0) || !equal(below, above) || !equal(volume, below * height))
    return {};
  return prism;
}

} // namespace

std::optional<Prism> find_prism() {
  gmsh::vectorpair volumes, faces;
  gmsh::model::getEntities(volumes, 3);
  if (volumes.size() != 1)
    return {};
  gmsh::model::getBoundary(volumes, faces, true, false);
  std::vector<FlatFace> flat;
  std::vector<std::vector<Vec3>> curved;
  for (const auto& [dimension, tag] : faces) {
    std::string type;
    gmsh::model::getType(2, tag, type);
    Vec3 point;
    auto normals = normals_of(tag, &point);
    if (type == "Plane")
      flat.push_back({tag, normals[4], point, mass_of(2, tag)});
    else
      curved.push_back(std::move(normals));
  }
  std::optional<Prism> best;
  std::vector<Vec3> tried;
  for (const FlatFace& f : flat) {
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Vec3& d) { return length(cross(d, f.normal)) < kParallel; }))
      continue;
    tried.push_back(f.normal);
    auto prism = along(f.normal, flat, curved, mass_of(3, volumes[0].second));
    if (prism && (!best || prism->height < (1 - kEqual) * best->height))
      best = std::move(prism);
  }
  if (!best)
    return {};
  best->volume = volumes[0].second;
  best->solid = mass_of(3, best->volume);
  for (const auto& [dimension, tag] : faces)
    best->skin += mass_of(2, tag);
  Box box;
  gmsh::model::getBoundingBox(3, best->volume, box.low.x, box.low.y, box.low.z, box.high.x,
                              box.high.y, box.high.z);
  best->box = box.size();
  return best;
}

} // namespace tactus::fem
