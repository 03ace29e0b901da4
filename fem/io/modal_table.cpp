#include "fem/io/modal_table.hpp"

#include "fem/io/mesh_bytes.hpp"
#include "fem/io/meta.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/io/vtu.hpp"
#include "fem/mesh/surface.hpp"
#include "files/json.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {
namespace {

std::string meta_of(const ModalTable& t) {
  const TableMetadata& metadata = t.metadata;
  std::string out = meta_head(
      {"modal-table", "modal_fem", "\"SI\"", "body_name", metadata.created, metadata.body_name},
      t.mesh, t.materials);
  out +=
      "], \"bc\": " + files::quoted_json(metadata.support) +
      format(", \"rigid_modes\": %zu", t.modes.rigid) +
      format(", \"air\": {\"rho\": %.9g, \"c\": %.9g}", metadata.air_density, metadata.air_speed) +
      ", \"accuracy\": {\"est_rel_error\": " + list(metadata.relative_error) + "}" +
      (metadata.command.empty() ? "" : ", \"command\": " + list(metadata.command)) +
      ", \"license\": \"of the body's author\"}";
  return out;
}

} // namespace

double decay_time(double frequency_hz, double loss_factor) noexcept {
  return 3 * std::numbers::ln10 / (std::numbers::pi * frequency_hz * loss_factor);
}

namespace {

void add_shape(NpzWriter& npz, const ShapeDerivatives& shape, std::size_t modes) {
  std::vector<double> rows;
  for (const auto& [control, axis, low, high] : shape.parameters)
    rows.insert(rows.end(), {static_cast<double>(control), static_cast<double>(axis), low, high});
  npz.add("control_points", coordinates(shape.control_points), {shape.control_points.size(), 3});
  npz.add("parameters", rows, {shape.parameters.size(), 4});
  npz.add("trust", std::span(&shape.trust, 1), {});
  npz.add("domega2_dp", shape.by_parameter, {shape.parameters.size(), modes});
  if (!shape.displacement.empty())
    npz.add("displacement", shape.displacement, {shape.parameters.size()});
}

void add_radiation(NpzWriter& npz, const ModeRadiation& r, std::size_t modes) {
  const std::array<double, 3> middle{r.centre.x, r.centre.y, r.centre.z};
  npz.add("alpha_rad", r.decay_rate, {modes});
  npz.add("mp_lmax", r.max_degree, {modes});
  npz.add("mp_off", r.offset, {modes + 1});
  npz.add("mp_scales", r.ratios, {r.ratios.size()});
  npz.add("mp_coef", r.coefficients, {r.coefficients.size()});
  npz.add("mp_center", middle, {3});
  npz.add("mp_rref", std::span(&r.reference_radius, 1), {});
  if (const ModeRadiation::Band& band = r.band; !band.frequency_hz.empty()) {
    npz.add("mp_band_freq", band.frequency_hz, {band.frequency_hz.size()});
    npz.add("mp_band_lmax", band.max_degree, {modes});
    npz.add("mp_band_off", band.offset, {modes + 1});
    npz.add("mp_band_coef", band.coefficients, {band.coefficients.size()});
  }
}

NpzWriter arrays_of(const ModalTable& t) {
  const Surface skin = surface_of(t.mesh);
  const std::size_t n = t.mesh.dofs(), modes = t.modes.frequency_hz.size();
  const std::size_t vertices = skin.node.size();
  std::vector<float> phi(modes * vertices * 3), xyz(vertices * 3);
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto node = static_cast<std::size_t>(skin.node[v]);
    for (std::size_t i = 0; i < 3; ++i) {
      xyz[3 * v + i] = static_cast<float>(t.mesh.nodes[node][static_cast<int>(i)]);
      for (std::size_t k = 0; k < modes; ++k)
        phi[(k * vertices + v) * 3 + i] = static_cast<float>(t.modes.shapes[k * n + 3 * node + i]);
    }
  }
  std::vector<std::int32_t> triangles;
  for (const auto& triangle : skin.triangles)
    triangles.insert(triangles.end(), triangle.begin(), triangle.end());
  const std::vector<std::int32_t> multiplicity(t.modes.multiplicity.begin(),
                                               t.modes.multiplicity.end());
  const std::string meta = meta_of(t);
  const std::vector<std::uint8_t> meta_bytes(meta.begin(), meta.end());
  const double mass = t.body.mass;
  const std::array<double, 3> centre{t.body.centre.x, t.body.centre.y, t.body.centre.z};

  NpzWriter npz;
  npz.add("meta", meta_bytes, {meta_bytes.size()});
  npz.add("freq", t.modes.frequency_hz, {modes});
  npz.add("phi", phi, {modes, vertices, 3});
  npz.add("xyz", xyz, {vertices, 3});
  npz.add("tri", triangles, {skin.triangles.size(), 3});
  npz.add("mult", multiplicity, {modes});
  npz.add("eta", t.loss, {modes});
  npz.add("mass", std::span(&mass, 1), {});
  npz.add("com", centre, {3});
  npz.add("inertia", t.body.inertia, {3, 3});
  if (!t.poisson_slope.empty())
    npz.add("dlnf_dnu", t.poisson_slope, {modes});
  if (!t.residual.empty())
    npz.add("resid", t.residual, {vertices});
  if (!t.shape.parameters.empty())
    add_shape(npz, t.shape, modes);
  if (!t.radiation.empty())
    add_radiation(npz, t.radiation, modes);
  return npz;
}

} // namespace

void write_table(const std::string& path, const ModalTable& t) {
  NpzWriter npz = arrays_of(t);
  if (!t.shape.parameters.empty() && !t.metadata.command.empty()) {
    const std::string mesh = to_bytes(t.mesh);
    npz.add_bytes("mesh", "|u1", std::as_bytes(std::span(mesh)), {mesh.size()});
  }
  write_npz(path, npz);
}

std::string table_bytes(const ModalTable& t) { return npz_bytes(arrays_of(t)); }

void write_csv(const std::string& path, const ModalTable& t) {
  SafeFile file(path);
  file.write(
      "mode,frequency_hz,multiplicity,loss_factor,t60_s,estimated_relative_error,residual\n");
  for (std::size_t k = 0; k < t.modes.frequency_hz.size(); ++k) {
    const double f = t.modes.frequency_hz[k];
    const std::string error =
        k < t.metadata.relative_error.size() ? format("%.3g", t.metadata.relative_error[k]) : "";
    file.write(format("%zu,%.6f,%d,%.4g,%.5g,%s,%.2g\n", k + 1, f, t.modes.multiplicity[k],
                      t.loss[k], decay_time(f, t.loss[k]), error.c_str(), t.modes.residual[k]));
  }
  file.commit();
}

void write_vtu(const std::string& path, const Mesh& mesh, const Modes& modes, std::size_t count) {
  std::vector<VtuField> shapes;
  for (std::size_t k = 0; k < std::min(count, modes.frequency_hz.size()); ++k)
    shapes.push_back({format("mode %02zu %.1f Hz", k + 1, modes.frequency_hz[k]), 3,
                      std::span(modes.shapes).subspan(k * mesh.dofs(), mesh.dofs())});
  write_vtu(path, mesh, shapes, {});
}

} // namespace tactus::fem
