// Would steepening inside the bore, on each way of the wave, replace the steepening on the way out?
// See docs/results/greed.md, "Steepening inside the bore".
//
//   bench_reed_bore_steepening [--quick]
//
// prints one passage beside Blackstock's solution (Fubini's before the shock, the sawtooth after
// it), what a reflection leaves of it, the brass presets with the steepening inside and outside the
// bore, one length inside at three sample rates, and what each costs a sample (--quick leaves that
// out).
#include "bench/paired.hpp"
#include "core/dsp/complex.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/radiation_path.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/instrument/instrument.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "core/reed/instrument/valve_bore_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <vector>

namespace {

using namespace tactus::reed;
using Signal = std::vector<double>;
constexpr double kPi = std::numbers::pi;
constexpr int kBlock = 32; // samples of one run

std::size_t index(int i) { return static_cast<std::size_t>(i); }
double decibels(double ratio) { return 20 * std::log10(ratio); }

/// Seconds for each Pa and metre by which a piece of a simple wave runs ahead:
/// (gamma + 1)/(2 gamma P_0 c).
double lead_time(double sound_speed) {
  return (kHeatCapacityRatio + 1) / (2 * kHeatCapacityRatio * 101325 * sound_speed);
}

/// y(t) = x(t + lead y(t)) for count samples of x from x[at] on, |lead y| <= reach. The place is
/// found by linear interpolation and two secant steps; where pieces overtake one another a jump
/// stays where it is, as the entropy condition wants it of a jump from -p to p. Third-order
/// Lagrange: without lead the plain delay.
void steepen(const double* x, double at, double lead, double reach, double* y, int count) {
  std::array<double, kBlock> position;
  const auto shift = [&](double value) {
    const double early = lead * value < reach ? lead * value : reach;
    return early > -reach ? early : -reach;
  };
  const auto value_at = [&](double where, double& slope) {
    const int whole = static_cast<int>(where);
    slope = x[whole + 1] - x[whole];
    return x[whole] + (where - whole) * slope;
  };
  double slope;
  for (int i = 0; i < count; ++i)
    position[index(i)] = at + i + shift(value_at(at + i, slope));
  for (int secant = 0; secant < 2; ++secant)
    for (int i = 0; i < count; ++i) {
      const double value = value_at(position[index(i)], slope);
      const double left = 1 - lead * slope; // at most 1/4 where a shock is near
      const double displacement = position[index(i)] - (at + i);
      position[index(i)] =
          at + i + shift(left > 0.25 ? (value - slope * displacement) / left : value);
    }
  for (int i = 0; i < count; ++i) {
    const int whole = static_cast<int>(position[index(i)]);
    const double f = position[index(i)] - whole;
    const double* p = x + whole;
    y[i] = (f + 1) * (f - 2) * ((f - 1) / 2 * p[0] - f / 2 * p[1]) +
           f * (f - 1) * ((f + 1) / 6 * p[2] - (f - 2) / 6 * p[-1]);
  }
}

/// A delay line whose reader steepens.
class SteepeningLine {
public:
  explicit SteepeningLine(int longest) : line_(index(longest), 0.0) {}
  void write(const double* wave, int count) {
    const int first = std::min(count, mask() + 1 - written_);
    std::copy_n(wave, first, line_.begin() + written_);
    std::copy_n(wave + first, count - first, line_.begin());
    written_ = (written_ + count) & mask();
  }
  /// The samples that come `delay` after their writing, the first of them written next.
  void read(double delay, double lead, double reach, double* wave, int count) {
    const int oldest = static_cast<int>(delay + reach) + 3;
    const int length = static_cast<int>(2 * reach) + count + 8;
    piece_.resize(index(length));
    const int from = (written_ - oldest) & mask(), first = std::min(length, mask() + 1 - from);
    std::copy_n(line_.begin() + from, first, piece_.begin());
    std::copy_n(line_.begin(), length - first, piece_.begin() + first);
    steepen(piece_.data(), oldest - delay, lead, reach, wave, count);
  }

private:
  [[nodiscard]] int mask() const { return static_cast<int>(line_.size()) - 1; }
  Signal line_, piece_;
  int written_ = 0;
};

/// Bore lengths over which the wave steepens: on its way out of the bore, as RadiationPath does it
/// (brassiness) or as steepen() does it (leaving); inside the bore on each way, the way back times
/// `returning`.
struct Steepening {
  double brassiness = 0, leaving = 0, inside = 0, returning = 1;
};

/// A preset with tune 1 and ear 0, out of the parts that ReedBank is made of.
class Loop {
public:
  Loop(Parameters p, const Steepening& steepening, double rate, double bore_frequency)
      : steepening_(steepening), line_(1 << 16), back_(1 << 12), out_(1 << 12) {
    p.brassiness = steepening.brassiness;
    design_.set(p, rate);
    const PlayingSetup playing = tuned(p, bore_frequency, p.reed_frequency);
    length_ = playing.length;
    constants_ = ValveConstants::from(playing.valve, design_, rate);
    const double omega = 2 * kPi * p.reed_frequency * playing.reed_scale;
    coefficients_ = ReedCoefficients<double>::at(constants_, omega);
    trip_ = design_.round_trip(length_);
    path_.set(RadiationConstants::from(p, design_, rate));
    // In a cone a wave falls as 1/x and steepens over r_0 ln(1 + L/r_0) only. RadiationPath counts
    // all of L, and so does this, that the two may be compared length by length.
    lead_ = lead_time(design_.air().sound_speed) * rate * length_;
    reach_ = std::floor(std::min(5e-4 * rate, (trip_.delay - kBlock - 10) / 3));
  }
  /// kBlock samples: sound at 1 m and p_b, Pa.
  void run(const double* mouth, double* sound, double* bore) {
    std::array<double, kBlock> wave, angle, flow;
    const bool inside = steepening_.inside > 0;
    const double lead = inside ? lead_ * steepening_.inside : 0, reach = inside ? reach_ : 0;
    const double return_delay = inside ? reach + 3 : 0; // samples; the rest of the delay is way out
    line_.read(trip_.delay - return_delay, lead, reach, wave.data(), kBlock);
    {
      RoundTripFilter<double>::BlockFilter filter(filter_, trip_, path_.reflected_weight());
      for (int i = 0; i < kBlock; ++i)
        wave[index(i)] = filter(wave[index(i)], sound[i]);
    }
    if (inside) {
      back_.write(wave.data(), kBlock);
      back_.read(return_delay + kBlock, lead * steepening_.returning, reach, wave.data(), kBlock);
    }
    if (steepening_.leaving > 0) {
      out_.write(sound, kBlock);
      out_.read(reach_ + 3 + kBlock, lead_ * steepening_.leaving, reach_, sound, kBlock);
    }
    path_.run(sound, kBlock, length_);
    step_valve<false, false, false>(constants_, &coefficients_, 0, state_,
                                    {mouth, nullptr, wave.data(), angle.data(), bore, flow.data()},
                                    kBlock);
    line_.write(wave.data(), kBlock);
  }

private:
  Steepening steepening_;
  BoreDesign design_;
  ValveConstants constants_;
  ReedCoefficients<double> coefficients_;
  ValveState<double> state_;
  RoundTrip trip_;
  RoundTripFilter<double> filter_;
  RadiationPath path_;
  SteepeningLine line_, back_, out_;
  double length_ = 0, lead_ = 0, reach_ = 0;
};

/// Amplitude of the sinusoid at `turns` a sample, Hann window.
tactus::Complex component(const Signal& x, std::size_t from, std::size_t count, double turns) {
  tactus::Complex sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i);
    const double window = 1 - std::cos(2 * kPi * t / static_cast<double>(count));
    sum += window * x[from + i] * tactus::math::polar(1.0, -2 * kPi * turns * t);
  }
  return 2.0 * sum / static_cast<double>(count);
}

