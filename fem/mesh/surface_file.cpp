#include "fem/mesh/surface_file.hpp"

#include "fem/io/words.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/fill.hpp"
#include "fem/mesh/holes.hpp"
#include "fem/mesh/resurface.hpp"
#include "fem/mesh/shells.hpp"
#include "fem/mesh/weld.hpp"

#include <algorithm>
#include <set>

namespace tactus::fem {
namespace {

constexpr double kHoleArea = .05, kHoleExtent = .4; ///< shares of the body that are closed
constexpr double kAllHolesArea = .1;                ///< of the skin, together
constexpr double kMaxVolumeChange = .01;            ///< of a surface made anew

using Say = std::function<void(const std::string&)>;

std::string percent(double share) { return format("%+.2f %%", 100 * share); }

void close_small_holes(Triangles& t, const Say& say) {
  const auto holes = close_holes(t, kHoleArea, kHoleExtent);
  std::size_t told = 0;
  for (const Hole& h : holes)
    if (!h.closed)
      throw Refusal(
          open_edge_sentence(t) +
          format("; the hole of %zu edges, %.3g mm wide,", h.edges, 1e3 * h.extent) +
          near_position(h.centre) +
          format(" is too large to be closed (limits: %g %% of the skin, %g %% of the "
                 "length); close it, or take --shrink-wrap SIZE with a SIZE above its width",
                 100 * kHoleArea, 100 * kHoleExtent));
  double patched = 0, skin = 0;
  for (const Hole& h : holes)
    patched += h.area;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    skin += .5 * length(t.normal(i));
  if (patched > kAllHolesArea * skin)
    throw Refusal(
        format("%zu holes make up %.0f %% of the skin, expected %g %% at most, the largest",
               holes.size(), 100 * patched / skin, 100 * kAllHolesArea) +
        near_position(holes[0].centre) +
        "; close them, or take --shrink-wrap SIZE with a SIZE above their width");
  for (const Hole& h : holes)
    if (told++ < 5)
      say(format("a hole of %zu edges, %.3g mm wide,", h.edges, 1e3 * h.extent) +
          near_position(h.centre) + " was closed");
  if (holes.size() > 5)
    say(format("%zu smaller holes were closed too", holes.size() - 5));
  if (!holes.empty()) {
    weld(t);
    close(t);
  }
}

/// A closed surface without crossings of what overlaps, touches or crosses itself.
Triangles unite(const Triangles& t, const std::string& reason, const Say& say) {
  for (const double finer : {1., 1.7, 3.}) {
    Resurfaced made = united(t, finer);
    if (made.inverted > .02 * made.volume)
      throw Refusal(reason + format(": %.3g %% of its volume is inside out; repair the surface, or "
                                    "take --shrink-wrap",
                                    100 * made.inverted / made.volume));
    if (std::abs(made.volume_change) > kMaxVolumeChange)
      continue;
    say(reason + format(": its outer skin was taken anew at %.3g mm, volume ", 1e3 * made.spacing) +
        percent(made.volume_change));
    return std::move(made.surface);
  }
  throw Refusal(reason + ", and its walls are too thin to take its outer skin anew: expected "
                         "one closed surface, or take --shrink-wrap");
}

/// Shells that cross nothing, cavities inward, for winding numbers.
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

Triangles repaired(Triangles t, const Say& say) {
  const Welded welded = weld(t);
  if (welded.duplicates + welded.split + welded.fins > 0)
    say(format(
        "corners within %.2g mm welded; %zu double, %zu dangling triangles left out, %zu cut "
        "at corners on their edges",
        1e3 * welded.tolerance, welded.duplicates, welded.fins, welded.split));
  find_shells(t);
  close_small_holes(t, say);
  const double size = bounding_box(t.points).largest();
  if (const std::size_t flat = drop_flat_shells(t, 1e-5 * size))
    say(format("%zu flat pieces without volume left out", flat));
  if (std::all_of(t.shell.begin(), t.shell.end(), [](int s) { return s == 0; }) &&
      !(shell_volumes(t)[0] > 1e-9 * size * size * size))
    throw Refusal("the surface encloses no volume");
  const auto pair = crossing(t);
  if (pair)
    return unite(turned_by_nesting(t),
                 "the surface crosses itself: " + place_of(t, (*pair)[0]) + " cuts " +
                     place_of(t, (*pair)[1]),
                 say);
  if (shells_touch(t, std::max(welded.tolerance, 1e-6 * size)))
    return unite(turned_by_nesting(t), format("the surface has %d pieces that touch", t.shells),
                 say);
  return t;
}

/// Leaves out bodies below 1e-4 of the largest one's volume: crumbs of modelling.
void drop_specks(std::vector<Triangles>& bodies, const Say& say) {
  std::vector<double> volumes;
  for (const Triangles& body : bodies)
    volumes.push_back(shell_volumes(body)[0]);
  const double limit = 1e-4 * *std::max_element(volumes.begin(), volumes.end());
  std::size_t kept = 0, told = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (volumes[b] >= limit) {
      if (kept != b)
        bodies[kept] = std::move(bodies[b]);
      ++kept;
    } else if (told++ < 3) {
      say(format("a speck of %.2g mm^3 was left out,", 1e9 * volumes[b]) +
          near_position(bodies[b].points[0]));
    }
  }
  if (told > 3)
    say(format("%zu more specks were left out", told - 3));
  bodies.resize(kept);
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
  const Say say = choice.say ? choice.say : [](const std::string&) {};
  Triangles closed;
  if (choice.shrink_wrap != 0) {
    const double largest = bounding_box(t.points).largest();
    const double gap = choice.shrink_wrap > 0 ? choice.shrink_wrap : largest / 25;
    Resurfaced made = shrink_wrapped(t, gap);
    say(format(
        "wrapped: holes and crevices below %.3g mm closed, grid of %.3g mm, volume %.4g cm^3",
        1e3 * gap, 1e3 * made.spacing, 1e6 * made.volume));
    closed = std::move(made.surface);
  } else {
    closed = repaired(std::move(t), say);
  }
  std::vector<Triangles> bodies = separate_bodies(closed);
  drop_specks(bodies, say);
  const std::vector<std::string> names = names_of(bodies);
  if (bodies.size() > 1 && !choice.multi) {
    std::string list;
    for (std::size_t b = 0; b < std::min<std::size_t>(bodies.size(), 8); ++b) {
      const Box box = bounding_box(bodies[b].points);
      list += (b > 0 ? ", " : "") + names[b] + format(" (%.3g mm)", 1e3 * box.largest()) +
              near_position(.5 * (box.low + box.high));
    }
    throw Refusal("the surface has " + std::to_string(bodies.size()) +
                  " separate pieces, expected one body: " + list +
                  (bodies.size() > 8 ? ", ..." : "") +
                  "; take all as one table with --multi, or save one alone");
  }
  Mesh whole;
  whole.regions.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Mesh part;
    try {
      part = mesh_surface(bodies[b], choice);
    } catch (const TooLarge&) {
      throw;
    } catch (const Refusal& refusal) {
      Triangles anew = unite(bodies[b], refusal.what(), say);
      const std::vector<Triangles> pieces = separate_bodies(anew);
      if (pieces.size() != 1)
        throw;
      LoadChoice again = choice;
      again.remesh = true;
      part = mesh_surface(pieces[0], again);
    }
    append(whole, part, bodies.size() == 1 ? "body" : names[b]);
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
  } catch (const Refusal& refusal) {
    throw Refusal(path + ": " + refusal.what());
  }
}

} // namespace tactus::fem
