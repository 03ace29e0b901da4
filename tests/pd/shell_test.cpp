#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <limits>

// The shell itself, through the probe: a class with one of everything.

using namespace tactus;
using namespace tactus::test;

namespace {
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void expect_no_errors() {
  for (const std::string& sentence : errors())
    FAIL_CHECK("unexpected: ", sentence);
}
} // namespace

TEST_CASE("flags, positional arguments and at-sign attributes set parameters") {
  for (const MessageAtoms& arguments :
       {MessageAtoms{3, "-sign", "minus"}, MessageAtoms{"-gain", 3, "-sign", "minus"},
        MessageAtoms{"@gain", 3, "@sign", "minus"}}) {
    Box box("probe~", arguments);
    REQUIRE(box.made());
    box.send("get");
    const auto answers = sent();
    REQUIRE(answers.size() == 2);
    CHECK(answers[0].selector == "gain");
    CHECK(answers[0].atoms == MessageAtoms{3});
    CHECK(answers[1].selector == "sign");
    CHECK(answers[1].atoms == MessageAtoms{"minus"});
    expect_no_errors();
  }
}

TEST_CASE("malformed creation arguments make no object and one sentence") {
  for (const MessageAtoms& arguments :
       {MessageAtoms{1, 2}, MessageAtoms{"-gian", 1}, MessageAtoms{"loud"},
        MessageAtoms{"-echo", 1, "-unknown"}}) {
    Box box("probe~", arguments);
    const auto said = errors();
    CAPTURE(said.size());
    if (arguments[0].is_word && arguments[0].text == "loud") {
      CHECK(box.made()); // a value out of range is refused, the object stays
    } else {
      CHECK_FALSE(box.made());
    }
    REQUIRE(said.size() == 1);
    CHECK(said[0].rfind("probe~: ", 0) == 0);
  }
}

TEST_CASE("the left inlet's number is the signal while nothing is connected") {
  Box box("probe~");
  box.dsp(48000, 64);
  box.send("float", {2});
  box.send(1, "float", {0.25});
  CHECK(box.run({}, 64)[0][63] == 0.5);
  expect_no_errors();
}

TEST_CASE("control inlets take numbers and refuse words") {
  Box box("probe~");
  box.send(2, "float", {7});
  const auto answers = sent();
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].selector == "scalar");
  CHECK(answers[0].atoms == MessageAtoms{2, 7});
  box.send(2, "symbol", {"word"});
  CHECK(errors().size() == 1);
}

TEST_CASE("list inlets take lists and numbers, and refuse words") {
  Box box("probe~");
  box.send(3, "list", {7, "eight", 9});
  box.send(3, "float", {5});
  const auto answers = sent();
  REQUIRE(answers.size() == 2);
  CHECK(answers[0].selector == "list");
  CHECK(answers[0].atoms == MessageAtoms{3, 7, "eight", 9});
  CHECK(answers[1].atoms == MessageAtoms{3, 5});
  expect_no_errors();
  box.send(3, "symbol", {"word"});
  CHECK(errors().size() == 1);
}

TEST_CASE("a message with the wrong number of arguments is refused") {
  Box box("probe~");
  box.send("wake");
  box.send("wake", {1, 2});
  box.send("gain");
  box.send("gain", {1, 2});
  CHECK(errors().size() == 4);
}

TEST_CASE("timers answer in logical time and can be replaced") {
  Box box("probe~");
  box.send("wake", {50});
  box.send("wake", {20});
  host_advance(30);
  auto answers = sent();
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].selector == "awake");
  CHECK(answers[0].atoms[0].number == doctest::Approx(20));
  host_advance(100);
  CHECK(sent().empty());
}

TEST_CASE("control outlets speak after the block, once for each") {
  Box box("probe~");
  box.dsp(48000, 16);
  static_cast<void>(box.run({}, 64));
  const auto answers = sent();
  REQUIRE(answers.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(answers[i].outlet == 1);
    CHECK(answers[i].atoms[0].number == static_cast<double>(i + 1));
  }
}

TEST_CASE("an object dropped with clocks pending leaves none behind") {
  {
    Box box("probe~");
    box.dsp(48000, 16);
    static_cast<void>(box.run({}, 16));
    box.send("wake", {5});
  }
  static_cast<void>(sent());
  host_advance(10);
  CHECK(sent().empty());
}

TEST_CASE("lists, bangs and symbols that mean nothing get one sentence each") {
  Box box("probe~");
  box.send("bang");
  box.send("list", {1, 2, 3});
  box.send("symbol", {"word"});
  box.send("nonsense", {kNan});
  CHECK(errors().size() == 4);
}

TEST_CASE("every channel of a newer Pd's signal is heard") {
  Box box("probe~");
  box.dsp(48000, 8, 3);
  if (box.run({}, 8)[0].size() != 24)
    return; // an older host
  std::vector<double> a(24), b(24, 2.0);
  for (std::size_t i = 0; i < 24; ++i)
    a[i] = static_cast<double>(i);
  const auto out = box.run({a, b}, 8)[0];
  for (std::size_t i = 0; i < 24; ++i)
    CHECK(out[i] == 2 * a[i]);
  expect_no_errors();
}
