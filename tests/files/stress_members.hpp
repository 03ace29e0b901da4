#pragma once

#include "tests/files/archives.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace tactus::test {

/// Arrays of a small sound file with everything in it.
inline std::vector<Member> small_stress_table() {
  const std::string meta =
      R"({"format":"stress-table","version":"1.0","name":"four","material":{"name":"steel"},)"
      R"("loads":"1 N","units":{"stress":"Pa","length":"m"}})";
  const std::vector<double> two{1, 2, 3, 4, 5, 6, 7, 8};
  return {
      {"meta", "|u1", {meta.size()}, meta},
      {"s0", "<f8", {4}, raw(std::vector<double>{10, 20, 30, 40})},
      {"S", "<f8", {2, 4}, raw(two)},
      {"shear0", "<f4", {4}, raw(std::vector<float>{5, 6, 7, 8})},
      {"S_shear", "<f4", {2, 4}, raw(std::vector<float>{8, 7, 6, 5, 4, 3, 2, 1})},
      {"weights", "<f8", {4}, raw(std::vector<double>{1e-6, 2e-6, 3e-6, 4e-6})},
      {"parameters", "<f8", {2, 4}, raw(std::vector<double>{1, 0, -0.01, 0.02, 0, 2, 0, 0.03})},
      {"control_points", "<f8", {2, 3}, raw(std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5})},
      {"trust", "<f8", {}, raw(std::vector<double>{0.005})},
      {"surface_nodes", "<f4", {3, 3}, raw(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0})},
      {"surface_triangles", "<i4", {1, 3}, raw(std::vector<std::int32_t>{0, 1, 2})},
      {"surface_weights", "<f4", {3, 2}, raw(std::vector<float>{1, 0, 0.5F, 0.5F, 0, 1})},
      {"surface_node_element", "<i4", {3}, raw(std::vector<std::int32_t>{3, 2, 0})},
  };
}

} // namespace tactus::test
