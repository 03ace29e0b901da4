#pragma once
#include "fem/statics/statics.hpp"

namespace tactus::fem {

/// Updates K u = f after nodes have moved: only elements whose nodes moved are integrated again, on
/// the same sparsity pattern. The matrix is bit-equal to that of a full assembly.
class MovingSystem {
public:
  MovingSystem(const Mesh&, const StaticModel&, StaticSystem&);

  /// Updates the system to the mesh's nodes. Returns the number of integrated elements.
  std::size_t update(const Mesh&, const StaticModel&, StaticSystem&);

  [[nodiscard]] double bytes() const noexcept;

private:
  std::vector<ElasticLaw> laws_;
  PairPositions positions_;
  std::vector<std::size_t> first_, around_; ///< elements of each node
  std::vector<Vec3> nodes_;                 ///< nodes at the last assembly
  std::vector<double> elements_alone_;      ///< K without springs, if there are springs
  std::vector<std::uint8_t> changed_pair_, element_state_;
};

} // namespace tactus::fem
