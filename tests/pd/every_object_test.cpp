#include "core/declaration_text.hpp"
#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>

// What holds for every object of the package, from its own declaration.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kSamples = 8192; // of every comparison

/// The one answer to `get name`.
MessageAtoms value_of(Box& box, std::string_view name) {
  static_cast<void>(sent());
  box.send("get", {MessageAtom(std::string(name))});
  for (const Sent& answer : sent())
    if (answer.selector == name)
      return answer.atoms;
  return {};
}

/// Whether it came out of the info outlet.
bool is_info(const Declaration& declaration, const Sent& line) {
  for (std::size_t i = 0; i < declaration.outlets.size(); ++i)
    if (declaration.outlets[i].name == kInfoOutlet)
      return line.outlet == static_cast<int>(i);
  return line.outlet == static_cast<int>(declaration.outlets.size()); // added at the right
}

void check_finite(const Buffers& outputs, const Declaration& declaration) {
  std::size_t port = 0;
  for (const Port& outlet : declaration.outlets) {
    if (outlet.kind != Port::Kind::kSignal)
      continue;
    const std::vector<double>& signal = outputs.at(port++);
    const bool sound = outlet.name == "sound";
    const auto bad = std::count_if(signal.begin(), signal.end(), [sound](double x) {
      return !std::isfinite(x) || (sound && std::abs(x) > 1);
    });
    CAPTURE(outlet.name);
    CHECK_MESSAGE(bad == 0, "samples that are not finite, or sound beyond 1");
  }
}

/// A sounding instance: words that its creation arguments need, none for most objects.
Buffers render(const Declaration& declaration, int frames, int rebuild_every = 0,
               bool alias = false) {
  Box box(declaration.name);
  REQUIRE(box.made());
  const double rate = 48000;
  const Buffers inputs = plausible_inputs(declaration, rate, kSamples);
  box.dsp(rate, frames, 1, alias);
  const std::size_t step =
      rebuild_every ? static_cast<std::size_t>(rebuild_every * frames) : kSamples;
  Buffers whole(static_cast<std::size_t>(host_outlets(box.get(), 1)));
  for (std::size_t begin = 0; begin < kSamples; begin += step) {
    Buffers part;
    for (const auto& signal : inputs)
      part.emplace_back(signal.begin() + static_cast<std::ptrdiff_t>(begin),
                        signal.begin() +
                            static_cast<std::ptrdiff_t>(std::min(begin + step, kSamples)));
    const Buffers collected = box.run(part, std::min(step, kSamples - begin));
    for (std::size_t i = 0; i < whole.size(); ++i)
      whole[i].insert(whole[i].end(), collected[i].begin(), collected[i].end());
    if (rebuild_every)
      box.dsp(rate, frames, 1, alias);
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
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    Box box(declaration.name);
    REQUIRE(box.made());
    CHECK(errors().empty());
    box.send("get");
    std::map<std::string, MessageAtoms> answers;
    for (const Sent& answer : sent())
      answers[answer.selector] = answer.atoms;
    CHECK(answers.size() == declaration.parameters.size());
    for (const Parameter& parameter : declaration.parameters) {
      CAPTURE(parameter.name);
      REQUIRE(answers[std::string(parameter.name)].size() == 1);
      const MessageAtom answer = answers[std::string(parameter.name)][0];
      if (parameter.choices.empty())
        CHECK(answer.number == doctest::Approx(parameter.initial).epsilon(1e-6));
      else
        CHECK(answer.text == parameter.choices[static_cast<std::size_t>(parameter.initial)]);
    }
    box.send("dump");
    CHECK(sent().size() >= declaration.parameters.size());
    CHECK(errors().empty());
  }
}

