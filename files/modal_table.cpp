#include "files/tables.hpp"

#include "files/json.hpp"
#include "files/product.hpp"
#include "files/table_arrays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <string_view>

namespace tactus::files {
namespace {

using modal::kMaxModes;
using modal::kMaxShapeSlopes;
using modal::kMaxVertices;
using modal::Material;
using modal::ModalTable;
using modal::MultipoleTable;
using modal::RawTable;
using modal::ShapeSensitivity;

constexpr double kMaxShape = 1e6;     // 1/sqrt(kg), reached by a body of one picogram
constexpr double kMaxFrequency = 1e8; // Hz
constexpr double kMaxExtent = 1e4;    // m
constexpr double kMaxDecayRate = 1e9; // 1/s

/// The three numbers of that name; zeros if the member is anything else.
std::array<double, 3> triple(const Json& object, std::string_view name) {
  std::array<double, 3> values{};
  const Json* const found = object.find(name);
  if (found && found->kind == Json::Kind::kList && found->list.size() == values.size())
    std::transform(found->list.begin(), found->list.end(), values.begin(),
                   [](const Json& x) { return x.kind == Json::Kind::kNumber ? x.number : 0; });
  return values;
}

void read_orthotropy(TableArrays& arrays, const Json& meta, Material& material) {
  const auto axis = [&](std::string_view name) {
    const auto xyz = triple(meta, name);
    return Vec3{xyz[0], xyz[1], xyz[2]};
  };
  modal::Orthotropy own{triple(meta, "E"), triple(meta, "G"), triple(meta, "nu")};
  if (meta.find("axis_1") || meta.find("axis_2")) {
    own.axis_1 = axis("axis_1");
    own.axis_2 = axis("axis_2");
  }
  if (!own.possible())
    return arrays.refuse(
        "the orthotropic material in meta is not possible: expected E, G and nu of "
        "three numbers each with a positive definite stiffness, and two axes");
  material.youngs_modulus_pa = own.youngs_modulus_pa[0];
  material.orthotropy = own;
}

void read_description(TableArrays& arrays, ModalTable& table) {
  const Json json = arrays.description("modal-table");
  if (!arrays.ok())
    return;
  table.body_name = json.text_or("body_name", "");
  if (const Json* boundary = json.find("bc")) {
    table.boundary = boundary->kind == Json::Kind::kText ? boundary->text : "held";
    const bool none =
        boundary->kind == Json::Kind::kNull ||
        ((boundary->kind == Json::Kind::kList || boundary->kind == Json::Kind::kObject) &&
         boundary->list.empty());
    if (none)
      table.boundary = "free";
  }
  table.free = table.boundary.empty() || table.boundary.starts_with("free");
  if (const Json* material = json.find("material")) {
    const Json& one = material->kind == Json::Kind::kList && !material->list.empty()
                          ? material->list.front()
                          : *material;
    table.material.name = one.text_or("name", "");
    table.material.youngs_modulus_pa = one.number_or("E", 0);
    table.material.poisson = one.number_or("nu", 0.3);
    if (const Json* moduli = one.find("E"); moduli && moduli->kind != Json::Kind::kNumber)
      read_orthotropy(arrays, one, table.material);
    table.material.density_kg_per_m3 = one.number_or("rho", 0);
  }
  if (!arrays.ok())
    return;
  const Material& m = table.material;
  if (m.youngs_modulus_pa < 0 || m.density_kg_per_m3 < 0 || m.poisson <= -1 || m.poisson >= 0.5)
    return arrays.refuse("the material in meta is not possible: expected E >= 0, rho >= 0 and "
                         "-1 < nu < 0.5");
  if (const Json* air = json.find("air")) {
    table.air_density_kg_per_m3 = air->number_or("rho", table.air_density_kg_per_m3);
    table.sound_speed_m_per_s = air->number_or("c", table.sound_speed_m_per_s);
  }
  if (!(table.air_density_kg_per_m3 > 0 && table.air_density_kg_per_m3 < 1e4) ||
      !(table.sound_speed_m_per_s > 1 && table.sound_speed_m_per_s < 1e5))
    arrays.refuse("the air in meta is not possible: expected rho in 0..1e4 kg/m^3 and c in "
                  "1..1e5 m/s");
}

void read_frequencies(TableArrays& arrays, ModalTable& table) {
  table.frequency_hz = arrays.doubles("freq", {TableArrays::kAny}, true);
  if (!arrays.ok())
    return;
  const auto& f = table.frequency_hz;
  if (f.empty())
    return arrays.refuse("it has no modes");
  if (f.size() > kMaxModes)
    return arrays.refuse("it has " + std::to_string(f.size()) + " modes: expected at most " +
                         std::to_string(kMaxModes));
  if (!(f.front() > 0) || f.back() > kMaxFrequency || !std::is_sorted(f.begin(), f.end()))
    return arrays.refuse("array 'freq': expected ascending values in 0..1e+08 Hz");
  const std::size_t modes = f.size();
  const auto rates = [&](std::string_view name, double maximum) {
    auto values = arrays.doubles(name, {modes}, false);
    if (std::any_of(values.begin(), values.end(),
                    [maximum](double x) { return x < 0 || x > maximum; }))
      arrays.refuse("array '" + std::string(name) + "' has values outside 0.." +
                    std::to_string(static_cast<long>(maximum)));
    return values;
  };
  table.decay_rate = rates("alpha", kMaxDecayRate);
  if (table.decay_rate.empty())
    table.loss_factor = rates("eta", 2);
  if (table.decay_rate.empty() && table.loss_factor.empty())
    table.loss_factor.assign(modes, 0);
  table.radiation_decay_rate = rates("alpha_rad", kMaxDecayRate);
  table.poisson_slope = arrays.doubles("dlnf_dnu", {modes}, false);
}

void read_surface(TableArrays& arrays, const NpzFile& file, ModalTable& table) {
  if (!arrays.has("phi")) // a table of frequencies only rings with unit gain everywhere
    return;
  const std::size_t modes = table.modes();
  if (const NpzArray* positions = file.find("xyz");
      positions && !positions->shape.empty() && positions->shape[0] > kMaxVertices)
    return arrays.refuse("it has more than " + std::to_string(kMaxVertices) + " vertices");
  const std::vector<double> positions = arrays.doubles("xyz", {TableArrays::kAny, 3}, true);
  const std::size_t count = positions.size() / 3;
  table.shape = arrays.floats("phi", {modes, count, 3}, true);
  const std::vector<double> corners = arrays.doubles("tri", {TableArrays::kAny, 3}, true);
  table.residual_compliance = arrays.floats("resid", {count}, false);
  if (!arrays.ok())
    return;
  if (count < 3 || corners.empty())
    return arrays.refuse("its surface is empty");
  table.vertex_m.resize(count);
  for (std::size_t v = 0; v < count; ++v)
    table.vertex_m[v] = {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]};
  if (std::any_of(positions.begin(), positions.end(),
                  [](double x) { return std::abs(x) > kMaxExtent; }))
    return arrays.refuse("array 'xyz' reaches beyond 10 km: are its units metres?");
  table.triangle.resize(corners.size() / 3);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!(corners[i] >= 0 && corners[i] < static_cast<double>(count)))
      return arrays.refuse("triangle " + std::to_string(i / 3) + " has a corner " +
                           std::to_string(static_cast<long long>(corners[i])) + " of " +
                           std::to_string(count));
    table.triangle[i / 3][i % 3] = static_cast<std::int32_t>(corners[i]);
  }
  float largest = 0;
  for (const float x : table.shape)
    largest = std::max(largest, std::abs(x));
  if (!(largest > 0) || largest > static_cast<float>(kMaxShape))
    return arrays.refuse("array 'phi': expected values up to 1e+06 1/sqrt(kg), not all zero");
  for (float& x : table.residual_compliance)
    x = std::max(x, 0.0F);
}

