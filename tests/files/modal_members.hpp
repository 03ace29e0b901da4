#pragma once

#include "tests/files/archives.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace tactus::test {

/// Arrays of a small sound table: a free tetrahedron with two made-up modes.
inline std::vector<Member> small_table() {
  const std::string meta = R"({"format":"modal-table","version":"1.0","body_name":"four corners",)"
                           R"("bc":"free","material":{"name":"x","E":7e10,"nu":0.3,"rho":2700}})";
  return {
      {"meta", "|u1", {meta.size()}, meta},
      {"freq", "<f8", {2}, raw(std::vector<double>{440, 1000})},
      {"eta", "<f8", {2}, raw(std::vector<double>{1e-3, 2e-3})},
      {"phi", "<f4", {2, 4, 3}, raw(std::vector<float>{1,  0, 0, 0, 2, 0, 0, 0, 3, -1, 0, 0,
                                                       .5, 0, 0, 0, 1, 0, 0, 0, 1, -1, 1, 0})},
      {"xyz", "<f4", {4, 3}, raw(std::vector<float>{0, 0, 0, .1F, 0, 0, 0, .1F, 0, 0, 0, .1F})},
      {"tri", "<i4", {4, 3}, raw(std::vector<std::int32_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})},
      {"mass", "<f8", {}, raw(std::vector<double>{0.2})},
      {"com", "<f8", {3}, raw(std::vector<double>{.025, .025, .025})},
      {"inertia", "<f8", {3, 3}, raw(std::vector<double>{1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4})},
  };
}

} // namespace tactus::test