struct Measurement {
  double cents = 0, level = 0, centroid = 0;
  std::array<double, 20> harmonics{}; // amplitude
};

/// What the last half second of a note sounds like.
Measurement measure(const Signal& sound, const Signal& bore, double rate, double frequency) {
  Measurement measurement;
  const std::size_t count = index(static_cast<int>(rate / 4)), from = sound.size() - 2 * count;
  // The fundamental turns by the true frequency between two windows: near the note first.
  double turns = frequency / rate, largest = 0;
  for (double cents = -300; cents <= 300; cents += 10) {
    const double tried = frequency / rate * std::exp2(cents / 1200);
    const double size = abs(component(bore, from, count, tried));
    if (size > largest)
      largest = size, turns = tried;
  }
  const std::size_t apart = index(static_cast<int>(rate / 100));
  for (int n = 0; n < 3; ++n) {
    const double turned = 2 * kPi * static_cast<double>(apart);
    const auto first = component(bore, from, count, turns);
    const auto second = component(bore, from + apart, count, turns);
    turns += arg(second / first * tactus::math::polar(1.0, -turned * turns)) / turned;
  }
  measurement.cents = 1200 * std::log2(turns * rate / frequency);
  double power = 0, first_moment = 0;
  for (std::size_t k = 0; k < measurement.harmonics.size(); ++k) {
    const double number = static_cast<double>(k + 1);
    measurement.harmonics[k] = abs(component(sound, from, 2 * count, number * turns));
    power += std::pow(measurement.harmonics[k], 2);
    first_moment += number * std::pow(measurement.harmonics[k], 2);
  }
  measurement.level = 10 * std::log10(power / 2 + 1e-300);
  measurement.centroid = first_moment / (power + 1e-300);
  return measurement;
}

