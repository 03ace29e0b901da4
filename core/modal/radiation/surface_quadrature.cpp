#include "core/modal/radiation/surface_quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
namespace {

constexpr int kMaxDepth = 9;
constexpr double kCoarser = 0.7; // factor of the wavenumber where there are too many sources
constexpr int kMaxAttempts = 40;
constexpr double kSmooth = 0.8660254037844386; // cosine of 30 degrees

struct Point {
  std::array<double, 3> weight;
  double share; ///< of the area
};
constexpr std::array kCentre{Point{{1.0 / 3, 1.0 / 3, 1.0 / 3}, 1}};
constexpr std::array kThree{Point{{2.0 / 3, 1.0 / 6, 1.0 / 6}, 1.0 / 3},
                            Point{{1.0 / 6, 2.0 / 3, 1.0 / 6}, 1.0 / 3},
                            Point{{1.0 / 6, 1.0 / 6, 2.0 / 3}, 1.0 / 3}};
// Radon's: a = (6 -+ sqrt(15))/21, shares (155 -+ sqrt(15))/1200.
constexpr double kA = 0.10128650732345633, kB = 0.47014206410511505;
constexpr double kShareA = 0.12593918054482717, kShareB = 0.13239415278850619;
constexpr std::array kSeven{
    Point{{1.0 / 3, 1.0 / 3, 1.0 / 3}, 0.225}, Point{{1 - 2 * kA, kA, kA}, kShareA},
    Point{{kA, 1 - 2 * kA, kA}, kShareA},      Point{{kA, kA, 1 - 2 * kA}, kShareA},
    Point{{1 - 2 * kB, kB, kB}, kShareB},      Point{{kB, 1 - 2 * kB, kB}, kShareB},
    Point{{kB, kB, 1 - 2 * kB}, kShareB}};

using Weights = std::array<double, 3>;

struct Accuracy {
  Vec3 listener;
  double wavenumber, nearest;
};

/// Divides a triangle until a rule is accurate enough. Parts are given by the barycentric weights
/// of their corners.
class Divider {
public:
  Divider(const std::array<Vec3, 3>& corners, std::uint32_t triangle, const Accuracy& accuracy,
          std::vector<SurfaceSource>& out)
      : corner_(corners), triangle_(triangle), listener_(accuracy.listener),
        wavenumber_(accuracy.wavenumber), nearest_(accuracy.nearest), out_(out) {}

  void divide(const std::array<Weights, 3>& part, int depth) {
    if (out_.size() > kMaxSurfaceSources) // too many: what is found is not used
      return;
    std::array<Vec3, 3> at;
    for (std::size_t i = 0; i < 3; ++i)
      at[i] = position(part[i]);
    const double edge = std::max({norm(at[1] - at[0]), norm(at[2] - at[1]), norm(at[0] - at[2])});
    const Vec3 centre = (at[0] + at[1] + at[2]) * (1.0 / 3);
    const double distance = std::max(norm(listener_ - centre) - 0.6 * edge, nearest_);
    const double area = 0.5 * norm(cross(at[1] - at[0], at[2] - at[0]));
    const double phase = wavenumber_ * edge;
    if (phase < 0.25 && edge < 0.1 * distance)
      return add_points(kCentre, part, area);
    if (phase < 0.8 && edge < 0.3 * distance)
      return add_points(kThree, part, area);
    if ((phase < 3 && edge < distance) || depth == kMaxDepth)
      return add_points(kSeven, part, area);
    std::array<Weights, 3> middle;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        middle[i][j] = 0.5 * (part[i][j] + part[(i + 1) % 3][j]);
    divide({part[0], middle[0], middle[2]}, depth + 1);
    divide({middle[0], part[1], middle[1]}, depth + 1);
    divide({middle[2], middle[1], part[2]}, depth + 1);
    divide(middle, depth + 1);
  }

private:
  [[nodiscard]] Vec3 position(const Weights& w) const noexcept {
    return w[0] * corner_[0] + w[1] * corner_[1] + w[2] * corner_[2];
  }
  void add_points(std::span<const Point> rule, const std::array<Weights, 3>& part, double area) {
    for (const Point& point : rule) {
      Weights w{};
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          w[j] += point.weight[i] * part[i][j];
      out_.push_back(
          {triangle_,
           {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])},
           area * point.share,
           std::max(norm(listener_ - position(w)), nearest_)});
    }
  }

  std::array<Vec3, 3> corner_;
  std::uint32_t triangle_;
  Vec3 listener_;
  double wavenumber_, nearest_;
  std::vector<SurfaceSource>& out_;
};

} // namespace

std::vector<SurfaceSource> surface_sources(const Surface& surface,
                                           std::span<const std::size_t> triangles,
                                           const Vec3& listener, double size, double wavenumber,
                                           double nearest) {
  std::vector<SurfaceSource> sources;
  sources.reserve(3 * triangles.size());
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    sources.clear();
    for (const std::size_t t : triangles) {
      const auto& c = surface.corners(t);
      Divider({size * c[0], size * c[1], size * c[2]}, static_cast<std::uint32_t>(t),
              {listener, wavenumber, nearest}, sources)
          .divide({Weights{1, 0, 0}, Weights{0, 1, 0}, Weights{0, 0, 1}}, 0);
    }
    if (sources.size() <= kMaxSurfaceSources)
      break;
    wavenumber *= kCoarser;
  }
  return sources;
}

SurfaceNodes surface_nodes(const Surface& surface,
                           std::span<const std::array<std::int32_t, 3>> triangles,
                           std::size_t vertices) {
  SurfaceNodes nodes;
  nodes.triangle_nodes.resize(triangles.size());
  // Linked lists of the nodes of each vertex so far.
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> first(vertices, kNone), next;
  std::vector<Vec3> sum; // of the triangles' normals times area
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& c = surface.corners(t);
    const Vec3 twice = cross(c[1] - c[0], c[2] - c[0]);
    const double length = norm(twice);
    const Vec3 normal = length > 0 ? twice * (1 / length) : Vec3{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(triangles[t][i]);
      std::uint32_t node = first[v];
      while (node != kNone && !(dot(sum[node], normal) >= kSmooth * norm(sum[node])))
        node = next[node];
      if (node == kNone) {
        node = static_cast<std::uint32_t>(nodes.vertex.size());
        nodes.vertex.push_back(static_cast<std::uint32_t>(v));
        sum.push_back({});
        next.push_back(first[v]);
        first[v] = node;
      }
      sum[node] += twice;
      nodes.triangle_nodes[t][i] = node;
    }
  }
  for (const Vec3& s : sum) {
    const double length = norm(s);
    nodes.normal.push_back(length > 0 ? s * (1 / length) : Vec3{});
  }
  return nodes;
}

} // namespace tactus::modal