TEST_CASE("get answers to every name that dump prints, with the lines that dump prints") {
  for (const ObjectDescription& described : objects()) {
    CAPTURE(described.declaration->name);
    MessageAtoms arguments;
    for (const Message& message : described.declaration->messages)
      if (message.name == "preset") // so that there is one to tell
        arguments = {"-preset",
                     std::string(message.arguments.substr(0, message.arguments.find('|')))};
    Box box(described.declaration->name, arguments);
    REQUIRE(box.made());
    static_cast<void>(sent());
    box.send("dump");
    std::map<std::string, std::vector<MessageAtoms>> lines;
    for (const Sent& line : sent())
      if (is_info(*described.declaration, line))
        lines[line.selector].push_back(line.atoms);
    CHECK(lines.size() >= described.declaration->parameters.size());
    CHECK(lines.contains("preset") == !arguments.empty());
    for (const auto& line : lines) {
      const std::string& name = line.first; // clang 14 lets no structured binding into CAPTURE
      const std::vector<MessageAtoms>& values = line.second;
      CAPTURE(name);
      box.send("get", {name});
      const auto answers = sent();
      for (const std::string& sentence : errors())
        FAIL_CHECK(sentence);
      REQUIRE(!answers.empty());
      if (find_parameter(*described.declaration, name)) {
        CHECK(answers.size() == 1);
        continue;
      }
      REQUIRE(answers.size() == values.size());
      for (std::size_t i = 0; i < values.size(); ++i) {
        CHECK(answers[i].selector == name);
        CHECK(answers[i].atoms.size() == values[i].size());
      }
    }
    box.send("get", {"no-such-name"});
    CHECK(errors().size() == 1);
    box.send("get", {"no-such-name"});
    CHECK(sent().empty());
  }
}

TEST_CASE("bang, an empty list, numbers and lists do something or are refused in one sentence") {
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    const bool takes_signals =
        std::any_of(declaration.inlets.begin(), declaration.inlets.end(),
                    [](const Port& port) { return port.kind == Port::Kind::kSignal; });
    for (const std::string selector : {"bang", "list", "float"}) {
      CAPTURE(selector);
      Box box(declaration.name);
      box.send(selector, selector == "list"    ? MessageAtoms{0.5, 0.25}
                         : selector == "float" ? MessageAtoms{0.5}
                                               : MessageAtoms{});
      const auto said = errors();
      CHECK(said.size() <= 1);
      const bool declared = find_message(declaration, selector).has_value();
      if (!declared && (selector == "bang" || !(takes_signals || described.traits.takes_numbers))) {
        REQUIRE(said.size() == 1);
        CHECK(
            said[0].rfind(std::string(declaration.name) + ": no message '" + selector + "'; there ",
                          0) == 0);
      }
      if (!declared && selector == "float" && (takes_signals || described.traits.takes_numbers))
        CHECK((said.empty() || said[0].find("no message") == std::string::npos));
    }
  }
}

TEST_CASE("an empty list is a bang, and a list of one number is that number") {
  const auto answer = [](std::string_view object, const char* selector, const MessageAtoms& atoms) {
    Box box(object);
    static_cast<void>(errors());
    box.send(selector, atoms);
    return errors();
  };
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    CHECK(answer(declaration.name, "list", {}) == answer(declaration.name, "bang", {}));
    const bool takes_signals =
        std::any_of(declaration.inlets.begin(), declaration.inlets.end(),
                    [](const Port& port) { return port.kind == Port::Kind::kSignal; });
    if (takes_signals || described.traits.takes_numbers)
      CHECK(answer(declaration.name, "list", {0.5}) == answer(declaration.name, "float", {0.5}));
  }
}

TEST_CASE("an object without parameters answers a word that it does not know by its messages") {
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    if (!declaration.parameters.empty() || declaration.messages.empty())
      continue;
    CAPTURE(declaration.name);
    Box box(declaration.name);
    static_cast<void>(errors());
    box.send("zyzzyva");
    const auto said = errors();
    REQUIRE(said.size() == 1);
    CHECK(said[0].rfind(std::string(declaration.name) + ": no message 'zyzzyva'; there ", 0) == 0);
    for (const Message& message : declaration.messages)
      CHECK(said[0].find(std::string(message.name)) != std::string::npos);
  }
}

TEST_CASE("an inlet's name sent as a message is told to be that inlet") {
  for (const auto& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    for (std::size_t i = 0; i < declaration.inlets.size(); ++i) {
      const std::string name(declaration.inlets[i].name);
      CAPTURE(name);
      if (find_message(declaration, name) || find_parameter(declaration, name) || name == "list")
        continue;
      Box box(declaration.name);
      static_cast<void>(errors());
      box.send(name, {1});
      const auto said = errors();
      REQUIRE(said.size() == 1);
      CHECK(said[0].rfind(std::string(declaration.name) + ": no message '" + name +
                              "'; it is inlet " + std::to_string(i + 1),
                          0) == 0);
    }
  }
}

