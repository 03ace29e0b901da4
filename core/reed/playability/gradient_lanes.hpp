#pragma once

#include "core/reed/instrument/reed_bank.hpp"
#include "core/reed/playability/gradient_ensemble.hpp"

#include <algorithm>

namespace tactus::reed {

/// ReedEnsemble for one instruction set: a ReedBank and a PlayabilityFollower over the lanes V.
///
/// Included once per instruction set, in a source file that is compiled for it. Everything here is
/// a template over that set's lane type, so that the linker cannot merge code for a newer processor
/// into the path of an older one.
template <class V> class LaneEnsemble final : public ReedEnsemble {
  static_assert(simd::LaneTraits<V>::count == kLanes);
  using Scalar = typename simd::LaneTraits<V>::Scalar;

public:
  void prepare(double sample_rate) override {
    bank_.prepare(sample_rate);
    follower_.prepare(sample_rate);
  }
  void set(const Parameters& parameters) noexcept override { bank_.set(parameters); }
  void set(const PlayabilityParameters& parameters) noexcept override { follower_.set(parameters); }
  void reset() noexcept override {
    bank_.reset();
    follower_.reset();
    angle_ = pressure_ = V(0.0);
  }

  [[gnu::flatten]] void process(const Pressure& mouth, const PerLane& reed_frequency,
                                double bore_frequency, std::size_t frames,
                                std::span<double> sound) noexcept override {
    V reed(0.0), start(0.0), slope(0.0);
    for (int lane = 0; lane < static_cast<int>(kLanes); ++lane) {
      const auto at = static_cast<std::size_t>(lane);
      simd::set_lane(reed, lane, static_cast<Scalar>(reed_frequency[at]));
      simd::set_lane(start, lane, static_cast<Scalar>(mouth.start[at]));
      simd::set_lane(slope, lane, static_cast<Scalar>(mouth.slope[at]));
    }
    constexpr int kBlock = ReedBank<V>::kControlPeriod;
    V pressure[kBlock + 1], angle[kBlock], bore[kBlock], flow[kBlock];
    double discarded[kBlock];
    for (int done = 0; done < static_cast<int>(frames);) {
      if (bank_.until_control() == 0)
        bank_.control(reed, bore_frequency);
      int count = static_cast<int>(frames) - done;
      if (count > bank_.until_control())
        count = bank_.until_control();
      // Odd and even samples apart make two shorter dependency chains.
      V odd(static_cast<double>(mouth.first) + done + 1), even(odd + V(1.0));
      for (int i = 0; i < count; i += 2) {
        pressure[i] = clamp_pressure(start + slope * odd);
        pressure[i + 1] = clamp_pressure(start + slope * even);
        odd += V(2.0);
        even += V(2.0);
      }
      double* radiated = sound.empty() ? discarded : sound.data() + done;
      bank_.run(pressure, {radiated, angle, bore, flow}, count);
      follower_.run(angle, count);
      angle_ = angle[count - 1];
      pressure_ = bore[count - 1];
      done += count;
    }
  }

  void set_active_lanes(std::size_t count) noexcept override {
    follower_.set_active_lanes(static_cast<int>(std::clamp<std::size_t>(count, 1, kLanes)));
  }
  double angle(std::size_t lane) const noexcept override { return at(angle_, lane); }
  double bore_pressure(std::size_t lane) const noexcept override { return at(pressure_, lane); }
  double playability(std::size_t lane) const noexcept override {
    return follower_.playability(static_cast<int>(lane));
  }
  double envelope(std::size_t lane) const noexcept override {
    return follower_.envelope(static_cast<int>(lane));
  }
  double length() const noexcept override { return bank_.length(); }

private:
  static double at(const V& values, std::size_t lane) noexcept {
    return static_cast<double>(simd::lane(values, static_cast<int>(lane)));
  }
  static V clamp_pressure(const V& p) noexcept {
    constexpr double kHighest = 50e3; // limit, as Instrument::kHighestPressure
    return simd::minimum(simd::maximum(p, V(-kHighest)), V(kHighest));
  }

  ReedBank<V> bank_;
  PlayabilityFollower<V> follower_;
  V angle_{0.0}, pressure_{0.0};
};

} // namespace tactus::reed