void read_inertia(TableArrays& arrays, ModalTable& table) {
  const std::vector<double> mass = arrays.doubles("mass", {}, arrays.has("phi"));
  const std::vector<double> centre = arrays.doubles("com", {3}, false);
  const std::vector<double> inertia = arrays.doubles("inertia", {3, 3}, false);
  if (!arrays.ok())
    return;
  if (!mass.empty()) {
    if (!(mass[0] > 0 && mass[0] < 1e9))
      return arrays.refuse("mass " + std::to_string(mass[0]) + " kg: expected more than 0");
    table.mass_kg = mass[0];
  }
  if (!centre.empty())
    table.centre_of_mass_m = {centre[0], centre[1], centre[2]};
  if (inertia.empty())
    return;
  for (std::size_t i = 0; i < 3; ++i)
    table.inertia_kg_m2[i] = {inertia[3 * i], inertia[3 * i + 1], inertia[3 * i + 2]};
  const auto& t = table.inertia_kg_m2;
  if (!(t[0].x > 0 && t[0].x * t[1].y - t[0].y * t[1].x > 0))
    arrays.refuse("array 'inertia': expected a positive definite matrix");
}

bool all_finite(const std::vector<std::complex<float>>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(),
                     [](auto x) { return std::isfinite(x.real()) && std::isfinite(x.imag()); });
}

