#pragma once

#include "core/stress/stress_table.hpp"
#include "tests/core/stress/tables.hpp"
#include "tests/files/archives.hpp"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace tactus::test {

using stress::StressTable;

struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    static std::atomic<int> count{0};
    path = std::filesystem::temp_directory_path() /
           ("externals_test." +
            std::to_string(std::chrono::steady_clock::now().time_since_epoch().count()) + "." +
            std::to_string(count++));
    std::filesystem::create_directories(path);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

/// With the cantilever's table in it.
struct TableFolder : TemporaryFolder {
  TableFolder() { write("cantilever.stress.npz", Cantilever::table()); }

  void write(const std::string& name, const StressTable& table) const {
    const std::string meta = R"({"format":"stress-table","version":"1.0","name":")" + name + "\"}";
    std::vector<double> rows, points;
    for (const auto& p : table.parameters)
      rows.insert(rows.end(), {static_cast<double>(p.control_point), static_cast<double>(p.axis),
                               p.low_m, p.high_m});
    for (const Vec3& c : table.control_point_m)
      points.insert(points.end(), {c.x, c.y, c.z});
    const auto& field = table.base.von_mises;
    const std::size_t p = table.parameters.size();
    std::vector<double> nodes;
    for (const Vec3& node : table.surface_node_m)
      nodes.insert(nodes.end(), {node.x, node.y, node.z});
    std::vector<std::int32_t> corners;
    for (const auto& triangle : table.surface_triangle)
      corners.insert(corners.end(), triangle.begin(), triangle.end());
    const std::size_t c = table.control_point_m.size(), v = nodes.size() / 3;
    std::vector<test::Member> members{
        {"meta", "|u1", {meta.size()}, meta},
        {"s0", "<f4", {table.elements()}, test::raw(field.stress)},
        {"S", "<f4", {p, table.elements()}, test::raw(field.sensitivity)},
        {"parameters", "<f8", {p, 4}, test::raw(rows)},
        {"control_points", "<f8", {points.size() / 3, 3}, test::raw(points)},
        {"trust", "<f8", {}, test::raw(std::vector<double>{table.trust_m})}};
    if (v > 0) {
      members.push_back({"surface_nodes", "<f8", {v, 3}, test::raw(nodes)});
      members.push_back({"surface_triangles", "<i4", {corners.size() / 3, 3}, test::raw(corners)});
      members.push_back(
          {"surface_node_element", "<i4", {v}, test::raw(table.surface_node_element)});
    }
    if (v > 0 && table.surface_weight.size() == v * c)
      members.push_back({"surface_weights", "<f4", {v, c}, test::raw(table.surface_weight)});
    std::ofstream(path / name, std::ios::binary) << test::archive(members);
  }
};

} // namespace tactus::test
