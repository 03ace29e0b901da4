#include "fem/mesh/cad.hpp"

#include "fem/io/cad_format.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/cad_solids.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "fem/mesh/surface_file.hpp"
#include "fem/mesh/sweep.hpp"

#include <algorithm>
#include <gmsh.h>
#include <optional>
#include <unordered_map>
#include <utility>

namespace tactus::fem {
namespace {

constexpr double kMaxVolumeChange = .01; ///< of the mesh against the solids

/// Fillets the one volume's concave curves; returns those that are left to be graded: none.
std::vector<double> round_off(const gmsh::vectorpair& volumes, const std::vector<double>& concave,
                              double radius) {
  if (volumes.size() != 1)
    throw InputError("--fillet rounds the edges of one solid, the file holds " +
                     std::to_string(volumes.size()));
  if (concave.empty())
    throw InputError("--fillet: the body has no concave edge to round");
  std::vector<int> curves;
  curves.reserve(concave.size());
  for (const double curve : concave)
    curves.push_back(static_cast<int>(curve));
  gmsh::model::mesh::clear();
  gmsh::vectorpair rounded;
  try {
    gmsh::model::occ::fillet({volumes[0].second}, curves, {radius}, rounded, true);
  } catch (...) { // what gmsh throws is no exception of the library
    throw InputError(format("--fillet: a radius of %g of the file's units does not fit the concave "
                            "edges",
                            radius));
  }
  gmsh::model::occ::synchronize();
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", radius / 3);
  return {};
}

/// Number, kind, middle and area of each of the model's faces, a sentence each.
void report_faces(double unit, const std::function<void(const std::string&)>& notify) {
  gmsh::vectorpair faces;
  gmsh::model::getEntities(faces, 2);
  for (const auto& [dimension, face] : faces) {
    std::string kind;
    gmsh::model::getType(dimension, face, kind);
    std::string text = "face " + std::to_string(face) + ": " + lower(kind);
    std::vector<double> low, high, largest, smallest, a, b;
    gmsh::model::getParametrizationBounds(dimension, face, low, high);
    gmsh::model::getPrincipalCurvatures(face, {.5 * (low[0] + high[0]), .5 * (low[1] + high[1])},
                                        largest, smallest, a, b);
    // A hole's wall bends inward: the curvature that is not zero may be the smaller one.
    if (const double bend = std::max(std::abs(largest[0]), std::abs(smallest[0]));
        kind == "Cylinder" && bend > 0)
      text += format(" of radius %.6g mm", 1e3 * unit / bend);
    Vector3 middle;
    gmsh::model::occ::getCenterOfMass(dimension, face, middle.x, middle.y, middle.z);
    for (int k = 0; k < 3; ++k)
      middle[k] = std::abs(middle[k]) < 1e-9 ? 0 : middle[k];
    notify(text + format(", area %.4g mm^2, around (%.4g, %.4g, %.4g) mm",
                         1e6 * unit * unit * mass_of(dimension, face), 1e3 * unit * middle.x,
                         1e3 * unit * middle.y, 1e3 * unit * middle.z));
  }
}

/// The faces' triangles of the model's present surface mesh, in metres.
Triangles skin_of_model(const gmsh::vectorpair& volumes, double unit) {
  Triangles out;
  std::unordered_map<std::size_t, int> number;
  std::vector<std::size_t> tags;
  std::vector<double> xyz, parameters;
  gmsh::model::mesh::getNodes(tags, xyz, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    number[tags[i]] = static_cast<int>(i);
    out.points.push_back({unit * xyz[3 * i], unit * xyz[3 * i + 1], unit * xyz[3 * i + 2]});
  }
  gmsh::vectorpair faces;
  gmsh::model::getBoundary(volumes, faces, true, true); // those between two solids fall out
  for (const auto& [dimension, face] : faces) {
    std::vector<std::size_t> elements, nodes;
    gmsh::model::mesh::getElementsByType(2, elements, nodes, std::abs(face));
    for (std::size_t e = 0; e < elements.size(); ++e)
      out.triangles.push_back(
          {number.at(nodes[3 * e]), number.at(nodes[3 * e + 1]), number.at(nodes[3 * e + 2])});
  }
  return out;
}

/// The model as a swept mesh if it is a prism; else it stands as it was imported.
std::optional<Mesh> mesh_of_prism(const std::string& path, const LoadChoice& choice, double unit) {
  for (const bool quadrilaterals : {true, false}) {
    std::optional<Mesh> mesh;
    const bool done = succeeds([&] { mesh = swept_mesh(choice, unit, quadrilaterals); });
    if (mesh)
      return mesh;
    if (done)
      break;                                                      // no prism
    import_solids(path, choice, unit, [](const std::string&) {}); // whole again
  }
  if (choice.sizes && !choice.sizes->levels.empty())
    throw InputError(path + ": the finer base could not be meshed");
  gmsh::option::setNumber("Mesh.RecombineAll", 0);
  gmsh::option::setNumber("Mesh.SecondOrderIncomplete", 0);
  return std::nullopt;
}

} // namespace

Mesh mesh_cad(const std::string& path, const LoadChoice& choice) {
  (void)cad_format(path); // refused before anything is tried
  const auto notify = choice.notify ? choice.notify : [](const std::string&) {};
  const double unit = choice.unit > 0 ? choice.unit : 1e-3;
  Triangles skin;
  std::string reason;
  std::size_t solids = 0;
  std::optional<Session> session(std::in_place);
  const auto attempt = [&](const std::string& how, bool heal, double finer, int algorithm) {
    return session->run(path + " cannot be meshed" + how, [&] {
      import_solids(path, choice, unit, notify);
      if (!heal && finer == 1 && !choice.face_sets && choice.h <= 0 && choice.size_for &&
          !(choice.fillet > 0))
        if (std::optional<Mesh> swept = mesh_of_prism(path, choice, unit))
          return std::move(*swept);
      if (heal) {
        gmsh::vectorpair healed;
        gmsh::model::occ::healShapes(healed, {}, 1e-5 * box_of(-1, -1).largest(), true, true, true,
                                     false, false);
        gmsh::model::occ::synchronize();
      }
      const gmsh::vectorpair volumes = volumes_of_model();
      solids = volumes.size();
      const double solid = volume_of(volumes);
      double area = 0;
      gmsh::vectorpair faces;
      gmsh::model::getBoundary(volumes, faces, true, false);
      for (const auto& [dimension, tag] : faces)
        area += mass_of(dimension, tag);
      const double h = finer / unit *
                       first_size(choice, unit * unit * unit * solid, unit * unit * area,
                                  unit * box_of(-1, -1).largest());
      gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 1);
      gmsh::option::setNumber("Mesh.MinimumElementsPerTwoPi", choice.elements_per_turn);
      gmsh::option::setNumber("Mesh.Algorithm", algorithm);
      const auto predict_size = [&](double triangles) {
        if (choice.on_prediction)
          choice.on_prediction(predicted_mesh_size(choice, unit * unit * unit * solid,
                                                   unit * unit * area, unit * box_of(-1, -1).size(),
                                                   unit * h, triangles),
                               notify);
      };
      predict_size(0);
      set_sizes(h, {});
      if (choice.h <= 0) // the first of several: what small curves need shows in the errors
        gmsh::option::setNumber("Mesh.CharacteristicLengthMin", h / 3);
      std::vector<double> concave;
      // Refinements grade where the errors are.
      if ((choice.grade_concave && choice.h > 0) || choice.fillet > 0) {
        generate(2);
        concave = concave_curves();
        if (choice.fillet > 0)
          concave = round_off(volumes, concave, choice.fillet / unit);
        if (!concave.empty()) {
          notify(std::to_string(concave.size()) + " concave edges, graded");
          gmsh::model::mesh::clear();
          set_sizes(h, concave);
        }
      }
      if (choice.sizes) {
        gmsh::model::mesh::clear();
        set_sizes(*choice.sizes, unit, finer);
      }
      generate(2);
      if (Triangles made = skin_of_model(volumes_of_model(), unit); !made.triangles.empty())
        skin = std::move(made);
      predict_size(static_cast<double>(skin.triangles.size()));
      generate(3);
      Mesh mesh = make_quadratic(choice.curved, unit, choice.face_sets);
      if (choice.face_sets)
        report_faces(unit, notify);
      check(mesh);
      if (choice.sizes && !choice.sizes->straight && has_straight_sides(mesh))
        throw InputError(path + ": curved sides turn inside out on a finer mesh");
      const double whole = unit * unit * unit * volume_of(volumes_of_model());
      if (const double change = volume(mesh) / whole - 1; std::abs(change) > kMaxVolumeChange)
        throw InputError(
            path + format(": the mesh has %+.2f %% of the solid's volume too much", 100 * change));
      return mesh;
    });
  };
  struct Attempt {
    const char* words;
    bool heal;
    double finer;
    int algorithm; ///< gmsh's for faces: 6 Frontal-Delaunay, 5 Delaunay, 1 MeshAdapt
  };
  const bool facets_serve = !choice.sizes || choice.sizes->straight; // else another body's
  const auto take_facets = [&] {
    session.reset(); // the surface is filled in one of its own
    notify(reason);
    notify("the solids' faces are taken as triangles, and as one region");
    return mesh_soup(skin, choice);
  };
  std::string facets_reason;
  // Each attempt stands for a fault seen in real files: small edges, coarse curved sides, bad
  // faces. One body's triangles are tried before ever finer elements.
  for (const Attempt& how :
       {Attempt{"", false, 1, 6}, Attempt{" with its small edges mended", true, 1, 6},
        Attempt{" in smaller elements", false, .6, 5},
        Attempt{" with adapted faces", true, .8, 1}}) {
    try {
      if (how.finer < 1 && solids == 1 && facets_serve && facets_reason.empty() &&
          !skin.triangles.empty()) {
        try {
          return take_facets();
        } catch (const TooLarge&) {
          throw;
        } catch (const InputError& refusal) {
          facets_reason = refusal.what();
          session.emplace();
        }
      }
      Mesh mesh = attempt(how.words, how.heal, how.finer, how.algorithm);
      if (*how.words)
        notify(std::string("meshed") + how.words);
      return mesh;
    } catch (const TooLarge&) {
      throw;
    } catch (const InputError& refusal) {
      const std::string what = refusal.what();
      const bool swept = choice.sizes && !choice.sizes->levels.empty();
      if (swept || choice.fillet > 0 || what.find("separate parts") != std::string::npos ||
          what.find("no solid") != std::string::npos ||
          what.find("cannot be read") != std::string::npos)
        throw;
      if (reason.empty())
        reason = what;
    }
  }
  if (!facets_serve)
    throw InputError(reason);
  if (!facets_reason.empty())
    throw InputError(reason + "; as triangles: " + facets_reason);
  if (skin.triangles.empty())
    throw InputError(reason + "; give another --h, or export it as STL");
  try {
    return take_facets();
  } catch (const TooLarge&) {
    throw;
  } catch (const InputError& refusal) {
    throw InputError(reason + "; as triangles: " + refusal.what());
  }
}

} // namespace tactus::fem
