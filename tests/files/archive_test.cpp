// NumPy's archives: types, orders, shapes and sizes.
#include "files/npz.hpp"

#include "files/product.hpp"
#include "tests/files/archives.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <string>
#include <vector>

using namespace tactus::files;
using namespace tactus::test;

TEST_CASE("arrays of every type, byte order and layout are the same numbers") {
  const auto read = [](Member member) {
    const std::string file = archive({std::move(member)});
    NpzFile npz;
    REQUIRE(npz.open(bytes_of(file)) == "");
    REQUIRE(npz.find("x"));
    const auto values = npz.find("x")->values();
    const auto singles = npz.find("x")->single_values();
    REQUIRE(values.size() == singles.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      CHECK(singles[i] == static_cast<float>(values[i]));
    CHECK(npz.find("y") == nullptr);
    return values;
  };
  const auto swapped = [](std::string bytes, std::size_t size) {
    for (std::size_t i = 0; i < bytes.size(); i += size)
      std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                   bytes.begin() + static_cast<std::ptrdiff_t>(i + size));
    return bytes;
  };
  const auto check = [&]<class T>(const char* type, const std::vector<T>& numbers,
                                  const std::vector<double>& expected) {
    CAPTURE(type);
    const std::string name = type;
    CHECK(read({"x", "<" + name, {numbers.size()}, raw(numbers)}) == expected);
    CHECK(read({"x", ">" + name, {numbers.size()}, swapped(raw(numbers), sizeof(T))}) == expected);
  };
  check("i1", std::vector<std::int8_t>{-128, 5}, {-128, 5});
  check("u1", std::vector<std::uint8_t>{255, 5}, {255, 5});
  check("i2", std::vector<std::int16_t>{-32768, 300}, {-32768, 300});
  check("u2", std::vector<std::uint16_t>{65535, 300}, {65535, 300});
  check("i4", std::vector<std::int32_t>{-2000000000, 7}, {-2e9, 7});
  check("u4", std::vector<std::uint32_t>{4000000000U, 7}, {4e9, 7});
  check("i8", std::vector<std::int64_t>{-(std::int64_t{1} << 40), 7}, {-1099511627776., 7});
  check("u8", std::vector<std::uint64_t>{std::uint64_t{1} << 63, 7}, {9223372036854775808., 7});
  check("f4", std::vector<float>{-1.5F, 3}, {-1.5, 3});
  check("f8", std::vector<double>{-1.1, 3e200}, {-1.1, 3e200});
  CHECK(read({"x", "|b1", {2}, std::string("\0\1", 2)}) == std::vector<double>{0, 1});
  CHECK(read({"x", "<c8", {2}, raw(std::vector<float>{1, 2, 3, 4})}) ==
        std::vector<double>{1, 2, 3, 4});
  CHECK(read({"x", "<c16", {1}, raw(std::vector<double>{1.1, 2.2})}) ==
        std::vector<double>{1.1, 2.2});
  CHECK(read({"x", "<f8", {}, raw(std::vector<double>{5})}) == std::vector<double>{5});
  CHECK(read({"x", "<f8", {0, 3}, ""}).empty());
  // Columns first: element [i][j][k] stands at i + 2 (j + 3 k).
  std::vector<double> columns(24), rows;
  for (std::size_t i = 0; i < 24; ++i)
    columns[i] = static_cast<double>(i);
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 4; ++k)
        rows.push_back(static_cast<double>(i + 2 * (j + 3 * k)));
  CHECK(read({"x", "<f8", {2, 3, 4}, raw(columns), true}) == rows);
  CHECK(read({"x", "<f8", {2, 3, 4}, raw(rows)}) == rows);
}

