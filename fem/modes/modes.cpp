#include "fem/modes/modes.hpp"

#include "core/modal/table/modal_table.hpp"
#include "fem/modes/dense.hpp"
#include "fem/modes/rigid.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {

double estimated_frequency(const Mesh& mesh, std::span<const Material> materials) {
  double speed = 0;
  for (const Material& m : materials)
    speed = std::max(speed, m.bar_speed());
  return estimated_frequency(bounding_box(mesh.nodes).size(), volume(mesh), speed);
}

double estimated_frequency(const Vec3& box, double volume, double speed) {
  const double size = std::max({box.x, box.y, box.z});
  const double surface = 2 * (box.x * box.y + box.y * box.z + box.z * box.x);
  const double thickness = 2 * volume / surface;
  return std::min(speed * thickness / (size * size), speed / (2 * size));
}

double default_shift(const Mesh& mesh, std::span<const Material> materials) {
  const double root = 2 * std::numbers::pi * .3 * estimated_frequency(mesh, materials);
  return root * root;
}

double highest_wave_number(double volume, double skin, double length, const Material& m,
                           std::size_t count) {
  // For an orthotropic material, uses the geometric mean of the stiffest and the softest direction.
  // It gives the same number of waves; the error estimate then refines each direction.
  const double soft =
      m.isotropic() ? m.young_pa[0] : *std::min_element(m.young_pa.begin(), m.young_pa.end());
  const double shear = m.isotropic() ? m.young_pa[0] / (2 * (1 + m.poisson[0]))
                                     : *std::max_element(m.shear_pa.begin(), m.shear_pa.end());
  const double bar = std::sqrt(std::sqrt(m.young_pa[0] * soft) / m.density);
  const double slow = std::sqrt(5. / 6 * shear / m.density);
  const double t = 2 * volume / skin;
  const auto wave_number = [&](double omega) {
    const double a = 1 / (bar * bar), b = 1 / (slow * slow), w = omega * omega;
    return std::sqrt(.5 * w * (a + b) +
                     std::sqrt(.25 * w * w * (a - b) * (a - b) + 12 * w * a / (t * t)));
  };
  double low = 0, high = 1;
  const auto enough = [&](double omega) {
    const double k = wave_number(omega), s = omega / slow;
    return skin * k * k / (8 * std::numbers::pi) + length * k / std::numbers::pi +
               volume * s * s * s / (2 * std::numbers::pi * std::numbers::pi) >
           static_cast<double>(count);
  };
  while (!enough(high))
    high *= 2;
  for (int i = 0; i < 60; ++i)
    (enough(.5 * (low + high)) ? high : low) = .5 * (low + high);
  return wave_number(high);
}

Modes find_modes(const Mesh& mesh, std::span<const Material> materials, const Matrices& matrices,
                 const ModeSettings& settings) {
  const auto report = [&](const char* stage, double share) {
    if (settings.report)
      settings.report(stage, share);
  };
  const double shift = default_shift(mesh, materials);
  report("ordering the equations", 0);
  const std::vector<double> rigid = rigid_motions(mesh, matrices);
  ShiftedFactor factor(matrices, shift);
  if (settings.predict)
    settings.predict(factor.cost());
  report("factorising", 0);
  factor.factorise();
  report("finding modes", 0);
  Modes modes;
  modes.rigid = rigid.size() / matrices.dofs();
  modes.cost = factor.cost();
  std::size_t kept = 0, found = 0, asked = settings.count + 1;
  do { // more than requested, until the last group is complete
    asked += asked > settings.count + 1 ? asked / 2 + 4 : 3;
    Spectrum spectrum = lowest_modes(
        matrices, factor, shift, rigid,
        {.count = asked, .progress = [&](double share) { report("finding modes", share); }});
    found = spectrum.lambda.size();
    modes.solves += spectrum.solves;
    modes.shapes = std::move(spectrum.vectors);
    modes.frequency_hz.resize(found);
    sort_by_quotient(matrices, modes);
    kept = modal::with_whole_groups(modes.frequency_hz, settings.count);
  } while (kept == asked && found == asked);
  make_canonical(mesh, modes);
  keep_first(modes, kept);
  report("finding modes", 1);
  if (settings.inspect)
    settings.inspect(modes, factor);
  return modes;
}

void keep_first(Modes& modes, std::size_t count) {
  const std::size_t before = modes.frequency_hz.size();
  modes.shapes.resize(before > 0 ? modes.shapes.size() / before * count : 0);
  modes.frequency_hz.resize(count);
  modes.multiplicity.resize(count);
  modes.residual.resize(count);
}

