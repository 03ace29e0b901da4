#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <utility>

// Random and absurd input to every object: nothing crashes, every output stays finite.
// TACTUS_FUZZ_ROUNDS=N makes it longer or shorter.

using namespace tactus;
using namespace tactus::test;

namespace {

/// Of the processor, after which a message counts as having stopped the music; with room for
/// sanitizers.
constexpr double kMaxMessage_s = 2;

/// Of the processor, in this thread.
double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Fuzzer {
public:
  Fuzzer(const Declaration& declaration, unsigned seed) : declaration_(declaration), random_(seed) {
    for (const Parameter& parameter : declaration_.parameters) {
      selectors_.emplace_back(parameter.name);
      words_.insert(words_.end(), parameter.choices.begin(), parameter.choices.end());
    }
    for (const Message& message : declaration_.messages) {
      selectors_.emplace_back(message.name);
      split(message.arguments);
    }
  }

  [[nodiscard]] std::size_t up_to(std::size_t max_value) {
    return std::uniform_int_distribution<std::size_t>(0, max_value)(random_);
  }
  [[nodiscard]] double uniform(double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random_);
  }

  /// Mostly of the kind a parameter wants, sometimes anything.
  [[nodiscard]] double number() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    switch (up_to(9)) {
    case 0:
      return std::nan("");
    case 1:
      return up_to(1) ? kInfinity : -kInfinity;
    case 2:
      return 0;
    case 3:
      return std::numeric_limits<float>::denorm_min() * 3;
    case 4:
      return uniform(-0.5, 0.5) * std::pow(10.0, static_cast<double>(up_to(76)) - 38);
    case 5:
      return std::floor(uniform(0, 20)) - 5;
    default:
      if (declaration_.parameters.empty())
        return uniform(0, 1);
      const Parameter& p = parameter();
      return uniform(p.lowest, p.highest);
    }
  }

  void message(Box& box) {
    MessageAtoms atoms;
    for (std::size_t n = up_to(up_to(1) ? 3 : 9); n-- > 0;)
      atoms.push_back(up_to(3) == 0 ? MessageAtom(words_[up_to(words_.size() - 1)])
                                    : MessageAtom(number()));
    if (up_to(3) == 0 && box.inlets() > 1) {
      const std::size_t inlet = 1 + up_to(box.inlets() - 2);
      if (inlet < declaration_.inlets.size() &&
          declaration_.inlets[inlet].kind == Port::Kind::kList && up_to(3) > 0)
        return box.send(inlet, "list", atoms);
      return box.send(inlet, "float", {number()});
    }
    std::string selector = selectors_[up_to(selectors_.size() - 1)];
    if (selector == "float")
      atoms = {number()};
    if (selector == "symbol")
      atoms = {"word"};
    if (selector == "bang")
      atoms.clear();
    // What a user sets: half of the time a value in range, so that odd states are reached at all.
    if (!declaration_.parameters.empty() && up_to(1) == 0) {
      const Parameter& p = parameter();
      selector = p.name;
      atoms = {uniform(p.lowest, p.highest)};
    }
    const double before = cpu_s();
    box.send(selector, atoms);
    CHECK_MESSAGE(cpu_s() - before < kMaxMessage_s, "held the host: ", selector);
  }

  [[nodiscard]] Buffers inputs(std::size_t samples) {
    Buffers result;
    for (const Port& port : declaration_.inlets) {
      if (port.kind != Port::Kind::kSignal)
        continue;
      std::vector<double>& signal = result.emplace_back(samples);
      const double level = number();
      const bool wild = up_to(4) == 0;
      for (double& x : signal)
        x = wild ? number() : level * uniform(-1, 1);
      if (up_to(4) == 0)
        signal.clear();
    }
    return result;
  }

private:
  const Parameter& parameter() {
    return declaration_.parameters[up_to(declaration_.parameters.size() - 1)];
  }

  /// The words of a message's declared arguments are good fuel: "line x0 y0 ... | array NAME".
  void split(std::string_view text) {
    std::string word;
    for (const char letter : std::string(text) + " ") {
      if (std::isalnum(static_cast<unsigned char>(letter)) || letter == '_')
        word += letter;
      else if (!word.empty())
        words_.push_back(std::exchange(word, {}));
    }
  }

  const Declaration& declaration_;
  std::mt19937 random_;
  std::vector<std::string> selectors_{"bang", "float", "list",     "symbol",
                                      "get",  "dump",  "nonsense", ""};
  std::vector<std::string> words_{"", "-", "..", "%n%s", "no-such-file", "-1e999"};
};

void play(const Declaration& declaration, unsigned seed) {
  CAPTURE(declaration.name);
  CAPTURE(seed);
  const char* const given = std::getenv("TACTUS_FUZZ_ROUNDS");
  const int rounds = given ? std::atoi(given) : 60;
  Fuzzer fuzz(declaration, seed);
  Box box(declaration.name);
  for (int round = 0; round < rounds; ++round) {
    CAPTURE(round);
    for (std::size_t n = fuzz.up_to(6); n-- > 0;)
      fuzz.message(box);
    const std::size_t frames = std::size_t{1} << fuzz.up_to(10);
    static constexpr double kRates[] = {8000, 44100, 48000, 96000, 12345.678};
    box.dsp(kRates[fuzz.up_to(4)], static_cast<int>(frames), 1, fuzz.up_to(1) == 0);
    const std::size_t samples = frames + 1024 / frames * frames;
    const Buffers outputs = box.run(fuzz.inputs(samples), samples);
    if (declaration.name != "probe~") { // multiplies whatever comes
      const std::string not_finite = bad_outlet(outputs, declaration);
      CAPTURE(not_finite); // name of the outlet; inputs may be NaN or infinite
      REQUIRE(not_finite.empty());
    }
    heard();
  }
  box.send("get");
  const auto answers = sent();
  CHECK(answers.size() == declaration.parameters.size());
  for (const Sent& answer : answers)
    for (const MessageAtom& atom : answer.atoms)
      CHECK(std::isfinite(atom.number));
}

void play_every_object(const std::vector<unsigned>& seeds) {
  const std::vector<double> array{0, 10, 20, std::nan(""), 1e30};
  set_array("x", array);
  set_array("t", array);
  set_folder(TACTUS_FUZZ_FOLDER);
  for (const ObjectDescription& described : objects())
    for (const unsigned seed : seeds)
      play(*described.declaration, seed);
}

} // namespace

TEST_CASE("any messages and signals leave every object finite, bounded and answering") {
  play_every_object({1});
}
TEST_CASE("more messages and signals do so too" * doctest::test_suite("slow")) {
  play_every_object({2, 3, 4});
}

TEST_CASE("random creation arguments make an object or one or more sentences") {
  for (const ObjectDescription& described : objects()) {
    CAPTURE(described.declaration->name);
    const auto& parameters = described.declaration->parameters;
    std::mt19937 random(7);
    for (int round = 0; round < 100; ++round) {
      MessageAtoms arguments;
      for (auto n = random() % 5; n-- > 0;) {
        if (random() % 2 && !parameters.empty())
          arguments.emplace_back("-" + std::string(parameters[random() % parameters.size()].name));
        else if (random() % 4)
          arguments.emplace_back(static_cast<double>(random() % 1000) / 7);
        else
          arguments.emplace_back("word");
      }
      const bool made = Box(described.declaration->name, arguments).made();
      CHECK((errors().size() == 1 || made));
    }
  }
}
