#include "fem/shapes/lift_arm.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/cad.hpp"
#include "fem/mesh/gmsh_model.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <unistd.h>

namespace tactus::fem {
namespace {

using std::numbers::pi;
constexpr double kMillimetre = 1e-3;
/// Area between two perpendicular walls and a quarter disk of radius 1 that touches them, and its
/// first moment about a wall.
constexpr double kCornerArea = 1 - pi / 4, kCornerMoment = 5. / 6 - pi / 4;

struct Circle {
  Vec3 centre;
  double radius = 0;
};

Vec3 on(const Circle& c, double angle) {
  return c.centre + c.radius * Vec3{std::cos(angle), std::sin(angle), 0};
}

double angle_of(const Vec3& v) { return std::atan2(v.y, v.x); }

/// Runs from angle `from` by `sweep` radians, counter-clockwise if positive.
struct Arc {
  Circle circle;
  double from = 0, sweep = 0;
  [[nodiscard]] Vec3 begin() const { return on(circle, from); }
  [[nodiscard]] Vec3 end() const { return on(circle, from + sweep); }
};
using Outline = std::vector<Arc>; ///< closed, counter-clockwise

double area(const Outline& outline) {
  double sum = 0;
  for (const Arc& a : outline) {
    const Vec3 p = a.begin(), q = a.end();
    sum += .5 * (p.x * q.y - p.y * q.x) +
           .5 * a.circle.radius * a.circle.radius * (a.sweep - std::sin(a.sweep));
  }
  return sum;
}

double perimeter(const Outline& outline) {
  double sum = 0;
  for (const Arc& a : outline)
    sum += a.circle.radius * std::abs(a.sweep);
  return sum;
}

/// The circle through `point` that touches `a` and `b`. With `side` 1, the plate's upper side, it
/// contains both; with -1, the lower side, both are outside. |P - A| = R - side a, |P - B| = R -
/// side b, |P - M| = R: two differences are linear in P and R, so that the third equation is
/// quadratic in R.
Circle touching(const Circle& a, const Circle& b, const Vec3& point, double side) {
  const Vec3 u = a.centre - point, v = b.centre - point;
  // With P relative to M: u.P = (u.u - a^2) / 2 + side a R
  const double det = u.x * v.y - u.y * v.x;
  const auto solved = [&](double s, double t) {
    return Vec3{(s * v.y - t * u.y) / det, (u.x * t - v.x * s) / det, 0};
  };
  const Vec3 p = solved(.5 * (dot(u, u) - a.radius * a.radius),
                        .5 * (dot(v, v) - b.radius * b.radius)),
             q = solved(side * a.radius, side * b.radius);
  const double qa = dot(q, q) - 1, qb = 2 * dot(p, q), qc = dot(p, p);
  const double root = std::sqrt(qb * qb - 4 * qa * qc);
  for (const double r : {(-qb - root) / (2 * qa), (-qb + root) / (2 * qa)}) {
    const Circle c{point + p + r * q, r};
    if (r > std::max(a.radius, b.radius) && c.centre.y < point.y)
      return c;
  }
  return {};
}

/// The outline of the plate and the circles it consists of, in the plane x y, as the dimensions
/// define them, in m and rad.
struct Plan {
  Circle centreline, upper, lower;
  Circle hub_end, rod_end;
  std::array<Pin, 3> pins{};
  std::array<double, 3> boss_radius{};
  double hub_angle = 0, rod_angle = 0; ///< angles of the centreline's ends
  Outline outline;
  std::vector<Outline> slots;
};

void require(bool good, const std::string& what, double value, const std::string& expected) {
  if (!good)
    throw InputError("lift_arm: " + what + format(" %.4g mm: expected ", 1e3 * value) + expected);
}

/// The part of the centreline's band between two angles (first > second), rounded at its ends.
Outline slot_between(const Circle& centreline, double width, double first, double second) {
  const double half = width / 2, sweep = first - second;
  const Vec3 o = centreline.centre;
  return {{{o, centreline.radius + half}, second, sweep},
          {{on(centreline, first), half}, first, pi},
          {{o, centreline.radius - half}, first, -sweep},
          {{on(centreline, second), half}, second + pi, pi}};
}

void add_slots(Plan& plan, const LiftArm& arm) {
  const double lift_angle = plan.hub_angle + arm.lift_position * (plan.rod_angle - plan.hub_angle);
  const std::array<double, 3> at{plan.hub_angle, lift_angle, plan.rod_angle};
  // Returns the angle from a pin to the middle of the slot's rounded end.
  const auto beside = [&](std::size_t k) {
    const double chord = plan.boss_radius[k] + arm.web + arm.slot_width / 2;
    return 2 * std::asin(std::min(1., chord / (2 * plan.centreline.radius)));
  };
  for (std::size_t k = 0; k < 2; ++k) {
    const double first = at[k] - beside(k), second = at[k + 1] + beside(k + 1);
    require(
        first - second > 1e-6, "slot_width", arm.slot_width,
        std::string("a lightening hole that fits between the bosses (smaller, or 0 for none) at "
                    "lift_position") +
            format(" %.3g", arm.lift_position));
    plan.slots.push_back(slot_between(plan.centreline, arm.slot_width, first, second));
    const double wall = arm.web / 2;
    for (int i = 0; i <= 32; ++i) {
      const double angle = first + (second - first) * i / 32;
      const Vec3 high = on(plan.slots.back()[0].circle, angle),
                 low = on(plan.slots.back()[2].circle, angle);
      require(plan.upper.radius - length(high - plan.upper.centre) >= wall + arm.edge_radius &&
                  length(low - plan.lower.centre) - plan.lower.radius >= wall + arm.edge_radius,
              "slot_width", arm.slot_width,
              "at least half a web between the lightening holes and the plate's outline");
    }
  }
}

/// Refuses dimensions that are not possible.
void check_dimensions(const LiftArm& arm) {
  const std::array<std::pair<const char*, double>, 8> lengths{{{"length", arm.length},
                                                               {"rise", arm.rise},
                                                               {"depth", arm.depth},
                                                               {"thickness", arm.thickness},
                                                               {"shoulder", arm.shoulder},
                                                               {"fillet", arm.fillet},
                                                               {"web", arm.web},
                                                               {"hub bore", arm.hub.bore}}};
  for (const auto& [name, value] : lengths)
    require(value > 1e-6 && value < 100, name, value, "0.001..100000 mm");
  require(arm.rise <= arm.length / 2, "rise", arm.rise, "at most half the length");
  require(arm.slot_width >= 0, "slot_width", arm.slot_width, "0 or more");
  require(arm.edge_radius >= 0 && 2 * arm.edge_radius < .9 * arm.thickness, "edge_radius",
          arm.edge_radius, "0..0.45 of the thickness");
  if (!(arm.lift_position > 0 && arm.lift_position < 1))
    throw InputError(
        format("lift_arm: lift_position %.4g: expected between 0 and 1", arm.lift_position));
}

/// The plate's outline, counter-clockwise from where the upper arc touches the hub's end.
Outline outline_of(const Plan& plan, const Vec3& hub, const Vec3& rod) {
  const auto turn = [](double from, double to) {
    const double t = std::fmod(to - from, 2 * pi);
    return t < 0 ? t + 2 * pi : t;
  };
  const double hub_up = angle_of(hub - plan.upper.centre),
               hub_low = angle_of(plan.lower.centre - hub);
  const double rod_low = angle_of(plan.lower.centre - rod),
               rod_up = angle_of(rod - plan.upper.centre);
  return {{plan.hub_end, hub_up, turn(hub_up, hub_low)},
          {plan.lower, hub_low + pi, -turn(rod_low, hub_low)},
          {plan.rod_end, rod_low, turn(rod_low, rod_up)},
          {plan.upper, rod_up, turn(rod_up, hub_up)}};
}

/// The plan of an arm. Refuses dimensions that cannot be built.
Plan plan_of(const LiftArm& arm) {
  check_dimensions(arm);
  Plan plan;
  const double half = arm.length / 2;
  const double radius = (half * half + arm.rise * arm.rise) / (2 * arm.rise);
  plan.centreline = {{half, arm.rise - radius, 0}, radius};
  const Vec3 hub{0, 0, 0}, rod{arm.length, 0, 0};
  plan.hub_angle = angle_of(hub - plan.centreline.centre);
  plan.rod_angle = angle_of(rod - plan.centreline.centre);
  const Vec3 lift =
      on(plan.centreline, plan.hub_angle + arm.lift_position * (plan.rod_angle - plan.hub_angle));
  const std::array<LiftArm::Boss, 3> bosses{arm.hub, arm.lift_eye, arm.rod_eye};
  const std::array<Vec3, 3> centres{hub, lift, rod};
  constexpr std::array<const char*, 3> kNames{"hub", "lift_eye", "rod_eye"};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = kNames[k];
    const LiftArm::Boss& b = bosses[k];
    require(b.bore > 1e-6, name + " bore", b.bore, "above 0");
    require(b.diameter > b.bore && b.diameter < 100, name + " diameter", b.diameter,
            "more than its bore");
    require(b.width >= arm.thickness + 2.1 * arm.fillet && b.width < 100, name + " width", b.width,
            format("at least the plate's thickness and two fillets, %.4g mm",
                   1e3 * (arm.thickness + 2.1 * arm.fillet)));
    plan.pins[k] = {kNames[k], centres[k], b.bore / 2, b.width};
    plan.boss_radius[k] = b.diameter / 2;
  }
  require(arm.shoulder >= 1.05 * (arm.fillet + arm.edge_radius), "shoulder", arm.shoulder,
          format("at least the fillet and the rounded edge, %.4g mm",
                 1.05e3 * (arm.fillet + arm.edge_radius)));
  require(arm.slot_width <= 0 || arm.web >= 1.05 * arm.fillet, "web", arm.web,
          "more than the fillet");
  for (std::size_t k = 0; k < 2; ++k)
    require(length(centres[k + 1] - centres[k]) >
                plan.boss_radius[k] + plan.boss_radius[k + 1] + 2.1 * arm.fillet,
            "length", arm.length, "bosses and fillets that do not overlap");
  plan.hub_end = {hub, plan.boss_radius[0] + arm.shoulder};
  plan.rod_end = {rod, plan.boss_radius[2] + arm.shoulder};
  const Vec3 middle{half, arm.rise, 0}, deep{0, arm.depth / 2, 0};
  plan.upper = touching(plan.hub_end, plan.rod_end, middle + deep, 1);
  plan.lower = touching(plan.hub_end, plan.rod_end, middle - deep, -1);
  require(plan.upper.radius > 0 && plan.lower.radius > 0 && plan.lower.centre.y < 0 &&
              plan.upper.centre.y < 0,
          "depth", arm.depth,
          "two arcs that touch the rounded ends: use another depth or more rise");
  const double clear = plan.boss_radius[1] + 1.05 * (arm.fillet + arm.edge_radius);
  require(plan.upper.radius - length(lift - plan.upper.centre) >= clear &&
              length(lift - plan.lower.centre) - plan.lower.radius >= clear,
          "lift_eye diameter", arm.lift_eye.diameter, "a boss and fillet within the plate");
  plan.outline = outline_of(plan, hub, rod);
  if (arm.slot_width > 0)
    add_slots(plan, arm);
  return plan;
}

/// Makes a face of the CAD kernel (mm) from an outline in the plane z (m) and returns the face's
/// tag. The kernel draws the shorter of the two arcs between two points, so arcs are divided into
/// pieces of less than half a turn.
int add_face(const Outline& outline, double z) {
  using namespace gmsh::model::occ;
  constexpr double kUnit = 1 / kMillimetre;
  const auto point = [&](const Vec3& p) { return addPoint(kUnit * p.x, kUnit * p.y, kUnit * z); };
  std::vector<int> curves;
  const int first = point(outline.front().begin());
  int from = first;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Arc& arc = outline[i];
    const int centre = point(arc.circle.centre), pieces = static_cast<int>(std::abs(arc.sweep)) + 1;
    for (int k = 1; k <= pieces; ++k) {
      const bool last = i + 1 == outline.size() && k == pieces;
      const int to = last ? first : point(on(arc.circle, arc.from + arc.sweep * k / pieces));
      curves.push_back(addCircleArc(from, centre, to));
      from = to;
    }
    remove({{0, centre}});
  }
  return addPlaneSurface({addWire(curves, -1, true)});
}

