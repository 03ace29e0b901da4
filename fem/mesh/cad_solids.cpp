#include "fem/mesh/cad_solids.hpp"

#include "fem/io/text.hpp"
#include "fem/io/triangles.hpp"
#include "fem/mesh/cad.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "fem/mesh/parts.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace tactus::fem {

using gmsh::vectorpair;

namespace {
constexpr double kMaxGapVolume = .005; ///< largest change of the solids' volume by closing gaps
} // namespace

vectorpair volumes_of_model() {
  vectorpair volumes;
  gmsh::model::getEntities(volumes, 3);
  return volumes;
}

double mass_of(int dimension, int tag) {
  double mass = 0;
  gmsh::model::occ::getMass(dimension, std::abs(tag), mass);
  return std::abs(mass);
}

double volume_of(const vectorpair& volumes) {
  double sum = 0;
  for (const auto& [dimension, tag] : volumes)
    sum += mass_of(dimension, tag);
  return sum;
}

Box box_of(int dimension, int tag) {
  Box box;
  gmsh::model::getBoundingBox(dimension, tag, box.low.x, box.low.y, box.low.z, box.high.x,
                              box.high.y, box.high.z);
  return box;
}

namespace {

/// A part's own name: the last component of its path in the file's assemblies.
std::string part_name(int volume) {
  std::string name;
  gmsh::model::getEntityName(3, volume, name);
  name = name.substr(name.find_last_of('/') + 1);
  return name.empty() ? "volume" + std::to_string(volume) : name;
}

/// Describes the content of a file without solids, and the openings of its surface.
std::string without_solid(double unit) {
  vectorpair faces, curves;
  gmsh::model::getEntities(faces, 2);
  gmsh::model::getEntities(curves, 1);
  if (faces.empty())
    return curves.empty() ? "it has no shape"
                          : "it has " + std::to_string(curves.size()) + " curves and no face";
  double longest = 0;
  std::size_t open = 0;
  Box at;
  for (const auto& [dimension, tag] : curves) {
    std::vector<int> above, below;
    gmsh::model::getAdjacencies(1, tag, above, below);
    double size = 0;
    succeeds([&size, curve = tag] { size = mass_of(1, curve); });
    if (above.size() < 2 && size > 0) {
      ++open;
      if (size > longest) {
        longest = size;
        at = box_of(1, tag);
      }
    }
  }
  const std::string what =
      "it has " + std::to_string(faces.size()) + " faces that enclose no volume";
  return open == 0 ? what
                   : what + "; " + std::to_string(open) + " edges have only one face, the longest" +
                         near_position(.5 * unit * (at.low + at.high));
}

/// Sews faces into closed shells, at growing tolerances, and makes solids of the shells.
bool sew(double largest) {
  for (const double share : {1e-8, 1e-6, 1e-5, 1e-4}) {
    vectorpair healed;
    if (succeeds([&] {
          gmsh::model::occ::healShapes(healed, {}, share * largest, true, true, true, true, true);
          gmsh::model::occ::synchronize();
        }) &&
        !volumes_of_model().empty())
      return true;
  }
  return false;
}

/// For each volume the number of its group: volumes that are connected by common faces.
std::vector<int> connected_groups(const vectorpair& volumes) {
  std::vector<int> group(volumes.size());
  std::map<int, int> owner; // first group that has the face
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    group[v] = static_cast<int>(v);
    vectorpair faces;
    gmsh::model::getBoundary({volumes[v]}, faces, false, false);
    for (const auto& [dimension, face] : faces) {
      const auto [known, added] = owner.try_emplace(std::abs(face), group[v]);
      if (added || known->second == group[v])
        continue;
      const int from = known->second, to = group[v];
      for (std::size_t w = 0; w <= v; ++w)
        if (group[w] == from)
          group[w] = to;
      for (auto& [f, g] : owner)
        if (g == from)
          g = to;
    }
  }
  return group;
}