TEST_CASE("the first argument of a box is what one would guess, before and after flags") {
  // A word or number for the first argument, and what `get` answers then.
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
      {"probe~", "gain", {2}, {2}},
      {"stress_haptic", "", {"no-such-table"}, {}},
  };
  CHECK(std::size(guesses) == objects().size());
  for (const Guess& guess : guesses) {
    CAPTURE(guess.object);
    const auto described =
        std::find_if(objects().begin(), objects().end(), [&](const ObjectDescription& o) {
          return o.declaration->name == guess.object;
        });
    REQUIRE(described != objects().end());
    MessageAtoms flag; // any other parameter, at its initial value
    for (const Parameter& parameter : described->declaration->parameters)
      if (flag.empty() && parameter.name != std::string_view(guess.get))
        flag = {"-" + std::string(parameter.name),
                parameter.choices.empty() ? MessageAtom(parameter.initial)
                                          : MessageAtom(std::string(parameter.choices[0]))};
    for (const bool after : {false, true}) {
      CAPTURE(after);
      MessageAtoms arguments = after ? flag : guess.given;
      const MessageAtoms& rest = after ? guess.given : flag;
      arguments.insert(arguments.end(), rest.begin(), rest.end());
      Box box(guess.object, arguments);
      REQUIRE(box.made());
      const auto said = errors();
      static_cast<void>(sent());
      if (guess.answer.empty()) { // a file, which is looked for
        REQUIRE(said.size() == 1);
        CHECK(said[0].find("load no-such-table: there is no such file") != std::string::npos);
        continue;
      }
      CHECK(said.empty());
      box.send("get", {guess.get});
      const auto answers = sent();
      REQUIRE(answers.size() == 1);
      CHECK(answers[0].atoms == guess.answer);
    }
  }
}

TEST_CASE("every parameter takes its whole range and refuses, in one sentence, what is outside") {
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    for (const Parameter& parameter : declaration.parameters) {
      CAPTURE(parameter.name);
      Box box(declaration.name);
      if (!parameter.choices.empty()) {
        for (const auto choice : parameter.choices) {
          box.send(parameter.name, {MessageAtom(std::string(choice))});
          CHECK(value_of(box, parameter.name) == MessageAtoms{MessageAtom(std::string(choice))});
        }
        CHECK(errors().empty());
        box.send(parameter.name, {"no-such-choice"});
        CHECK(errors().size() == 1);
        continue;
      }
      for (const double good : {parameter.lowest, parameter.highest}) {
        CAPTURE(good);
        box.send(parameter.name, {good});
        for (const std::string& sentence : errors())
          FAIL_CHECK(sentence);
        const MessageAtoms kept = value_of(box, parameter.name);
        REQUIRE(kept.size() == 1);
        // The sign of a rest angle follows the valve's type; its size is kept.
        CHECK(std::abs(kept[0].number) == doctest::Approx(std::abs(good)).epsilon(1e-6));
      }
      const double span = std::max(parameter.highest - parameter.lowest, 1e-3);
      const MessageAtoms before = value_of(box, parameter.name);
      for (const MessageAtom& bad :
           {MessageAtom(parameter.lowest - 0.01 * span),
            MessageAtom(parameter.highest + 0.01 * span), MessageAtom(kNan), MessageAtom(kInfinity),
            MessageAtom(-kInfinity), MessageAtom("word")}) {
        box.send(parameter.name, {bad});
        const auto said = errors();
        CAPTURE(bad.number);
        REQUIRE(said.size() == 1);
        CHECK(said[0].rfind(std::string(declaration.name) + ": " + std::string(parameter.name),
                            0) == 0);
        CHECK(value_of(box, parameter.name) == before);
      }
    }
  }
}

TEST_CASE("a parameter of listed numbers takes each of them and nothing between") {
  std::size_t found = 0;
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    for (const Parameter& parameter : declaration.parameters) {
      if (parameter.values.empty())
        continue;
      CAPTURE(parameter.name);
      ++found;
      CHECK(parameter.lowest == parameter.values.front());
      CHECK(parameter.highest == parameter.values.back());
      Box box(declaration.name);
      for (std::size_t i = 0; i < parameter.values.size(); ++i) {
        box.send(parameter.name, {parameter.values[i]});
        CHECK(errors().empty());
        CHECK(value_of(box, parameter.name) == MessageAtoms{MessageAtom(parameter.values[i])});
        if (i + 1 == parameter.values.size())
          continue;
        box.send(parameter.name, {0.5 * (parameter.values[i] + parameter.values[i + 1])});
        CHECK(errors().size() == 1);
        CHECK(value_of(box, parameter.name) == MessageAtoms{MessageAtom(parameter.values[i])});
      }
    }
  }
  CHECK(found >= 2); // os of greed~ and greed_gradient~
}

