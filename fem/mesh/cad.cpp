#include "fem/mesh/cad.hpp"

#include "fem/io/cad_format.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/gmsh_model.hpp"

#include <gmsh.h>

namespace tactus::fem {
namespace {

/// Fillets the one volume's concave curves; returns those that are left to be graded: none.
std::vector<double> round_off(const gmsh::vectorpair& volumes, const std::vector<double>& concave,
                              double radius) {
  if (volumes.size() != 1)
    throw Refusal("--fillet rounds the edges of one solid, the file holds " +
                  std::to_string(volumes.size()));
  if (concave.empty())
    throw Refusal("--fillet: the body has no concave edge to round");
  std::vector<int> curves;
  curves.reserve(concave.size());
  for (const double curve : concave)
    curves.push_back(static_cast<int>(curve));
  gmsh::model::mesh::clear();
  gmsh::vectorpair rounded;
  try {
    gmsh::model::occ::fillet({volumes[0].second}, curves, {radius}, rounded, true);
  } catch (...) { // what gmsh throws is no exception of the library
    throw Refusal(format("--fillet: a radius of %g of the file's units does not fit the concave "
                         "edges",
                         radius));
  }
  gmsh::model::occ::synchronize();
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", radius / 3);
  return {};
}

} // namespace

Mesh mesh_cad(const std::string& path, const LoadChoice& choice) {
  Session session;
  return session.run(path + " cannot be meshed", [&] {
    gmsh::vectorpair shapes;
    gmsh::model::occ::importShapes(path, shapes, true, cad_format(path)); // never a script
    gmsh::model::occ::synchronize();
    gmsh::vectorpair volumes;
    gmsh::model::getEntities(volumes, 3);
    if (volumes.empty())
      throw Refusal(path + " holds no solid: expected one at least");
    if (volumes.size() > 1) { // touching solids share their faces
      gmsh::vectorpair all;
      std::vector<gmsh::vectorpair> map;
      gmsh::model::occ::fragment({volumes[0]}, {volumes.begin() + 1, volumes.end()}, all, map);
      gmsh::model::occ::synchronize();
      gmsh::model::getEntities(volumes, 3);
    }
    double solid = 0, skin = 0;
    for (const auto& [dimension, tag] : volumes) {
      double mass = 0;
      gmsh::model::occ::getMass(dimension, tag, mass);
      solid += mass;
    }
    gmsh::vectorpair faces;
    gmsh::model::getBoundary(volumes, faces, true, false);
    for (const auto& [dimension, tag] : faces) {
      double mass = 0;
      gmsh::model::occ::getMass(dimension, std::abs(tag), mass);
      skin += mass;
    }
    Box box;
    gmsh::model::getBoundingBox(-1, -1, box.low.x, box.low.y, box.low.z, box.high.x, box.high.y,
                                box.high.z);
    const double unit = choice.unit > 0 ? choice.unit : 1e-3;
    const double h = choice.coarser *
                     (choice.h > 0 ? choice.h / unit : natural_size(box.largest(), solid, skin));
    gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 1);
    gmsh::option::setNumber("Mesh.MinimumElementsPerTwoPi", 12); // curved: 1e-4 of the radius
    set_sizes(h, {});
    std::vector<double> concave;
    if (choice.grade_concave || choice.fillet > 0) {
      gmsh::model::mesh::generate(2);
      concave = concave_curves();
      if (choice.fillet > 0)
        concave = round_off(volumes, concave, choice.fillet / unit);
      if (!concave.empty()) {
        if (choice.say)
          choice.say(std::to_string(concave.size()) + " concave edges, graded");
        gmsh::model::mesh::clear();
        set_sizes(h, concave);
      }
    }
    gmsh::model::mesh::generate(3);
    return make_quadratic(choice.curved, unit);
  });
}

} // namespace tactus::fem