/// Makes touching and overlapping solids share their faces, and keeps their names. Returns false if
/// gmsh fails or loses volume.
bool fragment_solids(double tolerance) {
  const vectorpair before = volumes_of_model();
  std::vector<std::string> names;
  for (const auto& [dimension, tag] : before)
    names.push_back(part_name(tag));
  const double whole = volume_of(before);
  gmsh::option::setNumber("Geometry.ToleranceBoolean", tolerance);
  vectorpair all;
  std::vector<vectorpair> map;
  const bool done = succeeds([&] {
    gmsh::model::occ::fragment({before[0]}, {before.begin() + 1, before.end()}, all, map);
    gmsh::model::occ::synchronize();
  });
  if (!done)
    return false;
  for (std::size_t v = before.size(); v-- > 0;) // an overlap gets the first part's name
    for (const auto& [dimension, tag] : map[v])
      if (dimension == 3)
        gmsh::model::setEntityName(3, tag, names[v]);
  const double after = volume_of(volumes_of_model());
  return after > 0 && after < 1.001 * whole; // since overlaps count only once, the volume may
                                             // shrink
}

/// Makes regions from the names of volumes; parts with the same name are one region.
void name_regions(const vectorpair& volumes) {
  std::map<std::string, std::vector<int>> regions;
  for (const auto& [dimension, tag] : volumes)
    regions[part_name(tag)].push_back(tag);
  for (const auto& [name, tags] : regions)
    gmsh::model::setPhysicalName(3, gmsh::model::addPhysicalGroup(3, tags), name);
}

/// The separate parts of the model, and the volumes of each.
std::vector<std::pair<Part, vectorpair>> separate_parts(double unit) {
  const vectorpair volumes = volumes_of_model();
  const auto group = connected_groups(volumes);
  std::map<int, std::size_t> index;
  std::vector<std::pair<Part, vectorpair>> parts;
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    const auto [at, added] = index.try_emplace(group[v], parts.size());
    const Box box = box_of(3, volumes[v].second);
    if (added)
      parts.push_back({{part_name(volumes[v].second), 0, {unit * box.low, unit * box.high}}, {}});
    auto& [part, members] = parts[at->second];
    members.push_back(volumes[v]);
    part.volume += unit * unit * unit * mass_of(3, volumes[v].second);
    for (int k = 0; k < 3; ++k) {
      part.box.low[k] = std::min(part.box.low[k], unit * box.low[k]);
      part.box.high[k] = std::max(part.box.high[k], unit * box.high[k]);
    }
  }
  return parts;
}

/// Removes the volumes of the parts that were not chosen from the model.
void keep_chosen_parts(const LoadChoice& choice, double unit) {
  const auto found = separate_parts(unit);
  std::vector<Part> parts;
  for (const auto& [part, members] : found)
    parts.push_back(part);
  const auto chosen = chosen_parts(parts, choice);
  vectorpair others;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (!std::binary_search(chosen.begin(), chosen.end(), i))
      others.insert(others.end(), found[i].second.begin(), found[i].second.end());
  if (others.empty())
    return;
  gmsh::model::occ::remove(others, true);
  gmsh::model::occ::synchronize();
}

/// Reads a file into gmsh's model and joins its solids.
class SolidImport {
public:
  SolidImport(const std::string& path, const LoadChoice& choice, double unit,
              const std::function<void(const std::string&)>& notify)
      : path_(path), choice_(choice), unit_(unit), notify_(notify), kind_(cad_format(path)) {}

  void run() {
    read();
    largest_ = box_of(-1, -1).largest();
    if (volumes_of_model().empty())
      sew_faces();
    remove_leftovers(true);
    if (volumes_of_model().size() > 1)
      join_solids();
    try {
      keep_chosen_parts(choice_, unit_);
    } catch (const InputError& refusal) {
      throw InputError(path_ + ": " + refusal.what());
    }
    const vectorpair volumes = volumes_of_model();
    if (volumes.size() > 1)
      name_regions(volumes);
  }

private:
  void read() const {
    gmsh::clear();
    vectorpair shapes;
    if (!succeeds([&] {
          gmsh::model::occ::importShapes(path_, shapes, false, kind_); // never a script
          gmsh::model::occ::synchronize();
        }) ||
        (gmsh::model::getEntities(shapes), shapes.empty()))
      throw InputError(path_ +
                       " cannot be read by the CAD kernel (Open CASCADE): it is damaged or has "
                       "another format; save it again as STEP, or as STL");
  }

