#include "fem/mesh/cad.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/cad_solids.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/mesh/surface_file.hpp"
#include "fem/mesh/sweep.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <unordered_map>
#include <utility>

#include <gmsh.h>

namespace tactus::fem {
namespace {

void skip_blanks(std::string_view& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  text.remove_prefix(first == std::string_view::npos ? text.size() : first);
}

} // namespace

std::string cad_format(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw InputError("cannot read " + path);
  std::string head(1024, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  std::string_view text = head;
  skip_blanks(text);
  if (text.starts_with("DBRep_DrawableShape") || text.starts_with("CASCADE Topology"))
    return "brep";
  while (text.starts_with("/*")) {
    const auto end = text.find("*/", 2);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 2);
    skip_blanks(text);
  }
  if (text.starts_with("ISO-10303-21;"))
    return "step";
  const std::string_view line = text.substr(0, text.find('\n'));
  throw InputError(path + " begins with \"" + printable(line, 40) +
                   "\", expected ISO-10303-21; (STEP) or DBRep_DrawableShape (BREP)");
}

namespace {

constexpr double kMaxSolidVolumeChange = .01; ///< difference between mesh and solids

/// Fillets the concave curves of the only volume. Returns an empty list, because no curves remain
/// to be graded.
std::vector<double> round_off(const gmsh::vectorpair& volumes, const std::vector<double>& concave,
                              double radius) {
  if (volumes.size() != 1)
    throw InputError("--fillet rounds the edges of one solid, the file has " +
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
  } catch (...) { // gmsh throws types that are not std::exception
    throw InputError(format("--fillet: a radius of %g of the file's units does not fit the concave "
                            "edges",
                            radius));
  }
  gmsh::model::occ::synchronize();
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", radius / 3);
  return {};
}

/// Reports number, kind, centre and area of each face of the model, one sentence each.
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
    // A hole's wall bends inward, so the curvature that is not zero may be the smaller one.
    if (const double bend = std::max(std::abs(largest[0]), std::abs(smallest[0]));
        kind == "Cylinder" && bend > 0)
      text += format(" of radius %.6g mm", 1e3 * unit / bend);
    Vec3 middle;
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
  gmsh::model::getBoundary(volumes, faces, true, true); // excludes faces between two solids
  for (const auto& [dimension, face] : faces) {
    std::vector<std::size_t> elements, nodes;
    gmsh::model::mesh::getElementsByType(2, elements, nodes, std::abs(face));
    for (std::size_t e = 0; e < elements.size(); ++e)
      out.triangles.push_back(
          {number.at(nodes[3 * e]), number.at(nodes[3 * e + 1]), number.at(nodes[3 * e + 2])});
  }
  return out;
}

/// Returns the model as a swept mesh if it is a prism; otherwise leaves the model as imported.
std::optional<Mesh> mesh_of_prism(const std::string& path, const LoadChoice& choice, double unit) {
  for (const bool quadrilaterals : {true, false}) {
    std::optional<Mesh> mesh;
    const bool done = succeeds([&] { mesh = swept_mesh(choice, unit, quadrilaterals); });
    if (mesh)
      return mesh;
    if (done)
      break;                                                      // not a prism
    import_solids(path, choice, unit, [](const std::string&) {}); // restores the model
  }
  if (choice.sizes && !choice.sizes->levels.empty())
    throw InputError(path + ": the finer base could not be meshed");
  gmsh::option::setNumber("Mesh.RecombineAll", 0);
  gmsh::option::setNumber("Mesh.SecondOrderIncomplete", 0);
  return std::nullopt;
}

/// Settings for meshing the solids. The attempts are tried in order until one succeeds; each
/// handles a fault that occurs in real files: small edges, coarse curved edges or bad faces.
struct Attempt {
  const char* words; ///< text for the user
  bool heal;
  double finer;  ///< factor on the element size
  int algorithm; ///< gmsh's algorithm for faces: 6 Frontal-Delaunay, 5 Delaunay, 1 MeshAdapt
};
constexpr Attempt kAttempts[]{{"", false, 1, 6},
                              {" with small edges repaired", true, 1, 6},
                              {" with smaller elements", false, .6, 5},
                              {" with adapted faces", true, .8, 1}};

/// Metres per unit of the imported model: a STEP file contains its unit and is imported in
/// millimetres.
double unit_of_lengths(const std::string& path, double given) {
  return given > 0 && cad_format(path) != "step" ? given : 1e-3;
}

/// Meshes the solids of a CAD file.
class CadMesher {
public:
  CadMesher(const std::string& path, const LoadChoice& choice)
      : path_(path), choice_(choice), unit_(unit_of_lengths(path, choice.unit)),
        facets_allowed_(!choice.sizes || choice.sizes->straight) {
    if (choice.notify)
      notify_ = choice.notify;
    if (choice.unit > 0 && choice.unit != unit_)
      notify_(
          "a STEP file states its own unit of length: --unit applies only to lengths in options");
  }

