#include "core/declaration_text.hpp"
#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

// What holds for every object of the package, from its own declaration.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kSamples = 8192; // of every comparison

template <class Check> void for_every_object(Check check) {
  for (const ObjectDescription& described : objects()) {
    CAPTURE(described.declaration->name);
    check(*described.declaration, described.traits);
  }
}

template <class Check> void for_every_parameter(Check check) {
  for_every_object([&](const Declaration& declaration, const Traits&) {
    for (const Parameter& parameter : declaration.parameters) {
      CAPTURE(parameter.name);
      check(declaration.name, parameter);
    }
  });
}

bool takes_numbers(const Declaration& declaration, const Traits& traits) {
  return traits.takes_numbers ||
         std::any_of(declaration.inlets.begin(), declaration.inlets.end(),
                     [](const Port& port) { return port.kind == Port::Kind::kSignal; });
}

MessageAtom atom_of(const Parameter& parameter, double value) {
  return parameter.choices.empty()
             ? MessageAtom(value)
             : MessageAtom(std::string(parameter.choices[static_cast<std::size_t>(value)]));
}

void expect_no_errors() {
  for (const std::string& sentence : errors())
    FAIL_CHECK(sentence);
}

/// The one sentence that a new box says of a message; empty if it takes it.
std::string refusal(std::string_view object, std::string_view selector, const MessageAtoms& atoms) {
  Box box(object);
  static_cast<void>(errors());
  box.send(selector, atoms);
  const auto said = errors();
  CHECK(said.size() <= 1);
  return said.empty() ? "" : said[0];
}

bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

/// The one answer to `get name`.
MessageAtoms value_of(Box& box, std::string_view name) {
  static_cast<void>(sent());
  box.send("get", {MessageAtom(std::string(name))});
  for (const Sent& answer : sent())
    if (answer.selector == name)
      return answer.atoms;
  return {};
}

/// The sign of a rest angle follows the valve's type; its size is kept.
void check_value(const MessageAtoms& answer, const MessageAtom& expected) {
  REQUIRE(answer.size() == 1);
  CHECK(answer[0].text == expected.text);
  CHECK(std::abs(answer[0].number) == doctest::Approx(std::abs(expected.number)).epsilon(1e-6));
}

/// Whether it came out of the info outlet, which is added at the right where none is declared.
bool is_info(const Declaration& declaration, const Sent& line) {
  const auto& outlets = declaration.outlets;
  return line.outlet == std::find_if(outlets.begin(), outlets.end(), [](const Port& port) {
                          return port.name == kInfoOutlet;
                        }) - outlets.begin();
}

Buffers render(const Declaration& declaration, int frames, bool rebuild = false,
               bool alias = false) {
  Box box(declaration.name);
  REQUIRE(box.made());
  const Buffers inputs = plausible_inputs(declaration, 48000, kSamples);
  box.dsp(48000, frames, 1, alias);
  const std::size_t step = rebuild ? static_cast<std::size_t>(frames) : kSamples;
  Buffers whole;
  for (std::size_t begin = 0; begin < kSamples; begin += step) {
    append(whole, box.run(part_of(inputs, begin, step), step));
    if (rebuild)
      box.dsp(48000, frames, 1, alias);
  }
  return whole;
}

void check_same(const Buffers& a, const Buffers& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto n = std::mismatch(a[i].begin(), a[i].end(), b[i].begin()).first - a[i].begin();
    CAPTURE(i);
    CHECK_MESSAGE(n == static_cast<std::ptrdiff_t>(a[i].size()), "first differs at sample ", n);
  }
}

} // namespace

TEST_CASE("every object starts with the values it declares and tells them") {
  for_every_object([](const Declaration& declaration, const Traits&) {
    Box box(declaration.name);
    REQUIRE(box.made());
    CHECK(errors().empty());
    box.send("get");
    const auto answers = sent();
    REQUIRE(answers.size() == declaration.parameters.size());
    for (std::size_t i = 0; i < answers.size(); ++i) {
      const Parameter& parameter = declaration.parameters[i];
      CHECK(answers[i].selector == parameter.name);
      check_value(answers[i].atoms, atom_of(parameter, parameter.initial));
    }
  });
}

