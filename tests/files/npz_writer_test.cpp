// Archives that are written are read as what they were.
#include "files/npz.hpp"
#include "files/npz_writer.hpp"
#include "tests/files/archives.hpp"

#include <doctest/doctest.h>

#include <complex>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

using namespace tactus::files;
using tactus::test::bytes_of;

namespace {

std::string written(const NpzWriter& writer) {
  std::string file;
  CHECK(writer.emit([&](const void* bytes, std::size_t size) {
    file.append(static_cast<const char*>(bytes), size);
  }) == "");
  return file;
}

} // namespace

TEST_CASE("arrays of every type and shape come back by name, in order") {
  NpzWriter writer;
  const std::vector<double> doubles{1.5, -0.0, 1e300, std::numeric_limits<double>::denorm_min()};
  const std::vector<float> singles{1, 2, 3, 4, 5, 6};
  const std::vector<std::int32_t> small{-5, 7};
  const std::vector<std::int64_t> large{1LL << 40};
  const std::vector<std::complex<float>> waves{{1, 2}, {3, -4}};
  const std::vector<std::uint8_t> text{'{', '}', 255};
  writer.add("reals", doubles, {2, 2});
  writer.add("singles", singles, {1, 2, 3});
  writer.add("small", small, {2});
  writer.add("large", large, {});
  writer.add("waves", waves, {2});
  writer.add("text", text, {3});
  writer.add_bytes("none", "<f8", {}, {0, 3});
  const std::string file = written(writer);
  CHECK(file == written(writer));
  NpzFile read;
  REQUIRE(read.open(bytes_of(file)) == "");
  std::vector<std::string> names;
  for (const NpzArray& array : read.arrays())
    names.push_back(array.name);
  CHECK(names ==
        std::vector<std::string>{"reals", "singles", "small", "large", "waves", "text", "none"});
  CHECK(read.find("reals")->shape == std::vector<std::size_t>{2, 2});
  CHECK(read.find("reals")->values() == doubles);
  CHECK(read.find("singles")->shape == std::vector<std::size_t>{1, 2, 3});
  CHECK(read.find("singles")->single_values() == singles);
  CHECK(read.find("small")->values() == std::vector<double>{-5, 7});
  CHECK(read.find("large")->shape.empty());
  CHECK(read.find("large")->values() == std::vector<double>{1099511627776.0});
  CHECK(read.find("waves")->single_values() == std::vector<float>{1, 2, 3, -4});
  CHECK(read.find("waves")->single_complex_values() ==
        std::vector<std::complex<float>>{{1, 2}, {3, -4}});
  CHECK(read.find("singles")->single_complex_values()[1] == std::complex<float>(singles[1], 0));
  CHECK(read.find("text")->item_bytes == 1);
  CHECK(read.find("text")->values() == std::vector<double>{'{', '}', 255});
  CHECK(read.find("none")->count() == 0);
}

TEST_CASE("the data of every array begins at a multiple of 64 bytes of its member") {
  // NumPy enhancement proposal 1: the header's length is padded for memory maps.
  for (std::size_t name = 1; name < 70; ++name) {
    NpzWriter writer;
    writer.add(std::string(name, 'a'), std::vector<double>{1}, {1});
    const std::string file = written(writer);
    const std::size_t member = file.find("\x93NUMPY");
    NpzFile read;
    REQUIRE(read.open(bytes_of(file)) == "");
    const auto* data = reinterpret_cast<const char*>(read.arrays().front().bytes.data());
    CHECK((data - file.data() - static_cast<std::ptrdiff_t>(member)) % 64 == 0);
  }
}
