#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <utility>

// The shell itself, through the probe: a class with one of everything.

using namespace tactus;
using namespace tactus::test;

namespace {

/// Selector and atoms of each message, and that nothing was refused.
std::vector<MessageAtoms> answers() {
  const auto [said, sent] = heard();
  for (const std::string& sentence : said)
    FAIL_CHECK("unexpected: ", sentence);
  std::vector<MessageAtoms> found;
  for (const Sent& message : sent) {
    found.push_back(message.atoms);
    found.back().insert(found.back().begin(), MessageAtom(message.selector));
  }
  return found;
}
using Answers = std::vector<MessageAtoms>;

} // namespace

TEST_CASE("flags, positional arguments and at-sign attributes set parameters") {
  for (const MessageAtoms& arguments :
       {MessageAtoms{3, "-sign", "minus"}, MessageAtoms{"-gain", 3, "-sign", "minus"},
        MessageAtoms{"@gain", 3, "@sign", "minus"}}) {
    Box box("probe~", arguments);
    REQUIRE(box.made());
    box.send("get");
    CHECK(answers() == Answers{{"gain", 3}, {"sign", "minus"}});
  }
}

TEST_CASE("positional arguments stand before, between or after flags, which refine them") {
  // echo, the second, sends its words as a message.
  const std::pair<MessageAtoms, Answers> cases[] = {
      {{2, "hello", "-sign", "minus"}, {{"hello"}, {"gain", 2}}},
      {{"-sign", "minus", 2, "hello"}, {{"hello"}, {"gain", 2}}},
      {{2, "-sign", "minus", "hello"}, {{"hello"}, {"gain", 2}}},
      {{"-gain", 3, 2, "hello"}, {{"hello"}, {"gain", 3}}},
      {{2, "hello", "-gain", 3}, {{"hello"}, {"gain", 3}}},
      {{2, "-echo", "hello", "there"}, {{"hello", "there"}, {"gain", 2}}}, // takes all it can
  };
  for (const auto& [arguments, expected] : cases) {
    Box box("probe~", arguments);
    REQUIRE(box.made());
    box.send("get", {"gain"});
    CHECK(answers() == expected);
  }
}

TEST_CASE("malformed creation arguments make no object and one sentence") {
  const std::pair<MessageAtoms, bool> cases[] = {
      {{"-wake", 1, 2, "-wake", 2, 3, "-wake", 1, 4}, false},
      {{"-gian", 1}, false},
      {{"-echo", 1, "-unknown"}, false},
      {{"loud"}, true}, // a value out of range is refused, the object stays
  };
  for (const auto& [arguments, made] : cases) {
    const Box box("probe~", arguments);
    const auto said = errors();
    CHECK(box.made() == made);
    REQUIRE(said.size() == 1);
    CHECK(said[0].rfind("probe~: ", 0) == 0);
  }
}

TEST_CASE("of a flood of errors about one message the first are printed, then their number") {
  Box box("probe~");
  std::vector<std::string> said;
  const auto flood = [&](int count) {
    for (int i = 0; i < count; ++i) {
      box.send("gain", {1e6 + i});
      for (std::string& sentence : errors())
        said.push_back(std::move(sentence));
    }
  };
  const auto after = [&](double milliseconds) {
    advance(milliseconds);
    return errors();
  };
  using Lines = std::vector<std::string>;
  flood(1000);
  CHECK(said.size() == 100);
  CHECK(after(501) == Lines{"probe~: gain: 900 more errors"});
  flood(3);
  CHECK(said.size() == 100);
  box.send("nothing");
  const Lines other = errors();
  REQUIRE(other.size() == 2);
  CHECK(other[0] == "probe~: gain: 3 more errors");
  CHECK(after(501).empty());
  flood(1);
  CHECK(said.size() == 101);
}

TEST_CASE("an inlet's number is the signal while nothing is connected") {
  Box box("probe~");
  box.dsp(48000, 64);
  box.send("float", {2});
  box.send(1, "float", {0.25});
  CHECK(box.run({}, 64)[0][63] == 0.5);
  CHECK(errors().empty());
}

TEST_CASE("control inlets take numbers, list inlets lists too; both refuse words") {
  Box box("probe~");
  box.send(2, "float", {7});
  box.send(3, "list", {7, "eight", 9});
  box.send(3, "float", {5});
  CHECK(answers() == Answers{{"scalar", 2, 7}, {"list", 3, 7, "eight", 9}, {"list", 3, 5}});
  for (const std::size_t inlet : {2U, 3U}) {
    box.send(inlet, "symbol", {"word"});
    CHECK(errors().size() == 1);
  }
}

