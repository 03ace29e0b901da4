// The cost of a contact: One mass pressed on a body of 8 modes, one surface rubbing it, a body that
// rings alone, many masses at once, many separate bodies in one list of modes; and STK's ModalBar,
// four filters without any contact, beside them.
//
//   bench_contact_speed --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
//
// prints nanoseconds a sample. The last lines, ratios of rounds that were run in turn within
// milliseconds of each other, are what to trust on a shared machine.
#include "bench/paired.hpp"
#include "core/contact/excited_body.hpp"

#include <benchmark/benchmark.h>
#ifdef TACTUS_HAS_STK
#include <stk/ModalBar.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <vector>

namespace {

using namespace tactus::contact;
using namespace tactus::bench;

constexpr double kRate = 48000;

std::vector<Mode> bar(std::size_t count) {
  std::vector<Mode> modes;
  for (std::size_t i = 0; i < count; ++i) {
    const double order = static_cast<double>(i) + 1;
    modes.push_back({180 * order * order / (1 + 0.1 * order), 0.8 / order, 0.3});
  }
  return modes;
}

using Block = std::array<double, kBlock>;

/// Masses that a changing force presses on the body, so that contact is never lost.
class Pressed {
public:
  Pressed(std::size_t modes, std::size_t masses, double exponent) : body_(modes, masses) {
    body_.prepare(kRate);
    body_.set_modes(bar(modes));
    for (std::size_t i = 0; i < masses; ++i) {
      body_.set_impact(i, {3e5, exponent, 0.3}, 0.05);
      body_.launch_mass(i, 0, 0.01);
    }
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    for (double& x : drive_) {
      phase_ = phase_ < 1 ? phase_ + 0.003 : 0;
      x = 5 + phase_;
    }
    if (body_.exciters() == 1) {
      body_.run_mass(0, drive_, sound_, force_);
    } else {
      for (std::size_t n = 0; n < sound_.size(); ++n) {
        for (std::size_t i = 0; i < body_.exciters(); ++i)
          body_.set_mass_force(i, drive_[n]);
        body_.step();
        sound_[n] = body_.pickup_velocity();
      }
    }
    benchmark::DoNotOptimize(sound_);
  }
  [[nodiscard]] const ExcitedBody& body() const { return body_; }

private:
  ExcitedBody body_;
  double phase_ = 0;
  Block drive_{}, sound_{}, force_{};
};

/// A surface that sticks and slips.
class Rubbed {
public:
  explicit Rubbed(std::size_t modes) : body_(modes, 1) {
    body_.prepare(kRate);
    body_.set_modes(bar(modes));
    body_.set_friction(0, {.8, .3, .1, .5, 1e5, 40, .5});
    velocity_.fill(0.1);
    normal_.fill(20);
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    body_.run_rub(0, velocity_, normal_, sound_, force_);
    benchmark::DoNotOptimize(sound_);
  }

private:
  ExcitedBody body_;
  Block velocity_{}, normal_{}, sound_{}, force_{};
};

/// A body that was struck and rings, or that never was.
class Free {
public:
  Free(std::size_t modes, bool rings) : body_(modes, 1), rings_(rings) {
    body_.prepare(kRate);
    body_.set_modes(bar(modes));
    body_.set_impact(0, {}, 0.05);
  }
  void block() {
    if (rings_ && clock_++ % 750 == 0)
      body_.apply_impulse(0, 1);
    body_.run_mass(0, drive_, sound_, force_);
    benchmark::DoNotOptimize(sound_);
  }

private:
  ExcitedBody body_;
  bool rings_;
  int clock_ = 0;
  Block drive_{}, sound_{}, force_{};
};

/// Separate bodies in one list of modes, a mass on each; on some it is pressed so that contact is
/// never lost, over the others it waits far away.
class SeparateBodies {
public:
  SeparateBodies(std::size_t bodies, std::size_t modes_each, std::size_t pressed)
      : body_(bodies * modes_each, bodies), pressed_(pressed) {
    std::vector<Mode> modes;
    for (std::size_t i = 0; i < bodies; ++i)
      for (Mode mode : bar(modes_each)) {
        mode.frequency_hz *= 1 + 0.002 * static_cast<double>(i);
        modes.push_back(mode);
      }
    body_.prepare(kRate);
    body_.set_modes(modes);
    std::vector<double> shape(modes.size(), 0.0);
    for (std::size_t i = 0; i < bodies; ++i) {
      const auto own = shape.begin() + static_cast<std::ptrdiff_t>(i * modes_each);
      std::fill_n(own, modes_each, 1.0);
      body_.set_contact_shape(i, shape);
      std::fill_n(own, modes_each, 0.0);
      body_.set_impact(i, {3e5, 1.5, 0.3}, 0.05);
      body_.launch_mass(i, i < pressed ? 0 : 1, i < pressed ? 0.01 : 0);
    }
    for (int n = 0; n < 50; ++n)
      block();
  }
  void block() {
    for (double& x : sound_) {
      phase_ = phase_ < 1 ? phase_ + 0.003 : 0;
      for (std::size_t i = 0; i < pressed_; ++i)
        body_.set_mass_force(i, 5 + phase_);
      body_.step();
      x = body_.pickup_velocity();
    }
    benchmark::DoNotOptimize(sound_);
  }
  [[nodiscard]] std::size_t touching() const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < body_.exciters(); ++i)
      sum += body_.force(i) > 0;
    return sum;
  }

