#pragma once

#include <algorithm>
#include <cmath>

namespace tactus {

/// A vector of three doubles, as a rule in the project frame: x right, y up, z towards the user.
/// The unit is that of the quantity: m, m/s, N.
struct Vec3 {
  double x = 0, y = 0, z = 0;

  constexpr double& operator[](int axis) noexcept { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr double operator[](int axis) const noexcept { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr Vec3& operator+=(const Vec3& b) noexcept { return *this = {x + b.x, y + b.y, z + b.z}; }
  constexpr Vec3& operator-=(const Vec3& b) noexcept { return *this = {x - b.x, y - b.y, z - b.z}; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

constexpr Vec3 operator+(Vec3 a, const Vec3& b) noexcept { return a += b; }
constexpr Vec3 operator-(Vec3 a, const Vec3& b) noexcept { return a -= b; }
constexpr Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(const Vec3& a, double s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
constexpr Vec3 operator*(double s, const Vec3& a) noexcept { return a * s; }
constexpr double dot(const Vec3& a, const Vec3& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline bool is_finite(const Vec3& a) noexcept {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// Euclidean length, sqrt(a . a), of a vector that is neither huge nor tiny, such as a position or
/// an edge of a mesh.
inline double length(const Vec3& a) noexcept { return std::sqrt(dot(a, a)); }

/// Euclidean length of any vector. The components are scaled first, so that their squares neither
/// overflow nor underflow.
inline double norm(const Vec3& a) noexcept {
  const double largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (!(largest > 0.0) || !std::isfinite(largest))
    return largest;
  const Vec3 scaled{a.x / largest, a.y / largest, a.z / largest};
  return largest * std::sqrt(dot(scaled, scaled));
}

/// The vector, shortened to max_norm if it is longer; its direction stays. Zero for a vector that
/// is not finite.
inline Vec3 limited(const Vec3& a, double max_norm) noexcept {
  const double largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (!is_finite(a))
    return {};
  if (largest == 0.0)
    return a;
  const Vec3 scaled{a.x / largest, a.y / largest, a.z / largest};
  const double length = std::sqrt(dot(scaled, scaled));
  return largest * length > max_norm ? scaled * (max_norm / length) : a;
}

} // namespace tactus