TEST_CASE("timers answer in logical time and can be replaced") {
  Box box("probe~");
  box.send("wake", {50});
  box.send("wake", {20});
  advance(30);
  const auto awake = answers();
  REQUIRE(awake.size() == 1);
  CHECK(awake[0][0].text == "awake");
  CHECK(awake[0][1].number == doctest::Approx(20));
  advance(100);
  CHECK(answers().empty());
}

TEST_CASE("a failure in any call of Pd is one sentence, and the object goes on") {
  using Call = void (*)(Box&);
  const std::pair<std::string, Call> calls[] = {
      {"message", [](Box& box) { box.send("echo", {"word"}); }},
      {"set", [](Box& box) { box.send("gain", {3}); }},
      {"get", [](Box& box) { box.send("get", {"gain"}); }},
      {"dump", [](Box& box) { box.send("dump"); }},
      {"scalar", [](Box& box) { box.send(2, "float", {7}); }},
      {"list",
       [](Box& box) {
         box.send(3, "list", {7, 8});
       }},
      {"tick", [](Box& box) { box.send("wake", {1}), advance(2); }},
      {"posted", [](Box&) { advance(10); }},
      {"report", [](Box& box) { static_cast<void>(box.run({}, 64)); }},
      {"dsp", [](Box& box) { box.dsp(44100, 64); }}};
  const std::pair<std::string, std::string> reasons[] = {{"memory", "not enough memory"},
                                                         {"size", "not enough memory"},
                                                         {"range", "a reason"},
                                                         {"int", "unknown error"}};
  for (const auto& one : calls)
    for (const auto& [how, reason] : reasons) {
      const auto& [member, call] = one;
      CAPTURE(one.first);
      Box box("probe~", {2});
      box.dsp(48000, 64);
      box.send("fail", {member, how});
      heard();
      call(box);
      const std::vector<std::string> said = errors();
      REQUIRE(said.size() == 1);
      CHECK(said[0].starts_with("probe~: "));
      CHECK(said[0].ends_with(": " + reason));
      if (member == "dsp")
        CHECK(box.run({std::vector<double>(64, 1.0), std::vector<double>(64, 1.0)}, 64)[0][63] ==
              0);
      box.send("fail", {"nothing", "memory"});
      box.dsp(48000, 64);
      heard();
      CHECK(box.run({std::vector<double>(64, 1.0), std::vector<double>(64, 1.0)}, 64)[0][63] == 2);
    }
  CHECK_FALSE(Box("probe~", {3.5}).made());
  CHECK(errors() == std::vector<std::string>{"probe~: not enough memory"});
}

TEST_CASE("control outlets speak after the block, once for each") {
  Box box("probe~");
  box.dsp(48000, 16);
  static_cast<void>(box.run({}, 64));
  const auto blocks = sent();
  REQUIRE(blocks.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(blocks[i].outlet == 1);
    CHECK(blocks[i].atoms == MessageAtoms{static_cast<double>(i + 1)});
  }
}

TEST_CASE("an object dropped with clocks pending leaves none behind") {
  static_cast<void>(objects());
  const std::size_t before = clock_count();
  {
    Box box("probe~");
    box.dsp(48000, 16);
    static_cast<void>(box.run({}, 16));
    box.send("wake", {5});
  }
  CHECK(clock_count() == before);
  heard();
  advance(10);
  CHECK(answers().empty());
}

TEST_CASE(
    "a message of no meaning or the wrong number of arguments is one sentence, which names what "
    "there is") {
  Box box("probe~");
  const std::string unknown = "probe~: no message '",
                    known = "'; there are echo, wake, fail, post and starts";
  box.send("bang");
  box.send("list"); // an empty list is a bang
  box.send("symbol", {"word"});
  CHECK(errors() == std::vector{unknown + "bang" + known, unknown + "bang" + known,
                                unknown + "symbol" + known});
  for (const auto& [selector, atoms] : {std::pair<const char*, MessageAtoms>{"nonsense", {1}},
                                        {"wake", {}},
                                        {"wake", {1, 2}},
                                        {"gain", {}},
                                        {"gain", {1, 2}}}) {
    box.send(selector, atoms);
    CHECK(errors().size() == 1);
  }
}