/// The outline as a solid between the planes low and high, m.
gmsh::vectorpair extruded(const Outline& outline, double low, double high) {
  gmsh::vectorpair all, solids;
  gmsh::model::occ::extrude({{2, add_face(outline, low)}}, 0, 0, (high - low) / kMillimetre, all);
  for (const auto& entity : all)
    if (entity.first == 3)
      solids.push_back(entity);
  return solids;
}

/// Curves that lie in the plate's two faces: those around bosses, and those of the outline.
struct PlateCurves {
  std::vector<int> bosses, outline;
};
PlateCurves curves_of_plate(const Plan& plan, double thickness) {
  PlateCurves found;
  gmsh::vectorpair curves;
  gmsh::model::occ::getEntities(curves, 1);
  for (const auto& [dimension, tag] : curves) {
    double x = 0, y = 0, z = 0, around = 0;
    gmsh::model::occ::getCenterOfMass(1, tag, x, y, z);
    gmsh::model::occ::getMass(1, tag, around);
    const Vec3 centre = kMillimetre * Vec3{x, y, 0};
    if (std::abs(std::abs(z) * kMillimetre - thickness / 2) > 1e-6 * thickness)
      continue;
    bool boss = false;
    for (std::size_t k = 0; k < 3; ++k)
      boss |= length(centre - plan.pins[k].centre) < 1e-6 &&
              std::abs(around * kMillimetre / (2 * pi * plan.boss_radius[k]) - 1) < 1e-6;
    (boss ? found.bosses : found.outline).push_back(tag);
  }
  return found;
}

