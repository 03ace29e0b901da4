#include "core/modal/radiation/surface_quadrature.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {
namespace {

constexpr double kCoarser = 0.7; // factor on the wavenumber if there are too many sources
constexpr int kMaxAttempts = 40;
constexpr double kSmooth = 0.8660254037844386; // cosine of 30 degrees
constexpr double kArcsAWavelength = 18;

struct Point {
  std::array<double, 3> weight;
  double share; ///< share of the area
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

/// Integrals over the angles around the foot of the listener's perpendicular on a triangle's plane:
/// of 1, and of the unit vector at that angle.
struct Angles {
  double angle = 0;
  Vec3 direction{};
};

/// The part of a circle about that foot that lies in the triangle between the foot and an edge,
/// negative if the edge is seen from outside.
class Edge {
public:
  Edge() = default;
  Edge(const Vec3& from, const Vec3& to, const Vec3& normal)
      : along_((to - from) * (1 / norm(to - from))) {
    const Vec3 outwards = cross(along_, normal);
    const double height = dot(from, outwards);
    sign_ = height < 0 ? -1 : 1;
    height_ = std::abs(height);
    outwards_ = outwards * sign_;
    begin_ = at(dot(from, along_), norm(from));
    end_ = at(dot(to, along_), norm(to));
  }
  [[nodiscard]] bool is_outside() const noexcept { return sign_ < 0 || height_ <= 0; }
  /// Whether a circle touches the edge between its ends, and the radius of that circle.
  [[nodiscard]] bool is_touched() const noexcept { return begin_.along < 0 && end_.along > 0; }
  [[nodiscard]] double height() const noexcept { return height_; }
  void add_arc(double radius, Angles& sum) const noexcept {
    if (!(height_ > 0))
      return;
    if (radius <= height_)
      return add(begin_, end_, sum);
    const double half = std::sqrt(radius * radius - height_ * height_); // half of the chord
    if (end_.along > half)
      add(begin_.along > half ? begin_ : at(half, radius), end_, sum);
    if (begin_.along < -half)
      add(begin_, end_.along < -half ? end_ : at(-half, radius), sum);
  }

private:
  /// A point on the edge, and the angle u at which it is seen, measured from the edge's normal.
  struct End {
    double along = 0, angle = 0, sine = 0, cosine = 1;
  };
  [[nodiscard]] End at(double along, double radius) const noexcept {
    return {along, math::atan2(along, height_), along / radius, height_ / radius};
  }
  void add(const End& from, const End& to, Angles& sum) const noexcept {
    // The integrals of 1, cos u and sin u.
    sum.angle += sign_ * (to.angle - from.angle);
    sum.direction +=
        outwards_ * (sign_ * (to.sine - from.sine)) - along_ * (sign_ * (to.cosine - from.cosine));
  }

  Vec3 along_{}, outwards_{};
  double sign_ = 1, height_ = 0;
  End begin_, end_;
};

class TriangleSources {
public:
  TriangleSources(const std::array<Vec3, 3>& corners, std::uint32_t triangle, const Vec3& listener,
                  double nearest, std::vector<SurfaceSource>& out)
      : corner_(corners), triangle_(triangle), listener_(listener), nearest_(nearest), out_(out) {}

  void find(double wavenumber) {
    const Vec3 first = corner_[1] - corner_[0], second = corner_[2] - corner_[0];
    const double edge = std::max({norm(first), norm(second), norm(second - first)});
    const Vec3 centre = (corner_[0] + corner_[1] + corner_[2]) * (1.0 / 3);
    const double to_centre = norm(listener_ - centre);
    const double distance = std::max(to_centre - 0.6 * edge, nearest_);
    double turn = 0; // largest difference of distance from the centre to a corner, m
    for (const Vec3& corner : corner_)
      turn = std::max(turn, std::abs(norm(listener_ - corner) - to_centre));
    const double phase = wavenumber * std::min(edge, 2 * turn + edge * edge / (2 * distance));
    const Vec3 twice = cross(first, second);
    if (phase < 0.25 && edge < 0.1 * distance)
      return add_points(kCentre, 0.5 * norm(twice));
    if (phase < 0.8 && edge < 0.3 * distance)
      return add_points(kThree, 0.5 * norm(twice));
    if (phase < 2 && edge < distance)
      return add_points(kSeven, 0.5 * norm(twice));
    if (norm(twice) > 0)
      add_arcs(twice, 2 * std::numbers::pi / (kArcsAWavelength * wavenumber),
               edge < distance ? 3 : 6);
  }

private:
  void add_points(std::span<const Point> rule, double area) {
    for (const Point& point : rule) {
      const Weights& w = point.weight;
      const Vec3 at = w[0] * corner_[0] + w[1] * corner_[1] + w[2] * corner_[2];
      add(w, area * point.share, norm(listener_ - at));
    }
  }