TEST_CASE("a list is a number for each inlet, signals and control, or one sentence") {
  Box box("probe~");
  box.dsp(48000, 64);
  box.send("list", {2, 0.25, 7, 9});
  CHECK(answers() == Answers{{"list", 3, 9}, {"scalar", 2, 7}}); // the right inlets first
  CHECK(box.run({}, 64)[0][63] == 0.5);
  box.send("list", {4, 0.5});
  CHECK(box.run({}, 64)[0][63] == 2);
  heard();
  const std::pair<MessageAtoms, const char*> refused[] = {
      {{5, "word"}, "list: 'word': not a number: expected one for each inlet: a, b, number, list"},
      {{5, 6, 7, 8, 9},
       "list: 5 numbers: expected at most 4, one for each inlet: a, b, number, list"}};
  for (const auto& [wrong, sentence] : refused) {
    box.send("list", wrong);
    CHECK(errors() == std::vector{"probe~: " + std::string(sentence)});
    CHECK(box.run({}, 64)[0][63] == 2); // nothing has changed
  }
}

TEST_CASE("get answers with the lines of dump that begin with the name, and with no others") {
  Box box("probe~");
  heard();
  box.send("dump");
  CHECK(answers() == Answers{{"kind", "probe"},
                             {"gain", 1},
                             {"sign", "plus"},
                             {"block", 1, 0.0},
                             {"block", 2, "last"},
                             {"float", -1}});
  box.send("get", {"block", "kind", "gain"});
  CHECK(answers() ==
        Answers{{"block", 1, 0.0}, {"block", 2, "last"}, {"kind", "probe"}, {"gain", 1}});
  box.send("get", {"gian", "echo", "blocked", 5});
  const auto [said, sent] = heard();
  CHECK(sent.empty());
  REQUIRE(said.size() == 4);
  CHECK(said[0] == "probe~: get gian: unknown name; did you mean 'gain'?");
  CHECK(said[1] == "probe~: get echo: a message has no value; 'dump' lists all values");
  CHECK(said[2] == "probe~: get blocked: unknown name; 'dump' lists all values");
}

TEST_CASE("every channel of a newer Pd's signal is heard") {
  Box box("probe~");
  box.dsp(48000, 8, 3);
  REQUIRE(box.run({}, 8)[0].size() == (is_newer() ? 24 : 8));
  if (!is_newer())
    return;
  std::vector<double> a(24);
  for (std::size_t i = 0; i < 24; ++i)
    a[i] = static_cast<double>(i);
  const auto out = box.run({a, std::vector<double>(24, 2.0)}, 8)[0];
  for (std::size_t i = 0; i < 24; ++i)
    CHECK(out[i] == 2 * a[i]);
  CHECK(errors().empty());
}

TEST_CASE("a signal of fewer channels begins again at its first") {
  if (!is_newer())
    return;
  Box box("probe~");
  box.dsp(48000, 8, std::vector{5, 2});
  std::vector<double> a(40), b(16, 10.0);
  for (std::size_t i = 0; i < 40; ++i)
    a[i] = static_cast<double>(i);
  std::fill_n(b.begin(), 8, 1.0);
  const auto out = box.run({a, b}, 8)[0];
  REQUIRE(out.size() == 40);
  for (std::size_t i = 0; i < 40; ++i)
    CHECK(out[i] == (i / 8 % 2 == 0 ? 1 : 10) * a[i]);
}

TEST_CASE("a block begins when its first sample does: one of a tick, of four, and four of one") {
  Box box("probe~");
  const auto check_blocks = [&box](double frames) {
    heard();
    box.send("starts");
    const MessageAtoms ago = answers().at(0); // the word, then four numbers
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(ago[i + 1].number == doctest::Approx((4.0 - static_cast<double>(i)) * frames / 48));
  };
  for (const int frames : {64, 256}) {
    box.dsp(48000, frames);
    static_cast<void>(box.run({}, 1024));
    check_blocks(frames);
  }
  box.dsp(48000, 16);
  for (int tick = 0; tick < 3; ++tick) {
    advance(64 / 48.0); // Pd's time is the tick's end while it computes
    static_cast<void>(box.run({}, 64, true));
    check_blocks(16);
  }
}

TEST_CASE("an object that is woken a hundred times before it is looked at is woken once") {
  Box box("probe~");
  for (int round = 0; round < 2; ++round) {
    box.send("post", {100});
    heard();
    advance(20);
    CHECK(answers() == Answers{{"posted"}});
  }
}

TEST_CASE("a signal of no channels is silence") {
  Box box("probe~");
  box.dsp(48000, 8, is_newer() ? 0 : 1);
  const auto out = box.run({}, 8)[0];
  for (const double sample : out)
    CHECK(sample == 0);
  CHECK(errors().empty());
}
