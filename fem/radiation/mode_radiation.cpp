#include "fem/radiation/mode_radiation.hpp"

#include "fem/io/text.hpp"
#include "fem/radiation/spherical_waves.hpp"

#include <algorithm>
#include <chrono>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr double kSameFrequency = 1e-3;
constexpr double kTailPowerShare =
    1e-6; // share of the power's sum at the reference sphere in the tail

/// Vertices of the outer skin as mesh nodes: outer_skin keeps the order of surface_of.
std::vector<Vector3> motion(const Modes& modes, std::size_t k, const Mesh& mesh,
                            std::span<const int> node) {
  std::vector<Vector3> v;
  v.reserve(node.size());
  for (const int i : node) {
    const double* u = &modes.shapes[k * mesh.dofs() + 3 * static_cast<std::size_t>(i)];
    v.push_back({u[0], u[1], u[2]});
  }
  return v;
}

double squared_normal_velocity(const AcousticSkin& skin, std::span<const Vector3> v) {
  double sum = 0;
  for (const auto& t : skin.triangle) {
    const auto corner = [&](std::size_t j) { return static_cast<std::size_t>(t[j]); };
    const Vector3 n = cross(skin.vertex[corner(1)] - skin.vertex[corner(0)],
                            skin.vertex[corner(2)] - skin.vertex[corner(0)]);
    const double twice = length(n);
    if (twice == 0)
      continue;
    std::array<double, 3> along{};
    for (std::size_t j = 0; j < 3; ++j)
      along[j] = dot(n, v[corner(j)]) / twice;
    const double total = along[0] + along[1] + along[2];
    sum += twice / 24 *
           (total * total + along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
  }
  return sum;
}

/// The lowest degree that leaves next to nothing of the field on the reference sphere behind.
std::size_t useful_degree(std::span<const Complex> c, std::size_t highest) {
  double all = 0;
  for (const Complex& x : c)
    all += std::norm(x);
  double tail = 0;
  for (std::size_t l = highest; l > 0; --l) {
    for (std::size_t q = l * l; q < (l + 1) * (l + 1); ++q)
      tail += std::norm(c[q]);
    if (tail > kTailPowerShare * all)
      return l;
  }
  return 0;
}

/// All modes at once at each frequency: they share its matrix.
ModeRadiation::Band radiate_band(const Mesh& mesh, const Modes& modes, std::span<const int> node,
                                 const FlowTransfer& transfer, const ExteriorField& field,
                                 const ModeRadiation& body, const RadiationSettings& settings) {
  ModeRadiation::Band band;
  band.frequency_hz =
      band_frequencies(body.reference_radius, settings.band_limit_hz, settings.sound_speed);
  const std::size_t count = modes.frequency_hz.size(), n = field.unknowns();
  std::vector<double> flow(n * count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto one = transfer(motion(modes, k, mesh, node));
    std::copy(one.begin(), one.end(), flow.begin() + static_cast<std::ptrdiff_t>(k * n));
  }
  std::vector<std::vector<std::vector<Complex>>> found(count); // [mode][frequency]
  std::vector<std::size_t> degree(count, 0);
  for (std::size_t f = 0; f < band.frequency_hz.size(); ++f) {
    const double k = 2 * std::numbers::pi * band.frequency_hz[f] / settings.sound_speed;
    const auto highest =
        static_cast<std::size_t>(std::min(std::ceil(k * body.reference_radius) + 14, 120.0));
    const std::size_t terms = (highest + 1) * (highest + 1);
    const auto mu = field.solve(k, flow, count, settings.air_density, settings.sound_speed);
    const auto c = multipoles(field, k, mu, count, highest, body.centre, body.reference_radius);
    for (std::size_t i = 0; i < count; ++i) {
      const std::span<const Complex> own(&c[i * terms], terms);
      degree[i] = std::max(degree[i], useful_degree(own, highest));
      found[i].emplace_back(own.begin(), own.end());
    }
    if (settings.report)
      settings.report("radiation below and between the modes",
                      static_cast<double>(f + 1) / static_cast<double>(band.frequency_hz.size()));
  }
  band.offset.push_back(0);
  for (std::size_t k = 0; k < count; ++k) {
    band.max_degree.push_back(static_cast<std::int32_t>(degree[k]));
    band.offset.push_back(band.offset.back() +
                          static_cast<std::int64_t>((degree[k] + 1) * (degree[k] + 1)));
  }
  const auto total = static_cast<std::size_t>(band.offset.back());
  band.coefficients.assign(total * band.frequency_hz.size(), 0);
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t f = 0; f < band.frequency_hz.size(); ++f)
      for (std::size_t q = 0; q < std::min((degree[k] + 1) * (degree[k] + 1), found[k][f].size());
           ++q)
        band.coefficients[f * total + static_cast<std::size_t>(band.offset[k]) + q] =
            std::complex<float>(found[k][f][q]);
  return band;
}

} // namespace

