#include "tests/pd/host.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <random>
#include <string>

// Random and absurd input to every object: nothing crashes, every output stays finite.
// TACTUS_FUZZ_ROUNDS=N makes it longer, TACTUS_FUZZ_OBJECT=NAME plays one object alone.

using namespace tactus;
using namespace tactus::test;

namespace {

/// Seconds of work or of waiting after which a message counts as having stopped the music, with
/// room for sanitizers and for a busy machine.
constexpr double kMaxCpu_s = 2, kMaxWait_s = 30;

/// Of the processor, in this thread.
double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Fuzzer {
public:
  Fuzzer(const ObjectDescription& described, unsigned seed)
      : declaration_(*described.declaration), random_(seed) {
    for (const Parameter& parameter : declaration_.parameters) {
      selectors_.emplace_back(parameter.name);
      for (const auto choice : parameter.choices)
        words_.emplace_back(choice);
    }
    for (const Message& message : declaration_.messages) {
      selectors_.emplace_back(message.name);
      split(message.arguments);
    }
    for (const char* common : {"bang", "float", "list", "symbol", "get", "dump", "nonsense", ""})
      selectors_.emplace_back(common);
    for (const char* common : {"", "-", "..", "%n%s", "no-such-file", "-1e999"})
      words_.emplace_back(common);
  }

  [[nodiscard]] std::size_t random_up_to(std::size_t max_value) {
    return std::uniform_int_distribution<std::size_t>(0, max_value)(random_);
  }

  /// Mostly of the kind a parameter wants, sometimes anything.
  [[nodiscard]] double number() {
    const double unit = std::uniform_real_distribution<>(0, 1)(random_);
    switch (random_up_to(9)) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return (unit < 0.5 ? 1 : -1) * std::numeric_limits<double>::infinity();
    case 2:
      return 0;
    case 3:
      return std::numeric_limits<float>::denorm_min() * 3;
    case 4:
      return (unit - 0.5) * std::pow(10.0, static_cast<double>(random_up_to(76)) - 38);
    case 5:
      return std::floor(unit * 20) - 5;
    default:
      if (declaration_.parameters.empty())
        return unit;
      const Parameter& p =
          declaration_.parameters[random_up_to(declaration_.parameters.size() - 1)];
      return p.lowest + unit * (p.highest - p.lowest);
    }
  }

  void message(Box& box) {
    MessageAtoms atoms;
    for (std::size_t n = random_up_to(random_up_to(1) ? 3 : 9); n-- > 0;) {
      if (random_up_to(3) == 0 && !words_.empty())
        atoms.emplace_back(words_[random_up_to(words_.size() - 1)]);
      else
        atoms.emplace_back(number());
    }
    const auto inlets = static_cast<std::size_t>(host_inlets(box.get(), 0));
    if (random_up_to(3) == 0 && inlets > 1) {
      const std::size_t inlet = 1 + random_up_to(inlets - 2);
      if (inlet < declaration_.inlets.size() &&
          declaration_.inlets[inlet].kind == Port::Kind::kList && random_up_to(3) > 0)
        box.send(static_cast<int>(inlet), "list", atoms);
      else
        box.send(static_cast<int>(inlet), "float", {number()});
      return;
    }
    std::string selector = selectors_[random_up_to(selectors_.size() - 1)];
    if (selector == "float")
      atoms = {number()};
    if (selector == "symbol")
      atoms = {"word"};
    if (selector == "bang")
      atoms.clear();
    // What a user sets: half of the time a value in range, so that odd states are reached at all.
    const std::size_t parameters = declaration_.parameters.size();
    if (parameters && random_up_to(1) == 0) {
      const Parameter& p = declaration_.parameters[random_up_to(parameters - 1)];
      selector = p.name;
      atoms = {p.lowest + std::uniform_real_distribution<>(0, 1)(random_) * (p.highest - p.lowest)};
    }
    const auto begin = std::chrono::steady_clock::now();
    const double before = cpu_s();
    box.send(selector, atoms);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    if (took.count() < kMaxWait_s && cpu_s() - before < kMaxCpu_s)
      return;
    std::string text = selector;
    for (const MessageAtom& atom : atoms)
      text += " " + (atom.is_word ? atom.text : std::to_string(atom.number));
    FAIL_CHECK("a message held the host for ", took.count(), " s: ", text);
  }