void read_multipoles(TableArrays& arrays, ModalTable& table) {
  if (!arrays.has("mp_coef"))
    return;
  const std::size_t modes = table.modes();
  MultipoleTable& out = table.multipoles;
  for (const double degree : arrays.doubles("mp_lmax", {modes}, true))
    out.highest_degree.push_back(static_cast<std::int32_t>(std::clamp(degree, -1.0, 1000.0)));
  for (const double offset : arrays.doubles("mp_off", {modes + 1}, true))
    out.offset.push_back(static_cast<std::int64_t>(std::clamp(offset, -1.0, 1e15)));
  out.scales = arrays.doubles("mp_scales", {TableArrays::kAny}, false);
  const std::vector<double> centre = arrays.doubles("mp_center", {3}, true);
  const std::vector<double> radius = arrays.doubles("mp_rref", {}, true);
  const NpzArray* coefficients =
      arrays.ok() ? arrays.take("mp_coef", "c", {TableArrays::kAny}) : nullptr;
  if (!coefficients)
    return;
  if (out.scales.empty())
    out.scales = {1};
  for (std::size_t k = 0; k < modes; ++k) {
    const std::int64_t degree = out.highest_degree[k];
    if (degree < 0 || degree > 200 || out.offset[0] != 0 ||
        out.offset[k + 1] - out.offset[k] != (degree + 1) * (degree + 1))
      return arrays.refuse("the multipoles of mode " + std::to_string(k) +
                           " do not fit mp_lmax and mp_off");
  }
  const auto waves = static_cast<std::uint64_t>(out.offset[modes]);
  if (product(waves, out.scales.size()) != coefficients->count())
    return arrays.refuse("array 'mp_coef' has " + std::to_string(coefficients->count()) +
                         " numbers: expected " + std::to_string(waves) + " for each of " +
                         std::to_string(out.scales.size()) + " scales");
  for (std::size_t s = 0; s < out.scales.size(); ++s)
    if (!(out.scales[s] > 0) || (s > 0 && out.scales[s] <= out.scales[s - 1]))
      return arrays.refuse("array 'mp_scales': expected ascending values above 0");
  out.coefficients = coefficients->single_complex_values();
  if (!all_finite(out.coefficients))
    return arrays.refuse("array 'mp_coef': not a finite number");
  out.centre = {centre[0], centre[1], centre[2]};
  out.reference_radius_m = radius[0];
  if (!(radius[0] > 0))
    arrays.refuse("mp_rref: expected more than 0 m");
}

/// Reads the waves at the frequencies common to all modes.
void read_band(TableArrays& arrays, ModalTable& table) {
  if (!arrays.has("mp_band_coef"))
    return;
  const std::size_t modes = table.modes();
  MultipoleTable::Band out;
  out.frequency_hz = arrays.doubles("mp_band_freq", {TableArrays::kAny}, true);
  for (const double degree : arrays.doubles("mp_band_lmax", {modes}, true))
    out.highest_degree.push_back(static_cast<std::int32_t>(std::clamp(degree, -1.0, 1000.0)));
  for (const double offset : arrays.doubles("mp_band_off", {modes + 1}, true))
    out.offset.push_back(static_cast<std::int64_t>(std::clamp(offset, -1.0, 1e15)));
  const NpzArray* coefficients =
      arrays.ok() ? arrays.take("mp_band_coef", "c", {TableArrays::kAny}) : nullptr;
  if (!coefficients)
    return;
  for (std::size_t k = 0; k < modes; ++k) {
    const std::int64_t degree = out.highest_degree[k];
    if (degree < 0 || degree > 200 || out.offset[0] != 0 ||
        out.offset[k + 1] - out.offset[k] != (degree + 1) * (degree + 1))
      return arrays.refuse("the multipoles of mode " + std::to_string(k) +
                           " do not fit mp_band_lmax and mp_band_off");
  }
  for (std::size_t f = 0; f < out.frequency_hz.size(); ++f)
    if (!(out.frequency_hz[f] > 0) || (f > 0 && out.frequency_hz[f] <= out.frequency_hz[f - 1]))
      return arrays.refuse("array 'mp_band_freq': expected ascending values above 0");
  const auto waves = static_cast<std::uint64_t>(out.offset[modes]);
  if (out.frequency_hz.size() < 4 ||
      product(waves, out.frequency_hz.size()) != coefficients->count())
    return arrays.refuse("array 'mp_band_coef' has " + std::to_string(coefficients->count()) +
                         " numbers: expected " + std::to_string(waves) + " at each of " +
                         std::to_string(out.frequency_hz.size()) + " frequencies, 4 or more");
  out.coefficients = coefficients->single_complex_values();
  if (!all_finite(out.coefficients))
    return arrays.refuse("array 'mp_band_coef': not a finite number");
  table.multipoles.band = std::move(out);
}

