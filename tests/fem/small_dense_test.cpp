// Small dense systems against their own equations.
#include "fem/small_dense.hpp"

#include <doctest/doctest.h>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

void check_eigenpairs(const std::array<Vec3, 3>& a, double tolerance) {
  const Eigenpairs3 pairs = symmetric_eigenpairs(a);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& v = pairs.vectors[k];
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(std::abs(dot(a[i], v) - pairs.values[k] * v[static_cast<int>(i)]) < tolerance);
      CHECK(std::abs(dot(v, pairs.vectors[i]) - (i == k ? 1 : 0)) < 1e-14);
    }
    if (k > 0)
      CHECK(pairs.values[k] >= pairs.values[k - 1]);
  }
}

} // namespace

TEST_CASE("eigenpairs of 3 x 3 matrices satisfy their equation, multiple and vanishing ones too") {
  check_eigenpairs({{{2, -1, .5}, {-1, 3, .25}, {.5, .25, -4}}}, 1e-14);
  check_eigenpairs({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}, 1e-14); // rank one: 0, 0, 3
  check_eigenpairs({{{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}}, 1e-14);
  check_eigenpairs({{{5, 0, 0}, {0, -1, 0}, {0, 0, 3}}}, 1e-14);
  check_eigenpairs({{{}, {}, {}}}, 1e-300);
  check_eigenpairs({{{1, 1e-9, 0}, {1e-9, 1 + 1e-9, 1e-9}, {0, 1e-9, 1}}}, 1e-14);
  check_eigenpairs({{{3e9, 2e8, -7e8}, {2e8, -1e9, 4e8}, {-7e8, 4e8, 5e8}}}, 1e-5);
  CHECK(symmetric_eigenpairs({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}).values[2] ==
        doctest::Approx(3).epsilon(1e-15));
  // What is no number ends as well.
  CHECK(std::isnan(symmetric_eigenpairs({{{NAN, 1, 1}, {1, 1, 1}, {1, 1, 1}}}).values[0]) == true);
}

TEST_CASE("systems are solved by columns; what has no solution is told") {
  const std::vector<double> a{4, 1, 0, 1, 3, -1, 0, -1, 2}; // column-major, symmetric
  for (const auto& solve : {solve_positive_definite, solve_regular}) {
    std::vector<double> x{1, 2, 3, -1, 0, 5};
    const std::vector<double> b = x;
    REQUIRE(solve(a, x, 3));
    for (std::size_t c = 0; c < 2; ++c)
      for (std::size_t i = 0; i < 3; ++i)
        CHECK(a[i] * x[3 * c] + a[3 + i] * x[3 * c + 1] + a[6 + i] * x[3 * c + 2] ==
              doctest::Approx(b[3 * c + i]).epsilon(1e-13));
  }
  std::vector<double> x{1, 2};
  CHECK(!solve_positive_definite({1, 2, 2, 1}, x, 2)); // eigenvalues 3 and -1
  x = {1, 2};
  CHECK(!solve_regular({1, 2, 2, 4}, x, 2));
  x = {5, 4}; // not symmetric: a matrix, not its transpose
  REQUIRE(solve_regular({1, 0, 2, 1}, x, 2));
  CHECK(x[0] == doctest::Approx(-3));
  CHECK(x[1] == doctest::Approx(4));
}

TEST_CASE("a system of any rank has the shortest of its nearest solutions") {
  const std::vector<double> right{3, 6}; // of x + 2 y = 3 twice
  const std::vector<double> x = solve_of_any_rank({1, 2, 2, 4}, right);
  CHECK(x[0] == doctest::Approx(.6).epsilon(1e-13));
  CHECK(x[1] == doctest::Approx(1.2).epsilon(1e-13));
  const std::vector<double> full = solve_of_any_rank({1, 0, 2, 1}, std::vector<double>{5, 4});
  CHECK(full[0] == doctest::Approx(-3));
  CHECK(full[1] == doctest::Approx(4));
}
