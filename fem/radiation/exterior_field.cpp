#include "fem/radiation/exterior_field.hpp"

#include <algorithm>
#include <numbers>

// LAPACK from OpenBLAS: LU with partial pivoting and its solve, column-major.
extern "C" void zgesv_(const int* n, const int* columns, tactus::Complex* matrix,
                       const int* leading, int* pivots, tactus::Complex* right,
                       const int* leading_right, int* info);

namespace tactus::fem {
namespace {

constexpr double kOver4Pi = 1 / (4 * std::numbers::pi);

/// Seven points of degree five (Radon 1948).
struct OuterPoint {
  std::array<double, 3> hat;
  double weight;
};
std::vector<OuterPoint> outer_rule(bool touching) {
  const double root = std::sqrt(15.0), a = (6 - root) / 21, b = (6 + root) / 21;
  const double wa = (155 - root) / 1200, wb = (155 + root) / 1200;
  std::vector<OuterPoint> rule{{{1. / 3, 1. / 3, 1. / 3}, .225}};
  for (const auto& [t, w] : {std::pair(a, wa), std::pair(b, wb)})
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<double, 3> hat{t, t, t};
      hat[k] = 1 - 2 * t;
      rule.push_back({hat, w});
    }
  if (!touching)
    return rule;
  // For touching panels the inner integral has a logarithmic singularity at the edge, which four
  // quarters resolve.
  const std::array<std::array<std::array<double, 3>, 3>, 4> quarters{
      {{{{1, 0, 0}, {.5, .5, 0}, {.5, 0, .5}}},
       {{{0, 1, 0}, {0, .5, .5}, {.5, .5, 0}}},
       {{{0, 0, 1}, {.5, 0, .5}, {0, .5, .5}}},
       {{{.5, .5, 0}, {0, .5, .5}, {.5, 0, .5}}}}};
  std::vector<OuterPoint> fine;
  for (const auto& quarter : quarters)
    for (const OuterPoint& p : rule) {
      OuterPoint q{{}, p.weight / 4};
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          q.hat[i] += p.hat[c] * quarter[c][i];
      fine.push_back(q);
    }
  return fine;
}

Vec3 point_of(const Panel& p, const std::array<double, 3>& hat) {
  return hat[0] * p.corner[0] + hat[1] * p.corner[1] + hat[2] * p.corner[2];
}

} // namespace

ExteriorField::ExteriorField(AcousticSkin skin) : skin_(std::move(skin)) {
  for (const auto& t : skin_.triangle)
    panels_.emplace_back(std::array<Vec3, 3>{skin_.vertex[static_cast<std::size_t>(t[0])],
                                             skin_.vertex[static_cast<std::size_t>(t[1])],
                                             skin_.vertex[static_cast<std::size_t>(t[2])]});
  arrays_ = PanelArrays(panels_);
  prepare_neighbours();
}

double ExteriorField::memory_bytes() const noexcept {
  return 16.0 * static_cast<double>(unknowns()) * static_cast<double>(unknowns());
}

void ExteriorField::prepare_neighbours() {
  const auto plain = outer_rule(false), touching = outer_rule(true);
  near_.resize(panels_.size());
  for (std::size_t t = 0; t < panels_.size(); ++t)
    for (std::size_t u = t; u < panels_.size(); ++u) {
      const Panel &p = panels_[t], &q = panels_[u];
      const double distance = length(p.middle - q.middle), reach = p.radius + q.radius;
      if (distance > 2 * reach)
        continue;
      Neighbours pair{static_cast<int>(u), {}, {}, {}};
      for (const OuterPoint& o : distance < reach ? touching : plain) {
        // With the test point on the first panel: the potential, and the slope along the normal of
        // the second panel (`back`).
        const StaticIntegrals over_q = static_integrals(q, point_of(p, o.hat));
        const StaticIntegrals over_p = static_integrals(p, point_of(q, o.hat));
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = 0; b < 3; ++b) {
            const double first = kOver4Pi * o.weight * p.area * o.hat[a];
            const double second = kOver4Pi * o.weight * q.area * o.hat[b];
            pair.potential[3 * a + b] += .5 * first * over_q.potential[b];
            pair.potential[3 * a + b] += .5 * second * over_p.potential[a];
            if (t != u) {
              pair.slope_back[3 * a + b] += first * over_q.slope[b];
              pair.slope[3 * a + b] += second * over_p.slope[a];
            }
          }
      }
      near_[t].push_back(pair);
    }
}

