// How many modes does a core ring? The bare mode bank and the whole [modal_impact~] core, each made
// for every instruction set of this processor, over bank size, beside Faust, STK, Csound, a plain
// loop and the recursion with nothing around it, all driven every sample at 48 kHz in blocks of 64;
// then bodies that are struck, a hand that stays, and strikes on plates of thousands of modes.
//
//   bench_modal_bank [banks|bodies|hand|resting|large [modes]]
//
// Everything is run in turn, round by round, and the least of all rounds is printed: on a shared
// machine trust the ratios. Bodies and strikes are timed by the processor time of their thread.
#include "bench/modal_bank/bare.hpp"
#include "bench/modal_bank/faust_peers.hpp"
#include "bench/modal_bank/large_bodies.hpp"
#include "bench/modal_bank/peers.hpp"
#include "core/dsp/complex.hpp"
#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace tactus::modal;
constexpr std::pair<VectorSet, const char*> kSets[] = {
    {VectorSet::kBaseline, "SSE2"}, {VectorSet::kAvx2, "AVX2"}, {VectorSet::kAvx512, "AVX-512"}};
constexpr int kRounds = 40;

struct Row {
  std::string name;
  std::size_t modes;
  std::function<void()> block;
  double nanoseconds = 1e30; // a mode and sample
};

double seconds(const std::function<void()>& work, std::size_t times) {
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < times; ++i)
    work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::shared_ptr<const LoadedTable> made_up_body(std::size_t modes) {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  table.mass_kg = 1;
  for (std::size_t k = 0; k < modes; ++k) {
    table.frequency_hz.push_back(50 +
                                 20000.0 * static_cast<double>(k) / static_cast<double>(modes));
    table.decay_rate.push_back(1 + 4 * static_cast<double>(k) / static_cast<double>(modes));
  }
  return std::make_shared<const LoadedTable>(std::move(table));
}

struct Body {
  explicit Body(std::size_t modes, VectorSet set = tactus::simd::kWidest) {
    settings.vector_set = set;
    settings.listeners = 1;
    settings.radiation = Radiation::kNone;
    body.prepare(48000);
    body.publish(std::make_unique<BodyModel>(made_up_body(modes), settings), false);
    body.adopt();
  }
  void block(bool pushed = true) {
    const std::array<std::span<float>, 2> out{left, right};
    body.process<float>(pushed ? std::span<const float>(noise) : std::span<const float>(silence),
                        height, out, contact);
  }
  BodySettings settings;
  StruckBody body;
  std::array<float, 64> noise = [] {
    std::array<float, 64> x{};
    for (std::size_t n = 0; n < x.size(); ++n)
      x[n] = static_cast<float>(std::sin(static_cast<double>(n * n)));
    return x;
  }();
  std::array<float, 64> silence{}, height{}, left{}, right{}, contact{};
};

struct Bank {
  /// Decay rates from 1 to 1 + `spread`, 1/s.
  Bank(std::size_t modes, VectorSet set, double spread = 4)
      : bank([&] {
          std::vector<tactus::Complex> rate;
          for (std::size_t k = 0; k < modes; ++k)
            rate.emplace_back(
                -1 - spread * static_cast<double>(k) / static_cast<double>(modes),
                2 * std::numbers::pi *
                    (50 + 20000.0 * static_cast<double>(k) / static_cast<double>(modes)));
          return ModeBank(rate, 48000, 1, 1, set);
        }()) {
    bank.set_gain(0, std::vector<double>(modes, 1.0));
    bank.jump_to_weight(0, std::vector<tactus::Complex>(modes, {0.3, 0.8}));
  }
  void block(const float* in, float* out) { bank.process({&in, 1}, {&out, 1}, 64); }
  ModeBank bank;
};

/// The bank, the whole object and the peers, of all sizes.
std::vector<Row> bank_rows() {
  static std::array<float, 64> in{}, out{};
  for (std::size_t n = 0; n < in.size(); ++n)
    in[n] = static_cast<float>(std::sin(static_cast<double>(n * n)));
  std::vector<Row> rows;
  const auto add = [&](std::string name, std::size_t modes, std::shared_ptr<Peer> peer) {
    if (!peer) {
      if (modes == 64)
        std::printf("%s: not installed\n", name.c_str());
      return;
    }
    rows.push_back({std::move(name), modes, [peer] { peer->block(in.data(), out.data()); }});
  };
  for (const std::size_t modes : {16UL, 64UL, 256UL, 1024UL, 4096UL, 16384UL}) {
    for (const auto& [set, name] : kSets)
      if (tactus::simd::runs(set)) {
        auto bank = std::make_shared<Bank>(modes, set);
        rows.push_back(
            {std::string("bank, ") + name, modes, [bank] { bank->block(in.data(), out.data()); }});
        auto body = std::make_shared<Body>(modes, set);
        rows.push_back({std::string("whole object, ") + name, modes, [body] { body->block(); }});
      }
    for (const auto& [set, name] : kSets)
      if (modes == 1024 && tactus::simd::runs(set))
        for (const auto& [spread, what] : {std::pair(100.0, "bank, decays 1 to 101/s, "),
                                           {1000.0, "bank, decays 1 to 1001/s, "}}) {
          auto bank = std::make_shared<Bank>(modes, set, spread);
          rows.push_back(
              {std::string(what) + name, modes, [bank] { bank->block(in.data(), out.data()); }});
        }
    for (const auto& [set, name] : kSets)
      if (modes >= 1024 && make_bare_recursion(set, modes))
        add(std::string("bare recursion, ") + name, modes, make_bare_recursion(set, modes));
    if (modes <= 1024) {
      add("plain loop", modes, make_loop(modes));
      add("STK BiQuad", modes, make_stk(modes));
    }
    if (modes <= 256)
      add("Csound mode", modes, make_csound(modes));
  }
  for (const FaustProgram& program : faust_programs())
    add(program.name, program.modes, program.make());
  if (faust_programs().empty())
    std::printf("Faust: not installed\n");
  return rows;
}

