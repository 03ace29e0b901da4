// JSON: what it is and what it is not.
#include "files/json.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace tactus::files;

TEST_CASE("JSON is read as RFC 8259 has it") {
  Json j;
  REQUIRE(
      read_json(" { \"a\" : [1, -2.5e3 ,true,false,null,\"x\\\"\\\\\\/\\n\\u00e9y\"] ,\t\"b\":{}"
                ",\"c\":[],\"a\":7}\r\n",
                j));
  CHECK(j.kind == Json::Kind::kObject);
  CHECK(j.keys == std::vector<std::string>{"a", "b", "c", "a"});
  const Json* a = j.find("a");
  REQUIRE(a);
  REQUIRE(a->list.size() == 6);
  CHECK(a->list[0].number == 1);
  CHECK(a->list[1].number == -2500);
  CHECK(a->list[2].kind == Json::Kind::kBoolean);
  CHECK(a->list[2].number == 1);
  CHECK(a->list[3].kind == Json::Kind::kBoolean);
  CHECK(a->list[3].number == 0);
  CHECK(a->list[4].kind == Json::Kind::kNull);
  CHECK(a->list[5].text == "x\"\\/ \xc3\xa9y");
  CHECK(j.find("b")->kind == Json::Kind::kObject);
  CHECK(j.find("c")->kind == Json::Kind::kList);
  CHECK(j.find("d") == nullptr);
  CHECK(a->find("a") == nullptr);
  CHECK(j.number_or("a", 3) == 3); // no number
  CHECK(j.number_or("d", 3) == 3);
  CHECK(j.text_or("a", "none") == "none");
  REQUIRE(read_json(R"({"n":4,"t":"five"})", j));
  CHECK(j.number_or("n", 3) == 4);
  CHECK(j.text_or("t", "none") == "five");
  CHECK(j.text_or("n", "none") == "none");
  for (const char* text : {"1", "-0.5", "0", "-0", "10.25E+2", "0e0", "\"\"", "null", "[[[]]]",
                           "\"\\b\\f\\r\\t\"", "[\"\\u1234\"]"})
    CHECK(read_json(text, j));
  for (const char* text :
       {"",         " ",          "{",       "}",       "[",         "]",
        "[1",       "[1,",        "[1,]",    "[,1]",    "[1 2]",     "{\"a\"}",
        "{\"a\":}", "{\"a\":1,}", "{a:1}",   "{1:1}",   "{\"a\" 1}", "\"",
        "\"a",      "\"\\",       "\"\\x\"", "\"\\u12", "tru",       "nul",
        "fals",     "truth",      "1 2",     "[] []",   "+1",        "-",
        "-.5",      "1.",         "1.e3",    "01",      "-012",      "\"\\u12g4\"",
        ".5",       "nan",        "inf",     "1e999",   "\"a\nb\"",  "{\"a\":1]",
        "[1}"}) {
    CAPTURE(text);
    CHECK(!read_json(text, j));
  }
}

TEST_CASE("depth is bounded for every kind of value, however long the text") {
  Json j;
  const auto around = [&](const std::string& value, std::size_t depth) {
    return read_json(std::string(depth, '[') + value + std::string(depth, ']'), j);
  };
  for (const char* value : {"1", "-1", "1.5", "true", "null", "\"x\"", "{}", "[]"}) {
    CAPTURE(value);
    CHECK(around(value, 32));
    CHECK(!around(value, 33));
  }
  for (const char* opening : {"[", "{\"a\":"})
    for (const int depth : {33, 200000}) {
      std::string text;
      for (int i = 0; i < depth; ++i)
        text += opening;
      CHECK(!read_json(text + "1" + std::string(33, opening[0] == '[' ? ']' : '}'), j));
    }
}

TEST_CASE("numbers are the nearest doubles") {
  Json j;
  const auto number = [&](const char* text) {
    REQUIRE(read_json(text, j));
    CHECK(j.kind == Json::Kind::kNumber);
    return j.number;
  };
  CHECK(number("0.1") == 0.1);
  CHECK(number("70300000000") == 7.03e10);
  CHECK(number("-9007199254740993") == -9007199254740992.0);
  CHECK(number("18446744073709551615") == 18446744073709551616.0);
  CHECK(number("123456789012345678901234567890") == 123456789012345678901234567890.0);
  CHECK(number("4.9e-324") == 4.9e-324);
}

TEST_CASE("texts are one line, and bytes that are no UTF-8 stay") {
  Json j;
  REQUIRE(read_json("\"a\\n\\u0000\\u001fb\"", j));
  CHECK(j.text == "a   b");
  REQUIRE(read_json("\"\xe9\xff\x80 \xc3\xa9 \\u20ac \\ud834\\udd1e\"", j));
  CHECK(j.text == "\xe9\xff\x80 \xc3\xa9 \xe2\x82\xac \xf0\x9d\x84\x9e");
  REQUIRE(read_json("{\"\xe9\\t\":1}", j));
  CHECK(j.number_or("\xe9 ", 0) == 1);
  CHECK(!read_json("\xe9", j));
  CHECK(!read_json("\xef\xbb\xbf[]", j)); // a byte order mark
  CHECK(!read_json("[1] // comment", j));
}

TEST_CASE("a text that is quoted is read as it was") {
  CHECK(quoted_json("") == "\"\"");
  CHECK(quoted_json("a\"b\\c/") == "\"a\\\"b\\\\c/\"");
  CHECK(quoted_json("\n\x01") == "\"\\n\\u0001\"");
  std::string all;
  for (int c = 0x20; c < 256; ++c)
    all += static_cast<char>(c);
  Json j;
  REQUIRE(read_json(quoted_json(all), j));
  CHECK(j.text == all);
}
