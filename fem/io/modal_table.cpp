#include "fem/io/modal_table.hpp"

#include "fem/io/checksums.hpp"
#include "fem/io/npz.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/surface.hpp"

#include <numbers>

namespace tactus::fem {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += '\\';
    if (static_cast<unsigned char>(c) < 32)
      out += format("\\u%04x", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string list(std::span<const double> values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i)
    out += (i ? ", " : "") + format("%.9g", values[i]);
  return out + "]";
}

std::string json_of(const Material& m, const std::string& region) {
  std::string out = "{\"region\": " + quoted(region) + ", \"name\": " + quoted(m.name) +
                    format(", \"rho\": %.9g", m.density);
  if (m.isotropic())
    out += format(", \"E\": %.9g, \"nu\": %.9g", m.young_pa[0], m.poisson[0]);
  else
    out += ", \"E\": " + list(m.young_pa) + ", \"G\": " + list(m.shear_pa) +
           ", \"nu\": " + list(m.poisson) +
           ", \"axis_1\": " + list(std::array{m.axis_1.x, m.axis_1.y, m.axis_1.z}) +
           ", \"axis_2\": " + list(std::array{m.axis_2.x, m.axis_2.y, m.axis_2.z});
  return out +
         format(", \"eta\": %.9g, \"rayleigh_a\": %.9g, \"rayleigh_b\": %.9g, ", m.loss_factor,
                m.rayleigh_a, m.rayleigh_b) +
         "\"source\": " + quoted(m.source) + "}";
}

std::string mesh_hash(const Mesh& mesh) {
  std::vector<std::byte> bytes;
  const auto add = [&](const auto& values) {
    const auto raw = std::as_bytes(std::span(values));
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  };
  static_assert(sizeof(Vector3) == 3 * sizeof(double));
  add(mesh.nodes);
  add(mesh.connectivity);
  return sha256(bytes);
}

std::string meta_of(const ModalTable& t) {
  const TableNotes& notes = t.notes;
  std::string out =
      "{\"format\": \"modal-table\", \"version\": \"1.0\", \"generator\": \"tactus modal_fem\"";
  if (!notes.created.empty())
    out += ", \"created\": " + quoted(notes.created);
  out += ", \"units\": \"SI\", \"body_name\": " + quoted(notes.body_name) +
         ", \"mesh_sha256\": \"" + mesh_hash(t.mesh) + "\"" +
         format(", \"n_nodes\": %zu, \"n_elements\": %zu, \"dofs\": %zu", t.mesh.nodes.size(),
                t.mesh.elements.size(), t.mesh.dofs()) +
         ", \"element\": " + quoted(t.mesh.element_names()) +
         ", \"material\": " + json_of(t.materials[0], t.mesh.regions[0]) + ", \"materials\": [";
  for (std::size_t i = 0; i < t.materials.size(); ++i)
    out += (i ? ", " : "") + json_of(t.materials[i], t.mesh.regions[i]);
  out += "], \"bc\": " + quoted(notes.support) + format(", \"rigid_modes\": %zu", t.modes.rigid) +
         format(", \"air\": {\"rho\": %.9g, \"c\": %.9g}", notes.air_density, notes.air_speed) +
         ", \"accuracy\": {\"est_rel_error\": " + list(notes.relative_error) + "}" +
         ", \"license\": \"of the body's author\"}";
  return out;
}

} // namespace

double decay_time(double frequency_hz, double loss_factor) noexcept {
  return 3 * std::numbers::ln10 / (std::numbers::pi * frequency_hz * loss_factor);
}