/// Rounds the curves of the only volume.
void round_curves(const std::vector<int>& curves, double radius) {
  gmsh::vectorpair volumes, rounded;
  gmsh::model::occ::getEntities(volumes, 3);
  gmsh::model::occ::fillet({volumes.at(0).second}, curves, {radius / kMillimetre}, rounded, true);
}

/// Builds the solid in gmsh's current session, mm.
void build(const LiftArm& arm) {
  const Plan plan = plan_of(arm);
  using namespace gmsh::model::occ;
  constexpr double kUnit = 1 / kMillimetre;
  gmsh::clear();
  const double t = arm.thickness;
  const auto cylinder = [](const Pin& pin, double radius, double width) {
    return std::pair{3, addCylinder(kUnit * pin.centre.x, kUnit * pin.centre.y, -kUnit * width / 2,
                                    0, 0, kUnit * width, kUnit * radius)};
  };
  gmsh::vectorpair bosses, holes, out;
  std::vector<gmsh::vectorpair> map;
  for (std::size_t k = 0; k < 3; ++k)
    bosses.push_back(cylinder(plan.pins[k], plan.boss_radius[k], plan.pins[k].width));
  fuse(extruded(plan.outline, -t / 2, t / 2), bosses, out, map);
  const PlateCurves curves = curves_of_plate(plan, t);
  if (out.size() != 1 || curves.bosses.size() != 6)
    throw InputError("lift_arm: the CAD kernel joined plate and bosses into " +
                     std::to_string(out.size()) + " solids with " +
                     std::to_string(curves.bosses.size()) + " circles, expected 1 with 6");
  round_curves(curves.bosses, arm.fillet);
  if (arm.edge_radius > 0)
    round_curves(curves_of_plate(plan, t).outline, arm.edge_radius);
  for (const Pin& pin : plan.pins)
    holes.push_back(cylinder(pin, pin.radius, 2 * pin.width));
  for (const Outline& slot : plan.slots)
    for (const auto& solid : extruded(slot, -t, t))
      holes.push_back(solid);
  gmsh::vectorpair volumes;
  getEntities(volumes, 3);
  std::erase_if(volumes, [&](const auto& v) {
    return std::find(holes.begin(), holes.end(), v) != holes.end();
  });
  cut(volumes, holes, out, map);
  synchronize();
  gmsh::vectorpair left;
  gmsh::model::getEntities(left, 3);
  if (left.size() != 1)
    throw InputError("lift_arm: the CAD kernel made " + std::to_string(left.size()) +
                     " solids, expected 1");
}

