#pragma once
#include "fem/assembly/matrices.hpp"
#include "fem/element/matrices.hpp"
#include "fem/error/enrichment.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::fem {

/// Number of modes processed together.
inline constexpr std::size_t kBlockColumns = 8;
using Lanes = std::array<double, kBlockColumns>;

/// The element matrices of the enriching space W beside the mesh's own space V, one after another
/// in single precision (its rounding is far below the error of the estimate): first K_WV, then the
/// lower blocks of K_WW, nine numbers per pair.
class EnrichedSystem {
public:
  EnrichedSystem(const Mesh&, std::span<const Material>, const Matrices&);

  [[nodiscard]] const Enrichment& functions() const noexcept { return functions_; }
  [[nodiscard]] std::size_t unknowns() const noexcept { return 3 * functions_.count; }

  /// y = K_WW x and down = K_VW x.
  void multiply(std::span<const Lanes> x, std::span<Lanes> y, std::span<Lanes> down) const;
  /// y -= K_WV x
  void subtract_coupling(std::span<const Lanes> x, std::span<Lanes> y) const;
  /// y = r: lambda M_WV u - K_WV u
  void residual(std::span<const Material> materials, std::span<const Lanes> u, const Lanes& lambda,
                std::span<Lanes> y) const;
  /// y = D^-1 x
  void precondition(std::span<const Lanes> x, std::span<Lanes> y) const;

private:
  void integrate(std::size_t index, const ElasticLaw& law);
  void invert_diagonal();
  [[nodiscard]] std::size_t unknown(std::size_t element, std::size_t function) const noexcept {
    return 3 * static_cast<std::size_t>(functions_.number[functions_.first[element] + function]);
  }
  [[nodiscard]] double sign(std::size_t element, std::size_t function) const noexcept {
    return functions_.sign[functions_.first[element] + function];
  }

  const Mesh& mesh_;
  std::span<const std::uint8_t> constrained_nodes_;
  Enrichment functions_;
  std::vector<std::size_t> at_;
  std::vector<float> blocks_;
  std::vector<double> diagonal_;
};

} // namespace tactus::fem