TEST_CASE("get answers to every name that dump prints, with the lines that dump prints") {
  for_every_object([](const Declaration& declaration, const Traits&) {
    MessageAtoms arguments;
    for (const Message& message : declaration.messages)
      if (message.name == "preset") // so that there is one to tell
        arguments = {"-preset",
                     std::string(message.arguments.substr(0, message.arguments.find('|')))};
    Box box(declaration.name, arguments);
    REQUIRE(box.made());
    static_cast<void>(sent());
    box.send("dump");
    std::map<std::string, std::vector<MessageAtoms>> lines;
    for (const Sent& line : sent())
      if (is_info(declaration, line))
        lines[line.selector].push_back(line.atoms);
    CHECK(lines.size() >= declaration.parameters.size());
    CHECK(lines.contains("preset") == !arguments.empty());
    for (const auto& line : lines) {
      const std::string& name = line.first; // clang 14 lets no structured binding into CAPTURE
      CAPTURE(name);
      box.send("get", {name});
      const auto [said, answers] = heard();
      CHECK(said.empty());
      REQUIRE(answers.size() == (find_parameter(declaration, name) ? 1 : line.second.size()));
      for (std::size_t i = 0; i < answers.size(); ++i) {
        CHECK(answers[i].selector == name);
        CHECK(answers[i].atoms.size() == line.second[i].size());
      }
    }
    box.send("get", {"no-such-name"});
    const auto [said, answers] = heard();
    CHECK(said.size() == 1);
    CHECK(answers.empty());
  });
}

TEST_CASE("bang, numbers and lists do something or are refused in one sentence") {
  for_every_object([](const Declaration& declaration, const Traits& traits) {
    const bool numbers = takes_numbers(declaration, traits);
    const std::pair<std::string, MessageAtoms> given[] = {
        {"bang", {}}, {"list", {0.5, 0.25}}, {"float", {0.5}}};
    for (const auto& [selector, atoms] : given) {
      const std::string said = refusal(declaration.name, selector, atoms);
      const std::string unknown =
          std::string(declaration.name) + ": no message '" + selector + "'; there ";
      if (!find_message(declaration, selector) && (selector == "bang" || !numbers))
        CHECK(begins(said, unknown));
      else if (selector == "float")
        CHECK_FALSE(begins(said, unknown));
    }
    // An empty list is a bang, and a list of one number is that number.
    CHECK(refusal(declaration.name, "list", {}) == refusal(declaration.name, "bang", {}));
    if (numbers)
      CHECK(refusal(declaration.name, "list", {0.5}) == refusal(declaration.name, "float", {0.5}));
  });
}

TEST_CASE("an object without parameters answers a word that it does not know by its messages") {
  for_every_object([](const Declaration& declaration, const Traits&) {
    if (!declaration.parameters.empty() || declaration.messages.empty())
      return;
    const std::string said = refusal(declaration.name, "zyzzyva", {});
    CHECK(begins(said, std::string(declaration.name) + ": no message 'zyzzyva'; there "));
    for (const Message& message : declaration.messages)
      CHECK(said.find(std::string(message.name)) != std::string::npos);
  });
}

TEST_CASE("an inlet's name sent as a message is told to be that inlet") {
  for_every_object([](const Declaration& declaration, const Traits&) {
    for (std::size_t i = 0; i < declaration.inlets.size(); ++i) {
      const std::string name(declaration.inlets[i].name);
      if (!find_message(declaration, name) && !find_parameter(declaration, name) && name != "list")
        CHECK(begins(refusal(declaration.name, name, {1}),
                     std::string(declaration.name) + ": no message '" + name + "'; it is inlet " +
                         std::to_string(i + 1)));
    }
  });
}