std::vector<Complex> ExteriorField::matrix(double k) const {
  const std::size_t n = unknowns(), count = panels_.size();
  std::vector<Complex> matrix(n * n, 0.0);
  // The rows of one panel's three corners, [column][corner], are stored next to each other until
  // they are complete.
  std::vector<std::array<Complex, 3>> rows(n);
  PanelPairs pairs;
  PanelPairs::Integrals there, back;
  for (std::size_t t = 0; t < count; ++t) {
    const Panel& p = panels_[t];
    std::array<std::size_t, 3> corner;
    std::copy(skin_.triangle[t].begin(), skin_.triangle[t].end(), corner.begin());
    std::fill(rows.begin(), rows.end(), std::array<Complex, 3>{});
    auto close = near_[t].begin();
    for (std::size_t first = t; first < count; first += PanelPairs::kSize) {
      const std::size_t last = std::min(first + PanelPairs::kSize, count);
      integrate_pairs(t, first, last, k, close, pairs);
      pairs.to_galerkin(p, arrays_, first, last - first, k, there, back);
      if (first == t) // the panel with itself has one entry and adds its share of -1/2
        for (std::size_t ab = 0; ab < 9; ++ab) {
          there.im[ab][0] -= k * p.area / (ab % 4 == 0 ? 12 : 24);
          back.re[ab][0] = back.im[ab][0] = 0;
        }
      for (std::size_t u = first; u < last; ++u)
        for (std::size_t b = 0; b < 3; ++b) {
          const auto other = static_cast<std::size_t>(skin_.triangle[u][b]);
          for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t ab = 3 * a + b;
            rows[other][a] += Complex(there.re[ab][u - first], there.im[ab][u - first]);
            matrix[corner[a] * n + other] +=
                Complex(back.re[ab][u - first], back.im[ab][u - first]);
          }
        }
    }
    for (std::size_t column = 0; column < n; ++column)
      for (std::size_t a = 0; a < 3; ++a)
        matrix[column * n + corner[a]] += rows[column][a];
  }
  return matrix;
}

void ExteriorField::integrate_pairs(std::size_t t, std::size_t first, std::size_t last, double k,
                                    std::vector<Neighbours>::const_iterator& close,
                                    PanelPairs& pairs) const {
  const auto end = std::find_if(close, near_[t].end(), [&](const Neighbours& pair) {
    return static_cast<std::size_t>(pair.second) >= last;
  });
  pairs.near.fill(0);
  for (auto pair = close; pair != end; ++pair)
    pairs.near[static_cast<std::size_t>(pair->second) - first] = 1;
  pairs.integrate(panels_[t], arrays_, first, last - first, k);
  for (; close != end; ++close) {
    const std::size_t u = static_cast<std::size_t>(close->second) - first;
    for (std::size_t ab = 0; ab < 9; ++ab) {
      pairs.value.re[ab][u] += close->potential[ab];
      pairs.slope.re[ab][u] += close->slope[ab];
      pairs.slope_back.re[ab][u] += close->slope_back[ab];
    }
  }
}

std::vector<Complex> ExteriorField::solve(double k, std::span<const double> flow,
                                          std::size_t columns, double air_density,
                                          double sound_speed) const {
  const std::size_t n = unknowns();
  std::vector<Complex> galerkin = matrix(k);
  std::vector<Complex> mu(n * columns);
  const Complex drive(0, -k * sound_speed * air_density);
  for (std::size_t i = 0; i < mu.size(); ++i)
    mu[i] = drive * flow[i];
  std::vector<int> pivots(n);
  const int size = static_cast<int>(n), right = static_cast<int>(columns);
  int info = 0;
  zgesv_(&size, &right, galerkin.data(), &size, pivots.data(), mu.data(), &size, &info);
  if (info != 0)
    throw InputError("the boundary element equations are singular: check that the skin is closed");
  return mu;
}

Complex ExteriorField::pressure(double k, std::span<const Complex> mu, const Vec3& x) const {
  Complex sum = 0;
  for (std::size_t t = 0; t < panels_.size(); ++t) {
    const Panel& p = panels_[t];
    for (std::size_t i = 0; i < 3; ++i) {
      Complex density = 0;
      for (std::size_t j = 0; j < 3; ++j)
        density += kHatAtPoint[i][j] * mu[static_cast<std::size_t>(skin_.triangle[t][j])];
      const Vec3 offset = x - p.point[i];
      const double r = length(offset);
      const Complex wave = math::polar(kOver4Pi * p.area / 3 / r, -k * r);
      sum += density * wave * (dot(offset, p.normal) / r * Complex(1 / r, k) + Complex(0, k));
    }
  }
  return sum;
}

} // namespace tactus::fem
