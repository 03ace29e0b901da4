#pragma once
#include <cmath>

namespace tactus::fem {

/// A point or a direction in space; metres unless a comment says otherwise.
struct Vector3 {
  double x = 0, y = 0, z = 0;

  constexpr double& operator[](int i) noexcept { return i == 0 ? x : i == 1 ? y : z; }
  constexpr double operator[](int i) const noexcept { return i == 0 ? x : i == 1 ? y : z; }
  constexpr Vector3& operator+=(const Vector3& b) noexcept {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  friend constexpr Vector3 operator+(Vector3 a, const Vector3& b) noexcept { return a += b; }
  friend constexpr Vector3 operator-(const Vector3& a, const Vector3& b) noexcept {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr Vector3 operator*(double s, const Vector3& a) noexcept {
    return {s * a.x, s * a.y, s * a.z};
  }
  friend constexpr bool operator==(const Vector3&, const Vector3&) = default;
};

constexpr double dot(const Vector3& a, const Vector3& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vector3 cross(const Vector3& a, const Vector3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector3& a) noexcept { return std::sqrt(dot(a, a)); }

} // namespace tactus::fem
