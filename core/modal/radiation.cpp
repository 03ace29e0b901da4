#include "core/modal/radiation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactus::modal {
namespace {

constexpr double kNearest = 1e-4; // m, to a source: closer the integral means nothing

Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

} // namespace

void RadiatingSurface::build(const ModalTable& table, const Surface& surface) {
  const std::size_t count = surface.triangles();
  centre_.resize(count);
  normal_.resize(count);
  area_.resize(count);
  surface_ = &surface;
  nodes_ = surface_nodes(surface, table.triangle, table.vertices());
  const std::size_t nodes = nodes_.vertex.size();
  displacement_.resize(nodes * table.modes());
  double total = 0;
  Vec3 along{};
  for (std::size_t t = 0; t < count; ++t) {
    const auto& c = surface.corners(t);
    const Vec3 n = cross(c[1] - c[0], c[2] - c[0]);
    const double size = norm(n);
    centre_[t] = (c[0] + c[1] + c[2]) * (1.0 / 3);
    normal_[t] = size > 0 ? n * (1 / size) : Vec3{};
    area_[t] = size / 2;
    total += area_[t];
    middle_ += area_[t] * centre_[t];
    along +=
        area_[t] * Vec3{std::abs(normal_[t].x), std::abs(normal_[t].y), std::abs(normal_[t].z)};
  }
  if (total > 0)
    middle_ = middle_ * (1 / total);
  // Seen from its thin direction a plate shows most of its surface; a ball half from everywhere.
  constexpr double kFlatShare = 0.6;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (along[a] > along[axis])
      axis = a;
  flat_ = along[axis] > kFlatShare * total;
  thin_ = {};
  thin_[axis] = 1;
  for (std::size_t k = 0; k < table.modes(); ++k)
    for (std::size_t n = 0; n < nodes; ++n)
      displacement_[k * nodes + n] =
          static_cast<float>(dot(table.shape_at(k, nodes_.vertex[n]), nodes_.normal[n]));
}

std::vector<std::size_t> RadiatingSurface::facing(const Vec3& listener) const {
  std::vector<std::size_t> seen;
  const double side = dot(listener - middle_, thin_) < 0 ? -1 : 1;
  for (std::size_t t = 0; t < area_.size(); ++t) {
    const bool faces =
        flat_ ? side * dot(normal_[t], thin_) > 0.5 : dot(normal_[t], listener - centre_[t]) > 0;
    if (faces && area_[t] > 0)
      seen.push_back(t);
  }
  return seen;
}

ListenerTransfer RadiatingSurface::modal(std::span<const std::complex<double>> rate,
                                         std::span<const std::size_t> mode, const Vec3& listener,
                                         double size, double shape_scale, double air_density,
                                         double sound_speed) const {
  ListenerTransfer out;
  out.pressure.assign(rate.size(), 0);
  double highest = 0;
  for (const std::complex<double>& s : rate)
    highest = std::max(highest, s.imag());
  const std::vector<SurfaceSource> sources =
      surface_ ? surface_sources(*surface_, facing(listener * (1 / size)), listener, size,
                                 highest / sound_speed, kNearest)
               : std::vector<SurfaceSource>{};
  if (sources.empty())
    return out;
  std::vector<double> share(sources.size());
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sources.size(); ++i) {
    shortest = std::min(shortest, sources[i].distance_m);
    share[i] = sources[i].area_m2 / (2 * std::numbers::pi * sources[i].distance_m);
  }
  out.delay_s = shortest / sound_speed;
  for (std::size_t k = 0; k < rate.size(); ++k) {
    double real = 0, imaginary = 0;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const double way = (sources[i].distance_m - shortest) / sound_speed;
      const double amount =
          displacement(mode[k], sources[i]) * share[i] * std::exp(-rate[k].real() * way);
      real += amount * std::cos(rate[k].imag() * way);
      imaginary -= amount * std::sin(rate[k].imag() * way);
    }
    out.pressure[k] = air_density * shape_scale * rate[k] * std::complex<double>(real, imaginary);
  }
  return out;
}

} // namespace tactus::modal