  /// Tries each attempt in turn; for a single body the skin's triangles are filled before finer
  /// elements are tried.
  [[nodiscard]] Mesh mesh() {
    for (const Attempt& how : kAttempts) {
      try {
        if (how.finer < 1 && solids_ == 1 && facets_allowed_ && facets_reason_.empty() &&
            !skin_.triangles.empty())
          if (std::optional<Mesh> mesh = try_facets())
            return std::move(*mesh);
        Mesh mesh = mesh_solids(how);
        if (*how.words)
          notify_(std::string("meshed") + how.words);
        return mesh;
      } catch (const TooLarge&) {
        throw;
      } catch (const InputError& refusal) {
        if (is_final(refusal.what()))
          throw;
        if (reason_.empty())
          reason_ = refusal.what();
      }
    }
    return last_resort();
  }

private:
  /// Volume (m^3) and skin (m^2) of the solids, and the size of their elements in the model's unit.
  struct Extent {
    double volume, area, h;
  };

  /// True if another attempt would end with the same refusal.
  [[nodiscard]] bool is_final(const std::string& what) const {
    const bool swept = choice_.sizes && !choice_.sizes->levels.empty();
    return swept || choice_.fillet > 0 || what.find("separate parts") != std::string::npos ||
           what.find("no solid") != std::string::npos ||
           what.find("cannot be read") != std::string::npos;
  }

  [[nodiscard]] Mesh mesh_solids(const Attempt& how) {
    return session_->run(path_ + " cannot be meshed" + how.words, [&] {
      import_solids(path_, choice_, unit_, notify_);
      if (!how.heal && how.finer == 1 && !choice_.face_sets && choice_.h <= 0 && choice_.size_for &&
          !(choice_.fillet > 0))
        if (std::optional<Mesh> swept = mesh_of_prism(path_, choice_, unit_))
          return std::move(*swept);
      if (how.heal)
        heal_shapes();
      const gmsh::vectorpair volumes = volumes_of_model();
      solids_ = volumes.size();
      const Extent extent = measure(volumes, how.finer);
      gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 1);
      gmsh::option::setNumber("Mesh.MinimumElementsPerTwoPi", choice_.elements_per_turn);
      gmsh::option::setNumber("Mesh.Algorithm", how.algorithm);
      predict_size(extent, 0);
      choose_sizes(volumes, extent.h, how.finer);
      generate(2);
      if (Triangles made = skin_of_model(volumes_of_model(), unit_); !made.triangles.empty())
        skin_ = std::move(made);
      predict_size(extent, static_cast<double>(skin_.triangles.size()));
      generate(3);
      return finished_mesh();
    });
  }

  static void heal_shapes() {
    gmsh::vectorpair healed;
    gmsh::model::occ::healShapes(healed, {}, 1e-5 * box_of(-1, -1).largest(), true, true, true,
                                 false, false);
    gmsh::model::occ::synchronize();
  }

  [[nodiscard]] Extent measure(const gmsh::vectorpair& volumes, double finer) const {
    const double solid = volume_of(volumes);
    double area = 0;
    gmsh::vectorpair faces;
    gmsh::model::getBoundary(volumes, faces, true, false);
    for (const auto& [dimension, tag] : faces)
      area += mass_of(dimension, tag);
    const double volume_m3 = unit_ * unit_ * unit_ * solid, area_m2 = unit_ * unit_ * area;
    return {volume_m3, area_m2,
            finer / unit_ *
                first_size(choice_, volume_m3, area_m2, unit_ * box_of(-1, -1).largest())};
  }

