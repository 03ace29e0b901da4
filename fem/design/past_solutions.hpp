#pragma once
#include "fem/assembly/matrices.hpp"

namespace tactus::fem {

/// The last few solutions of K(p) u = f(p) at different shapes, and the best start for the next
/// one: the combination that minimises the energy of its error, V (V' K V)^-1 V' f (Fischer,
/// Projection techniques for iterative solution of Ax = b with successive right-hand sides, 1998).
/// Along a drag u is a smooth function of the shape, so with m solutions the error of the start
/// falls as the m-th power of the step.
class PastSolutions {
public:
  explicit PastSolutions(std::size_t max_count) : max_count_(max_count) {}

  /// Adds a solution, with zeros in constrained directions, as the newest. If there are more than
  /// `max_count`, removes the oldest.
  void add(std::span<const double> u);
  /// The start for K x = b. Zero while no solution is stored.
  void start(const Matrices&, std::span<const double> b, std::span<double> x) const;
  [[nodiscard]] double bytes() const noexcept;

private:
  std::size_t max_count_;
  std::vector<std::vector<double>> kept_; ///< the newest first
};

} // namespace tactus::fem
