#include "core/modal/radiation/radiation.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kMaxFrequencyRatio = 0.45; // share of the sample rate: the surface is resolved up
                                            // to it
constexpr double kNearest = 1e-4;           // m, smallest distance to a source; below it the
                                            // integral is not valid

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
  // The projected area along the thin axis is nearly half the surface of a plate, and a quarter of
  // the surface of a ball.
  constexpr double kFlatShare = 0.6;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (along[a] > along[axis])
      axis = a;
  flat_ = along[axis] > kFlatShare * total;
  thin_axis_ = {};
  thin_axis_[axis] = 1;
  for (std::size_t k = 0; k < table.modes(); ++k)
    for (std::size_t n = 0; n < nodes; ++n)
      displacement_[k * nodes + n] =
          static_cast<float>(dot(table.shape_at(k, nodes_.vertex[n]), nodes_.normal[n]));
}

std::vector<std::size_t> RadiatingSurface::facing(const Vec3& listener) const {
  std::vector<std::size_t> visible;
  const double side = dot(listener - middle_, thin_axis_) < 0 ? -1 : 1;
  for (std::size_t t = 0; t < area_.size(); ++t) {
    const bool faces = flat_ ? side * dot(normal_[t], thin_axis_) > 0.5
                             : dot(normal_[t], listener - centre_[t]) > 0;
    if (faces && area_[t] > 0)
      visible.push_back(t);
  }
  return visible;
}

ListenerTransfer RadiatingSurface::modal(std::span<const Complex> rate,
                                         std::span<const std::size_t> mode, const Vec3& listener,
                                         const Scene& scene) const {
  const double size = scene.size, sound_speed = scene.sound_speed_m_per_s;
  ListenerTransfer out;
  out.pressure.assign(rate.size(), 0);
  double highest = 0;
  for (const Complex& s : rate)
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
      const double delay = (sources[i].distance_m - shortest) / sound_speed;
      const double amount =
          displacement(mode[k], sources[i]) * share[i] * math::exp(-rate[k].real() * delay);
      real += amount * math::cos(rate[k].imag() * delay);
      imaginary -= amount * math::sin(rate[k].imag() * delay);
    }
    out.pressure[k] =
        scene.air_density_kg_per_m3 * scene.shape_scale * rate[k] * Complex(real, imaginary);
  }
  return out;
}