private:
  ExcitedBody body_;
  std::size_t pressed_;
  double phase_ = 0;
  Block sound_{};
};

/// Two of a kind in turn.
template <class Player> struct Two {
  Player first, second;
  void block() {
    first.block();
    second.block();
  }
};

#ifdef TACTUS_HAS_STK
class Peer {
public:
  Peer() {
    stk::Stk::setSampleRate(kRate);
    stk::Stk::setRawwavePath("/usr/share/stk/rawwaves/");
    bar_ = std::make_unique<stk::ModalBar>();
    bar_->noteOn(220, 0.8);
    for (int n = 0; n < 750; ++n)
      block();
  }
  void block() {
    if (++clock_ % 750 == 0)
      bar_->noteOn(220, 0.8);
    for (double& x : sound_)
      x = bar_->tick();
    benchmark::DoNotOptimize(sound_);
  }

private:
  std::unique_ptr<stk::ModalBar> bar_;
  int clock_ = 0;
  std::array<double, kBlock> sound_{};
};
#endif

} // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  Pressed ball(8, 1, 1.5), felt(8, 1, 2.3), many(8, 64, 1.5), some(12, 4, 1.5);
  Rubbed rubbed(8);
  SeparateBodies pebbles(1000, 1, 1000), few(1000, 1, 10), far(1000, 1, 0), bars(2, 20, 2);
  Two<SeparateBodies> separate{SeparateBodies(1, 20, 1), SeparateBodies(1, 20, 1)};
  Free ringing(8, true), large(64, true), silent(8, false);
  add("impact in contact, 8 modes, exponent 1.5", ball);
  add("impact in contact, 8 modes, exponent 2.3", felt);
  add("friction, 8 modes", rubbed);
  add("ringing alone, 8 modes", ringing);
  add("ringing alone, 64 modes", large);
  add("silence", silent);
  add("4 masses in contact, 12 modes", some);
  add("64 masses in contact, 8 modes", many);
  add("1000 pebbles of one mode, all in contact", pebbles);
  add("1000 pebbles of one mode, ten in contact", few);
  add("1000 pebbles of one mode, none near", far);
  add("two bars of 20 modes in contact, one list", bars);
  add("two bars of 20 modes in contact, each its own", separate);
#ifdef TACTUS_HAS_STK
  Peer peer;
  add("STK ModalBar, 4 modes", peer);
#endif
  benchmark::RunSpecifiedBenchmarks();
  std::printf("\nsteps a sample: %u, %u, %u with 64 masses\n", ball.body().steps(),
              felt.body().steps(), many.body().steps());
  std::printf("pebbles in contact: %zu, %zu, %zu\n", pebbles.touching(), few.touching(),
              far.touching());
  std::printf("\nratio, median of paired rounds\n");
  print_ratio("64 masses in contact / one", many, ball);
  print_ratio("1000 pebbles in contact / one mass on 8 modes", pebbles, ball);
  print_ratio("1000 pebbles, ten in contact / one mass on 8 modes", few, ball);
  print_ratio("two bars in contact in one list / two separate ones", bars, separate);
#ifdef TACTUS_HAS_STK
  print_ratio("impact in contact, exponent 1.5 / STK ModalBar", ball, peer);
  print_ratio("impact in contact, exponent 2.3 / STK ModalBar", felt, peer);
  print_ratio("friction / STK ModalBar", rubbed, peer);
  print_ratio("ringing alone, 8 modes / STK ModalBar", ringing, peer);
  print_ratio("silence / STK ModalBar", silent, peer);
#endif
}