TEST_CASE("every parameter is a creation flag, and an unknown flag makes no object") {
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    for (const Parameter& parameter : declaration.parameters) {
      CAPTURE(parameter.name);
      const MessageAtom value = parameter.choices.empty()
                                    ? MessageAtom(parameter.lowest)
                                    : MessageAtom(std::string(parameter.choices.back()));
      Box box(declaration.name, {"-" + std::string(parameter.name), value});
      for (const std::string& sentence : errors())
        FAIL_CHECK(sentence);
      REQUIRE(box.made());
      const MessageAtoms kept = value_of(box, parameter.name);
      REQUIRE(kept.size() == 1);
      if (value.is_word)
        CHECK(kept[0].text == value.text);
      else
        CHECK(kept[0].number == doctest::Approx(value.number).epsilon(1e-6));
    }
    Box box(declaration.name, {"-no-such-flag", 1});
    CHECK_FALSE(box.made());
    CHECK(errors().size() == 1);
  }
}

TEST_CASE("the sound is the same bits in blocks of any size") {
  for (const ObjectDescription& described : objects()) {
    if (!described.traits.processes)
      continue;
    CAPTURE(described.declaration->name);
    const Buffers reference = render(*described.declaration, 64);
    check_finite(reference, *described.declaration);
    for (const int frames : {1, 2, 32, 512, 4096}) {
      CAPTURE(frames);
      check_same(reference, render(*described.declaration, frames));
    }
    CHECK(errors().empty());
    static_cast<void>(sent());
  }
}

TEST_CASE("128 rebuilds of the graph while it sounds change no bit, nor do outputs in the inputs' "
          "memory") {
  for (const ObjectDescription& described : objects()) {
    if (!described.traits.processes)
      continue;
    CAPTURE(described.declaration->name);
    const Buffers reference = render(*described.declaration, 64);
    check_same(reference, render(*described.declaration, 64, 1));
    check_same(reference, render(*described.declaration, 64, 0, true));
    CHECK(errors().empty());
    static_cast<void>(sent());
  }
}

TEST_CASE("instances do not hear each other") {
  for (const ObjectDescription& described : objects()) {
    if (!described.traits.processes)
      continue;
    const Declaration& declaration = *described.declaration;
    CAPTURE(declaration.name);
    const Buffers reference = render(declaration, 64);
    const Buffers inputs = plausible_inputs(declaration, 48000, kSamples);
    Box one(declaration.name), other(declaration.name);
    one.dsp(48000, 64);
    other.dsp(96000, 64);
    Buffers collected(reference.size());
    for (std::size_t begin = 0; begin < kSamples; begin += 64) {
      Buffers part, noise;
      for (const auto& signal : inputs) {
        part.emplace_back(signal.begin() + static_cast<std::ptrdiff_t>(begin),
                          signal.begin() + static_cast<std::ptrdiff_t>(begin + 64));
        noise.emplace_back(64, 0.3);
      }
      const Buffers block = one.run(part, 64);
      static_cast<void>(other.run(noise, 64));
      for (std::size_t i = 0; i < collected.size(); ++i)
        collected[i].insert(collected[i].end(), block[i].begin(), block[i].end());
    }
    check_same(reference, collected);
    static_cast<void>(sent());
  }
}

TEST_CASE("all rates from 8 to 384 kHz stay finite, bounded and silent about it") {
  for (const ObjectDescription& described : objects()) {
    if (!described.traits.processes)
      continue;
    CAPTURE(described.declaration->name);
    Box box(described.declaration->name);
    for (const double rate : {8000.0, 22050.0, 44100.0, 48000.0, 96000.0, 192000.0, 384000.0}) {
      CAPTURE(rate);
      box.dsp(rate, 64);
      check_finite(box.run(plausible_inputs(*described.declaration, rate, 4096), 4096),
                   *described.declaration);
    }
    CHECK(errors().empty());
    static_cast<void>(sent());
  }
}
