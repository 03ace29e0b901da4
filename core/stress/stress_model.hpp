#pragma once

#include "core/stress/feedback.hpp"
#include "core/stress/stress_table.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace tactus::stress {

/// Feedback of one shape of the part. The three components differ only in the axis mapping.
struct Feedback {
  Vec3 raw, min, max;     ///< g and its range: Pa, or Pa^2/m in the weighted and axis mappings
  Vec3 gamma;             ///< 0..1
  double mean_pa = 0;     ///< weighted mean of the stress, in every mapping
  double peak_pa = 0;     ///< largest stress of an element
  double trust_ratio = 0; ///< largest displacement of a control point from the base / trust size
  friend bool operator==(const Feedback&, const Feedback&) = default;
};

/// First-order Taylor series of the stress about the last solution (the base), and its feedback:
///     s = s0 + S (p - p0).
/// p: displacements of the parameters from the table's shape, m; p0: those of the base; S:
/// sensitivities, Pa/m. The error grows as |p - p0|^2. Far outside the trust size the von Mises
/// stress of the series can become negative.
class StressModel {
public:
  explicit StressModel(std::shared_ptr<const StressTable> table);

  [[nodiscard]] const StressTable& table() const noexcept { return *table_; }
  [[nodiscard]] const StressBase& base() const noexcept { return base_ ? *base_ : table_->base; }
  /// Sets the mapping, and the control point whose sensitivities it uses; none: the mean over all
  /// control points that have parameters. A table without shear stress or volumes falls back to von
  /// Mises stress and uniform weights. Allocates.
  void select(const FeedbackSettings& settings, std::optional<std::size_t> control_point);
  /// Sets a new base that check_base() accepts; null: the base of the table. Allocates.
  void rebase(std::shared_ptr<const StressBase> base);
  /// Feedback at displacement_m, [P]; NaN and infinities count as 0. Does not allocate.
  [[nodiscard]] const Feedback& update(std::span<const double> displacement_m) noexcept;
  /// Stress at some elements, Pa; `stress_pa` has the size of `elements`. Does not allocate.
  void stress_of(std::span<const std::size_t> elements, std::span<const double> displacement_m,
                 std::span<double> stress_pa) const noexcept;
  /// Largest length of a control point's displacement between two shapes, m.
  [[nodiscard]] double distance_m(std::span<const double> a, std::span<const double> b) noexcept;

private:
  /// h of the three axes: rows of a base, or means over the control points.
  struct Weighting {
    std::array<const float*, 3> h{};
    std::array<std::vector<float>, 3> mean;
  };
  [[nodiscard]] const StressField& field(const StressBase& base) const noexcept;
  void compute_weighting(const StressField& field, Weighting& weighting) const;
  [[nodiscard]] FeedbackTask task(const StressField& field,
                                  const Weighting& weighting) const noexcept;
  void prepare();
  [[nodiscard]] double share() const noexcept; ///< factor from a sum to the result

  std::shared_ptr<const StressTable> table_;
  std::shared_ptr<const StressBase> base_;
  FeedbackSettings settings_;
  std::optional<std::size_t> control_point_;
  Weighting weighting_;
  FeedbackSums initial_{}; ///< sums of the table's own base
  double weight_sum_ = 0;
  double scale_pa_ = 1; ///< divisor in the sum of powers: largest stress of the table's own base
  std::vector<TaylorTerm> terms_;
  std::vector<Vec3> moves_m_; ///< [C]
  Feedback feedback_;
};

} // namespace tactus::stress
