#include "fem/io/inp_materials.hpp"

#include "fem/io/text.hpp"

namespace tactus::fem {
namespace {

/// The file's unit of force in newtons: with inches the pound-force, with micrometres the
/// micronewton.
double force_n(double unit) {
  constexpr double kInch = 25.4e-3, kMicrometre = 1e-6;
  return unit == kInch ? 4.4482216152605 : unit == kMicrometre ? 1e-6 : 1;
}

/// Computes moduli and ratios from the stiffness D of the normal strains. The inverse of D has 1 /
/// E_i on its diagonal and -nu_ij / E_i beside the diagonal.
void take_stiffness(Material& m, const std::array<Vec3, 3>& d) {
  const double determinant = dot(d[0], cross(d[1], d[2]));
  const std::array<Vec3, 3> s{(1 / determinant) * cross(d[1], d[2]),
                              (1 / determinant) * cross(d[2], d[0]),
                              (1 / determinant) * cross(d[0], d[1])};
  m.young_pa = {1 / s[0].x, 1 / s[1].y, 1 / s[2].z};
  m.poisson = {-s[1].z / s[1].y, -s[0].z / s[0].x, -s[0].y / s[0].x};
}

std::string compact(const std::string& text) {
  std::string out = lower(text);
  std::erase(out, ' ');
  return out;
}

} // namespace

Vec3 InpMaterials::turned(const Vec3& direction) const {
  return turn_ ? turn_(direction) : direction;
}

InpMaterials::Definition& InpMaterials::last_material() {
  const auto at = materials_.find(last_material_);
  if (at == materials_.end())
    lines_.refuse("expected *MATERIAL before it");
  return at->second;
}

double InpMaterials::constant(const std::string& cell, double scale, double low, double high,
                              const char* quantity) const {
  const double value = scale * lines_.number(cell);
  if (!(value >= low && value <= high))
    lines_.refuse(
        printable(cell, 60) +
        format(" is %.4g %s with lengths of %g m and the force of %g N, expected %g to %g:"
               " --unit is the unit of the file's lengths",
               value, quantity, unit_, force_n(unit_), low, high));
  return value;
}

void InpMaterials::begin_material(const InpKeyword& keyword) {
  last_material_ = lower(keyword.value("name"));
  Definition fresh;
  fresh.material = {.name = keyword.value("name"), .density = 0, .source = lines_.path()};
  fresh.line = keyword.line;
  if (last_material_.empty())
    lines_.refuse(keyword.words + ": expected NAME=", keyword.line);
  if (!materials_.try_emplace(last_material_, fresh).second)
    lines_.refuse("material " + keyword.value("name") + " is defined twice", keyword.line);
}

void InpMaterials::begin_elastic(const InpKeyword& keyword) {
  (void)last_material();
  const std::string type = compact(keyword.value("type"));
  type_ = type == "engineeringconstants" ? Constants::engineering
          : type.starts_with("ortho")    ? Constants::stiffness
                                         : Constants::isotropic;
  if (type_ == Constants::isotropic && !type.empty() && type != "iso" && type != "isotropic")
    lines_.refuse(keyword.words + " TYPE=" + printable(keyword.value("type"), 40) +
                      ": expected ISO, ORTHO or ENGINEERING CONSTANTS",
                  keyword.line);
  constants_.clear();
}

void InpMaterials::add_elastic() {
  Definition& definition = last_material();
  const auto cells = lines_.cells();
  constants_.insert(constants_.end(), cells.begin(), cells.end());
  const std::size_t needed = type_ == Constants::isotropic ? 2 : 9;
  if (needed == 9 && constants_.size() == 8)
    return; // the ninth constant is on a separate line
  if (definition.elastic || constants_.size() < needed || constants_.size() > needed + 1)
    lines_.refuse(format("expected %zu elastic constants, of one temperature", needed));
  Material& m = definition.material;
  const double pressure = force_n(unit_) / (unit_ * unit_);
  const auto modulus = [&](std::size_t i) {
    return constant(constants_[i], pressure, 1e6, 1e13, "Pa");
  };
  const auto ratio = [&](std::size_t i) { return lines_.number(constants_[i]); };
  if (type_ == Constants::isotropic) {
    m.young_pa = {modulus(0), 0, 0};
    m.poisson = {ratio(1), 0, 0};
  } else if (type_ == Constants::engineering) {
    m.young_pa = {modulus(0), modulus(1), modulus(2)};
    m.poisson = {ratio(5), ratio(4), ratio(3)};
    m.shear_pa = {modulus(8), modulus(7), modulus(6)};
  } else {
    const auto beside = [&](std::size_t i) { return pressure * ratio(i); }; // ratios may have any
                                                                            // sign
    take_stiffness(m, {Vec3{modulus(0), beside(1), beside(3)},
                       {beside(1), modulus(2), beside(4)},
                       {beside(3), beside(4), modulus(5)}});
    m.shear_pa = {modulus(8), modulus(7), modulus(6)};
    if (!(m.young_pa[0] > 0 && m.young_pa[1] > 0 && m.young_pa[2] > 0))
      lines_.refuse("the elastic constants of " + m.name +
                    " are unstable, expected a positive definite matrix");
  }
  definition.elastic = true;
}

void InpMaterials::add_density() {
  Material& m = last_material().material;
  const auto cells = lines_.cells();
  if (m.density > 0 || cells.empty() || cells.size() > 2)
    lines_.refuse("expected one density, of one temperature");
  m.density = constant(cells[0], force_n(unit_) / std::pow(unit_, 4), 1, 1e5, "kg/m^3");
}

void InpMaterials::begin_damping(const InpKeyword& keyword) {
  Material& m = last_material().material;
  const bool structural = keyword.has("structural");
  if (structural == (keyword.has("alpha") || keyword.has("beta")))
    lines_.refuse(keyword.words + ": expected STRUCTURAL=, or ALPHA= and BETA=", keyword.line);
  const auto value = [&](const char* name) {
    return keyword.has(name) ? lines_.number(keyword.value(name)) : 0;
  };
  m.loss_factor = value("structural");
  m.rayleigh_a = value("alpha");
  m.rayleigh_b = value("beta");
}

void InpMaterials::begin_orientation(const InpKeyword& keyword) {
  const std::string system = compact(keyword.value("system"));
  const std::string definition = compact(keyword.value("definition"));
  if (!system.empty() && system != "rectangular" && system != "r")
    lines_.refuse(keyword.words + " SYSTEM=" + printable(system, 40) + ": expected RECTANGULAR",
                  keyword.line);
  if (!definition.empty() && definition != "coordinates")
    lines_.refuse(keyword.words + " DEFINITION=" + printable(definition, 40) +
                      ": expected COORDINATES",
                  keyword.line);
  last_orientation_ = lower(keyword.value("name"));
}

void InpMaterials::add_orientation() {
  const auto cells = lines_.cells();
  if (orientations_.contains(last_orientation_) || (cells.size() != 6 && cells.size() != 9))
    lines_.refuse("expected one line with a point on axis 1, a point beside it towards axis 2 and, "
                  "if given, their origin: 6 or 9 numbers");
  std::array<Vec3, 3> points{};
  for (std::size_t i = 0; i < cells.size(); ++i)
    points[i / 3][static_cast<int>(i % 3)] = lines_.number(cells[i]);
  orientations_[last_orientation_] = {turned(points[0] - points[2]), turned(points[1] - points[2])};
}

void InpMaterials::begin_section(const InpKeyword& keyword) {
  sections_.push_back({keyword.value("elset"),
                       keyword.value("material"),
                       keyword.value("orientation"),
                       {turned({1, 0, 0}), turned({0, 1, 0})},
                       keyword.line});
  if (sections_.back().elements.empty() || sections_.back().material.empty())
    lines_.refuse(keyword.words + ": expected ELSET= and MATERIAL=", keyword.line);
}

void InpMaterials::add_thickness() {
  const auto cells = lines_.cells();
  if (cells.size() > 1 || (!cells.empty() && !to_number(cells[0])))
    lines_.refuse(printable(lines_.text(), 60) +
                  ": expected no data, since a solid has no thickness");
}

Material InpMaterials::material_of(const Section& section) const {
  const auto at = materials_.find(lower(section.material));
  if (at == materials_.end())
    lines_.refuse("unknown material " + printable(section.material, 60), section.line);
  if (!at->second.elastic)
    lines_.refuse("material " + at->second.material.name + " has no *ELASTIC", at->second.line);
  Material material = at->second.material;
  material.axis_1 = section.axes[0];
  material.axis_2 = section.axes[1];
  if (section.orientation.empty())
    return material;
  const auto axes = orientations_.find(lower(section.orientation));
  if (axes == orientations_.end())
    lines_.refuse("unknown orientation " + printable(section.orientation, 60), section.line);
  material.axis_1 = axes->second[0];
  material.axis_2 = axes->second[1];
  return material;
}

} // namespace tactus::fem