void banks() {
  std::vector<Row> rows = bank_rows();
  for (int round = 0; round < kRounds; ++round)
    for (Row& row : rows) {
      const std::size_t times = std::max<std::size_t>(500000 / (row.modes * 64), 8);
      static_cast<void>(seconds(row.block, 2)); // refills the caches after the row before
      row.nanoseconds = std::min(row.nanoseconds, seconds(row.block, times) * 1e9 /
                                                      static_cast<double>(times * 64 * row.modes));
    }
  std::printf("%-34s %7s %12s %16s\n", "driven every sample", "modes", "ns/mode/smp",
              "modes a core");
  double faust = 1e30;
  for (const Row& row : rows) {
    std::printf("%-34s %7zu %12.4f %16.0f\n", row.name.c_str(), row.modes, row.nanoseconds,
                1e9 / 48000 / row.nanoseconds);
    if (row.name.starts_with("Faust"))
      faust = std::min(faust, row.nanoseconds);
  }
  for (const auto& [set, name] : kSets)
    for (const char* what : {"bank, ", "whole object, "}) {
      double best = 1e30;
      for (const Row& row : rows)
        if (row.name == std::string(what) + name)
          best = std::min(best, row.nanoseconds);
      if (best < 1e29 && faust < 1e29)
        std::printf("%s%s: %.2f times Faust's best\n", what, name, faust / best);
    }
  // In a leap of 16 samples: 16 products for the force, 16 for the output, 10 for gains, weights
  // and the state's step (core/modal/bank/bank_lanes.hpp).
  for (const auto& [set, name] : kSets)
    if (const double rate = multiply_adds_per_ns(set); rate > 0)
      std::printf("%s: %.1f multiply-adds a ns at best; the bank's 42 in 16 samples take %.4f ns a "
                  "mode and sample or more\n",
                  name, rate, 42.0 / 16 / rate);
}

void bodies() {
  // Voices of 64 modes, each struck four times a second at its own time.
  constexpr std::size_t kVoices = 100;
  std::vector<std::unique_ptr<Body>> voices;
  for (std::size_t i = 0; i < kVoices; ++i)
    voices.push_back(std::make_unique<Body>(64));
  double best = 1e30;
  for (int round = 0; round < 5; ++round) {
    const double begin = thread_cpu_seconds();
    for (std::size_t b = 0; b < 750; ++b)
      for (std::size_t i = 0; i < kVoices; ++i) {
        if ((b + 7 * i) % 187 == 0)
          voices[i]->body.hit({{}, {0, 0, 1}, 1});
        voices[i]->block(false);
      }
    best = std::min(best, thread_cpu_seconds() - begin);
  }
  std::printf("64 modes, coupled, 4 strikes a second: %.1f ns a sample, %.0f voices a core\n",
              best * 1e9 / (kVoices * 48000), kVoices / best);
}

/// A held striker that never lets go.
void lasting_contact(const char* what, const Striker& striker, double depth, double amplitude) {
  Body hand(64);
  StruckBody::Options options;
  options.driven = true;
  hand.body.set_options(options);
  hand.body.set_striker(striker);
  for (std::size_t n = 0; n < 64; ++n)
    hand.height[n] =
        static_cast<float>(-depth + amplitude * std::sin(static_cast<double>(n) * 0.1));
  double minimum = 1e30;
  for (int round = 0; round < 10 * kRounds; ++round)
    minimum = std::min(minimum, seconds([&] { hand.block(false); }, 40) * 1e9 / (40 * 64));
  std::printf("64 modes in lasting contact, %s: %.1f ns a sample (%zu contact)\n", what, minimum,
              hand.body.contacts());
}

} // namespace

int main(int argc, char** argv) {
  const std::string part = argc > 1 ? argv[1] : "";
  if (part.empty() || part == "banks")
    banks();
  if (part.empty() || part == "bodies")
    bodies();
  if (part.empty() || part == "hand") {
    Striker spring, ball;
    spring.stiffness = 1e4;
    spring.exponent = 1;
    ball.stiffness = 1e6;
    lasting_contact("spring", spring, 1e-3, 1e-5);
    lasting_contact("ball", ball, 1e-4, 1e-6);
  }
  if (part.empty() || part == "resting")
    resting_bodies();
  if (part.empty() || part == "large")
    large_bodies(argc > 2 ? std::stoul(argv[2]) : 0);
}
