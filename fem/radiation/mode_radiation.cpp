#include "fem/radiation/mode_radiation.hpp"

#include "fem/io/text.hpp"
#include "fem/radiation/spherical_waves.hpp"

#include <algorithm>
#include <chrono>
#include <numbers>
#include <optional>

namespace tactus::fem {
namespace {

constexpr double kSameFrequency = 1e-3;
constexpr double kTailPowerShare = 1e-6; // truncated fraction of the power at the reference sphere

/// Vertices of the outer skin as mesh nodes: outer_skin() keeps the order of surface_of().
std::vector<Vec3> motion(const Modes& modes, std::size_t k, const Mesh& mesh,
                         std::span<const int> node) {
  std::vector<Vec3> v;
  v.reserve(node.size());
  for (const int i : node) {
    const double* u = &modes.shapes[k * mesh.dofs() + 3 * static_cast<std::size_t>(i)];
    v.push_back({u[0], u[1], u[2]});
  }
  return v;
}

double squared_normal_velocity(const AcousticSkin& skin, std::span<const Vec3> v) {
  double sum = 0;
  for (const auto& t : skin.triangle) {
    const auto corner = [&](std::size_t j) { return static_cast<std::size_t>(t[j]); };
    const Vec3 n = cross(skin.vertex[corner(1)] - skin.vertex[corner(0)],
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

/// The lowest degree up to which truncation removes only a negligible part of the field on the
/// reference sphere.
std::size_t useful_degree(std::span<const Complex> c, std::size_t highest) {
  double all = 0;
  for (const Complex& x : c)
    all += math::norm(x);
  double tail = 0;
  for (std::size_t l = highest; l > 0; --l) {
    for (std::size_t q = l * l; q < (l + 1) * (l + 1); ++q)
      tail += math::norm(c[q]);
    if (tail > kTailPowerShare * all)
      return l;
  }
  return 0;
}

/// The boundary elements of one body, and the mapping of its modes to them.
struct AcousticModel {
  const Mesh& mesh;
  const Modes& modes;
  const RadiationSettings& settings;
  std::vector<int> node; ///< mesh node of each vertex of `fine`
  AcousticSkin fine;
  Vec3 centre;
  double reference_radius = 0;
  double matrix_bytes = 0;
  std::optional<FlowTransfer> transfer{};
  std::optional<ExteriorField> field{};

  /// Coefficients of the outgoing waves of modes `first` to `first + count` at one frequency.
  struct Waves {
    std::size_t highest; ///< degree
    std::vector<Complex> coefficients;
    [[nodiscard]] std::span<const Complex> of(std::size_t mode) const {
      const std::size_t terms = (highest + 1) * (highest + 1);
      return std::span(coefficients).subspan(mode * terms, terms);
    }
  };
  /// The flows of `count` modes as columns, m^3/s.
  [[nodiscard]] std::vector<double> flow(std::size_t first, std::size_t count) const {
    const std::size_t n = field->unknowns();
    std::vector<double> columns(n * count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto one = (*transfer)(motion(modes, first + i, mesh, node));
      std::copy(one.begin(), one.end(), columns.begin() + static_cast<std::ptrdiff_t>(i * n));
    }
    return columns;
  }
  [[nodiscard]] Waves waves(double k, std::span<const double> flow_columns,
                            std::size_t count) const {
    const auto highest =
        static_cast<std::size_t>(std::min(std::ceil(k * reference_radius) + 14, 120.0));
    const auto mu =
        field->solve(k, flow_columns, count, settings.air_density, settings.sound_speed);
    return {highest, multipoles(*field, k, mu, highest, centre, reference_radius)};
  }
};

/// The waves of each mode at several frequencies or ratios, and the degree that each mode needs.
struct FoundWaves {
  explicit FoundWaves(std::size_t modes) : coefficients(modes), degree(modes, 0) {}
  std::vector<std::vector<std::vector<Complex>>> coefficients; ///< [mode][frequency]
  std::vector<std::size_t> degree;

  void add(std::size_t mode, std::span<const Complex> own, std::size_t highest) {
    degree[mode] = std::max(degree[mode], useful_degree(own, highest));
    coefficients[mode].emplace_back(own.begin(), own.end());
  }
  /// Writes the arrays max_degree, offset and coefficients of a table, for `frequencies`
  /// frequencies per mode.
  template <class Arrays> void pack(std::size_t frequencies, Arrays& out) const {
    out.offset.push_back(0);
    for (const std::size_t l : degree) {
      out.max_degree.push_back(static_cast<std::int32_t>(l));
      out.offset.push_back(out.offset.back() + static_cast<std::int64_t>((l + 1) * (l + 1)));
    }
    const auto total = static_cast<std::size_t>(out.offset.back());
    out.coefficients.assign(total * frequencies, 0);
    for (std::size_t k = 0; k < degree.size(); ++k) {
      const std::size_t terms = (degree[k] + 1) * (degree[k] + 1);
      for (std::size_t f = 0; f < frequencies; ++f)
        for (std::size_t q = 0; q < std::min(terms, coefficients[k][f].size()); ++q)
          out.coefficients[f * total + static_cast<std::size_t>(out.offset[k]) + q] = {
              static_cast<float>(coefficients[k][f][q].real()),
              static_cast<float>(coefficients[k][f][q].imag())};
    }
  }
};

double mean_edge(const AcousticSkin& skin) {
  double edges = 0;
  for (const auto& t : skin.triangle)
    for (std::size_t j = 0; j < 3; ++j)
      edges += length(skin.vertex[static_cast<std::size_t>(t[(j + 1) % 3])] -
                      skin.vertex[static_cast<std::size_t>(t[j])]);
  return edges / (3 * static_cast<double>(skin.triangle.size()));
}

/// Centre and radius of the smallest sphere about the centre of the outer skin's box.
void set_reference_sphere(AcousticModel& model) {
  std::vector<Vec3> used; // the outer skin's own vertices
  for (const auto& t : model.fine.triangle)
    for (const int v : t)
      used.push_back(model.fine.vertex[static_cast<std::size_t>(v)]);
  const Box box = bounding_box(used);
  model.centre = .5 * (box.low + box.high);
  for (const Vec3& x : used)
    model.reference_radius = std::max(model.reference_radius, length(x - model.centre));
}

/// Coarsens the skin and prepares its boundary elements. Refuses boundary elements that would not
/// fit into memory.
AcousticModel acoustic_model(const Mesh& mesh, const Modes& modes,
                             const RadiationSettings& settings, ModeRadiation& out) {
  const auto stage = [&](const char* name) {
    if (settings.report)
      settings.report(name, 0);
  };
  stage("coarsening the skin");
  AcousticModel model{mesh, modes, settings, surface_of(mesh).node, outer_skin(mesh), {}};
  AcousticSkin coarse = with_triangles(model.fine, settings.triangles);
  model.matrix_bytes = 16.0 * std::pow(static_cast<double>(coarse.vertex.size()), 2);
  if (settings.memory_limit_bytes > 0 && model.matrix_bytes > .8 * settings.memory_limit_bytes)
    throw InputError(format("the boundary elements need %.0f MB, more than is free: use fewer with "
                            "--acoustic-triangles",
                            model.matrix_bytes / 1e6));
  set_reference_sphere(model);
  out.triangles = coarse.triangle.size();
  out.resolved_hz = settings.sound_speed / (4 * mean_edge(coarse));
  out.centre = model.centre;
  out.reference_radius = model.reference_radius;
  stage("pairs of close acoustic elements");
  model.transfer.emplace(model.fine, coarse);
  model.field.emplace(std::move(coarse));
  stage("radiation");
  return model;
}

/// The first mode of each group of nearly equal frequency, and the number of modes at the end.
std::vector<std::size_t> frequency_groups(const Modes& modes) {
  std::vector<std::size_t> first{0};
  for (std::size_t k = 1; k < modes.frequency_hz.size(); ++k)
    if (modes.frequency_hz[k] > (1 + kSameFrequency) * modes.frequency_hz[first.back()])
      first.push_back(k);
  first.push_back(modes.frequency_hz.size());
  return first;
}

/// The waves of every mode at its own frequency times each ratio; the modes of a group share the
/// matrix at their mean frequency.
FoundWaves waves_of_groups(const AcousticModel& model) {
  const RadiationSettings& settings = model.settings;
  const std::vector<std::size_t> first = frequency_groups(model.modes);
  const std::size_t groups = first.size() - 1;
  const auto solutions = static_cast<double>(groups * settings.ratios.size());
  FoundWaves found(model.modes.frequency_hz.size());
  const auto begin = std::chrono::steady_clock::now();
  std::size_t done = 0;
  for (std::size_t g = 0; g < groups; ++g) {
    const std::size_t from = first[g], columns = first[g + 1] - from;
    double mean = 0;
    for (std::size_t i = 0; i < columns; ++i)
      mean += model.modes.frequency_hz[from + i] / static_cast<double>(columns);
    const std::vector<double> flow = model.flow(from, columns);
    for (const double ratio : settings.ratios) {
      const double k = 2 * std::numbers::pi * mean * ratio / settings.sound_speed;
      const auto waves = model.waves(k, flow, columns);
      for (std::size_t i = 0; i < columns; ++i)
        found.add(from + i, waves.of(i), waves.highest);
      ++done;
      if (done == 1 && settings.notify) {
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        settings.notify(
            format("boundary elements: %zu triangles, %zu unknowns, %.0f MB; about %.0f s left",
                   model.field->skin().triangle.size(), model.field->unknowns(),
                   model.matrix_bytes / 1e6, std::max(1.0, seconds * (solutions - 1))));
      }
      if (settings.report)
        settings.report("radiation", static_cast<double>(done) / solutions);
    }
  }
  return found;
}

/// Radiated power of each mode, from the waves at the ratio nearest to 1.
void add_power(const AcousticModel& model, const FoundWaves& found, ModeRadiation& out) {
  const RadiationSettings& settings = model.settings;
  std::size_t own = 0;
  for (std::size_t s = 1; s < settings.ratios.size(); ++s)
    if (std::abs(settings.ratios[s] - 1) < std::abs(settings.ratios[own] - 1))
      own = s;
  for (std::size_t k = 0; k < model.modes.frequency_hz.size(); ++k) {
    const double wavenumber = 2 * std::numbers::pi * model.modes.frequency_hz[k] *
                              settings.ratios[own] / settings.sound_speed;
    // The energy of a mode of unit velocity amplitude and unit mass is 1/2 J, so alpha = W/(2 E) =
    // W.
    const double power =
        radiated_power(found.coefficients[k][own], wavenumber, model.reference_radius,
                       settings.air_density, settings.sound_speed);
    const double flat =
        .5 * settings.air_density * settings.sound_speed *
        squared_normal_velocity(model.fine, motion(model.modes, k, model.mesh, model.node));
    out.decay_rate.push_back(power);
    out.efficiency.push_back(flat > 0 ? power / flat : 0);
  }
}

/// Solves for all modes at once at each frequency, since they share its matrix.
ModeRadiation::Band radiate_band(const AcousticModel& model) {
  const RadiationSettings& settings = model.settings;
  ModeRadiation::Band band;
  band.frequency_hz =
      band_frequencies(model.reference_radius, settings.band_limit_hz, settings.sound_speed);
  const std::size_t count = model.modes.frequency_hz.size();
  const std::vector<double> flow = model.flow(0, count);
  FoundWaves found(count);
  for (std::size_t f = 0; f < band.frequency_hz.size(); ++f) {
    const double k = 2 * std::numbers::pi * band.frequency_hz[f] / settings.sound_speed;
    const auto waves = model.waves(k, flow, count);
    for (std::size_t i = 0; i < count; ++i)
      found.add(i, waves.of(i), waves.highest);
    if (settings.report)
      settings.report("radiation below and between the modes",
                      static_cast<double>(f + 1) / static_cast<double>(band.frequency_hz.size()));
  }
  found.pack(band.frequency_hz.size(), band);
  return band;
}

} // namespace

std::vector<double> band_frequencies(double radius, double limit_hz, double sound_speed) {
  const double hz = sound_speed / (2 * std::numbers::pi * radius); // frequency of k a = 1
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
  ModeRadiation out;
  out.ratios = settings.ratios;
  const AcousticModel model = acoustic_model(mesh, modes, settings, out);
  const FoundWaves found = waves_of_groups(model);
  found.pack(settings.ratios.size(), out);
  add_power(model, found, out);
  if (settings.band_limit_hz > 0)
    out.band = radiate_band(model);
  return out;
}

} // namespace tactus::fem
