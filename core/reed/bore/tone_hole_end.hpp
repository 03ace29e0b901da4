#pragma once

#include "core/reed/bore/termination.hpp"
#include "core/reed/bore/termination_filter.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace tactus::reed {

/// The end of a bore with tone holes, or a brass bell: reflection and radiation of the present
/// fingering (Termination), with a cross-fade to the next.
///
/// A fade takes 5 ms, about as long as a key moves. The two reflectances are weighted by shares
/// that add up to 1, so that the sum never reflects more than the larger of them. V is double or
/// simd::Lanes. No allocation.
template <class V> class ToneHoleEnd {
public:
  /// rate: internal, Hz; speed_ratio: c/c_20; input_radius: of the bore, m.
  void set(double rate, double speed_ratio, double input_radius) noexcept {
    rate_ = rate;
    speed_ratio_ = speed_ratio;
    radius_ = input_radius;
    step_ = 1 / (kFadeTime * rate);
    for (std::size_t i = 0; i < 2; ++i)
      design(i);
  }
  /// Sets the next fingering, which must outlive its use; null: no holes. Changes to or from null
  /// are immediate; other changes wait for start_pending_fade().
  void finger(const Termination* termination) noexcept {
    target_ = termination;
    if (termination == nullptr || fingerings_[current_] == nullptr) {
      fingerings_ = {termination, termination};
      reflection_fade_ = radiation_fade_ = 1;
      design(current_);
      reset();
    }
  }
  [[nodiscard]] bool active() const noexcept { return fingerings_[current_] != nullptr; }
  /// To be called between blocks: begins the fade to the fingering set last, once the previous fade
  /// has ended.
  void start_pending_fade() noexcept {
    if (reflection_fade_ < 1 || radiation_fade_ < 1 || target_ == fingerings_[current_])
      return;
    current_ = 1 - current_;
    fingerings_[current_] = target_;
    reflection_fade_ = radiation_fade_ = 0;
    design(current_);
    reflection_filters_[current_].reset();
    radiation_filters_[current_].reset();
  }
  void reset() noexcept {
    for (auto& filter : reflection_filters_)
      filter.reset();
    for (auto& filter : radiation_filters_)
      filter.reset();
  }
  /// Calls change() for each number of the state inside the bore.
  template <class Change> void each(Change change) noexcept {
    for (auto& filter : reflection_filters_)
      filter.each(change);
  }
  /// Calls change() for each number of the state outside the bore.
  template <class Change> void each_radiation(Change change) noexcept {
    for (auto& filter : radiation_filters_)
      filter.each(change);
  }

  /// Arriving wave to reflected wave, in place, Pa.
  void reflect(V* wave, int count) noexcept {
    reflection_fade_ = run(reflection_filters_, reflection_designs_, reflection_fade_, wave, count);
  }
  /// Arriving wave to sound pressure at 1 m, in place, Pa.
  void radiate(double* wave, int count) noexcept {
    radiation_fade_ = run(radiation_filters_, radiation_designs_, radiation_fade_, wave, count);
  }

private:
  static constexpr double kFadeTime = 5e-3; // s

  void design(std::size_t i) noexcept {
    if (fingerings_[i] == nullptr)
      return;
    reflection_designs_[i].set(fingerings_[i]->reflection, fingerings_[i]->dc_value, rate_,
                               speed_ratio_, 1);
    radiation_designs_[i].set(fingerings_[i]->radiation, 0, rate_, speed_ratio_, radius_);
  }

  template <class Filters, class Designs, class S>
  double run(Filters& filters, const Designs& designs, double share, S* wave, int count) noexcept {
    if (share >= 1) {
      run_steady(filters[current_], designs[current_], wave, count);
      return 1;
    }
    typename Filters::value_type::BlockFilter before(filters[1 - current_], designs[1 - current_]);
    typename Filters::value_type::BlockFilter after(filters[current_], designs[current_]);
    for (int i = 0; i < count; ++i) {
      share = std::min(1.0, share + step_);
      wave[i] = S(1 - share) * before(wave[i]) + S(share) * after(wave[i]);
    }
    return share;
  }
  template <class Filter, class Design, class S>
  [[gnu::noinline, gnu::flatten]] static void run_steady(Filter& filter, const Design& design,
                                                         S* wave, int count) noexcept {
    typename Filter::BlockFilter block_filter(filter, design);
    for (int i = 0; i < count; ++i)
      wave[i] = block_filter(wave[i]);
  }

  std::array<const Termination*, 2> fingerings_{}; // present ([current_]) and previous
  const Termination* target_ = nullptr;
  std::size_t current_ = 0;
  double rate_ = 48000, speed_ratio_ = 1, radius_ = 7.5e-3, step_ = 1;
  double reflection_fade_ = 1, radiation_fade_ = 1; // fade of the new fingering, inside and outside
  std::array<DigitalReflection, 2> reflection_designs_{};
  std::array<DigitalRadiation, 2> radiation_designs_{};
  std::array<TerminationFilter<V, Termination::kReflectionBlocks>, 2> reflection_filters_{};
  std::array<TerminationFilter<double, Termination::kRadiationBlocks>, 2> radiation_filters_{};
};

} // namespace tactus::reed