void read_raw(TableArrays& arrays, const NpzFile& file, ModalTable& table) {
  const NpzArray* array = file.find("raw_v");
  if (!array || !arrays.ok())
    return;
  if (array->shape.size() != 3 || array->count() == 0)
    return arrays.refuse("array 'raw_v': expected the shape hits x points x samples");
  RawTable& out = table.raw;
  out.hits = array->shape[0];
  out.points = array->shape[1];
  out.samples = array->shape[2];
  out.velocity_m_per_s = arrays.floats("raw_v", {out.hits, out.points, out.samples}, true);
  const auto positions = arrays.doubles("raw_xyz", {out.points, 3}, true);
  const auto hits = arrays.doubles("raw_hit", {out.hits, 3}, true);
  out.area_m2 = arrays.doubles("raw_ds", {out.points}, true);
  const auto rate = arrays.doubles("raw_fs", {}, true);
  if (!arrays.ok())
    return;
  for (std::size_t p = 0; p < out.points; ++p)
    out.position_m.push_back({positions[3 * p], positions[3 * p + 1], positions[3 * p + 2]});
  for (std::size_t h = 0; h < out.hits; ++h)
    out.hit_m.push_back({hits[3 * h], hits[3 * h + 1], hits[3 * h + 2]});
  out.sample_rate_hz = rate[0];
  if (!(rate[0] >= 1000 && rate[0] <= 1e6))
    arrays.refuse("raw_fs " + std::to_string(rate[0]) + " Hz: expected 1000..1000000");
}

void read_sensitivity(TableArrays& arrays, const NpzFile& file, ModalTable& table) {
  if (!arrays.has("domega2_dp"))
    return;
  ShapeSensitivity& out = table.sensitivity;
  read_shape_parameters(arrays, file, out.shape);
  if (!arrays.ok())
    return;
  const std::size_t modes = table.modes(), parameters = out.parameters();
  if (parameters > kMaxShapeSlopes / modes)
    return arrays.refuse("it has " + std::to_string(parameters) + " shape parameters for " +
                         std::to_string(modes) + " modes: expected at most " +
                         std::to_string(kMaxShapeSlopes / modes));
  out.eigenvalue_slope = arrays.doubles("domega2_dp", {parameters, modes}, true);
  out.solved_at_m = arrays.doubles("displacement", {parameters}, false);
  for (std::size_t p = 0; p < parameters && arrays.ok(); ++p) {
    const design::DesignParameter& range = out.shape.parameters[p];
    if (out.solved_at(p) < range.low_m || out.solved_at(p) > range.high_m)
      arrays.refuse("array 'displacement' is outside the bounds of parameter " + std::to_string(p));
  }
}

} // namespace

std::string read_modal_table(std::span<const std::byte> file, ModalTable& table) {
  NpzFile archive;
  if (std::string refusal = archive.open(file); !refusal.empty())
    return refusal;
  TableArrays arrays(archive);
  ModalTable read;
  read_description(arrays, read);
  if (arrays.ok())
    read_frequencies(arrays, read);
  if (arrays.ok())
    read_surface(arrays, archive, read);
  if (arrays.ok())
    read_inertia(arrays, read);
  if (arrays.ok())
    read_multipoles(arrays, read);
  if (arrays.ok() && !read.multipoles.empty())
    read_band(arrays, read);
  read_raw(arrays, archive, read);
  if (arrays.ok())
    read_sensitivity(arrays, archive, read);
  read.has_mesh = !read.sensitivity.empty() && arrays.has("mesh");
  if (!arrays.ok())
    return arrays.refusal();
  table = std::move(read);
  return {};
}

} // namespace tactus::files