  void sew_faces() const {
    const std::string reason = without_solid(unit_);
    if (!sew(largest_))
      throw InputError(path_ + " has no solid: " + reason +
                       "; expected a solid or faces that can be sewn into one: close it in a CAD "
                       "program, or export it as STL for --shrink-wrap");
    notify_("faces were sewn into " + std::to_string(volumes_of_model().size()) + " solid");
  }

  /// Sews faces if there is no solid, and removes faces and curves that belong to no solid.
  void remove_leftovers(bool report_gaps) const {
    if (volumes_of_model().empty())
      sew(largest_);
    vectorpair sheets;
    for (int dimension = 1; dimension < 3; ++dimension) {
      vectorpair all;
      gmsh::model::getEntities(all, dimension);
      for (const auto& entity : all) {
        std::vector<int> above, below;
        gmsh::model::getAdjacencies(dimension, entity.second, above, below);
        if (above.empty())
          sheets.push_back(entity);
      }
    }
    const bool gone = !sheets.empty() && succeeds([&] {
      gmsh::model::occ::remove(sheets, true);
      gmsh::model::occ::synchronize();
    });
    if (gone && report_gaps)
      notify_(format("%zu faces and curves that belong to no solid were left out", sheets.size()));
  }

  [[nodiscard]] static std::size_t connected_pieces() {
    const auto group = connected_groups(volumes_of_model());
    return std::set<int>(group.begin(), group.end()).size();
  }

  /// Gives touching solids common faces. Closes small gaps if several parts would remain otherwise.
  void join_solids() const {
    bool joined = fragment_solids(0);
    if (!joined || (!choice_.multi && choice_.part.empty() && connected_pieces() > 1)) {
      joined = close_gaps(joined);
      if (!joined) {
        read();
        remove_leftovers(false);
        joined = fragment_solids(0);
      }
    }
    if (!joined)
      throw InputError(
          path_ + ": its " + std::to_string(volumes_of_model().size()) +
          " solids could not be joined where they touch: fuse them in a CAD program, or "
          "save only one");
  }

  /// Joins the solids with a tolerance, because CAD systems leave small gaps. Returns whether the
  /// last tolerance reduced the number of parts and left the volume unchanged. `joined`: touching
  /// solids have already been joined.
  [[nodiscard]] bool close_gaps(bool joined) const {
    const std::size_t separate = joined ? connected_pieces() : volumes_of_model().size();
    const double whole = joined ? volume_of(volumes_of_model()) : 0;
    bool closed = false;
    for (const double share : {1e-4, 1e-3}) {
      read();
      remove_leftovers(false);
      const bool done = fragment_solids(share * largest_);
      const double change = !done       ? 1.
                            : whole > 0 ? std::abs(volume_of(volumes_of_model()) / whole - 1)
                                        : 0;
      closed = change < kMaxGapVolume && (!joined || connected_pieces() < separate);
      if (closed) {
        notify_(format("gaps below %.2g mm between the parts were closed",
                       1e3 * unit_ * share * largest_));
        if (connected_pieces() == 1 || share > 5e-4)
          break;
      }
    }
    return closed;
  }

  const std::string& path_;
  const LoadChoice& choice_;
  double unit_; ///< metres per unit of the model's lengths
  const std::function<void(const std::string&)>& notify_;
  std::string kind_;   ///< "step" or "brep"
  double largest_ = 0; ///< extent of the model, in its unit
};

} // namespace

void import_solids(const std::string& path, const LoadChoice& choice, double unit,
                   const std::function<void(const std::string&)>& notify) {
  SolidImport(path, choice, unit, notify).run();
}

} // namespace tactus::fem
