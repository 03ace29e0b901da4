// What a re-solved stress must be to take the table's place.
#include "core/stress/stress_table.hpp"
#include "tests/core/stress/tables.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <string>

using namespace tactus;
using namespace tactus::test;
using stress::check_base;
using stress::StressTable;

TEST_CASE("a re-solved base must have the table's sizes and finite numbers") {
  using Base = stress::StressBase;
  StressTable table = Cantilever::table();
  const auto refusal = [&table](void (*damage)(Base&)) {
    Base base = Cantilever::solve(0.001, 0);
    damage(base);
    return check_base(table, base);
  };
  CHECK(refusal([](Base&) {}) == "");
  CHECK(refusal([](Base& base) { base.von_mises.stress.pop_back(); }) != "");
  CHECK(refusal([](Base& base) { base.von_mises.sensitivity.pop_back(); }) != "");
  CHECK(refusal([](Base& base) { base.displacement_m.push_back(0); }) != "");
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  CHECK(refusal([](Base& base) {
          base.von_mises.sensitivity[7] = kInfinite;
        }).find("not a finite number") != std::string::npos);
  for (const float impossible : {-1e30F, -1.F, 1e30F, kInfinite}) {
    Base base = Cantilever::solve(0.001, 0);
    base.von_mises.stress[3] = impossible;
    CHECK(check_base(table, base).find("0..1e+15 Pa") != std::string::npos);
  }
  table.base.max_shear = table.base.von_mises;
  CHECK(refusal([](Base&) {}) != "");
}