  void predict_size(const Extent& extent, double triangles) const {
    if (choice_.on_prediction)
      choice_.on_prediction(predicted_mesh_size(choice_, extent.volume, extent.area,
                                                unit_ * box_of(-1, -1).size(), unit_ * extent.h,
                                                triangles),
                            notify_);
  }

  /// Element sizes: h, graded towards concave edges if h is given, or the sizes of a refinement.
  void choose_sizes(const gmsh::vectorpair& volumes, double h, double finer) const {
    set_sizes(h, {});
    if (choice_.h <= 0) // the first of several meshes, since the error estimate refines small
                        // curves
      gmsh::option::setNumber("Mesh.CharacteristicLengthMin", h / 3);
    // A refinement already grades by the estimated errors.
    if ((choice_.grade_concave && choice_.h > 0) || choice_.fillet > 0) {
      generate(2);
      std::vector<double> concave = concave_curves();
      if (choice_.fillet > 0)
        concave = round_off(volumes, concave, choice_.fillet / unit_);
      if (!concave.empty()) {
        notify_(std::to_string(concave.size()) + " concave edges, graded");
        gmsh::model::mesh::clear();
        set_sizes(h, concave);
      }
    }
    if (choice_.sizes) {
      gmsh::model::mesh::clear();
      set_sizes(*choice_.sizes, unit_, finer);
    }
  }

  /// The model's mesh in second order. Refuses a mesh that does not fill the solids.
  [[nodiscard]] Mesh finished_mesh() const {
    Mesh mesh = make_quadratic(choice_.curved, unit_, choice_.face_sets);
    if (choice_.face_sets)
      report_faces(unit_, notify_);
    check(mesh);
    if (choice_.sizes && !choice_.sizes->straight && has_straight_sides(mesh))
      throw InputError(path_ + ": curved edges invert elements on a finer mesh");
    const double whole = unit_ * unit_ * unit_ * volume_of(volumes_of_model());
    if (const double change = volume(mesh) / whole - 1; std::abs(change) > kMaxSolidVolumeChange)
      throw InputError(
          path_ + format(": the mesh's volume differs by %+.2f %% from the solid's", 100 * change));
    return mesh;
  }

  /// Fills the triangulated faces of the solids, as for a surface file.
  [[nodiscard]] Mesh mesh_facets() {
    session_.reset(); // filling the surface uses its own session
    notify_(reason_);
    notify_("the solids' faces are converted to triangles, in one region");
    return mesh_soup(skin_, choice_);
  }
  [[nodiscard]] std::optional<Mesh> try_facets() {
    try {
      return mesh_facets();
    } catch (const TooLarge&) {
      throw;
    } catch (const InputError& refusal) {
      facets_reason_ = refusal.what();
      session_.emplace();
      return std::nullopt;
    }
  }
  [[nodiscard]] Mesh last_resort() {
    if (!facets_allowed_)
      throw InputError(reason_);
    if (!facets_reason_.empty())
      throw InputError(reason_ + "; as triangles: " + facets_reason_);
    if (skin_.triangles.empty())
      throw InputError(reason_ + "; use another --h, or export it as STL");
    try {
      return mesh_facets();
    } catch (const TooLarge&) {
      throw;
    } catch (const InputError& refusal) {
      throw InputError(reason_ + "; as triangles: " + refusal.what());
    }
  }

  const std::string& path_;
  const LoadChoice& choice_;
  double unit_;         ///< metres per unit of the model
  bool facets_allowed_; ///< false for a refinement of curved sides, whose sizes belong to another
                        ///< body
  std::function<void(const std::string&)> notify_ = [](const std::string&) {};
  std::optional<Session> session_{std::in_place};
  Triangles skin_; ///< triangles of the last attempt that meshed the faces
  std::size_t solids_ = 0;
  std::string reason_, facets_reason_; ///< the first refusals
};

} // namespace

Mesh mesh_cad(const std::string& path, const LoadChoice& choice) {
  (void)cad_format(path); // refuses early
  return CadMesher(path, choice).mesh();
}

} // namespace tactus::fem
