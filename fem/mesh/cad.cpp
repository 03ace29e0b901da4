#include "fem/mesh/cad.hpp"

#include "fem/io/cad_format.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "fem/mesh/surface_file.hpp"
#include "fem/mesh/sweep.hpp"

#include <gmsh.h>
#include <new>
#include <set>
#include <unordered_map>

namespace tactus::fem {
namespace {

constexpr double kMaxVolumeChange = .01; ///< of the mesh against the solids

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

namespace {

using gmsh::vectorpair;

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

/// A part's own name: the last of those that the file's assemblies put before it.
std::string part_name(int volume) {
  std::string name;
  gmsh::model::getEntityName(3, volume, name);
  name = name.substr(name.find_last_of('/') + 1);
  return name.empty() ? "volume" + std::to_string(volume) : name;
}

/// gmsh's last exception may be no std::exception. Whether `work` went through.
template <class Work> bool tried(Work&& work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const TooLarge&) {
    throw;
  } catch (...) {
    return false;
  }
}

/// What a file holds that is no solid, and where it is open.
std::string without_solid(double unit) {
  vectorpair faces, curves;
  gmsh::model::getEntities(faces, 2);
  gmsh::model::getEntities(curves, 1);
  if (faces.empty())
    return curves.empty() ? "it holds no shape"
                          : "it holds " + std::to_string(curves.size()) + " curves and no face";
  double longest = 0;
  std::size_t open = 0;
  Box at;
  for (const auto& [dimension, tag] : curves) {
    std::vector<int> above, below;
    gmsh::model::getAdjacencies(1, tag, above, below);
    double size = 0;
    tried([&size, curve = tag] { size = mass_of(1, curve); });
    if (above.size() < 2 && size > 0) {
      ++open;
      if (size > longest) {
        longest = size;
        at = box_of(1, tag);
      }
    }
  }
  const std::string what = "it holds " + std::to_string(faces.size()) + " faces that close no body";
  return open == 0 ? what
                   : what + "; " + std::to_string(open) + " edges have one face only, the longest" +
                         near_position(.5 * unit * (at.low + at.high));
}

/// Sews faces into closed shells and makes solids of them, at growing tolerances.
bool sew(double largest) {
  for (const double share : {1e-8, 1e-6, 1e-5, 1e-4}) {
    vectorpair healed;
    if (tried([&] {
          gmsh::model::occ::healShapes(healed, {}, share * largest, true, true, true, true, true);
          gmsh::model::occ::synchronize();
        }) &&
        !volumes_of_model().empty())
      return true;
  }
  return false;
}

/// Numbers of volumes that hang together by common faces, for each volume.
std::vector<int> connected_groups(const vectorpair& volumes) {
  std::vector<int> group(volumes.size());
  std::map<int, int> owner; // first group at a face
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

/// Touching and overlapping solids share their faces from now on; names are carried over. False if
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
  const bool done = tried([&] {
    gmsh::model::occ::fragment({before[0]}, {before.begin() + 1, before.end()}, all, map);
    gmsh::model::occ::synchronize();
  });
  if (!done)
    return false;
  for (std::size_t v = before.size(); v-- > 0;) // of an overlap, the first part's name
    for (const auto& [dimension, tag] : map[v])
      if (dimension == 3)
        gmsh::model::setEntityName(3, tag, names[v]);
  const double after = volume_of(volumes_of_model());
  return after > 0 && after < 1.001 * whole; // overlaps count once
}

/// Names of volumes become regions; parts of one name are one region.
void name_regions(const vectorpair& volumes) {
  std::map<std::string, std::vector<int>> regions;
  for (const auto& [dimension, tag] : volumes)
    regions[part_name(tag)].push_back(tag);
  for (const auto& [name, tags] : regions)
    gmsh::model::setPhysicalName(3, gmsh::model::addPhysicalGroup(3, tags), name);
}

std::string list_of(const vectorpair& volumes, const std::vector<int>& group, double unit) {
  std::string list;
  std::set<int> seen;
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    if (!seen.insert(group[v]).second)
      continue;
    if (seen.size() > 8)
      return list + ", ...";
    const Box box = box_of(3, volumes[v].second);
    list += (list.empty() ? "" : ", ") + part_name(volumes[v].second) +
            format(" (%.3g mm)", 1e3 * unit * box.largest()) +
            near_position(.5 * unit * (box.low + box.high));
  }
  return list;
}

/// Reads the file into gmsh: at least one solid, touching ones with common faces.
void import_solids(const std::string& path, const LoadChoice& choice, double unit,
                   const std::function<void(const std::string&)>& say) {
  const std::string kind = cad_format(path);
  const auto read = [&] {
    gmsh::clear();
    vectorpair shapes;
    if (!tried([&] {
          gmsh::model::occ::importShapes(path, shapes, false, kind); // never a script
          gmsh::model::occ::synchronize();
        }) ||
        (gmsh::model::getEntities(shapes), shapes.empty()))
      throw Refusal(path + " cannot be read by the CAD kernel (Open CASCADE): is it damaged or of "
                           "another format? save it again as STEP, or as STL");
  };
  read();
  const double largest = box_of(-1, -1).largest();
  if (volumes_of_model().empty()) {
    const std::string reason = without_solid(unit);
    if (!sew(largest))
      throw Refusal(path + " holds no solid: " + reason +
                    "; expected a solid or faces that can be sewn into one: close it in a CAD "
                    "program, or export it as STL for --shrink-wrap");
    say("faces were sewn into " + std::to_string(volumes_of_model().size()) + " solid");
  }
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
  if (!sheets.empty() && tried([&] {
        gmsh::model::occ::remove(sheets, true);
        gmsh::model::occ::synchronize();
      }))
    say(format("%zu faces and curves that belong to no solid were left out", sheets.size()));
  const auto pieces = [&] {
    const auto group = connected_groups(volumes_of_model());
    return std::set<int>(group.begin(), group.end()).size();
  };
  if (volumes_of_model().size() > 1) {
    bool shared = fragment_solids(0);
    if (!shared || (pieces() > 1 && !choice.multi)) { // small gaps of the CAD system
      read();
      if (volumes_of_model().empty())
        sew(largest);
      const double fuzzy = 1e-4 * largest;
      const std::size_t separate = pieces();
      if (fragment_solids(fuzzy)) {
        if (pieces() < separate)
          say(format("gaps below %.2g mm between the parts were closed", 1e3 * unit * fuzzy));
        shared = true;
      } else {
        read();
        shared = fragment_solids(0);
      }
    }
    if (!shared)
      throw Refusal(path + ": its " + std::to_string(volumes_of_model().size()) +
                    " solids could not be joined where they touch; fuse them in a CAD program, or "
                    "save one alone");
  }
  const vectorpair volumes = volumes_of_model();
  const auto group = connected_groups(volumes);
  if (const std::size_t count = std::set<int>(group.begin(), group.end()).size();
      count > 1 && !choice.multi)
    throw Refusal(path + " holds " + std::to_string(count) +
                  " separate parts, expected one body: " + list_of(volumes, group, unit) +
                  "; take all as one table with --multi, or save one alone");
  if (volumes.size() > 1)
    name_regions(volumes);
}

/// The faces' triangles of the model's present surface mesh, in metres.
Triangles skin_of_model(const vectorpair& volumes, double unit) {
  Triangles out;
  std::unordered_map<std::size_t, int> number;
  std::vector<std::size_t> tags;
  std::vector<double> xyz, parameters;
  gmsh::model::mesh::getNodes(tags, xyz, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    number[tags[i]] = static_cast<int>(i);
    out.points.push_back({unit * xyz[3 * i], unit * xyz[3 * i + 1], unit * xyz[3 * i + 2]});
  }
  vectorpair faces;
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

} // namespace

Mesh mesh_cad(const std::string& path, const LoadChoice& choice) {
  (void)cad_format(path); // refused before anything is tried
  const auto say = choice.say ? choice.say : [](const std::string&) {};
  const double unit = choice.unit > 0 ? choice.unit : 1e-3;
  Triangles skin;
  std::string reason;
  {
    Session session;
    const auto attempt = [&](const std::string& how, bool heal, double finer, int algorithm) {
      return session.run(path + " cannot be meshed" + how, [&] {
        import_solids(path, choice, unit, say);
        if (!heal && finer == 1 && choice.h <= 0 && choice.size_for && !(choice.fillet > 0)) {
          for (const bool quadrilaterals : {true, false}) {
            std::optional<Mesh> mesh;
            const bool done = tried([&] { mesh = swept_mesh(choice, unit, quadrilaterals); });
            if (mesh)
              return std::move(*mesh);
            if (done)
              break;                                                      // no prism
            import_solids(path, choice, unit, [](const std::string&) {}); // whole again
          }
          if (choice.sizes && !choice.sizes->levels.empty())
            throw Refusal(path + ": the finer base could not be meshed");
          gmsh::option::setNumber("Mesh.RecombineAll", 0);
          gmsh::option::setNumber("Mesh.SecondOrderIncomplete", 0);
        }
        if (heal) {
          vectorpair healed;
          gmsh::model::occ::healShapes(healed, {}, 1e-5 * box_of(-1, -1).largest(), true, true,
                                       true, false, false);
          gmsh::model::occ::synchronize();
        }
        const vectorpair volumes = volumes_of_model();
        const double solid = volume_of(volumes);
        double area = 0;
        vectorpair faces;
        gmsh::model::getBoundary(volumes, faces, true, false);
        for (const auto& [dimension, tag] : faces)
          area += mass_of(dimension, tag);
        const double h = finer / unit *
                         first_size(choice, unit * unit * unit * solid, unit * unit * area,
                                    unit * box_of(-1, -1).largest());
        gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 1);
        gmsh::option::setNumber("Mesh.MinimumElementsPerTwoPi", 12); // curved: 1e-4 of the radius
        gmsh::option::setNumber("Mesh.Algorithm", algorithm);
        const auto foretell = [&](double triangles) {
          if (choice.foretold)
            choice.foretold(foretold_size(choice, unit * unit * unit * solid, unit * unit * area,
                                          unit * box_of(-1, -1).size(), unit * h, triangles),
                            say);
        };
        foretell(0);
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
            say(std::to_string(concave.size()) + " concave edges, graded");
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
        foretell(static_cast<double>(skin.triangles.size()));
        generate(3);
        Mesh mesh = make_quadratic(choice.curved, unit);
        check(mesh);
        if (choice.sizes && !choice.sizes->straight && has_straight_sides(mesh))
          throw Refusal(path + ": curved sides turn inside out on a finer mesh");
        const double whole = unit * unit * unit * volume_of(volumes_of_model());
        if (const double change = volume(mesh) / whole - 1; std::abs(change) > kMaxVolumeChange)
          throw Refusal(path + format(": the mesh has %+.2f %% of the solid's volume too much",
                                      100 * change));
        return mesh;
      });
    };
    struct Way {
      const char* words;
      bool heal;
      double finer;
      int algorithm; ///< gmsh's for faces: 6 Frontal-Delaunay, 5 Delaunay, 1 MeshAdapt
    };
    // Each way stands for a fault seen in real files: small edges, coarse curved sides, bad faces.
    for (const Way& way :
         {Way{"", false, 1, 6}, Way{" with its small edges mended", true, 1, 6},
          Way{" in smaller elements", false, .6, 5}, Way{" with adapted faces", true, .8, 1}}) {
      try {
        Mesh mesh = attempt(way.words, way.heal, way.finer, way.algorithm);
        if (*way.words)
          say(std::string("meshed") + way.words);
        return mesh;
      } catch (const TooLarge&) {
        throw;
      } catch (const Refusal& refusal) {
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
  }
  if (choice.sizes && !choice.sizes->straight) // facets would be another body than the last mesh's
    throw Refusal(reason);
  if (skin.triangles.empty())
    throw Refusal(reason + "; give another --h, or export it as STL");
  say(reason);
  say("the solids' faces are taken as triangles, and as one region");
  try {
    return mesh_soup(std::move(skin), choice);
  } catch (const TooLarge&) {
    throw;
  } catch (const Refusal& refusal) {
    throw Refusal(reason + "; as triangles: " + refusal.what());
  }
}

} // namespace tactus::fem
