#pragma once
#include "fem/design/sensitivity.hpp"
#include "fem/design/valid_step.hpp"

namespace tactus::fem {

/// Methods that compute the stress of a moved shape.
enum class Method : std::uint8_t {
  taylor,   ///< s0 + S dp, without a solve
  combined, ///< combined approximations (Kirsch 1991), three basis vectors
  pcg,      ///< conjugate gradients, preconditioned with the factor of an earlier shape
  refactor  ///< a new factor on the old symbolic analysis
};
[[nodiscard]] const char* name(Method) noexcept;

/// Seconds of one operation, measured on this machine when the part was loaded. `factor` is the
/// first factorisation with its solution.
struct CostModel {
  double product = 0, solve = 0, assembly = 0, factor = 0;
};

/// Memory in bytes.
struct MemoryUse {
  double factor = 0, matrix = 0, sensitivities = 0, mesh = 0;
  [[nodiscard]] double total() const noexcept { return factor + matrix + sensitivities + mesh; }
};

struct ReanalysisSettings {
  double tolerance = 1e-6;            ///< for PCG: ||f - K u|| / ||f||
  int max_iterations = 60;            ///< above this, PCG refuses and recommends a new factor
  int refactor_iterations = 15;       ///< above this, PCG recommends a new factor
  std::size_t max_past_solutions = 5; ///< PCG starts from their best combination, or from zero if 0
  bool sensitivities = true; ///< S for the Taylor update, one back-substitution per parameter
};

/// The result of one update.
struct StressUpdate {
  Method method = Method::taylor;
  std::vector<double> von_mises, max_shear; ///< at the centroids, [element], Pa
  int iterations = 0;                       ///< iterations of PCG
  double residual = 0;                      ///< ||f - K u|| / ||f||; NaN for Taylor
  double seconds = 0;
  bool refactor_recommended = false; ///< a new factor would save time: start a Refactorisation
};

/// The numeric factorisation of one shape, which the caller may run in a separate thread, since the
/// job owns its data. Call run() once, then Reanalysis::adopt().
class Refactorisation {
public:
  Refactorisation(Refactorisation&&) noexcept;
  ~Refactorisation();
  void run();

private:
  friend class Reanalysis;
  Refactorisation();
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

/// A part whose stress follows its shape: a mesh, a model, shape parameters, and the factor of an
/// earlier shape. Not safe for use by two threads at once; a Refactorisation may run beside it.
///
///   Reanalysis part(mesh, model, velocities);
///   part.move_to(p);                      // nodes move, as far as the mesh stays valid
///   StressUpdate s = part.taylor();       // microseconds
///   s = part.solve();                     // by what the cost model expects to be fastest
///   if (s.refactor_recommended) { auto job = part.refactorisation(); ...job.run() elsewhere...;
///                         part.adopt(std::move(job)); }
///   part.rebase();                        // s0 and S at the present shape
class Reanalysis {
public:
  /// Solves the present shape and measures the cost model. Refuses as solve_static() does.
  Reanalysis(Mesh, StaticModel, std::vector<DesignVelocity>, ReanalysisSettings = {},
             const Progress& = {});
  ~Reanalysis();
  Reanalysis(const Reanalysis&) = delete;
  Reanalysis& operator=(const Reanalysis&) = delete;

  /// Moves the nodes to parameters p (absolute; 0 is the mesh as given). The step is reduced to the
  /// largest fraction at which every element stays valid; parameters() returns the parameters that
  /// were reached. Refuses a wrong count and values that are not finite; the shape then stays as it
  /// was.
  ValidStep move_to(std::span<const double> parameters);
  [[nodiscard]] std::span<const double> parameters() const noexcept;

  /// Stress at parameters() from the last base: s0 + S (p - p_base).
  [[nodiscard]] StressUpdate taylor() const;
  /// At parameters(): assembles the elements that moved since the last assembly and solves.
  StressUpdate solve(Method);
  /// Solves by PCG or a new factor, whichever the cost model expects to be faster.
  StressUpdate solve();

  /// Sets the tolerance of further PCG solutions, ||f - K u|| / ||f||. Callers use a coarser one
  /// while a control point is dragged and a finer one when it is released.
  void set_tolerance(double) noexcept;

  /// A job that factorises the present shape.
  [[nodiscard]] Refactorisation refactorisation();
  /// Installs a factor whose run() has ended as the preconditioner of PCG.
  void adopt(Refactorisation);

  /// Recomputes s0 and S at the current shape, by a new factor.
  void rebase(const Progress& = {});

  [[nodiscard]] const Mesh& mesh() const noexcept;
  [[nodiscard]] const StaticModel& model() const noexcept;
  [[nodiscard]] const StaticSolution& solution() const noexcept; ///< the last solution
  [[nodiscard]] const StressSensitivity& sensitivity() const noexcept;
  [[nodiscard]] std::span<const double> base_von_mises() const noexcept;
  [[nodiscard]] std::span<const double> base_max_shear() const noexcept;
  [[nodiscard]] std::span<const double> base_parameters() const noexcept;
  [[nodiscard]] const CostModel& cost() const noexcept;
  [[nodiscard]] MemoryUse memory() const;
  /// PCG iterations expected at parameters(), from the spread of the preconditioned spectrum in the
  /// last run (Lanczos). The spread grows exponentially with the move from the factor's shape.
  [[nodiscard]] double expected_iterations() const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

} // namespace tactus::fem