void write_table(const std::string& path, const ModalTable& t) {
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
  if (const ShapeDerivatives& shape = t.shape; !shape.parameters.empty()) {
    std::vector<double> points, rows;
    for (const Vector3& p : shape.control_points)
      points.insert(points.end(), {p.x, p.y, p.z});
    for (const auto& [control, axis, low, high] : shape.parameters)
      rows.insert(rows.end(), {static_cast<double>(control), static_cast<double>(axis), low, high});
    npz.add("control_points", points, {shape.control_points.size(), 3});
    npz.add("parameters", rows, {shape.parameters.size(), 4});
    npz.add("trust", std::span(&shape.trust, 1), {});
    npz.add("domega2_dp", shape.by_parameter, {shape.parameters.size(), modes});
  }
  if (const ModeRadiation& r = t.radiation; !r.empty()) {
    const std::array<double, 3> middle{r.centre.x, r.centre.y, r.centre.z};
    npz.add("alpha_rad", r.decay_rate, {modes});
    npz.add("mp_lmax", r.highest_degree, {modes});
    npz.add("mp_off", r.offset, {modes + 1});
    npz.add("mp_scales", r.ratios, {r.ratios.size()});
    npz.add("mp_coef", r.coefficients, {r.coefficients.size()});
    npz.add("mp_center", middle, {3});
    npz.add("mp_rref", std::span(&r.reference_radius, 1), {});
    if (const ModeRadiation::Band& band = r.band; !band.frequency_hz.empty()) {
      npz.add("mp_band_freq", band.frequency_hz, {band.frequency_hz.size()});
      npz.add("mp_band_lmax", band.highest_degree, {modes});
      npz.add("mp_band_off", band.offset, {modes + 1});
      npz.add("mp_band_coef", band.coefficients, {band.coefficients.size()});
    }
  }
  npz.write(path);
}

void write_csv(const std::string& path, const ModalTable& t) {
  SafeFile file(path);
  file.write(
      "mode,frequency_hz,multiplicity,loss_factor,t60_s,estimated_relative_error,residual\n");
  for (std::size_t k = 0; k < t.modes.frequency_hz.size(); ++k) {
    const double f = t.modes.frequency_hz[k];
    const std::string error =
        k < t.notes.relative_error.size() ? format("%.3g", t.notes.relative_error[k]) : "";
    file.write(format("%zu,%.6f,%d,%.4g,%.5g,%s,%.2g\n", k + 1, f, t.modes.multiplicity[k],
                      t.loss[k], decay_time(f, t.loss[k]), error.c_str(), t.modes.residual[k]));
  }
  file.commit();
}

void write_vtu(const std::string& path, const Mesh& mesh, const Modes& modes, std::size_t count) {
  SafeFile file(path);
  count = std::min(count, modes.frequency_hz.size());
  file.write("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
             "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n");
  file.write(format("<Piece NumberOfPoints=\"%zu\" NumberOfCells=\"%zu\">\n<Points>\n"
                    "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
                    mesh.nodes.size(), mesh.elements.size()));
  for (const Vector3& p : mesh.nodes)
    file.write(format("%.9g %.9g %.9g\n", p.x, p.y, p.z));
  file.write("</DataArray>\n</Points>\n<Cells>\n"
             "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n");
  for (const Element& e : mesh.elements) {
    std::string line;
    for (const int node : mesh.nodes_of(e))
      line += std::to_string(node) + ' ';
    file.write(line + "\n");
  }
  file.write("</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n");
  std::size_t end = 0;
  for (const Element& e : mesh.elements)
    file.write(std::to_string(end += static_cast<std::size_t>(node_count(e.shape))) + "\n");
  file.write("</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  for (const Element& e : mesh.elements)
    file.write(std::to_string(vtk_type(e.shape)) + "\n");
  file.write("</DataArray>\n</Cells>\n<CellData>\n"
             "<DataArray type=\"Int32\" Name=\"region\" format=\"ascii\">\n");
  for (const Element& e : mesh.elements)
    file.write(std::to_string(e.region) + "\n");
  file.write("</DataArray>\n</CellData>\n<PointData>\n");
  for (std::size_t k = 0; k < count; ++k) {
    file.write(format("<DataArray type=\"Float32\" Name=\"mode %02zu %.1f Hz\" "
                      "NumberOfComponents=\"3\" format=\"ascii\">\n",
                      k + 1, modes.frequency_hz[k]));
    const double* u = &modes.shapes[k * mesh.dofs()];
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
      file.write(format("%.6g %.6g %.6g\n", u[3 * i], u[3 * i + 1], u[3 * i + 2]));
    file.write("</DataArray>\n");
  }
  file.write("</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
  file.commit();
}

} // namespace tactus::fem