/// H1..H10 of both against their strongest, what is below -40 dB counting as -40: rms of the
/// differences, dB, as bench/realism_reed measures it.
double distance(const Measurement& a, const Measurement& b) {
  const auto level = [](const Measurement& measurement, std::size_t k) {
    const double top =
        *std::max_element(measurement.harmonics.begin(), measurement.harmonics.begin() + 10);
    return std::max(-40.0, decibels(measurement.harmonics[k] / (top + 1e-300) + 1e-30));
  };
  double sum = 0;
  for (std::size_t k = 0; k < 10; ++k)
    sum += std::pow(level(a, k) - level(b, k), 2);
  return std::sqrt(sum / 10);
}

Measurement play(const Parameters& p, const Steepening& steepening, double rate, double frequency,
                 double pressure) {
  Loop loop(p, steepening, rate, frequency);
  const int samples = static_cast<int>(1.6 * rate) / kBlock * kBlock;
  Signal sound(index(samples)), bore(index(samples));
  for (int i = 0; i < samples; i += kBlock) {
    std::array<double, kBlock> mouth;
    for (int k = 0; k < kBlock; ++k)
      mouth[index(k)] = pressure * std::min(1.0, (i + k) / (0.02 * rate));
    loop.run(mouth.data(), sound.data() + i, bore.data() + i);
  }
  return measure(sound, bore, rate, frequency);
}

/// n-th harmonic of a sine of amplitude 1 after sigma shock distances (Blackstock 1966): Fubini's
/// series before the shock, after it what the weak shock at phi_s = sigma sin(phi_s) leaves.
double blackstock(int n, double sigma) {
  double shock = 0;
  if (sigma > 1) {
    shock = kPi * sigma / (1 + sigma);
    for (int k = 0; k < 60; ++k)
      shock -= (shock - sigma * std::sin(shock)) / (1 - sigma * std::cos(shock));
  }
  constexpr int kSteps = 20000;
  double integral = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double phi = shock + (kPi - shock) * (k + 0.5) / kSteps;
    integral += std::cos(n * (phi - sigma * std::sin(phi))) * (kPi - shock) / kSteps;
  }
  return 2 / (n * kPi) * (std::sin(shock) + integral / sigma);
}

/// A travelling sine of 233 Hz and 1000 Pa, `steps` passages long.
void print_single_trip(double rate, double sigma, int steps) {
  const double frequency = 233, pressure = 1000, period = rate / frequency;
  const double lead = sigma / steps * period / (2 * kPi * pressure);
  const int reach = static_cast<int>(lead * pressure) + 2, margin = steps * (reach + 8);
  const int size = static_cast<int>(8 * period) + 2 * margin + 2 * kBlock;
  Signal wave(index(size)), next(index(size));
  for (int i = 0; i < size; ++i)
    wave[index(i)] = pressure * std::sin(2 * kPi * i / period);
  const std::size_t from = index(margin), count = index(static_cast<int>(6 * period));
  const auto energy_of = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i)
      sum += wave[from + i] * wave[from + i];
    return sum;
  };
  double energy = energy_of(), gain = 0; // the largest of one passage
  for (int n = 1; n <= steps; ++n) {
    for (int i = n * (reach + 8); i + kBlock < size - n * (reach + 8); i += kBlock)
      steepen(wave.data(), i, lead, reach, next.data() + i, kBlock);
    wave.swap(next);
    const double now = energy_of();
    gain = std::max(gain, now / energy - 1);
    energy = now;
  }
  std::printf("%6.0f %5.2f %5d  ", rate, sigma, steps);
  for (int n = 1; n <= 6; ++n)
    std::printf(" %+6.2f", decibels(abs(component(wave, from, count, n / period)) /
                                    (pressure * blackstock(n, sigma))));
  std::printf("  %8.5f\n", gain);
}

