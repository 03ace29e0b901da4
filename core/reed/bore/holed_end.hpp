#pragma once

#include "core/reed/bore/termination.hpp"
#include "core/reed/bore/termination_filter.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace tactus::reed {

/// The end of a bore with tone holes while it is fingered: what comes back from the first open
/// hole, and what is heard outside. A new fingering is blended in over 5 ms, as long as keys take
/// to move: the sum of two reflectances by shares that add up to 1 reflects no more than the larger
/// of them.
template <class V> class HoledEnd {
public:
  /// Internal samples a second, c/c_20, and the radius of the bore's input, m.
  void set(double rate, double speed_ratio, double input_radius) noexcept {
    rate_ = rate;
    speed_ratio_ = speed_ratio;
    radius_ = input_radius;
    step_ = 1 / (kMovingTime * rate);
    for (std::size_t i = 0; i < 2; ++i)
      design(i);
  }
  /// The fingering from now on; null: no holes. Where there were none it is there at once.
  void finger(const Termination* termination) noexcept {
    wanted_ = termination;
    if (termination == nullptr || of_[now_] == nullptr) {
      of_ = {termination, termination};
      share_ = heard_ = 1;
      design(now_);
      reset();
    }
  }
  [[nodiscard]] bool active() const noexcept { return of_[now_] != nullptr; }
  /// Between stretches: begins the next movement once the last has ended.
  void proceed() noexcept {
    if (share_ < 1 || heard_ < 1 || wanted_ == of_[now_])
      return;
    now_ = 1 - now_;
    of_[now_] = wanted_;
    share_ = heard_ = 0;
    design(now_);
    returning_[now_].reset();
    outside_[now_].reset();
  }
  void reset() noexcept {
    for (auto& filter : returning_)
      filter.reset();
    for (auto& filter : outside_)
      filter.reset();
  }
  /// Calls change() for each number of the state inside the bore,
  template <class Change> void each(Change change) noexcept {
    for (auto& filter : returning_)
      filter.each(change);
  }
  /// and outside.
  template <class Change> void each_outside(Change change) noexcept {
    for (auto& filter : outside_)
      filter.each(change);
  }

  /// What arrives at the end, in place, becomes what comes back.
  void reflect(V* wave, int count) noexcept {
    share_ = run(returning_, reflection_, share_, wave, count);
  }
  /// What arrives becomes the pressure at 1 m, Pa.
  void radiate(double* wave, int count) noexcept {
    heard_ = run(outside_, radiation_, heard_, wave, count);
  }

private:
  static constexpr double kMovingTime = 5e-3; // s

  void design(std::size_t i) noexcept {
    if (of_[i] == nullptr)
      return;
    reflection_[i].set(of_[i]->reflection, of_[i]->at_zero, rate_, speed_ratio_, 1);
    radiation_[i].set(of_[i]->radiation, 0, rate_, speed_ratio_, radius_);
  }

  template <class Filters, class Designs, class S>
  double run(Filters& filters, const Designs& designs, double share, S* wave, int count) noexcept {
    if (share >= 1) {
      settled(filters[now_], designs[now_], wave, count);
      return 1;
    }
    typename Filters::value_type::Stretch before(filters[1 - now_], designs[1 - now_]);
    typename Filters::value_type::Stretch after(filters[now_], designs[now_]);
    for (int i = 0; i < count; ++i) {
      share = std::min(1.0, share + step_);
      wave[i] = S(1 - share) * before(wave[i]) + S(share) * after(wave[i]);
    }
    return share;
  }
  template <class Filter, class Design, class S>
  [[gnu::noinline, gnu::flatten]] static void settled(Filter& filter, const Design& design, S* wave,
                                                      int count) noexcept {
    typename Filter::Stretch stretch(filter, design);
    for (int i = 0; i < count; ++i)
      wave[i] = stretch(wave[i]);
  }

  std::array<const Termination*, 2> of_{}; // the fingering now, and the one before
  const Termination* wanted_ = nullptr;
  std::size_t now_ = 0;
  double rate_ = 48000, speed_ratio_ = 1, radius_ = 7.5e-3, step_ = 1;
  double share_ = 1, heard_ = 1; // of the new fingering, inside and outside
  std::array<DigitalReflection, 2> reflection_{};
  std::array<DigitalRadiation, 2> radiation_{};
  std::array<TerminationFilter<V, Termination::kReflectionBlocks>, 2> returning_{};
  std::array<TerminationFilter<double, Termination::kRadiationBlocks>, 2> outside_{};
};

} // namespace tactus::reed
