#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// NumPy archives for the reader, made here byte by byte.
namespace tactus::test {

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

inline Member& named(std::vector<Member>& members, std::string_view name) {
  for (Member& m : members)
    if (m.name == name)
      return m;
  return members.emplace_back(Member{std::string(name), "<f8", {}, {}});
}

/// A change to the arrays of a table.
using Change = std::function<void(std::vector<Member>&)>;

/// These numbers in place of an array's own, or in a new one.
template <class T>
Change array(const char* name, std::vector<T> numbers, std::vector<std::size_t> shape) {
  static_assert(std::is_floating_point_v<T> || std::is_signed_v<T>);
  return [=](std::vector<Member>& members) {
    Member& m = named(members, name);
    m.type = (std::is_floating_point_v<T> ? "<f" : "<i") + std::to_string(sizeof(T));
    m.data = raw(numbers);
    m.shape = shape;
  };
}
/// As many numbers as there were.
template <class T> Change array(const char* name, std::vector<T> numbers) {
  return [=](std::vector<Member>& members) {
    array(name, numbers, named(members, name).shape)(members);
  };
}
inline Change meta(const std::string& text) {
  return [=](std::vector<Member>& members) {
    named(members, "meta").data = text;
    named(members, "meta").shape = {text.size()};
  };
}
inline Change without(const std::string& name) {
  return [=](std::vector<Member>& members) {
    std::erase_if(members, [&](const Member& m) { return m.name == name; });
  };
}

/// Whether a sentence is one line with all of these words.
inline void mentions(const std::string& sentence, std::initializer_list<std::string> words) {
  CAPTURE(sentence);
  CHECK(!sentence.empty());
  CHECK(sentence.find('\n') == std::string::npos);
  for (const std::string& word : words) {
    CAPTURE(word);
    CHECK(sentence.find(word) != std::string::npos);
  }
}

} // namespace tactus::test