void sort_by_quotient(const Matrices& m, Modes& modes) {
  const std::size_t n = m.dofs(), count = modes.frequency_hz.size();
  std::vector<double> stiff(n * count), heavy(n * count);
  m.multiply_stiffness(modes.shapes, stiff, count);
  m.multiply_mass(modes.shapes, heavy, count);
  struct Entry {
    double lambda, residual;
    std::size_t column;
  };
  std::vector<Entry> entries(count);
  for (std::size_t c = 0; c < count; ++c) {
    const double *u = &modes.shapes[c * n], *k = &stiff[c * n], *w = &heavy[c * n];
    double energy = 0, mass = 0, miss = 0, size = 0;
    for (std::size_t i = 0; i < n; ++i) {
      energy += u[i] * k[i];
      mass += u[i] * w[i];
    }
    const double lambda = energy / mass;
    for (std::size_t i = 0; i < n; ++i) {
      miss += (k[i] - lambda * w[i]) * (k[i] - lambda * w[i]);
      size += w[i] * w[i];
    }
    entries[c] = {lambda, std::sqrt(miss / size) / lambda, c};
    for (std::size_t i = 0; i < n; ++i)
      modes.shapes[c * n + i] /= std::sqrt(mass);
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.lambda < b.lambda; });
  // Modes that are equal except for rounding keep their order, whatever the last bit is.
  for (std::size_t first = 0; first < count;) {
    std::size_t end = first + 1;
    while (end < count &&
           entries[end].lambda - entries[end - 1].lambda < 1e-9 * entries[end].lambda)
      ++end;
    std::vector<double> lambdas;
    for (std::size_t c = first; c < end; ++c)
      lambdas.push_back(entries[c].lambda);
    std::sort(entries.begin() + static_cast<std::ptrdiff_t>(first),
              entries.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Entry& a, const Entry& b) { return a.column < b.column; });
    for (std::size_t c = first; c < end; ++c)
      entries[c].lambda = lambdas[c - first];
    first = end;
  }
  std::vector<double> sorted(n * count);
  modes.residual.resize(count);
  for (std::size_t c = 0; c < count; ++c) {
    std::copy_n(&modes.shapes[entries[c].column * n], n, &sorted[c * n]);
    modes.frequency_hz[c] = std::sqrt(std::max(entries[c].lambda, 0.0)) / (2 * std::numbers::pi);
    modes.residual[c] = entries[c].residual;
  }
  modes.shapes = std::move(sorted);
}

namespace {

/// The node farthest from the middle in a direction; the first of equally distant nodes.
std::size_t farthest_node(const Mesh& mesh, const Vec3& direction) {
  const double size = bounding_box(mesh.nodes).largest();
  std::size_t best = 0;
  for (std::size_t i = 1; i < mesh.nodes.size(); ++i)
    if (dot(mesh.nodes[i] - mesh.nodes[best], direction) > 1e-9 * size)
      best = i;
  return best;
}

/// The orthogonal matrix (columns: new modes) that puts the motion at `node` into the first column;
/// false if the group does not move there.
bool concentrate(std::span<const double> shapes, std::size_t n, std::size_t first,
                 std::size_t width, std::size_t node, std::vector<double>& rotation) {
  std::vector<double> gram(width * width, 0.0);
  for (std::size_t a = 0; a < width; ++a)
    for (std::size_t b = 0; b < width; ++b)
      for (std::size_t k = 0; k < 3; ++k)
        gram[a * width + b] +=
            shapes[(first + a) * n + 3 * node + k] * shapes[(first + b) * n + 3 * node + k];
  double largest = 0;
  for (std::size_t c = 0; c < width; ++c)
    for (std::size_t i = 0; i < n; ++i)
      largest = std::max(largest, std::abs(shapes[(first + c) * n + i]));
  const Eigenpairs pairs = symmetric_eigenpairs(gram, width);
  if (pairs.values[width - 1] < 1e-4 * largest * largest)
    return false;
  rotation.resize(width * width);
  for (std::size_t c = 0; c < width; ++c)
    std::copy_n(&pairs.vectors[(width - 1 - c) * width], width, &rotation[c * width]);
  return true;
}

} // namespace

void make_canonical(const Mesh& mesh, Modes& modes, double same) {
  const std::size_t n = mesh.dofs(), count = modes.frequency_hz.size();
  const std::array<std::size_t, 3> probes{farthest_node(mesh, {1, 1e-3, 1e-4}),
                                          farthest_node(mesh, {1e-3, 1, 1e-4}),
                                          farthest_node(mesh, {1e-3, 1e-4, 1})};
  const auto groups = [&](double gap, auto&& use) {
    for (std::size_t first = 0; first < count;) {
      std::size_t end = first + 1;
      while (end < count &&
             modes.frequency_hz[end] - modes.frequency_hz[end - 1] < gap * modes.frequency_hz[end])
        ++end;
      use(first, end - first);
      first = end;
    }
  };
  groups(same, [&](std::size_t first, std::size_t width) {
    std::size_t done = 0;
    for (const std::size_t probe : probes) {
      std::vector<double> rotation;
      const std::size_t left = width - done;
      if (left < 2 || !concentrate(modes.shapes, n, first + done, left, probe, rotation))
        continue;
      std::vector<double> rotated(n * left, 0.0);
      add_product(1, {std::span(modes.shapes).subspan((first + done) * n, left * n), left},
                  {rotation, left}, rotated, n);
      std::copy(rotated.begin(), rotated.end(),
                modes.shapes.begin() + static_cast<std::ptrdiff_t>((first + done) * n));
      ++done;
    }
  });
  modes.multiplicity.assign(count, 1);
  groups(1e-3, [&](std::size_t first, std::size_t width) {
    std::fill_n(modes.multiplicity.begin() + static_cast<std::ptrdiff_t>(first), width,
                static_cast<int>(width));
  });
  for (std::size_t c = 0; c < count; ++c) {
    double* u = &modes.shapes[c * n];
    double largest = 0;
    for (std::size_t i = 0; i < n; ++i)
      largest = std::max(largest, std::abs(u[i]));
    // Takes the first entry near the largest, because symmetric shapes have several that are equal
    // except for rounding.
    const double* sign =
        std::find_if(u, u + n, [&](double x) { return std::abs(x) > .99 * largest; });
    if (sign != u + n && *sign < 0)
      for (std::size_t i = 0; i < n; ++i)
        u[i] = -u[i];
  }
}

} // namespace tactus::fem
