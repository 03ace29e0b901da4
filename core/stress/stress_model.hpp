#pragma once

#include "core/stress/feedback.hpp"
#include "core/stress/stress_table.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace tactus::stress {

/// The feedback of one shape of the part. Components are equal but in the axis mapping.
struct Feedback {
  haptic::Vec3 raw, min, max; ///< g and its range: Pa, or Pa^2/m where sensitivities weigh
  haptic::Vec3 gamma;         ///< 0..1
  double mean_pa = 0;         ///< weighted mean of the stress, whatever the mapping
  double peak_pa = 0;         ///< largest stress of an element
  double trust_ratio = 0;     ///< largest displacement of a control point since the base / trust
  friend bool operator==(const Feedback&, const Feedback&) = default;
};

/// Taylor's series of the stress about the last solution, and the feedback of it.
/// s = s0 + S (p - p0); p: displacements of the parameters from the table's shape, p0: those of the
/// base. First order: the error grows as the square of p - p0. The von Mises stress of the series
/// can become negative far outside the trust size.
class StressModel {
public:
  explicit StressModel(std::shared_ptr<const StressTable> table);

  [[nodiscard]] const StressTable& table() const noexcept { return *table_; }
  [[nodiscard]] const StressBase& base() const noexcept { return base_ ? *base_ : table_->base; }
  /// The control point whose sensitivities weigh; none: the mean over all that have parameters.
  /// A table without shear or volumes gives von Mises and uniform weights. Allocates.
  void select(const FeedbackSettings& settings, std::optional<std::size_t> control_point);
  /// A new solution; `check_base` has passed it. Null: the table's own. Allocates.
  void rebase(std::shared_ptr<const StressBase> base);
  /// displacement_m: [P]; what is not finite is 0. Allocates nothing.
  [[nodiscard]] const Feedback& update(std::span<const double> displacement_m) noexcept;
  /// The series at some elements, Pa: as many numbers as elements. Allocates nothing.
  void stress_of(std::span<const std::size_t> elements, std::span<const double> displacement_m,
                 std::span<double> stress_pa) const noexcept;
  /// Largest length of a control point's displacement between two shapes, m.
  [[nodiscard]] double distance_m(std::span<const double> a, std::span<const double> b) noexcept;

private:
  /// h of the three axes: rows of a base, or means over control points.
  struct Weighting {
    std::array<const float*, 3> h{};
    std::array<std::vector<float>, 3> mean;
  };
  [[nodiscard]] const StressField& field(const StressBase& base) const noexcept;
  void compute_weighting(const StressField& field, Weighting& weighting) const;
  [[nodiscard]] FeedbackTask task(const StressField& field,
                                  const Weighting& weighting) const noexcept;
  void prepare();
  [[nodiscard]] double share() const noexcept; ///< of a sum in the result

  std::shared_ptr<const StressTable> table_;
  std::shared_ptr<const StressBase> base_;
  FeedbackSettings settings_;
  std::optional<std::size_t> control_point_;
  Weighting weighting_;
  FeedbackSums initial_{}; ///< of the table's own base
  double weight_sum_ = 0;
  double scale_pa_ = 1; ///< of the sum of powers: the largest stress of the table's own base
  std::vector<TaylorTerm> terms_;
  std::vector<haptic::Vec3> moves_m_; ///< [C]
  Feedback feedback_;
};

} // namespace tactus::stress
