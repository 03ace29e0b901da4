#include "core/text.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

using namespace tactus;

TEST_CASE("a number is the whole text, as C++ writes it, with a plus or without") {
  for (const char* text :
       {"1000", "+1000", "1e3", "+1E+3", "1000.0", "1000.", " 1000\t", "\r1000\n"})
    CHECK(to_number(text) == 1000);
  CHECK(to_number("-.5") == -0.5);
  CHECK(to_number("-0.5e-3") == -0.5e-3);
  for (const char* text : {"",   " ",  "+",   "-",  "+-3", "-+3", "++3", "+ 3",  "3 4", "3,4",
                           "3x", "x3", "0x3", "1e", "e3",  ".",   "inf", "-inf", "nan", "1e999"})
    CHECK(!to_number(text));
}

TEST_CASE("whole numbers are read by the same rule, as far as the type holds them") {
  CHECK(to_number<int>("+3") == 3);
  CHECK(to_number<int>("-3") == -3);
  CHECK(to_number<std::size_t>("3") == 3);
  CHECK(!to_number<std::size_t>("-3"));
  CHECK(!to_number<int>("3.0"));
  CHECK(!to_number<int>("3e0"));
  CHECK(!to_number<std::int32_t>("2147483648"));
  CHECK(to_number("5", 1, 5) == 5);
  CHECK(!to_number("6", 1, 5));
  double kept = 7;
  CHECK(read_number("1e999", kept) == std::errc::result_out_of_range);
  CHECK(read_number("1-2", kept) == std::errc::invalid_argument);
  CHECK(kept == 7);
}

TEST_CASE("blanks and what else separates them stand between words") {
  using List = std::vector<std::string_view>;
  CHECK(split_words(" a \t b\r\n") == List{"a", "b"});
  CHECK(split_words("a,b, ;c", ",;") == List{"a", "b", "c"});
  CHECK(split_words(" \t").empty());
  Words words(" one  two three ");
  CHECK(words.next() == "one");
  CHECK(words.rest() == "two three");
}

TEST_CASE("lines end with LF, CR LF or CR") {
  std::vector<std::string> lines;
  for_each_line("a\nb\r\n\rc\n\nd", [&](std::size_t number, std::string_view line) {
    lines.push_back(std::to_string(number) + std::string(line));
    return line != "d";
  });
  CHECK(lines == std::vector<std::string>{"1a", "2b", "3", "4c", "5", "6d"});
}

TEST_CASE("text of unknown origin is shown without control characters, and cut") {
  CHECK(printable("a\x1b[2J\x7f") == "a?[2J?");
  CHECK(printable("abcdef", 3) == "abc...");
  CHECK(printable("abc", 3) == "abc");
}