TEST_CASE("types, shapes and sizes that are none are refused") {
  const auto refusal = [](const Member& member) {
    const std::string file = archive({member});
    NpzFile npz;
    const std::string sentence = npz.open(bytes_of(file));
    CHECK(npz.arrays().empty() == !sentence.empty());
    return sentence;
  };
  const std::string eight(8, '\1');
  CHECK(refusal({"x", "<f8", {1}, eight}) == "");
  for (const char* type :
       {"<f2", "<f16", "<c4", "<i3", "<u16", "|b2", "<U1", "|O8", "=f8", "f8", "<f"}) {
    CAPTURE(type);
    CHECK(refusal({"x", type, {1}, eight}).find("type") != std::string::npos);
  }
  CHECK(refusal({"x", "<f8", {2}, eight}).find("16") != std::string::npos);
  CHECK(refusal({"x", "<f8", {}, eight + "1"}).find("9 bytes") != std::string::npos);
  CHECK(refusal({"x", "<f8", {1, 1, 1, 1}, eight}) == "");
  CHECK(refusal({"x", "<f8", {1, 1, 1, 1, 1}, eight}).find("shape") != std::string::npos);
  CHECK(refusal({std::string(196, 'a'), "<f8", {1}, eight}) == ""); // with .npy 200 letters
  CHECK(refusal({std::string(197, 'a'), "<f8", {1}, eight}) != "");
  CHECK(refusal({"a-b.c_9Z", "<f8", {1}, eight}) == "");
  for (const char* name : {"a/b", "a b", "..", "a\\b", "a:b", "\xc3\xa9"}) {
    CAPTURE(name);
    CHECK(refusal({name, "<f8", {1}, eight}).find("plain name") != std::string::npos);
  }
  std::vector<std::pair<std::string, std::string>> many;
  for (int i = 0; i < 1001; ++i)
    many.emplace_back(std::to_string(i), "");
  NpzFile npz;
  CHECK(npz.open(bytes_of(zip(many))).find("1000") != std::string::npos);
  many.pop_back();
  CHECK(npz.open(bytes_of(zip(many))) == "");
  CHECK(npz.arrays().empty()); // none is a .npy
}

TEST_CASE(
    "a member that is cut off or shares bytes with another is refused, whatever stands behind") {
  const std::string whole = archive({{"x", "<f8", {4}, std::string(32, '\1')}});
  const std::size_t directory = whole.find("PK\x01\x02");
  NpzFile npz;
  // The archive's end comes first: the member's bytes go on behind the end of the file, with the
  // right checksum, where memory holds them.
  const std::string local = whole.substr(0, directory), rest = whole.substr(directory);
  std::string moved = rest;
  const auto set = [&](std::size_t at, std::size_t value) {
    std::string bytes;
    put(bytes, value, 4);
    moved.replace(at, 4, bytes);
  };
  const std::size_t end = moved.find("PK\x05\x06");
  set(42, rest.size());
  set(end + 16, 0);
  moved += local;
  for (const std::size_t missing : {std::size_t{1}, std::size_t{32}}) {
    const auto refused = npz.open(bytes_of(moved).first(moved.size() - missing));
    mentions(refused, {"damaged"});
  }
  CHECK(npz.open(bytes_of(moved)) == "");

  // A thousand names for one megabyte: refused before the first checksum.
  std::string file = zip({{"a.npy", npy({"a", "|u1", {1u << 20}, std::string(1u << 20, '\2')})}});
  const std::size_t begin = file.find("PK\x01\x02"), close = file.find("PK\x05\x06");
  std::string entries, tail = file.substr(close);
  for (int i = 0; i < 999; ++i) {
    std::string entry = file.substr(begin, close - begin);
    std::string name = std::to_string(1000 + i) + ".npy";
    entry.replace(28, 2, std::string{static_cast<char>(name.size()), '\0'});
    entries += entry.substr(0, 46) + name;
  }
  std::string numbers;
  put(numbers, 999, 2);
  put(numbers, 999, 2);
  put(numbers, entries.size(), 4);
  put(numbers, begin, 4);
  tail.replace(8, 12, numbers);
  file = file.substr(0, begin) + entries + tail;
  const std::clock_t began = std::clock(); // of the processor
  mentions(npz.open(bytes_of(file)), {"overlap"});
  CHECK(std::clock() - began < CLOCKS_PER_SEC / 20); // a thousand checksums take half a second
}

TEST_CASE("products that size_t does not hold are nothing, in 32 bits too") {
  CHECK(product<std::uint32_t>(65536, 65535) == 4294901760U);
  CHECK(!product<std::uint32_t>(65536, 65536));
  CHECK(!product<std::uint32_t>(std::uint64_t{1} << 32, 1));
  CHECK(!product<std::uint32_t>(50, 0xffffffff)); // of a binary STL's triangles
  CHECK(product<std::uint32_t>(std::uint64_t{1} << 31, 0) == 0U);
  CHECK(product<std::uint64_t>(std::uint64_t{1} << 32, 1) == std::uint64_t{1} << 32);
  CHECK(!product<std::uint64_t>(std::uint64_t{1} << 32, std::uint64_t{1} << 32));
}

TEST_CASE("checksums are those of the polynomial's division, bit by bit, for every length") {
  CHECK(crc32(bytes_of("123456789")) == 0xcbf43926U); // the check value of its definition
  std::string text;
  for (int i = 0; i < 70; ++i) {
    CHECK(crc32(bytes_of(text)) == plain_crc32(text));
    text += static_cast<char>(i * i * 37 + 11 * i);
  }
}
