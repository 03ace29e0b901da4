#include "core/decimal.hpp"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <system_error>
#include <version>

using namespace tactus;

namespace {

std::uint64_t bits_of(std::string_view text) {
  double value = 7;
  CHECK(read_decimal(text, value) == std::errc{});
  return std::bit_cast<std::uint64_t>(value);
}

#ifdef __cpp_lib_to_chars
/// The library's own reading, for the whole text.
void check_like_the_library(const std::string& text) {
  double ours = 7, theirs = 7;
  const std::errc error = read_decimal(text, ours);
  const auto [stopped, expected] = std::from_chars(text.data(), text.data() + text.size(), theirs);
  INFO(text);
  const bool whole = stopped == text.data() + text.size();
  CHECK(error == (whole ? expected : std::errc::invalid_argument));
  theirs = whole ? theirs : 7;
  CHECK(std::bit_cast<std::uint64_t>(ours) == std::bit_cast<std::uint64_t>(theirs));
}
#endif

template <class Number> std::string shown(Number value, int digits) {
  std::array<char, 2000> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value,
                                          std::chars_format::scientific, digits - 1);
  return {text.data(), end};
}

} // namespace

TEST_CASE("a decimal number is rounded to the nearest double, ties to even") {
  CHECK(bits_of("0.1") == 0x3fb999999999999a);
  CHECK(bits_of("-0") == 0x8000000000000000);
  // 2^53 + 1 lies halfway; the slightest more is nearer to the double above.
  CHECK(bits_of("9007199254740993") == std::bit_cast<std::uint64_t>(9007199254740992.0));
  CHECK(bits_of("9007199254740995") == std::bit_cast<std::uint64_t>(9007199254740996.0));
  CHECK(bits_of("9007199254740993." + std::string(900, '0') + "1") ==
        std::bit_cast<std::uint64_t>(9007199254740994.0));
  // The limits of double: the largest, the smallest normal and subnormal.
  CHECK(bits_of("1.7976931348623157e308") == 0x7fefffffffffffff);
  CHECK(bits_of("2.2250738585072014e-308") == 0x0010000000000000);
  CHECK(bits_of("2.2250738585072011e-308") == 0x000fffffffffffff);
  CHECK(bits_of("5e-324") == 1);
}

TEST_CASE("what no double holds is out of range, what is no number is invalid") {
  double kept = 7;
  for (const char* text : {"1e309", "1.797693134862315808e308", "1e999999999999999999999", "2e-324",
                           "-1e-999", "1e-999999999999999999999"})
    CHECK(read_decimal(text, kept) == std::errc::result_out_of_range);
  for (const char* text : {"", "-", ".", "e3", "1e", "1e+", "--1", "+1", "1.2.3", "1x", " 1", "1 ",
                           "0x1", "inf", "nan", "1e5.", "-.e1"})
    CHECK(read_decimal(text, kept) == std::errc::invalid_argument);
  CHECK(kept == 7);
  CHECK(bits_of("0e999999999999999999999") == 0);
}

TEST_CASE("what to_chars writes of a double is read as this double") {
  std::mt19937_64 draw(1);
  for (int i = 0; i < 3000; ++i) {
    const auto value = std::bit_cast<double>(draw());
    if (!std::isfinite(value))
      continue;
    for (const int digits : {17, 25, 780})
      CHECK(bits_of(shown(value, digits)) == std::bit_cast<std::uint64_t>(value));
  }
}

#ifdef __cpp_lib_to_chars
TEST_CASE("every text is read as from_chars reads it") {
  std::mt19937_64 draw(2);
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    const auto letters = draw() % 30;
    for (std::uint64_t k = 0; k < letters; ++k)
      text += "0123456789019900.-e+"[draw() % 20];
    check_like_the_library(text);
    check_like_the_library(std::to_string(draw()) + "e" +
                           std::to_string(static_cast<int>(draw() % 700) - 360));
  }
}

TEST_CASE("halfway between two doubles the even one is read, beside it the nearer one") {
  if (std::numeric_limits<long double>::digits < 64)
    return; // no type holds the middle
  std::mt19937_64 draw(3);
  for (int i = 0; i < 3000; ++i) {
    auto whole = static_cast<long double>((draw() >> 10) | (std::uint64_t{1} << 53) | 1);
    int exponent = static_cast<int>(draw() % 2000) - 1075;
    if (i % 4 == 0) { // subnormal
      whole = static_cast<long double>((draw() >> (14 + i % 48)) | 1);
      exponent = -1075;
    }
    std::string text = shown(std::ldexp(whole, exponent), 790);
    check_like_the_library(text);
    text[text.find('e') - 1] = '1';
    check_like_the_library(text);
  }
}
#endif
