#include "fem/mesh/ray_grid.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// Twice the signed area of p, a, b in the plane of axes u and v. Exchanging a and b gives exactly
/// the opposite number, so that a line through the common edge of two triangles meets exactly one
/// of them.
double area(double pu, double pv, const Vec3& a, const Vec3& b, int u, int v) {
  const bool swapped = a[u] != b[u] ? a[u] > b[u] : a[v] > b[v];
  const Vec3 &from = swapped ? b : a, &to = swapped ? a : b;
  const double value = (from[u] - pu) * (to[v] - pv) - (from[v] - pv) * (to[u] - pu);
  return swapped ? -value : value;
}

/// A pseudo-random number in -1..1, a hash of two integers.
double scattered(int a, int b) noexcept {
  std::uint64_t h = static_cast<std::uint32_t>(a) * 0x9E3779B97F4A7C15ULL ^
                    static_cast<std::uint32_t>(b) * 0xC2B2AE3D27D4EB4FULL;
  h = (h ^ (h >> 31)) * 0x94D049BB133111EBULL;
  return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

} // namespace

RayGrid::RayGrid(const Triangles& t, double spacing, int margin) : spacing_(spacing) {
  const Box box = bounding_box(t.points);
  static constexpr std::array<double, 3> shift{.3819, .4142, .2679};
  for (int k = 0; k < 3; ++k) {
    origin_[k] = box.low[k] - (margin + shift[at(k)]) * spacing;
    size_[at(k)] = static_cast<int>(std::ceil((box.high[k] - origin_[k]) / spacing)) + margin + 1;
  }
  for (int axis = 0; axis < 3; ++axis)
    lines_[at(axis)] = cross_lines(t, axis, 0);
}

std::size_t RayGrid::count() const noexcept { return at(size_[0]) * at(size_[1]) * at(size_[2]); }

std::size_t RayGrid::index(int i, int j, int k) const noexcept {
  return (at(k) * at(size_[1]) + at(j)) * at(size_[0]) + at(i);
}

std::array<int, 3> RayGrid::cell(std::size_t index) const noexcept {
  const std::size_t x = index % at(size_[0]), rest = index / at(size_[0]);
  return {static_cast<int>(x), static_cast<int>(rest % at(size_[1])),
          static_cast<int>(rest / at(size_[1]))};
}

Vec3 RayGrid::point(const std::array<int, 3>& c) const noexcept {
  return origin_ + spacing_ * Vec3{double(c[0]), double(c[1]), double(c[2])};
}

std::size_t RayGrid::step(int axis) const noexcept {
  return axis == 0 ? 1 : axis == 1 ? at(size_[0]) : at(size_[0]) * at(size_[1]);
}

std::size_t RayGrid::line_of(const std::array<int, 3>& c, int axis) const noexcept {
  const std::size_t u = at((axis + 1) % 3), v = at((axis + 2) % 3);
  return at(c[v]) * at(size_[u]) + at(c[u]);
}

RayGrid::Lines RayGrid::cross_lines(const Triangles& t, int axis, double jitter) const {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const std::size_t lines = at(size_[at(u)]) * at(size_[at(v)]);
  std::vector<std::pair<std::size_t, Crossing>> found;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const Vec3 a = t.corner(i, 0), b = t.corner(i, 1), c = t.corner(i, 2);
    Vec3 normal = t.normal(i);
    const double double_area = length(normal);
    if (!(double_area > 0) || normal[axis] == 0)
      continue;
    normal = (1 / double_area) * normal;
    const auto range = [&](int k) {
      const double low = std::min({a[k], b[k], c[k]}), high = std::max({a[k], b[k], c[k]});
      return std::array{
          std::max(0, static_cast<int>(std::ceil((low - origin_[k]) / spacing_ - jitter))),
          std::min(size_[at(k)] - 1,
                   static_cast<int>(std::floor((high - origin_[k]) / spacing_ + jitter)))};
    };
    const auto [u_low, u_high] = range(u);
    const auto [v_low, v_high] = range(v);
    for (int m = v_low; m <= v_high; ++m)
      for (int n = u_low; n <= u_high; ++n) {
        const double pu = origin_[u] + (n + jitter * scattered(n, m)) * spacing_;
        const double pv = origin_[v] + (m + jitter * scattered(m, ~n)) * spacing_;
        const double wa = area(pu, pv, b, c, u, v), wb = area(pu, pv, c, a, u, v),
                     wc = area(pu, pv, a, b, u, v);
        if (!((wa > 0 && wb > 0 && wc > 0) || (wa < 0 && wb < 0 && wc < 0)))
          continue;
        const double position = (wa * a[axis] + wb * b[axis] + wc * c[axis]) / (wa + wb + wc);
        found.emplace_back(at(m) * at(size_[at(u)]) + at(n),
                           Crossing{position, wa > 0 ? 1 : -1, normal});
      }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& x, const auto& y) {
    return x.first != y.first ? x.first < y.first : x.second.position < y.second.position;
  });
  Lines out;
  out.of.resize(lines);
  std::size_t next = 0;
  for (std::size_t line = 0; line < lines; ++line) {
    const std::size_t first = next;
    while (next < found.size() && found[next].first == line)
      out.crossings.push_back(found[next++].second);
    out.of[line] = {first, next};
  }
  return out;
}

std::span<const Crossing> RayGrid::between(const std::array<int, 3>& c, int axis) const {
  const Lines& lines = lines_[at(axis)];
  const Line line = lines.of[line_of(c, axis)];
  const auto all = std::span(lines.crossings).subspan(line.first, line.last - line.first);
  const double low = point(c)[axis];
  const auto below = [](const Crossing& x, double level) { return x.position < level; };
  const auto first = std::lower_bound(all.begin(), all.end(), low, below);
  const auto last = std::lower_bound(first, all.end(), low + spacing_, below);
  return all.subspan(static_cast<std::size_t>(first - all.begin()),
                     static_cast<std::size_t>(last - first));
}

std::vector<std::int8_t> RayGrid::winding() const {
  std::vector<std::int8_t> around(count(), 0);
  const std::vector<Crossing>& along = lines_[0].crossings;
  for (int k = 0; k < size_[2]; ++k)
    for (int j = 0; j < size_[1]; ++j) {
      const Line line = lines_[0].of[line_of({0, j, k}, 0)];
      int number = 0;
      std::size_t next = line.first;
      for (int i = 0; i < size_[0] && line.first != line.last; ++i) {
        const double x = point({i, j, k}).x;
        for (; next < line.last && along[next].position < x; ++next)
          number -= along[next].sign;
        around[index(i, j, k)] = static_cast<std::int8_t>(std::clamp(number, -127, 127));
      }
    }
  return around;
}

std::array<double, 2> RayGrid::volumes(const Triangles& t) const {
  std::array<double, 2> sum{};
  const auto main_axis = std::max_element(lines_.begin(), lines_.end(),
                                          [](const Lines& a, const Lines& b) {
                                            return a.crossings.size() < b.crossings.size();
                                          }) -
                         lines_.begin();
  const auto [lines, along] = cross_lines(t, static_cast<int>(main_axis), .5);
  for (const Line line : lines) {
    int number = 0;
    for (std::size_t n = line.first; n + 1 < line.last; ++n) {
      number -= along[n].sign;
      const double size = along[n + 1].position - along[n].position;
      if (number != 0)
        sum[number > 0 ? 0 : 1] += size * spacing_ * spacing_;
    }
  }
  return sum;
}

} // namespace tactus::fem