TEST_CASE("the first argument of a box is what one would guess, before and after flags") {
  // A word or number for the first argument, and what `get` answers then; nothing: a file, which
  // is looked for. An object that is not listed has no arguments, or a parameter as the first.
  struct Guess {
    const char *object, *get;
    MessageAtoms given, answer;
  };
  const Guess guesses[] = {
      {"contact_friction~", "modes", {440, 1, 0.5}, {440, 1, 0.5}},
      {"contact_impact~", "modes", {440, 1, 0.5}, {440, 1, 0.5}},
      {"footstep~", "surface", {"snow"}, {"snow", "snow", 0.0}},
      {"greed_gradient~", "preset", {"trumpet"}, {"trumpet"}},
      {"greed~", "preset", {"trumpet"}, {"trumpet"}},
      {"haptic_server", "port", {7788}, {7788}},
      {"ioa_link", "status", {0.0}, {"open"}},
      {"modal_impact~", "", {"no-such-table"}, {}},
      {"particle~", "preset", {"gravel"}, {"gravel"}},
      {"phantom", "backend", {"sim"}, {"sim"}},
      {"phantom~", "name", {"left"}, {"left"}},
      {"playability_map", "preset", {"oboe"}, {"oboe"}},
      {"playability~", "mode", {"paper"}, {"paper"}},
      {"stress_haptic", "", {"no-such-table"}, {}},
  };
  for_every_object([&](const Declaration& declaration, const Traits&) {
    const auto* guess = std::find_if(std::begin(guesses), std::end(guesses), [&](const Guess& one) {
      return declaration.name == one.object;
    });
    std::string first;
    Guess derived{};
    if (guess == std::end(guesses)) {
      if (declaration.arguments.empty())
        return;
      first = declaration.arguments.front().parameter;
      const auto index = find_parameter(declaration, first);
      if (!index)
        FAIL("add a row for " << declaration.name << " to guesses[]: '" << first
                              << "' is not a parameter");
      const Parameter& parameter = declaration.parameters[*index];
      const MessageAtom value = atom_of(parameter, parameter.highest);
      derived = {nullptr, first.c_str(), {value}, {value}};
      guess = &derived;
    }
    MessageAtoms
        flag; // another parameter, at its initial value: the last, which is part of no preset
    for (const Parameter& parameter : declaration.parameters)
      if (parameter.name != guess->get)
        flag = {"-" + std::string(parameter.name), atom_of(parameter, parameter.initial)};
    for (const bool after : {false, true}) {
      CAPTURE(after);
      MessageAtoms arguments = guess->given;
      arguments.insert(after ? arguments.begin() : arguments.end(), flag.begin(), flag.end());
      Box box(declaration.name, arguments);
      REQUIRE(box.made());
      const auto said = errors();
      if (guess->answer.empty()) {
        REQUIRE(said.size() == 1);
        CHECK(said[0].find("load no-such-table: file not found") != std::string::npos);
        continue;
      }
      CHECK(said.empty());
      CHECK(value_of(box, guess->get) == guess->answer);
    }
  });
}

TEST_CASE("every parameter takes its whole range and refuses, in one sentence, what is outside") {
  std::size_t listed = 0;
  for_every_parameter([&](std::string_view object, const Parameter& parameter) {
    Box box(object);
    std::vector<MessageAtom> good, bad{"no-such-word"};
    for (const std::string_view choice : parameter.choices)
      good.emplace_back(std::string(choice));
    if (parameter.choices.empty()) {
      const double span = std::max(parameter.highest - parameter.lowest, 1e-3);
      good = {parameter.lowest, parameter.highest};
      bad = {parameter.lowest - 0.01 * span,
             parameter.highest + 0.01 * span,
             std::nan(""),
             kInfinity,
             -kInfinity,
             "word"};
    }
    const auto& values = parameter.values;
    if (!values.empty()) { // each of these numbers and nothing between
      ++listed;
      CHECK(parameter.lowest == values.front());
      CHECK(parameter.highest == values.back());
      good.assign(values.begin(), values.end());
      for (std::size_t i = 1; i < values.size(); ++i)
        bad.emplace_back(0.5 * (values[i - 1] + values[i]));
    }
    for (const MessageAtom& atom : good) {
      box.send(parameter.name, {atom});
      expect_no_errors();
      check_value(value_of(box, parameter.name), atom);
    }
    const MessageAtoms before = value_of(box, parameter.name);
    for (const MessageAtom& atom : bad) {
      CAPTURE(atom.number);
      box.send(parameter.name, {atom});
      const auto said = errors();
      REQUIRE(said.size() == 1);
      CHECK(begins(said[0], std::string(object) + ": " + std::string(parameter.name)));
      CHECK(value_of(box, parameter.name) == before);
    }
  });
  CHECK(listed >= 2); // os of greed~ and greed_gradient~
}