std::vector<double> band_frequencies(double radius, double limit_hz, double sound_speed) {
  const double hz = sound_speed / (2 * std::numbers::pi * radius); // of k a = 1
  const double last = limit_hz / hz;
  const double step = std::max(.5, last / 60);
  std::vector<double> frequencies;
  for (const double x : {.2, .5, 1.0, 1.5})
    if (x * step < last)
      frequencies.push_back(x * step * hz);
  for (double x = 2 * step; x < last; x += step)
    frequencies.push_back(x * hz);
  frequencies.push_back(limit_hz);
  return frequencies;
}

ModeRadiation radiate(const Mesh& mesh, const Modes& modes, const RadiationSettings& settings) {
  const std::size_t count = modes.frequency_hz.size();
  const auto stage = [&](const char* name) {
    if (settings.report)
      settings.report(name, 0);
  };
  stage("coarsening the skin");
  const std::vector<int> node = surface_of(mesh).node;
  const AcousticSkin fine = outer_skin(mesh);
  ModeRadiation out;
  out.ratios = settings.ratios;
  AcousticSkin coarse = with_triangles(fine, settings.triangles);
  out.triangles = coarse.triangle.size();
  const double bytes = 16.0 * std::pow(static_cast<double>(coarse.vertex.size()), 2);
  if (settings.memory_limit_bytes > 0 && bytes > .8 * settings.memory_limit_bytes)
    throw InputError(
        format("the boundary elements need %.0f MB, more than is free: take fewer with "
               "--acoustic-triangles",
               bytes / 1e6));
  double edges = 0;
  for (const auto& t : coarse.triangle)
    for (std::size_t j = 0; j < 3; ++j)
      edges += length(coarse.vertex[static_cast<std::size_t>(t[(j + 1) % 3])] -
                      coarse.vertex[static_cast<std::size_t>(t[j])]);
  const double edge = edges / (3 * static_cast<double>(coarse.triangle.size()));
  out.resolved_hz = settings.sound_speed / (4 * edge);

  std::vector<Vector3> used; // the outer skin's own vertices
  for (const auto& t : fine.triangle)
    for (const int v : t)
      used.push_back(fine.vertex[static_cast<std::size_t>(v)]);
  const Box box = bounding_box(used);
  out.centre = .5 * (box.low + box.high);
  for (const Vector3& x : used)
    out.reference_radius = std::max(out.reference_radius, length(x - out.centre));

  stage("pairs of close acoustic elements");
  const FlowTransfer transfer(fine, coarse);
  const ExteriorField field(std::move(coarse));

  // Groups of nearly equal frequency share a matrix.
  std::vector<std::size_t> first{0};
  for (std::size_t k = 1; k < count; ++k)
    if (modes.frequency_hz[k] > (1 + kSameFrequency) * modes.frequency_hz[first.back()])
      first.push_back(k);
  const std::size_t groups = first.size();
  first.push_back(count);

  std::vector<std::vector<std::vector<Complex>>> found(count); // [mode][ratio]
  std::vector<std::size_t> degree(count, 0);
  const auto begin = std::chrono::steady_clock::now();
  stage("radiation");
  std::size_t done = 0;
  for (std::size_t g = 0; g < groups; ++g) {
    const std::size_t from = first[g], columns = first[g + 1] - from, n = field.unknowns();
    double mean = 0;
    std::vector<double> flow(n * columns);
    for (std::size_t i = 0; i < columns; ++i) {
      mean += modes.frequency_hz[from + i] / static_cast<double>(columns);
      const auto one = transfer(motion(modes, from + i, mesh, node));
      std::copy(one.begin(), one.end(), flow.begin() + static_cast<std::ptrdiff_t>(i * n));
    }
    for (const double ratio : settings.ratios) {
      const double k = 2 * std::numbers::pi * mean * ratio / settings.sound_speed;
      const double reach = k * out.reference_radius;
      const auto highest = static_cast<std::size_t>(std::min(std::ceil(reach) + 14, 120.0));
      const auto mu = field.solve(k, flow, columns, settings.air_density, settings.sound_speed);
      const auto c = multipoles(field, k, mu, columns, highest, out.centre, out.reference_radius);
      const std::size_t terms = (highest + 1) * (highest + 1);
      for (std::size_t i = 0; i < columns; ++i) {
        const std::span<const Complex> own(&c[i * terms], terms);
        degree[from + i] = std::max(degree[from + i], useful_degree(own, highest));
        found[from + i].emplace_back(own.begin(), own.end());
      }
      ++done;
      if (done == 1 && settings.notify) {
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        settings.notify(format(
            "boundary elements: %zu triangles, %zu unknowns, %.0f MB; about %.0f s ahead",
            out.triangles, n, bytes / 1e6,
            std::max(1.0, seconds * (static_cast<double>(groups * settings.ratios.size()) - 1))));
      }
      if (settings.report)
        settings.report("radiation", static_cast<double>(done) /
                                         static_cast<double>(groups * settings.ratios.size()));
    }
  }

  out.offset.push_back(0);
  for (std::size_t k = 0; k < count; ++k) {
    out.max_degree.push_back(static_cast<std::int32_t>(degree[k]));
    out.offset.push_back(out.offset.back() +
                         static_cast<std::int64_t>((degree[k] + 1) * (degree[k] + 1)));
  }
  const auto total = static_cast<std::size_t>(out.offset.back());
  out.coefficients.assign(total * settings.ratios.size(), 0);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t terms = (degree[k] + 1) * (degree[k] + 1);
    for (std::size_t s = 0; s < settings.ratios.size(); ++s)
      for (std::size_t q = 0; q < std::min(terms, found[k][s].size()); ++q)
        out.coefficients[s * total + static_cast<std::size_t>(out.offset[k]) + q] =
            std::complex<float>(found[k][s][q]);
    // The ratio nearest to 1 is the body as it is.
    std::size_t own = 0;
    for (std::size_t s = 1; s < settings.ratios.size(); ++s)
      if (std::abs(settings.ratios[s] - 1) < std::abs(settings.ratios[own] - 1))
        own = s;
    const double wavenumber =
        2 * std::numbers::pi * modes.frequency_hz[k] * settings.ratios[own] / settings.sound_speed;
    // Energy of a mode of unit velocity amplitude and unit mass is 1/2 J: alpha = W/(2 E) = W.
    const double power = radiated_power(found[k][own], wavenumber, out.reference_radius,
                                        settings.air_density, settings.sound_speed);
    const double flat = .5 * settings.air_density * settings.sound_speed *
                        squared_normal_velocity(fine, motion(modes, k, mesh, node));
    out.decay_rate.push_back(power);
    out.efficiency.push_back(flat > 0 ? power / flat : 0);
  }
  if (settings.band_limit_hz > 0)
    out.band = radiate_band(mesh, modes, node, transfer, field, out, settings);
  return out;
}

} // namespace tactus::fem