/// Arrivals of a surface: the shares of delay bins at each node, and of each source for the rigid
/// motions.
class RadiatingSurface::Retarded final : public Arrivals {
public:
  Retarded(const RadiatingSurface& surface, const Vec3& listener, const Scene& scene,
           const RigidShapes& rigid)
      : surface_(surface), band_(&BandLimit::at_rate(scene.sample_rate)) {
    if (!surface.surface_)
      return;
    const double wavenumber =
        2 * std::numbers::pi * kMaxFrequencyRatio * scene.sample_rate / scene.sound_speed_m_per_s;
    const std::vector<SurfaceSource> sources =
        surface_sources(*surface.surface_, surface.facing(listener * (1 / scene.size)), listener,
                        scene.size, wavenumber, kNearest);
    double shortest = std::numeric_limits<double>::infinity();
    for (const SurfaceSource& source : sources)
      shortest = std::min(shortest, source.distance_m);
    TravelTime travel;
    silent = sources.empty();
    if (!silent)
      travel =
          TravelTime(shortest / scene.sound_speed_m_per_s, scene.sample_rate, scene.delay_from_s);
    delay_s = travel.delay_s;
    std::vector<Arrival> arrival;
    arrival.reserve(sources.size());
    for (const SurfaceSource& source : sources) {
      const double share =
          source.area_m2 / (2 * std::numbers::pi * source.distance_m) * scene.air_density_kg_per_m3;
      const double late =
          std::min((source.distance_m - shortest) / scene.sound_speed_m_per_s * scene.sample_rate +
                       travel.fractional_samples,
                   static_cast<double>(scene.max_spread));
      const double position = late * static_cast<double>(BandLimit::kBins);
      const auto bin = static_cast<std::uint32_t>(position);
      // Lagrange's cubic through four bins, the first of them one earlier.
      const double x = position - static_cast<double>(bin);
      arrival.push_back(
          {bin,
           {-share * x * (x - 1) * (x - 2) / 6, share * (x + 1) * (x - 1) * (x - 2) / 2,
            -share * (x + 1) * x * (x - 2) / 2, share * (x + 1) * x * (x - 1) / 6}});
      bins_ = std::max<std::size_t>(bins_, bin + BandLimit::kSpan);
    }
    collect_nodes(sources, arrival, scene.shape_scale);
    for (std::size_t r = 0; r < kRigid && !rigid.empty(); ++r) { // rigid motions are already in kg,
                                                                 // m and radians
      rigid_[r].assign(bins_, 0);
      for (std::size_t i = 0; i < sources.size(); ++i)
        for (std::size_t j = 0; j < BandLimit::kSpan; ++j)
          rigid_[r][arrival[i].bin + j] += rigid[sources[i].triangle][r] * arrival[i].share[j];
    }
  }
  [[nodiscard]] std::size_t modes() const noexcept override {
    const std::size_t nodes = surface_.nodes_.vertex.size();
    return nodes == 0 ? 0 : surface_.displacement_.size() / nodes;
  }
  [[nodiscard]] std::size_t samples() const noexcept override {
    return bins_ / BandLimit::kBins + 1 + BandLimit::kLength;
  }
  void find(std::size_t motion, std::span<double> pressure) const override {
    std::vector<double> binned(bins_, 0);
    if (motion < modes()) {
      const std::size_t nodes = surface_.nodes_.vertex.size();
      const float* const displacement = surface_.displacement_.data() + motion * nodes;
      for (const NodeArrivals& node : node_) {
        const auto x = static_cast<double>(displacement[node.node]);
        for (std::size_t i = 0; i < node.count; ++i)
          binned[node.first_bin + i] += x * share_[node.begin + i];
      }
    } else if (const auto& rigid = rigid_[motion - modes()]; !rigid.empty()) {
      binned = rigid;
    }
    const BandLimit& band = *band_;
    std::fill(pressure.begin(), pressure.end(), 0);
    for (std::size_t b = 0; b < bins_; ++b) {
      const auto& response = band.response[b % BandLimit::kBins];
      double* const out = pressure.data() + b / BandLimit::kBins * BandLimit::kNodes;
      for (std::size_t i = 0; i < response.size(); ++i)
        out[i] += binned[b] * response[i];
    }
  }

private:
  struct Arrival { ///< arrival of a source
    std::uint32_t bin;
    std::array<double, BandLimit::kSpan> share;
  };
  struct NodeArrivals { ///< shares of consecutive bins, from the first that the node contributes to
    std::uint32_t node = 0, first_bin = 0;
    std::size_t begin = 0, count = 0; ///< range in `share_`
  };

  /// Displacements at the sources are interpolated between nodes, so that a mode is summed over the
  /// nodes, of which there are far fewer.
  void collect_nodes(std::span<const SurfaceSource> sources, std::span<const Arrival> arrival,
                     double shape_scale) {
    const std::size_t nodes = surface_.nodes_.vertex.size();
    constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> low(nodes, kNone), high(nodes, 0);
    for (std::size_t i = 0; i < sources.size(); ++i)
      for (const std::uint32_t node : surface_.nodes_.triangle_nodes[sources[i].triangle]) {
        low[node] = std::min(low[node], arrival[i].bin);
        high[node] = std::max(high[node], arrival[i].bin);
      }
    std::vector<std::size_t> row(nodes, 0);
    std::size_t total = 0;
    for (std::size_t n = 0; n < nodes; ++n) {
      if (low[n] == kNone)
        continue;
      row[n] = total;
      node_.push_back(
          {static_cast<std::uint32_t>(n), low[n], total, high[n] - low[n] + BandLimit::kSpan});
      total += node_.back().count;
    }
    share_.assign(total, 0);
    for (std::size_t i = 0; i < sources.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t node = surface_.nodes_.triangle_nodes[sources[i].triangle][c];
        const double weight = shape_scale * static_cast<double>(sources[i].weight[c]);
        double* const to = share_.data() + row[node] + (arrival[i].bin - low[node]);
        for (std::size_t j = 0; j < BandLimit::kSpan; ++j)
          to[j] += weight * arrival[i].share[j];
      }
  }

  const RadiatingSurface& surface_;
  const BandLimit* band_;
  std::vector<NodeArrivals> node_;
  std::vector<double> share_;
  std::array<std::vector<double>, kRigid> rigid_;
  std::size_t bins_ = 1;
};

std::unique_ptr<Arrivals> RadiatingSurface::arrivals(const Vec3& listener, const Scene& scene,
                                                     const RigidShapes& rigid) const {
  return std::make_unique<Retarded>(*this, listener, scene, rigid);
}

} // namespace tactus::modal
