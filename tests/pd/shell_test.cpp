#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <utility>

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

TEST_CASE("positional arguments stand before, between or after flags, which refine them") {
  const auto echoed = [](const MessageAtoms& arguments) {
    Box box("probe~", arguments);
    REQUIRE(box.made());
    const auto answers = sent();
    REQUIRE(answers.size() == 1); // of echo, which sends its words as a message
    MessageAtoms words = answers[0].atoms;
    words.insert(words.begin(), MessageAtom(answers[0].selector));
    box.send("get", {"gain"});
    words.push_back(sent().at(0).atoms.at(0));
    return words;
  };
  CHECK(echoed({2, "hello", "-sign", "minus"}) == MessageAtoms{"hello", 2});
  CHECK(echoed({"-sign", "minus", 2, "hello"}) == MessageAtoms{"hello", 2});
  CHECK(echoed({2, "-sign", "minus", "hello"}) == MessageAtoms{"hello", 2});
  CHECK(echoed({"-gain", 3, 2, "hello"}) == MessageAtoms{"hello", 3});
  CHECK(echoed({2, "hello", "-gain", 3}) == MessageAtoms{"hello", 3});
  CHECK(echoed({2, "-echo", "hello", "there"}) ==
        MessageAtoms{"hello", "there", 2}); // takes all it can
}

TEST_CASE("malformed creation arguments make no object and one sentence") {
  for (const MessageAtoms& arguments :
       {MessageAtoms{"-wake", 1, 2, "-wake", 2, 3, "-wake", 1, 4}, MessageAtoms{"-gian", 1},
        MessageAtoms{"loud"}, MessageAtoms{"-echo", 1, "-unknown"}}) {
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

TEST_CASE("bangs and symbols that mean nothing get one sentence each, which names what there is") {
  Box box("probe~");
  box.send("bang");
  box.send("list");
  box.send("symbol", {"word"});
  box.send("nonsense", {kNan});
  const auto said = errors();
  REQUIRE(said.size() == 4);
  CHECK(said[0] == "probe~: no message 'bang'; there are echo and wake");
  CHECK(said[1] == said[0]); // an empty list is a bang
  CHECK(said[2] == "probe~: no message 'symbol'; there are echo and wake");
}

TEST_CASE("a list is a number for each inlet, signals and control, or one sentence") {
  Box box("probe~");
  box.dsp(48000, 64);
  box.send("list", {2, 0.25, 7, 9});
  const auto answers = sent();
  REQUIRE(answers.size() == 2);
  CHECK(answers[0].selector == "list"); // the right inlets first
  CHECK(answers[0].atoms == MessageAtoms{3, 9});
  CHECK(answers[1].selector == "scalar");
  CHECK(answers[1].atoms == MessageAtoms{2, 7});
  CHECK(box.run({}, 64)[0][63] == 0.5);
  box.send("list", {4, 0.5});
  CHECK(box.run({}, 64)[0][63] == 2);
  expect_no_errors();
  static_cast<void>(sent());
  for (const auto& [wrong, sentence] :
       {std::pair<MessageAtoms, const char*>{
            {5, "word"},
            "list: 'word' is no number: expected one for each inlet: a, b, number, list"},
        {{5, 6, 7, 8, 9},
         "list: 5 numbers: expected at most 4, one for each inlet: a, b, number, list"}}) {
    box.send("list", wrong);
    const auto said = errors();
    REQUIRE(said.size() == 1);
    CHECK(said[0] == "probe~: " + std::string(sentence));
    CHECK(box.run({}, 64)[0][63] == 2); // nothing has changed
  }
}

TEST_CASE("get answers with the lines of dump that begin with the name, and with no others") {
  Box box("probe~");
  static_cast<void>(sent());
  box.send("dump");
  std::vector<std::string> names;
  for (const Sent& answer : sent())
    names.push_back(answer.selector);
  CHECK(names == std::vector<std::string>{"kind", "gain", "sign", "block", "block", "float"});
  box.send("get", {"block", "kind", "gain"});
  const auto answers = sent();
  REQUIRE(answers.size() == 4);
  CHECK(answers[0].atoms == MessageAtoms{1, 0.0});
  CHECK(answers[1].atoms == MessageAtoms{2, "last"});
  CHECK(answers[2].selector == "kind");
  CHECK(answers[3].selector == "gain");
  expect_no_errors();
  box.send("get", {"gian", "echo", "blocked", 5});
  const auto said = errors();
  REQUIRE(said.size() == 4);
  CHECK(said[0] == "probe~: get gian: nothing of that name; did you mean 'gain'?");
  CHECK(said[1] == "probe~: get echo: a message without a value; 'dump' shows all that have one");
  CHECK(said[2] == "probe~: get blocked: nothing of that name; 'dump' shows all that have a value");
  box.send("get", {"blocked"});
  CHECK(sent().empty());
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
