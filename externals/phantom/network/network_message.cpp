#include "core/declaration_text.hpp"
#include "externals/phantom/network/named_network.hpp"
#include "externals/phantom/words.hpp"

#include <algorithm>

/// The messages that build a network, and their ranges.
namespace tactus::phantom {
namespace {

constexpr double kMaxPosition_mm = 1000;
constexpr Range near_mm(std::string_view name) {
  return {name, "mm", -kMaxPosition_mm, kMaxPosition_mm};
}
constexpr Range kPointMass{"mass", "kg", 1e-7, 10};
constexpr Range kTotalMass{"mass", "kg", 1e-6, 1000};
constexpr Range kLinkStiffness{"k", "N/m", 0, 1e6};
constexpr Range kCorners[] = {near_mm("x1"), near_mm("y1"), near_mm("z1"),
                              near_mm("x2"), near_mm("y2"), near_mm("z2")};

} // namespace

std::string NamedNetwork::change(Words words, const Host& host) {
  const Words rest = words.subspan(1);
  if (is(words[0], "mass"))
    return add_mass(rest);
  if (is(words[0], "anchor"))
    return add_anchor(rest);
  if (is(words[0], "link"))
    return add_link(rest);
  if (is(words[0], "string"))
    return add_string(rest);
  if (is(words[0], "membrane"))
    return add_membrane(rest);
  if (is(words[0], "load"))
    return load(rest, host);
  if (is(words[0], "del"))
    return remove(rest);
  if (is(words[0], "touch"))
    return set_touch(rest);
  if (is(words[0], "grab"))
    return set_grab(rest);
  if (is(words[0], "listen"))
    return set_pickup(rest);
  if (is(words[0], "drag") || is(words[0], "gravity") || is(words[0], "rate"))
    return set_motion(words);
  return "expected mass, anchor, link, string, membrane, load, del, touch, grab, listen, pluck, "
         "drag, gravity, rate or reset";
}

/// Adds a mass, or changes the mass of that name. A changed mass keeps its motion and its links; it
/// moves to its new position only on `reset`.
std::string NamedNetwork::add_mass(Words words) {
  constexpr Range ranges[] = {kPointMass, near_mm("x"), near_mm("y"), near_mm("z")};
  if (words.empty())
    return "expected a name, kg and x y z in mm";
  double v[4] = {};
  if (std::string refusal = read_some(words.subspan(1), ranges, 4, v); !refusal.empty())
    return refusal;
  const std::string name = text_of(words[0]);
  const std::size_t old = find(name);
  if (old == kNone) {
    add({0, v[0], metres(v + 1), false}, name, {});
    return {};
  }
  network_.masses[old].mass_kg = v[0];
  network_.masses[old].position = metres(v + 1);
  network_.masses[old].fixed = false;
  return {};
}

/// Adds a fixed point, or fixes an existing mass where it is.
std::string NamedNetwork::add_anchor(Words words) {
  constexpr Range ranges[] = {near_mm("x"), near_mm("y"), near_mm("z")};
  if (words.empty())
    return "expected a name, and x y z in mm for a new one";
  const std::string name = text_of(words[0]);
  const std::size_t old = find(name);
  if (old != kNone && words.size() == 1) {
    network_.masses[old].fixed = true;
    return {};
  }
  if (old == kNone && words.size() == 1)
    return name + ": no such mass: expected x y z in mm for a new anchor";
  if (old != kNone)
    return name + ": this mass already exists: expected its name alone";
  double v[3] = {};
  if (std::string refusal = read_some(words.subspan(1), ranges, 3, v); !refusal.empty())
    return refusal;
  add({0, 1, metres(v), true}, name, {});
  return {};
}

/// Adds a spring and damper between two masses, or replaces theirs. Unless given, the rest length
/// (l0) is the distance of the masses.
std::string NamedNetwork::add_link(Words words) {
  using Kind = haptic::NetworkLink::Kind;
  constexpr Range ranges[] = {
      kLinkStiffness, kNetworkDamping, {"l0", "mm", 0, 2 * kMaxPosition_mm}};
  if (words.size() < 3)
    return "expected two masses and k, optionally b, l0 and pull or push";
  const std::size_t a = find(text_of(words[0])), b = find(text_of(words[1]));
  if (a == kNone || b == kNone)
    return text_of(words[a == kNone ? 0 : 1]) + ": no such mass";
  if (a == b)
    return text_of(words[0]) + ": expected two different masses";
  haptic::NetworkLink link;
  if (is(words.back(), "pull") || is(words.back(), "push")) {
    link.kind = is(words.back(), "pull") ? Kind::kPull : Kind::kPush;
    words = words.first(words.size() - 1);
  } else if (words.size() == 6) {
    return text_of(words[5]) + ": expected pull or push";
  }
  const auto& masses = network_.masses;
  double v[3] = {0, 0, norm(masses[b].position - masses[a].position) * 1e3};
  if (std::string refusal = read_some(words.subspan(2), ranges, 1, v); !refusal.empty())
    return refusal;
  link.a = static_cast<std::uint16_t>(a);
  link.b = static_cast<std::uint16_t>(b);
  link.stiffness_n_per_m = v[0];
  link.damping_n_s_per_m = v[1];
  link.rest_length_m = v[2] * 1e-3;
  auto& links = network_.links;
  const auto same = std::find_if(links.begin(), links.end(), [&](const auto& other) {
    return (other.a == a && other.b == b) || (other.a == b && other.b == a);
  });
  if (same != links.end())
    *same = link;
  else
    links.push_back(link);
  return {};
}

std::string NamedNetwork::add_string(Words words) {
  haptic::NetworkString string;
  constexpr Range ranges[] = {{"n", "", 1, static_cast<double>(haptic::Network::kMaxMasses)},
                              kCorners[0],
                              kCorners[1],
                              kCorners[2],
                              kCorners[3],
                              kCorners[4],
                              kCorners[5],
                              kTotalMass,
                              {"tension", "N", 1e-4, 1e4},
                              kNetworkDamping,
                              {"stiffness", "N/m", 0, 1e6}};
  if (words.empty())
    return "expected a name, the number of masses and two ends in mm";
  double v[11] = {0, 0, 0, 0, 0, 0, 0, string.mass_kg, string.tension_n, string.damping_n_s_per_m,
                  0};
  if (std::string refusal = read_some(words.subspan(1), ranges, 7, v); !refusal.empty())
    return refusal;
  string = {static_cast<int>(v[0]), metres(v + 1), metres(v + 4), v[7], v[8], v[9], v[10]};
  const double length_m = norm(string.to - string.from);
  if (length_m < 1e-3)
    return "the ends are " + number_text(length_m * 1e3) + " mm apart: expected 1 or more";
  // A softer link would need a negative rest length to have that tension.
  const double min_stiffness = string.tension_n * (string.count + 1) / length_m;
  if (string.stiffness_n_per_m > 0 && string.stiffness_n_per_m < min_stiffness)
    return "stiffness " + number_text(string.stiffness_n_per_m) + " N/m: expected 0 or at least " +
           number_text(min_stiffness) + ", the tension over the spacing of the masses";
  const std::string name = text_of(words[0]);
  std::vector<std::string> names;
  for (int i = 0; i <= string.count + 1; ++i)
    names.push_back(name + "-" + std::to_string(i));
  add(make_string(string), name, names);
  return {};
}

std::string NamedNetwork::add_membrane(Words words) {
  haptic::NetworkMembrane membrane;
  constexpr Range ranges[] = {
      {"nx", "", 1, 50}, {"ny", "", 1, 50}, kCorners[0], kCorners[1], kCorners[2],
      kCorners[3],       kCorners[4],       kCorners[5], kTotalMass,  {"tension", "N/m", 1e-2, 1e6},
      kNetworkDamping};
  if (words.empty())
    return "expected a name, columns, rows and two corners in mm";
  double v[11] = {0,
                  0,
                  0,
                  0,
                  0,
                  0,
                  0,
                  0,
                  membrane.mass_kg,
                  membrane.tension_n_per_m,
                  membrane.damping_n_s_per_m};
  if (std::string refusal = read_some(words.subspan(1), ranges, 8, v); !refusal.empty())
    return refusal;
  membrane = {static_cast<int>(v[0]),
              static_cast<int>(v[1]),
              metres(v + 2),
              metres(v + 5),
              v[8],
              v[9],
              v[10]};
  if (membrane.nx * membrane.ny > static_cast<int>(haptic::Network::kMaxMasses))
    return std::to_string(membrane.nx * membrane.ny) + " masses: expected at most " +
           std::to_string(haptic::Network::kMaxMasses);
  const haptic::NetworkPart part = make_membrane(membrane);
  if (part.masses.empty())
    return "expected two corners of a rectangle that share exactly one of x, y and z";
  const std::string name = text_of(words[0]);
  std::vector<std::string> names(part.masses.size());
  for (int j = 0; j <= membrane.ny + 1; ++j)
    for (int i = 0; i <= membrane.nx + 1; ++i)
      if ((i > 0 && i <= membrane.nx) || (j > 0 && j <= membrane.ny))
        names[haptic::membrane_index(membrane.nx, membrane.ny, i, j)] =
            name + "-" + std::to_string(i) + "-" + std::to_string(j);
  add(part, name, names);
  return {};
}

std::string NamedNetwork::remove(Words words) {
  if (words.size() != 1)
    return "expected a name or all";
  if (is(words[0], "all")) {
    network_.masses.clear();
    network_.links.clear();
    network_.pickups = {};
    names_.clear();
    return {};
  }
  return remove_named(text_of(words[0])) ? std::string()
                                         : text_of(words[0]) + ": no such mass, string or membrane";
}

} // namespace tactus::phantom
