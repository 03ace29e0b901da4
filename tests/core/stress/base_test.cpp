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
  const StressTable table = Cantilever::table();
  CHECK(check_base(table, Cantilever::solve(0.001, 0)) == "");
  auto base = Cantilever::solve(0.001, 0);
  base.von_mises.stress.pop_back();
  CHECK(check_base(table, base) != "");
  base = Cantilever::solve(0.001, 0);
  base.von_mises.sensitivity.pop_back();
  CHECK(check_base(table, base) != "");
  base = Cantilever::solve(0.001, 0);
  base.displacement_m.push_back(0);
  CHECK(check_base(table, base) != "");
  base = Cantilever::solve(0.001, 0);
  base.von_mises.sensitivity[7] = std::numeric_limits<float>::infinity();
  CHECK(check_base(table, base).find("not finite") != std::string::npos);
  auto with_shear = table;
  with_shear.base.max_shear = with_shear.base.von_mises;
  CHECK(check_base(with_shear, Cantilever::solve(0, 0)) != "");
}