  [[nodiscard]] Buffers inputs(std::size_t samples) {
    Buffers result;
    for (const Port& port : declaration_.inlets) {
      if (port.kind != Port::Kind::kSignal)
        continue;
      std::vector<double> signal(samples);
      const double level = number();
      const bool wild = random_up_to(4) == 0;
      for (double& x : signal)
        x = wild ? number() : level * std::uniform_real_distribution<>(-1, 1)(random_);
      if (random_up_to(4) == 0)
        signal.clear();
      result.push_back(std::move(signal));
    }
    return result;
  }

private:
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
  std::vector<std::string> selectors_, words_;
};

std::size_t rounds() {
  const char* text = std::getenv("TACTUS_FUZZ_ROUNDS");
  return text ? static_cast<std::size_t>(std::atoi(text)) : 60;
}

void check_outputs(const Buffers& outputs, const Declaration& declaration, bool& good) {
  std::size_t port = 0;
  for (const Port& outlet : declaration.outlets) {
    if (outlet.kind != Port::Kind::kSignal)
      continue;
    for (const double x : outputs.at(port))
      good = good && std::isfinite(x) && (outlet.name != "sound" || std::abs(x) <= 1);
    ++port;
  }
}

} // namespace

TEST_CASE("any messages and signals leave every object finite, bounded and answering") {
  const double array[] = {0, 10, 20, std::numeric_limits<double>::quiet_NaN(), 1e30};
  host_set_array("x", 5, array);
  host_set_array("t", 5, array);
  host_set_folder(TACTUS_FUZZ_FOLDER);
  for (const ObjectDescription& described : objects()) {
    const Declaration& declaration = *described.declaration;
    const char* only = std::getenv("TACTUS_FUZZ_OBJECT");
    if (only && declaration.name != only)
      continue;
    const bool bounded = &described != &objects().back(); // the probe multiplies whatever comes
    CAPTURE(declaration.name);
    for (unsigned seed = 1; seed <= 4; ++seed) {
      Fuzzer fuzz(described, seed);
      Box box(declaration.name);
      bool good = true;
      for (std::size_t round = 0; round < rounds() && good; ++round) {
        CAPTURE(seed);
        CAPTURE(round);
        for (std::size_t n = fuzz.random_up_to(6); n-- > 0;)
          fuzz.message(box);
        const int frames = 1 << fuzz.random_up_to(10);
        static constexpr double kRates[] = {8000, 44100, 48000, 96000, 12345.678};
        box.dsp(kRates[fuzz.random_up_to(4)], frames, 1, fuzz.random_up_to(1) == 0);
        const std::size_t samples =
            static_cast<std::size_t>(frames) * (1 + 1024 / static_cast<std::size_t>(frames));
        const Buffers outputs = box.run(fuzz.inputs(samples), samples);
        if (bounded)
          check_outputs(outputs, declaration, good);
        CHECK_MESSAGE(good, "an output is not finite, or sound is beyond 1");
        host_clear_events();
      }
      box.send("get");
      CHECK(sent().size() == declaration.parameters.size());
      for (const Sent& answer : sent())
        for (const MessageAtom& atom : answer.atoms)
          CHECK(std::isfinite(atom.number));
      host_clear_events();
    }
  }
}

TEST_CASE("random creation arguments make an object or one or more sentences") {
  for (const ObjectDescription& described : objects()) {
    CAPTURE(described.declaration->name);
    std::mt19937 random(7);
    for (int round = 0; round < 200; ++round) {
      MessageAtoms arguments;
      for (auto n = random() % 5; n-- > 0;) {
        const auto& parameters = described.declaration->parameters;
        if (random() % 2 && !parameters.empty())
          arguments.emplace_back("-" + std::string(parameters[random() % parameters.size()].name));
        else if (random() % 4)
          arguments.emplace_back(static_cast<double>(random() % 1000) / 7);
        else
          arguments.emplace_back("word");
      }
      const Box box(described.declaration->name, arguments);
      CHECK((box.made() || host_error_count() == 1));
      host_clear_events();
    }
  }
}
