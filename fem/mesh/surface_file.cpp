#include "fem/mesh/surface_file.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/fill.hpp"
#include "fem/mesh/holes.hpp"
#include "fem/mesh/parts.hpp"
#include "fem/mesh/resurface.hpp"
#include "fem/mesh/shells.hpp"
#include "fem/mesh/weld.hpp"

#include <algorithm>
#include <set>

namespace tactus::fem {
namespace {

constexpr double kHoleArea = .05, kHoleExtent = .4; ///< largest hole to close, relative to the body
constexpr double kAllHolesArea = .1;                ///< all holes together, relative to the skin
constexpr double kSheet = .003; ///< relative thickness below which a capped surface is a sheet
constexpr double kMaxSkinVolumeChange = .01; ///< for a rebuilt surface
constexpr double kClosedGap = 2e-4;          ///< gap between joined pieces, relative to the body's
                                             ///< size

using Notify = std::function<void(const std::string&)>;

std::string percent(double share) { return format("%+.2f %%", 100 * share); }

void close_small_holes(Triangles& t, const Notify& notify) {
  const auto holes = close_holes(t, kHoleArea, kHoleExtent);
  for (const Hole& h : holes)
    if (!h.closed)
      throw InputError(
          open_edge_sentence(t) +
          format("; the hole of %zu edges, %.3g mm wide,", h.edges, 1e3 * h.extent) +
          near_position(h.centre) +
          format(" is too large to be closed (limits: %g %% of the skin, %g %% of the length, or "
                 "one flat opening): close it, give a sheet a thickness, or use --shrink-wrap "
                 "SIZE with a SIZE above its width",
                 100 * kHoleArea, 100 * kHoleExtent));
  if (holes.empty())
    return;
  double patched = 0, skin = 0;
  for (const Hole& h : holes)
    patched += h.flat_opening ? 0 : h.area;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    skin += .5 * length(t.normal(i));
  if (patched > kAllHolesArea * skin)
    throw InputError(
        format("%zu holes make up %.0f %% of the skin, expected at most %g %%, the largest",
               holes.size(), 100 * patched / skin, 100 * kAllHolesArea) +
        near_position(holes[0].centre) +
        ": close them, or use --shrink-wrap SIZE with a SIZE above their width");
  std::size_t reported = 0;
  for (const Hole& h : holes)
    if (reported++ < 5)
      notify(format(h.flat_opening ? "the open flat side of %zu edges, %.3g mm wide,"
                                   : "a hole of %zu edges, %.3g mm wide,",
                    h.edges, 1e3 * h.extent) +
             near_position(h.centre) +
             (h.flat_opening ? " was closed: the surface is treated as the skin of a solid"
                             : " was closed"));
  if (holes.size() > 5)
    notify(format("%zu smaller holes were closed too", holes.size() - 5));
  weld(t);
  close(t);
  double solid = 0;
  for (const double v : shell_volumes(t))
    solid += std::abs(v);
  const double wall = 2 * solid / skin;
  if (holes[0].flat_opening && wall < kSheet * bounding_box(t.points).largest())
    throw InputError(
        format("the surface is a sheet: with its open side of %zu edges closed its mean "
               "thickness is %.2g mm, expected %.2g mm or more; the opening is",
               holes[0].edges, 1e3 * wall, 1e3 * kSheet * bounding_box(t.points).largest()) +
        near_position(holes[0].centre) + ": give it a thickness, or use --shrink-wrap SIZE");
}

/// Makes a closed surface without intersections from one that overlaps, touches or crosses itself.
Triangles unite(const Triangles& t, const std::string& reason, const Notify& notify) {
  for (const double finer : {1., 1.7, 3.}) {
    Resurfaced made = united(t, finer);
    if (made.inverted > .02 * made.volume)
      throw InputError(reason +
                       format(": %.3g %% of its volume is inverted: repair the surface, or "
                              "use --shrink-wrap SIZE",
                              100 * made.inverted / made.volume));
    if (std::abs(made.volume_change) > kMaxSkinVolumeChange)
      continue;
    notify(reason + format(": its outer skin was rebuilt at %.3g mm, volume ", 1e3 * made.spacing) +
           percent(made.volume_change));
    return std::move(made.surface);
  }
  throw InputError(reason + ", and its walls are too thin to rebuild its outer skin: expected "
                            "one closed surface; repair it there, or use --shrink-wrap SIZE");
}

/// Shells that do not cross each other, with cavities turned inward, for winding numbers.
Triangles turned_by_nesting(const Triangles& t) {
  Triangles out;
  out.groups = t.groups;
  for (const Triangles& body : separate_bodies(t)) {
    const int base = static_cast<int>(out.points.size());
    out.points.insert(out.points.end(), body.points.begin(), body.points.end());
    for (std::size_t i = 0; i < body.triangles.size(); ++i) {
      auto corners = body.triangles[i];
      for (int& v : corners)
        v += base;
      out.triangles.push_back(corners);
      out.shell.push_back(out.shells + body.shell[i]);
      if (!body.group.empty())
        out.group.push_back(body.group[i]);
    }
    out.shells += body.shells;
  }
  return out;
}

Triangles repaired(Triangles t, bool multi, const Notify& notify) {
  const Welded welded = weld(t);
  if (welded.duplicates + welded.split + welded.fins > 0)
    notify(format("corners within %.2g mm welded; %zu duplicate and %zu dangling triangles "
                  "removed, %zu split "
                  "at corners on their edges",
                  1e3 * welded.tolerance, welded.duplicates, welded.fins, welded.split));
  find_shells(t);
  close_small_holes(t, notify);
  const double size = bounding_box(t.points).largest();
  if (const std::size_t flat = drop_flat_shells(t, 1e-5 * size))
    notify(format("%zu flat pieces without volume removed", flat));
  if (std::all_of(t.shell.begin(), t.shell.end(), [](int s) { return s == 0; }) &&
      !(shell_volumes(t)[0] > 1e-9 * size * size * size))
    throw InputError("the surface encloses no volume: it is flat" + near_position(t.points[0]) +
                     ": give a sheet a thickness, or use --shrink-wrap SIZE");
  const auto pair = crossing(t);
  if (pair)
    return unite(turned_by_nesting(t),
                 "the surface crosses itself: " + triangle_location(t, (*pair)[0]) + " cuts " +
                     triangle_location(t, (*pair)[1]),
                 notify);
  // Faces of an assembly often miss each other by rounding in the program that made them. The grid
  // of the union is a hundred times coarser and closes such gaps.
  const double gap = std::max(welded.tolerance, (multi ? 1e-6 : kClosedGap) * size);
  if (shells_touch(t, gap))
    return unite(turned_by_nesting(t),
                 format("the surface has %d pieces with gaps below %.2g mm", t.shells, 1e3 * gap),
                 notify);
  return t;
}

/// The wrap of a given size. Without one, starts with 1/25 of the body and doubles the size until
/// the wrap encloses more than the sheet of triangles itself.
Triangles wrapped(const Triangles& t, double size, const Notify& notify) {
  constexpr int kDoublings = 5;
  double gap = size > 0 ? size : bounding_box(t.points).largest() / 25;
  for (int doubling = size > 0 ? kDoublings : 0;; ++doubling, gap *= 2)
    try {
      Resurfaced made = shrink_wrapped(t, gap);
      notify(format(
          "wrapped: holes and crevices below %.3g mm closed, grid of %.3g mm, volume %.4g cm^3",
          1e3 * gap, 1e3 * made.spacing, 1e6 * made.volume));
      return std::move(made.surface);
    } catch (const EnclosesNothing&) {
      if (doubling == kDoublings)
        throw;
    }
}

std::vector<std::string> names_of(const std::vector<Triangles>& bodies) {
  std::vector<std::string> names;
  std::set<std::string> used;
  for (const Triangles& body : bodies) {
    std::vector<std::size_t> votes(body.groups.size(), 0);
    for (const int g : body.group)
      ++votes[static_cast<std::size_t>(g)];
    std::string name = votes.empty() || body.group.empty()
                           ? "body"
                           : body.groups[static_cast<std::size_t>(
                                 std::max_element(votes.begin(), votes.end()) - votes.begin())];
    const std::string stem = name;
    for (int copy = 2; !used.insert(name).second; ++copy)
      name = stem + "_" + std::to_string(copy);
    names.push_back(name);
  }
  return names;
}

void append(Mesh& whole, const Mesh& part, const std::string& region) {
  const int base = static_cast<int>(whole.nodes.size());
  whole.regions.push_back(region);
  whole.nodes.insert(whole.nodes.end(), part.nodes.begin(), part.nodes.end());
  for (const Element& e : part.elements) {
    std::vector<int> nodes(part.nodes_of(e).begin(), part.nodes_of(e).end());
    for (int& n : nodes)
      n += base;
    whole.add(e.shape, nodes, static_cast<int>(whole.regions.size()) - 1);
  }
}

} // namespace

Mesh mesh_soup(Triangles t, const LoadChoice& choice) {
  const Notify notify = choice.notify ? choice.notify : [](const std::string&) {};
  Triangles closed;
  if (choice.shrink_wrap != 0) {
    closed = wrapped(t, choice.shrink_wrap, notify);
  } else {
    closed = repaired(std::move(t), choice.multi || !choice.part.empty(), notify);
  }
  std::vector<Triangles> bodies = separate_bodies(closed);
  const std::vector<std::string> names = names_of(bodies);
  std::vector<Part> parts;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    parts.push_back({names[b], shell_volumes(bodies[b])[0], bounding_box(bodies[b].points)});
  const std::vector<std::size_t> chosen = chosen_parts(parts, choice);
  Mesh whole;
  whole.regions.clear();
  for (const std::size_t b : chosen) {
    Mesh part;
    try {
      part = mesh_surface(bodies[b], choice);
    } catch (const TooLarge&) {
      throw;
    } catch (const InputError& refusal) {
      if (choice.shrink_wrap != 0)
        throw InputError(std::string("its wrap cannot be meshed: ") + refusal.what() +
                         "; expected another --shrink-wrap SIZE");
      Triangles rebuilt = unite(bodies[b], refusal.what(), notify);
      const std::vector<Triangles> pieces = separate_bodies(rebuilt);
      if (pieces.size() != 1)
        throw;
      LoadChoice again = choice;
      again.remesh = true;
      part = mesh_surface(pieces[0], again);
    }
    append(whole, part, chosen.size() == 1 ? "body" : names[b]);
  }
  return whole;
}

Mesh mesh_surface_file(const std::string& path, double unit, const LoadChoice& choice) {
  Triangles t = read_triangles(path, unit);
  check_range(path, t.points);
  try {
    return mesh_soup(std::move(t), choice);
  } catch (const TooLarge&) {
    throw;
  } catch (const InputError& refusal) {
    throw InputError(path + ": " + refusal.what());
  }
}

} // namespace tactus::fem
