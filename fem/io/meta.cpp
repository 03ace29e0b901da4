#include "fem/io/meta.hpp"

#include "fem/io/text.hpp"
#include "files/json.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace tactus::fem {
namespace {

/// The first 32 bits of the fractional parts of roots of the first primes: the standard's
/// constants.
std::array<std::uint32_t, 64> prime_roots(bool cube, std::size_t count) {
  std::array<std::uint32_t, 64> words{};
  std::uint64_t found = 0;
  for (std::uint64_t p = 2; found < count; ++p) {
    bool prime = true;
    for (std::uint64_t d = 2; d * d <= p; ++d)
      prime = prime && p % d != 0;
    if (!prime)
      continue;
    const long double root =
        cube ? std::cbrt(static_cast<long double>(p)) : std::sqrt(static_cast<long double>(p));
    words[found++] = static_cast<std::uint32_t>((root - std::floor(root)) * 4294967296.0L);
  }
  return words;
}

} // namespace

std::string sha256(std::span<const std::byte> bytes) {
  static const auto k = prime_roots(true, 64);
  auto h = prime_roots(false, 8);
  std::vector<std::byte> text(bytes.begin(), bytes.end());
  const std::uint64_t bits = 8 * static_cast<std::uint64_t>(bytes.size());
  text.push_back(std::byte{0x80});
  while (text.size() % 64 != 56)
    text.push_back(std::byte{0});
  for (int i = 7; i >= 0; --i)
    text.push_back(static_cast<std::byte>(bits >> (8 * i)));
  for (std::size_t block = 0; block < text.size(); block += 64) {
    std::array<std::uint32_t, 64> w{};
    for (std::size_t i = 0; i < 64; ++i)
      if (i < 16)
        for (std::size_t b = 0; b < 4; ++b)
          w[i] = w[i] << 8 | static_cast<std::uint32_t>(text[block + 4 * i + b]);
      else
        w[i] = w[i - 16] + w[i - 7] +
               (std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ w[i - 15] >> 3) +
               (std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ w[i - 2] >> 10);
    std::array<std::uint32_t, 8> v{};
    for (std::size_t i = 0; i < 8; ++i)
      v[i] = h[i];
    for (std::size_t i = 0; i < 64; ++i) {
      const std::uint32_t e = v[4], a = v[0];
      const std::uint32_t t1 = v[7] + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) +
                               ((e & v[5]) ^ (~e & v[6])) + k[i] + w[i];
      const std::uint32_t t2 = (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) +
                               ((a & v[1]) ^ (a & v[2]) ^ (v[1] & v[2]));
      v = {t1 + t2, v[0], v[1], v[2], v[3] + t1, v[4], v[5], v[6]};
    }
    for (std::size_t i = 0; i < 8; ++i)
      h[i] += v[i];
  }
  std::string hex;
  for (std::size_t i = 0; i < 8; ++i)
    for (int shift = 28; shift >= 0; shift -= 4)
      hex += "0123456789abcdef"[h[i] >> shift & 15];
  return hex;
}

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
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  add(mesh.nodes);
  add(mesh.connectivity);
  return sha256(bytes);
}

std::string meta_head(const MetaHead& h, const Mesh& mesh, std::span<const Material> materials) {
  std::string out =
      format("{\"format\": \"%s\", \"version\": \"1.0\", \"generator\": \"tactus %s\"", h.format,
             h.program);
  if (!h.created.empty())
    out += ", \"created\": " + files::quoted_json(h.created);
  out += format(", \"units\": %s, \"%s\": ", h.units, h.name) + files::quoted_json(h.body_name) +
         ", \"mesh_sha256\": \"" + mesh_hash(mesh) + "\"" +
         format(", \"n_nodes\": %zu, \"n_elements\": %zu, \"dofs\": %zu", mesh.nodes.size(),
                mesh.elements.size(), mesh.dofs()) +
         ", \"element\": " + files::quoted_json(mesh.element_names()) +
         ", \"material\": " + json_of(materials[0], mesh.regions[0]) + ", \"materials\": [";
  for (std::size_t i = 0; i < materials.size(); ++i)
    out += (i ? ", " : "") + json_of(materials[i], mesh.regions[i]);
  return out;
}

std::vector<double> coordinates(std::span<const Vec3> points) {
  std::vector<double> out;
  for (const Vec3& p : points)
    out.insert(out.end(), {p.x, p.y, p.z});
  return out;
}

} // namespace tactus::fem