/// A sine out to the end, where it is inverted, and back: what is left of the steepening.
void print_round_trip(double rate, double sigma) {
  const double period = rate / 233, lead = sigma * period / (2 * kPi);
  const int size = static_cast<int>(12 * period), reach = static_cast<int>(lead) + 2;
  Signal wave(index(size)), next(index(size));
  for (int i = 0; i < size; ++i)
    wave[index(i)] = std::sin(2 * kPi * i / period);
  std::printf("%6.0f %5.2f  ", rate, sigma);
  for (int direction = 1; direction <= 2; ++direction) {
    for (int i = direction * (reach + 8); i + kBlock < size - direction * (reach + 8); i += kBlock)
      steepen(wave.data(), i, lead, reach, next.data() + i, kBlock);
    wave.swap(next);
    const auto level = [&](int n) {
      const std::size_t from = index(static_cast<int>(2 * period));
      return decibels(abs(component(wave, from, index(static_cast<int>(6 * period)), n / period)));
    };
    std::printf("  %s H1 %+6.2f H2 %+7.2f H3 %+7.2f", direction == 1 ? "out" : "back", level(1),
                level(2), level(3));
    for (double& value : wave)
      value = -value;
  }
  std::printf("\n");
}

/// The same for the way out as it is, of which the bell is made flat.
void print_outgoing(double rate, double sigma) {
  const double frequency = 466, length = 2, pressure = 600; // within its reach of 24 samples
  Parameters p;
  p.bell = 1e-3;
  BoreDesign bore;
  bore.set(p, rate);
  p.brassiness =
      sigma / (2 * kPi * frequency * pressure * lead_time(bore.air().sound_speed) * length);
  RadiationPath path;
  path.set(RadiationConstants::from(p, bore, rate));
  Signal wave(index(static_cast<int>(rate) / kBlock * kBlock));
  for (std::size_t i = 0; i < wave.size(); ++i)
    wave[i] = pressure * std::sin(2 * kPi * frequency / rate * static_cast<double>(i));
  for (std::size_t i = 0; i < wave.size(); i += kBlock)
    path.run(wave.data() + i, kBlock, length);
  std::printf("%6.0f %5.2f   out  ", rate, sigma);
  for (int n = 1; n <= 6; ++n)
    std::printf(" %+6.2f", decibels(abs(component(wave, wave.size() / 2, wave.size() / 4,
                                                  n * frequency / rate)) /
                                    (pressure * p.input_radius / 2 * blackstock(n, sigma))));
  std::printf("\n");
}

struct Brass {
  const char* name;
  std::array<int, 3> keys;
  std::array<double, 4> pressures;
};
constexpr std::array<Brass, 2> kBrass{{{"trombone", {46, 50, 55}, {1200, 2000, 2500, 3000}},
                                       {"trumpet", {58, 62, 67}, {2000, 3000, 4000, 6000}}}};
double key_frequency(int key) { return 440 * std::exp2((key - 69) / 12.0); }

constexpr std::array<const char*, 7> kVariants{
    "outside, preset's lengths", "the same, RadiationPath", "no steepening",
    "outside, 1 length",         "inside, 1 length",        "inside, 1, back linear",
    "inside, preset's lengths"};

void print_presets() {
  std::printf("\npresets, tune 1, ear 0, 48 kHz: cents | level dB | centroid/f0 | H1..H10 against "
              "the first, dB\n");
  struct Sum {
    double cents = 0, centroid = 0, outside = 0, single = 0;
  };
  for (const Brass& brass : kBrass) {
    std::array<Sum, kVariants.size()> sums{};
    const double notes = static_cast<double>(brass.keys.size() * brass.pressures.size());
    for (const int key : brass.keys)
      for (const double pressure : brass.pressures) {
        const Parameters p = *find_preset(brass.name);
        const std::array<Steepening, kVariants.size()> variants{Steepening{.leaving = p.brassiness},
                                                                {.brassiness = p.brassiness},
                                                                {},
                                                                {.leaving = 1},
                                                                {.inside = 1},
                                                                {.inside = 1, .returning = 0},
                                                                {.inside = p.brassiness}};
        std::array<Measurement, kVariants.size()> measurement;
        for (std::size_t i = 0; i < variants.size(); ++i)
          measurement[i] = play(p, variants[i], 48000, key_frequency(key), pressure);
        for (std::size_t i = 0; i < variants.size(); ++i) {
          const double from_outside = distance(measurement[i], measurement[0]);
          std::printf("%-8s %d %4.0f Pa  %-26s %+8.1f | %6.1f | %5.2f | %5.1f\n", brass.name, key,
                      pressure, kVariants[i], measurement[i].cents, measurement[i].level,
                      measurement[i].centroid, from_outside);
          sums[i].cents =
              std::max(sums[i].cents, std::abs(measurement[i].cents - measurement[2].cents));
          sums[i].centroid += measurement[i].centroid / measurement[0].centroid / notes;
          sums[i].outside += from_outside / notes;
          sums[i].single += distance(measurement[i], measurement[3]) / notes;
        }
      }
    std::printf("\n%s, all notes: largest change of pitch, cents | mean centroid against the first "
                "| mean distance from it, dB | from one length outside, dB\n",
                brass.name);
    for (std::size_t i = 0; i < kVariants.size(); ++i)
      std::printf("  %-26s %6.1f | %5.2f | %5.1f | %5.1f\n", kVariants[i], sums[i].cents,
                  sums[i].centroid, sums[i].outside, sums[i].single);
  }
}