/// Discards standard output while it lives: the CAD kernel prints its transfer statistics there.
class SilentOutput {
public:
  SilentOutput() {
    std::fflush(stdout);
    const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nothing, STDOUT_FILENO);
    ::close(nothing);
  }
  ~SilentOutput() {
    std::cout.flush();
    std::fflush(stdout);
    ::dup2(saved_, STDOUT_FILENO);
    ::close(saved_);
  }
  SilentOutput(const SilentOutput&) = delete;
  SilentOutput& operator=(const SilentOutput&) = delete;

private:
  int saved_ = ::dup(STDOUT_FILENO);
};

/// A new file in the folder for temporary files; the destructor removes it.
class TemporaryFile {
public:
  explicit TemporaryFile(const std::string& ending)
      : path_((std::filesystem::temp_directory_path() / ("tactusXXXXXX" + ending)).string()) {
    const int file = ::mkstemps(path_.data(), static_cast<int>(ending.size()));
    if (file < 0)
      throw InputError("cannot write " + path_);
    ::close(file);
  }
  ~TemporaryFile() { ::unlink(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

private:
  std::string path_;
};

} // namespace

std::array<Pin, 3> pins(const LiftArm& arm) { return plan_of(arm).pins; }

void check(const LiftArm& arm) { (void)plan_of(arm); }

double volume(const LiftArm& arm) {
  const Plan plan = plan_of(arm);
  const double t = arm.thickness, f = arm.fillet, e = arm.edge_radius;
  double sum = t * area(plan.outline);
  for (const Outline& slot : plan.slots)
    sum -= t * area(slot);
  sum -= 2 * (kCornerArea * e * e * perimeter(plan.outline) - 2 * pi * kCornerMoment * e * e * e);
  for (std::size_t k = 0; k < 3; ++k) {
    const double radius = plan.boss_radius[k], bore = plan.pins[k].radius;
    sum += pi * radius * radius * (plan.pins[k].width - t) - pi * bore * bore * plan.pins[k].width +
           2 * 2 * pi * (radius * kCornerArea * f * f + kCornerMoment * f * f * f);
  }
  return sum;
}

void write_step(const std::string& path, const LiftArm& arm) {
  const SilentOutput silence;
  Session session;
  session.run("lift_arm cannot be written to " + path, [&] {
    build(arm);
    gmsh::option::setString("Geometry.OCCTargetUnit", "MM");
    gmsh::write(path);
  });
  std::error_code error;
  if (std::filesystem::file_size(path, error) == 0 || error)
    throw InputError("cannot write " + path);
}

Mesh mesh_lift_arm(const LiftArm& arm, const LoadChoice& choice) {
  const TemporaryFile file(".step");
  write_step(file.path(), arm);
  LoadChoice own = choice;
  own.unit = kMillimetre;
  own.part.clear();
  Mesh mesh = load_body(file.path(), own);
  for (const Pin& pin : pins(arm)) {
    auto& nodes = mesh.node_sets[pin.name];
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      const Vec3 d = mesh.nodes[i] - pin.centre;
      if (std::abs(std::hypot(d.x, d.y) - pin.radius) < 1e-4 * pin.radius)
        nodes.push_back(static_cast<int>(i));
    }
  }
  return mesh;
}

} // namespace tactus::fem