TEST_CASE("every parameter is a creation flag, and an unknown flag makes no object") {
  for_every_parameter([](std::string_view object, const Parameter& parameter) {
    const MessageAtom value =
        atom_of(parameter, parameter.choices.empty() ? parameter.lowest : parameter.highest);
    Box box(object, {"-" + std::string(parameter.name), value});
    expect_no_errors();
    REQUIRE(box.made());
    check_value(value_of(box, parameter.name), value);
  });
  for_every_object([](const Declaration& declaration, const Traits&) {
    CHECK_FALSE(Box(declaration.name, {"-no-such-flag", 1}).made());
    CHECK(errors().size() == 1);
  });
}

TEST_CASE("the sound is the same bits in blocks of any size, when the graph is rebuilt at each "
          "block, and when outputs use the inputs' memory") {
  for_every_object([](const Declaration& declaration, const Traits& traits) {
    if (!traits.processes)
      return;
    const Buffers reference = render(declaration, 64);
    CHECK(bad_outlet(reference, declaration).empty());
    for (const int frames : {1, 2, 32, 512, 4096}) {
      CAPTURE(frames);
      check_same(reference, render(declaration, frames));
    }
    check_same(reference, render(declaration, 64, true));
    check_same(reference, render(declaration, 64, false, true));
    CHECK(errors().empty());
  });
}

TEST_CASE("instances do not hear each other") {
  for_every_object([](const Declaration& declaration, const Traits& traits) {
    if (!traits.processes)
      return;
    const Buffers inputs = plausible_inputs(declaration, 48000, kSamples);
    const Buffers alone = render(declaration, 64);
    Box one(declaration.name), other(declaration.name);
    one.dsp(48000, 64);
    other.dsp(96000, 64);
    Buffers collected;
    for (std::size_t begin = 0; begin < kSamples; begin += 64) {
      append(collected, one.run(part_of(inputs, begin, 64), 64));
      static_cast<void>(other.run(Buffers(inputs.size(), std::vector<double>(64, 0.3)), 64));
    }
    check_same(alone, collected);
  });
}

TEST_CASE(
    "what is left to chance differs in every instance and channel, the same at each opening") {
  std::size_t seeded = 0;
  for_every_object([&](const Declaration& declaration, const Traits&) {
    for (const Parameter& parameter : declaration.parameters) {
      CHECK(parameter.seeds == (parameter.name == "seed"));
      seeded += parameter.seeds ? 1 : 0;
      if (!parameter.seeds)
        continue;
      for (int opening = 0; opening < 2; ++opening) {
        Box first(declaration.name);
        Box second(declaration.name), third(declaration.name, {"-seed", 2});
        check_value(value_of(first, "seed"), 1);
        check_value(value_of(second, "seed"), 2);
        check_value(value_of(third, "seed"), 2); // as it was asked for
      }
    }
  });
  CHECK(seeded >= 6);

  constexpr int kFrames = 4096;
  const auto rubbed = [](int channels) {
    Box box("contact_friction~", {"-roughness", 1});
    box.dsp(48000, kFrames, channels);
    const std::vector<double> signal(static_cast<std::size_t>(channels * kFrames), 0.5);
    return box.run({signal, signal}, kFrames)[1];
  };
  const std::vector<double> one = rubbed(1), two = rubbed(2);
  if (two.size() == one.size())
    return; // a Pd without channels
  CHECK(std::equal(one.begin(), one.end(), two.begin()));
  double product = 0, first = 0, second = 0;
  for (std::size_t i = 1; i < kFrames; ++i) { // differences: the steady force is the same
    const double a = two[i] - two[i - 1], b = two[i + kFrames] - two[i + kFrames - 1];
    product += a * b;
    first += a * a;
    second += b * b;
  }
  CHECK(std::abs(product) < 0.2 * std::sqrt(first * second));
}

TEST_CASE("all rates from 8 to 384 kHz stay finite, bounded and silent about it") {
  for_every_object([](const Declaration& declaration, const Traits& traits) {
    if (!traits.processes)
      return;
    Box box(declaration.name);
    for (const double rate : {8000.0, 22050.0, 44100.0, 48000.0, 96000.0, 192000.0, 384000.0}) {
      CAPTURE(rate);
      box.dsp(rate, 64);
      const Buffers outputs = box.run(plausible_inputs(declaration, rate, 4096), 4096);
      CHECK(bad_outlet(outputs, declaration).empty());
    }
    CHECK(errors().empty());
  });
}