void print_rates() {
  std::printf("\none length inside at 48, 192 and 768 kHz: cents | level dB | centroid | from 768 "
              "kHz, dB\n");
  for (const Brass& brass : kBrass) {
    const Parameters p = *find_preset(brass.name);
    const double frequency = key_frequency(brass.keys[1]), pressure = brass.pressures[2];
    const Measurement finest = play(p, {.inside = 1}, 768000, frequency, pressure);
    for (const double rate : {48000.0, 192000.0, 768000.0}) {
      const Measurement measurement = play(p, {.inside = 1}, rate, frequency, pressure);
      std::printf("%-8s %6.0f  %+8.1f | %6.1f | %5.2f | %5.2f\n", brass.name, rate,
                  measurement.cents, measurement.level, measurement.centroid,
                  distance(measurement, finest));
    }
  }
}

/// One part of the step, fed with a played wave.
class Part {
public:
  enum class Kind { kPlainRead, kOutgoing, kBothWays };
  explicit Part(Kind kind) : kind_(kind), parameters_(*find_preset("trombone")) {
    design_.set(parameters_, 48000);
    plain_.prepare(max_delay(48000));
    path_.set(RadiationConstants::from(parameters_, design_, 48000));
    for (std::size_t n = 0; n < wave_.size(); ++n)
      source_[n] = 1500 * std::sin(2 * kPi * static_cast<double>(n) / static_cast<double>(kBlock));
  }
  void block() {
    for (std::size_t from = 0; from < source_.size(); from += kBlock) {
      double* wave = wave_.data() + from;
      const double* source = source_.data() + from;
      if (kind_ == Kind::kOutgoing) {
        std::copy_n(source, kBlock, wave);
        path_.run(wave, kBlock, 2);
      } else if (kind_ == Kind::kPlainRead) {
        double* next = plain_.next();
        plain_.read(560.3, 1e-20, next, kBlock);
        plain_.advance(kBlock);
      } else {
        line_.write(source, kBlock);
        line_.read(533.3, 1e-3, 24, wave, kBlock);
        back_.write(wave, kBlock);
        back_.read(27 + kBlock, 1e-3, 24, wave, kBlock);
      }
    }
    benchmark::DoNotOptimize(wave_);
  }

private:
  Kind kind_;
  Parameters parameters_;
  BoreDesign design_;
  RadiationPath path_;
  BoreLine<double, 64> plain_;
  SteepeningLine line_{1 << 12}, back_{1 << 12};
  std::array<double, tactus::bench::kBlock> source_{}, wave_{};
};

void print_cost(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  Part read(Part::Kind::kPlainRead), out(Part::Kind::kOutgoing), inside(Part::Kind::kBothWays);
  tactus::bench::add("plain read of the bore's line", read);
  tactus::bench::add("bell with steepening outside", out);
  tactus::bench::add("both steepened reads inside", inside);
  benchmark::RunSpecifiedBenchmarks();
  tactus::bench::print_ratio("both steepened reads / bell with steepening outside", inside, out);
}

} // namespace

int main(int argc, char** argv) {
  std::printf(
      "a sine after sigma shock distances, H1..H6 in dB from Blackstock's solution; energy gained\n"
      "  rate sigma steps\n");
  for (const double rate : {48000.0, 192000.0, 768000.0}) {
    for (const double sigma : {0.3, 0.7, 0.9})
      print_single_trip(rate, sigma, 1);
    for (const double sigma : {1.5, 3.0, 8.0})
      print_single_trip(rate, sigma, 40);
  }
  std::printf("the way out as it is (RadiationPath)\n");
  for (const double sigma : {0.3, 0.7, 0.9})
    print_outgoing(48000, sigma);
  std::printf("out, inverted, back: harmonics in dB of the sine that went out\n");
  for (const double sigma : {0.3, 0.7})
    print_round_trip(192000, sigma);
  print_presets();
  print_rates();
  if (argc < 2 || std::strcmp(argv[1], "--quick") != 0)
    print_cost(argc, argv);
}
