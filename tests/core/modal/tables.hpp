#pragma once

#include "core/modal/modal_table.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Bodies in closed form, and files for the reader made here byte by byte.
namespace tactus::test {

using modal::ModalTable;
using modal::Vec3;

/// A .npy member.
struct Member {
  std::string name, type;
  std::vector<std::size_t> shape;
  std::string data;
  bool fortran = false;
};

template <class T> std::string raw(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty())
    std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::string npy(const Member& m) {
  std::string header = "{'descr': '" + m.type +
                       "', 'fortran_order': " + (m.fortran ? "True" : "False") + ", 'shape': (";
  for (const std::size_t extent : m.shape)
    header += std::to_string(extent) + ", ";
  header += "), }";
  while ((header.size() + 11) % 64)
    header += ' ';
  header += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  out += static_cast<char>(header.size() & 0xff);
  out += static_cast<char>(header.size() >> 8);
  return out + header + m.data;
}

inline std::uint32_t plain_crc32(std::string_view bytes) { // bit by bit, not the reader's table
  std::uint32_t sum = 0xffffffff;
  for (const char c : bytes) {
    sum ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit)
      sum = sum & 1 ? sum >> 1 ^ 0xedb88320 : sum >> 1;
  }
  return ~sum;
}

inline void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i)
    out += static_cast<char>(i < 8 ? value >> 8 * i & 0xff : 0);
}

/// A ZIP archive of stored members; method 8 claims that they are compressed.
inline std::string zip(const std::vector<std::pair<std::string, std::string>>& members,
                       int method = 0) {
  std::string out, directory;
  for (const auto& [name, content] : members) {
    const auto offset = out.size();
    std::string common;
    put(common, 20, 2);
    put(common, 0, 2);
    put(common, static_cast<std::uint64_t>(method), 2);
    put(common, 0, 4);
    put(common, plain_crc32(content), 4);
    put(common, content.size(), 4);
    put(common, content.size(), 4);
    put(common, name.size(), 2);
    put(common, 0, 2);
    out += "PK\x03\x04" + common + name + content;
    directory += "PK\x01\x02";
    put(directory, 20, 2);
    directory += common;
    put(directory, 0, 2 + 2 + 2 + 4);
    put(directory, offset, 4);
    directory += name;
  }
  const auto begin = out.size();
  out += directory + std::string("PK\x05\x06");
  put(out, 0, 4);
  put(out, members.size(), 2);
  put(out, members.size(), 2);
  put(out, directory.size(), 4);
  put(out, begin, 4);
  put(out, 0, 2);
  return out;
}

inline std::string archive(const std::vector<Member>& members) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const Member& m : members)
    files.emplace_back(m.name + ".npy", npy(m));
  return zip(files);
}

inline std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

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

inline Member& named(std::vector<Member>& members, std::string_view name) {
  for (Member& m : members)
    if (m.name == name)
      return m;
  return members.emplace_back(Member{std::string(name), "<f8", {}, {}});
}

/// A simply supported rectangular plate (Leissa 1969, section 4.1) of aluminium, centred in the x-y
/// plane; one face is enough for it.
inline ModalTable plate(double a = 0.32, double b = 0.2, double h = 0.005, double highest = 20000,
                        std::size_t columns = 32, std::size_t rows = 20) {
  constexpr double kPi = std::numbers::pi, kE = 70.3e9, kNu = 0.33, kRho = 2700;
  ModalTable table;
  table.body_name = "plate";
  table.boundary = "simply supported";
  table.free = false;
  table.material = {"aluminium", kE, kNu, kRho};
  table.mass_kg = kRho * a * b * h;
  const double factor = kPi / 2 * std::sqrt(kE * h * h * h / (12 * (1 - kNu * kNu)) / (kRho * h));
  std::multimap<double, std::pair<int, int>> modes;
  for (int m = 1; m < 60; ++m)
    for (int n = 1; n < 60; ++n) {
      const double f = factor * (m * m / (a * a) + n * n / (b * b));
      if (f < highest)
        modes.insert({f, {m, n}});
    }
  for (std::size_t k = 0; k <= rows; ++k)
    for (std::size_t i = 0; i <= columns; ++i)
      table.vertex_m.push_back({a * (static_cast<double>(i) / static_cast<double>(columns) - 0.5),
                                b * (static_cast<double>(k) / static_cast<double>(rows) - 0.5),
                                h / 2});
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t i = 0; i < columns; ++i) {
      const auto p = static_cast<std::int32_t>(k * (columns + 1) + i);
      const auto r = static_cast<std::int32_t>(p + static_cast<std::int32_t>(columns) + 2);
      table.triangle.push_back({p, p + 1, r});
      table.triangle.push_back({p, r, r - 1});
    }
  for (const auto& [f, mn] : modes) {
    table.frequency_hz.push_back(f);
    table.loss_factor.push_back(1e-3);
    for (const Vec3& v : table.vertex_m) {
      table.shape.push_back(0);
      table.shape.push_back(0);
      table.shape.push_back(static_cast<float>(2 / std::sqrt(table.mass_kg) *
                                               std::sin(mn.first * kPi * (v.x / a + 0.5)) *
                                               std::sin(mn.second * kPi * (v.y / b + 0.5))));
    }
  }
  return table;
}

} // namespace tactus::test
