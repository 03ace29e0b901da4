// Which modes of one shape are those of another: a plate whose modes change order, a square bar
// whose pairs of equal frequency part, and modes that have no likeness.
#include "fem/modes/mode_match.hpp"
#include "static_bodies.hpp"

#include <algorithm>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

/// The modes of the mesh with its coordinates stretched, free.
SolvedModes stretched(Mesh mesh, const Vec3& by, std::size_t count) {
  for (Vec3& x : mesh.nodes)
    x = {by.x * x.x, by.y * x.y, by.z * x.z};
  return solve_modes(std::move(mesh), steel(), count);
}

std::vector<ModeMatch> matched(const SolvedModes& before, const SolvedModes& now) {
  return match_modes(now.matrices, before.modes.shapes, now.modes.shapes);
}

/// +-1 under a mirror of x (0) or y (1): of the bending displacement z. The mesh is a box about 0.
int parity(const SolvedModes& body, std::size_t mode, int axis) {
  const std::size_t n = body.mesh.dofs();
  double sum = 0;
  for (std::size_t i = 0; i < body.mesh.nodes.size(); ++i) {
    Vec3 mirrored = body.mesh.nodes[i];
    mirrored[axis] = -mirrored[axis];
    const auto other = static_cast<std::size_t>(
        std::min_element(body.mesh.nodes.begin(), body.mesh.nodes.end(),
                         [&](const Vec3& a, const Vec3& b) {
                           return length(a - mirrored) < length(b - mirrored);
                         }) -
        body.mesh.nodes.begin());
    sum += body.modes.shapes[mode * n + 3 * i + 2] * body.modes.shapes[mode * n + 3 * other + 2];
  }
  return sum > 0 ? 1 : -1;
}

/// Largest entry of T T' T - T: 0 for a partial isometry, which gives no motion energy.
double isometry_error(const std::vector<ModeMatch>& matches, std::size_t before, std::size_t now) {
  std::vector<double> t(before * now, 0); // [now][before]
  for (const ModeMatch& m : matches)
    t[m.now * before + m.before] = m.share;
  double max_difference = 0;
  for (std::size_t j = 0; j < now; ++j)
    for (std::size_t i = 0; i < before; ++i) {
      double sum = 0;
      for (std::size_t a = 0; a < before; ++a)
        for (std::size_t b = 0; b < now; ++b)
          sum += t[j * before + a] * t[b * before + a] * t[b * before + i];
      max_difference = std::max(max_difference, std::abs(sum - t[j * before + i]));
    }
  return max_difference;
}

/// A box about the origin in hex20.
Mesh box(const Vec3& size, int nx, int ny, int nz) {
  const Vec3 half = .5 * size;
  return block(even(-half.x, half.x, nx), even(-half.y, half.y, ny), even(-half.z, half.z, nz));
}

} // namespace

TEST_CASE("modes of a plate that change order go on as themselves, by their nodal lines") {
  const Mesh mesh = box({.3, .2, .01}, 6, 4, 1);
  const std::size_t count = 8;
  const SolvedModes before = stretched(mesh, {1, 1, 1}, count),
                    now = stretched(mesh, {1, 1.25, 1}, count);
  const auto matches = matched(before, now);
  REQUIRE(matches.size() >= 6);
  bool crossed = false;
  for (const ModeMatch& m : matches) {
    CAPTURE(m.before);
    CAPTURE(m.now);
    CHECK(std::abs(m.share) <= 1);
    for (const int axis : {0, 1})
      CHECK(parity(before, m.before, axis) == parity(now, m.now, axis));
    crossed = crossed || m.before != m.now;
  }
  CHECK(crossed);
  CHECK(isometry_error(matches, count, count) < 1e-9);
}

TEST_CASE("the same solution goes on as it is, with the signs it is given") {
  const SolvedModes body = stretched(box({.3, .2, .01}, 6, 4, 1), {1, 1, 1}, 6);
  auto turned = body.modes.shapes;
  const std::size_t n = body.mesh.dofs();
  for (std::size_t i = 0; i < n; ++i)
    turned[2 * n + i] = -turned[2 * n + i];
  const auto matches = match_modes(body.matrices, body.modes.shapes, turned);
  REQUIRE(matches.size() == 6);
  for (const ModeMatch& m : matches) {
    CHECK(m.before == m.now);
    CHECK(m.share == (m.now == 2 ? -1 : 1));
  }
}

TEST_CASE("pairs of a square bar that is flattened are rotated: none of their motion is lost") {
  const Mesh mesh = box({.2, .02, .02}, 10, 2, 2);
  const std::size_t count = 7; // three pairs and a torsion
  const SolvedModes before = stretched(mesh, {1, 1, 1}, count),
                    now = stretched(mesh, {1, .95, 1}, count);
  REQUIRE(before.modes.multiplicity[0] == 2);
  REQUIRE(now.modes.multiplicity[0] == 1);
  const auto matches = matched(before, now);
  CHECK(isometry_error(matches, count, count) < 1e-9);
  for (std::size_t i = 0; i < 2; ++i) { // the whole of each of the first pair, into the pair
    double sum = 0;
    for (const ModeMatch& m : matches)
      if (m.before == i) {
        CHECK(m.now < 2);
        sum += m.share * m.share;
      }
    CHECK(sum == doctest::Approx(1).epsilon(1e-9));
  }
}

TEST_CASE("modes without likeness are not matched") {
  const SolvedModes body = stretched(box({.3, .2, .01}, 6, 4, 1), {1, 1, 1}, 6);
  const std::size_t n = body.mesh.dofs();
  const std::span<const double> all = body.modes.shapes;
  CHECK(match_modes(body.matrices, all.first(3 * n), all.subspan(3 * n)).empty());
  // Half of one and half of another: what is kept of the sum, 0.7, is under a half of its square.
  std::vector<double> sum(n);
  for (std::size_t i = 0; i < n; ++i)
    sum[i] = (all[i] + all[3 * n + i] + all[4 * n + i]) / std::sqrt(3);
  CHECK(match_modes(body.matrices, sum, all.first(2 * n)).empty());
}
