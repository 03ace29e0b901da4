#include "fem/io/meta.hpp"

#include "fem/io/checksums.hpp"
#include "fem/io/text.hpp"
#include "files/json.hpp"

namespace tactus::fem {

std::string list(const std::vector<std::string>& words) {
  std::string out = "[";
  for (std::size_t i = 0; i < words.size(); ++i)
    out += (i ? ", " : "") + files::quoted_json(words[i]);
  return out + "]";
}

std::string list(std::span<const double> values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i)
    out += (i ? ", " : "") + format("%.9g", values[i]);
  return out + "]";
}

std::string json_of(const Material& m, const std::string& region) {
  std::string out = "{\"region\": " + files::quoted_json(region) +
                    ", \"name\": " + files::quoted_json(m.name) +
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
         "\"source\": " + files::quoted_json(m.source) + "}";
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

} // namespace tactus::fem
