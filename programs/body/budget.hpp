#pragma once
#include "fem/modes/cost.hpp"

#include <functional>
#include <string>

namespace tactus::fem {

/// Memory available to this process: the machine's free memory, or less if a control group (version
/// 1 or 2) sets a limit. Bytes; 0 if unknown.
[[nodiscard]] double free_memory();

/// Reads a size such as 4G, 800M, 1.5GiB or 64k, in bytes. Prefixes are powers of 1000, with "i" of
/// 1024. Refuses other texts.
[[nodiscard]] double read_memory(const std::string& option, const std::string& word);

/// The memory that the whole program may use, compared with the predicted need of its work.
class Budget {
public:
  /// `bytes` is the budget; 0 stands for half of the available memory.
  explicit Budget(double bytes);
  [[nodiscard]] double bytes() const noexcept { return bytes_; }

  /// The same work with another element size (m); for gmsh's meshes it is scaled from this work.
  using WithElementSize = std::function<Workload(double h)>;
  /// The work for fewer modes, if their number determines the mesh.
  using WithModes = std::function<Workload(double modes)>;

  /// Refuses work beyond the budget in one sentence. It names the predicted need, the limit, and
  /// the element size, the number of modes or the number of acoustic triangles that fits. `unit`:
  /// metres per unit of the user's --h. A prediction that is not `exact` may exceed the budget by
  /// kCostMargin.
  void check_budget(const std::string& body, const Workload&, const WithElementSize&,
                    const WithModes&, double unit,
                    const std::optional<FactorCost>& exact = {}) const;

private:
  double bytes_;
  bool given_;
};

/// Texts such as "850 MB", "12.3 GB" or "4e+15 GB", and "12 s", "25 min", "3 h" or "40 days".
[[nodiscard]] std::string format_bytes(double bytes);
[[nodiscard]] std::string format_seconds(double seconds);

} // namespace tactus::fem