  /// On the plane of a triangle at the distance H, dS = r dr dphi = d dd dphi with d^2 = H^2 + r^2.
  /// The surface between two distances follows exactly from the angles of the circle of radius r
  /// that lie within the triangle. Between the distances at which that circle meets a corner or
  /// touches an edge, these angles change smoothly, apart from square roots at both ends. The steps
  /// are therefore short there: d = a + (b - a) (s - sin(2 pi s)/(2 pi)), s at the middles of n
  /// equal steps.
  void add_arcs(const Vec3& twice, double step, double fewest) {
    const Vec3 normal = twice * (1 / norm(twice));
    const double height = dot(listener_ - corner_[0], normal);
    const Vec3 foot = listener_ - height * normal;
    std::array<Edge, 3> edge;
    Weights at_foot{};
    std::array<Vec3, 3> slope; // gradients of the weights
    std::array<double, 7> limit{};
    std::size_t limits = 0;
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 &from = corner_[i], &to = corner_[(i + 1) % 3];
      edge[i] = Edge(from - foot, to - foot, normal);
      inside = inside && !edge[i].is_outside();
      const std::size_t opposite = (i + 2) % 3;
      slope[opposite] = cross(normal, to - from) * (1 / norm(twice));
      at_foot[opposite] = dot(foot - from, slope[opposite]);
      limit[limits++] = norm(from - listener_);
      if (edge[i].is_touched())
        limit[limits++] = math::hypot(height, edge[i].height());
    }
    if (inside)
      limit[limits++] = std::abs(height);
    std::sort(limit.begin(), limit.begin() + static_cast<std::ptrdiff_t>(limits));
    for (std::size_t i = 1; i < limits && out_.size() <= kMaxSurfaceSources; ++i) {
      const double begin = limit[i - 1], length = limit[i] - begin;
      const double steps = std::ceil(1.5 * length / step) + fewest;
      for (double n = 0.5; length > 0 && n < steps && out_.size() <= kMaxSurfaceSources; ++n) {
        const double turn = 2 * std::numbers::pi * n / steps;
        const double distance =
            begin + length * (n / steps - math::sin(turn) / (2 * std::numbers::pi));
        const double radius = std::sqrt(std::max(distance * distance - height * height, 0.0));
        Angles arc;
        for (const Edge& one : edge)
          one.add_arc(radius, arc);
        if (!(arc.angle > 0))
          continue;
        Weights w{};
        for (std::size_t j = 0; j < 3; ++j)
          w[j] = at_foot[j] + radius * dot(slope[j], arc.direction) / arc.angle;
        add(w, distance * arc.angle * length * (1 - math::cos(turn)) / steps, distance);
      }
    }
  }

  using Weights = std::array<double, 3>;
  void add(const Weights& w, double area, double distance) {
    out_.push_back({triangle_,
                    {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])},
                    area,
                    std::max(distance, nearest_)});
  }

  std::array<Vec3, 3> corner_;
  std::uint32_t triangle_;
  Vec3 listener_;
  double nearest_;
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
      TriangleSources({size * c[0], size * c[1], size * c[2]}, static_cast<std::uint32_t>(t),
                      listener, nearest, sources)
          .find(wavenumber);
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
  std::vector<Vec3> sum; // sums of the triangles' normals times area
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
