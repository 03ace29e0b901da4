#pragma once
#include "fem/design/sensitivity.hpp"
#include "fem/design/valid_step.hpp"

namespace tactus::fem {

/// Methods that compute the stress of a moved shape.
enum class Method : std::uint8_t {
  taylor,   ///< s0 + S dp: no solve
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
  double tolerance = 1e-6;            ///< of PCG: ||f - K u|| / ||f||
  int max_iterations = 60;            ///< PCG refuses beyond this and recommends a new factor
  int refactor_iterations = 15;       ///< more PCG iterations than this recommend a new factor
  std::size_t max_past_solutions = 5; ///< PCG starts from their best combination; 0: from zero
  bool sensitivities = true; ///< S for the Taylor update: one back-substitution a parameter
};

/// The result of one update.
struct StressUpdate {
  Method method = Method::taylor;
  std::vector<double> von_mises, max_shear; ///< at the centroids, [element], Pa
  int iterations = 0;                       ///< of PCG
  double residual = 0;                      ///< ||f - K u|| / ||f||; NaN for Taylor
  double seconds = 0;
  bool refactor_recommended = false; ///< a new factor would pay: start a Refactorisation
};

/// The numeric factorisation of one shape, which the caller may run on a thread of its own: the job
/// owns its data. run() once, then Reanalysis::adopt().
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
  /// Solves the shape at hand and measures the cost model. Refuses as solve_static() does.
  Reanalysis(Mesh, StaticModel, std::vector<DesignVelocity>, ReanalysisSettings = {},
             const Progress& = {});
  ~Reanalysis();
  Reanalysis(const Reanalysis&) = delete;
  Reanalysis& operator=(const Reanalysis&) = delete;

  /// Moves the nodes to parameters p (absolute, 0: the mesh as given). The step is cut to the
  /// largest fraction on which every element stays valid; the parameters that were reached are
  /// parameters(). Refuses a wrong count and values that are not finite; the shape then stays as it
  /// was.
  ValidStep move_to(std::span<const double> parameters);
  [[nodiscard]] std::span<const double> parameters() const noexcept;

  /// Stress at parameters() from the last base: s0 + S (p - p_base).
  [[nodiscard]] StressUpdate taylor() const;
  /// At parameters(): assembles the elements that moved since the last assembly and solves.
  StressUpdate solve(Method);
  /// Solves by PCG or a new factor, whichever the cost model expects to be faster.
  StressUpdate solve();

  /// Tolerance of further PCG solutions, ||f - K u|| / ||f||. Coarser while a control point is
  /// dragged, finer when it is released.
  void set_tolerance(double) noexcept;

  /// The job of factorising the present shape.
  [[nodiscard]] Refactorisation refactorisation();
  /// Installs a factor whose run() has ended as the preconditioner of PCG.
  void adopt(Refactorisation);

  /// Recomputes s0 and S at the current shape, by a new factor.
  void rebase(const Progress& = {});

  [[nodiscard]] const Mesh& mesh() const noexcept;
  [[nodiscard]] const StaticModel& model() const noexcept;
  [[nodiscard]] const StaticSolution& solution() const noexcept; ///< of the last solve
  [[nodiscard]] const StressSensitivity& sensitivity() const noexcept;
  [[nodiscard]] std::span<const double> base_von_mises() const noexcept;
  [[nodiscard]] std::span<const double> base_max_shear() const noexcept;
  [[nodiscard]] std::span<const double> base_parameters() const noexcept;
  [[nodiscard]] const CostModel& cost() const noexcept;
  [[nodiscard]] MemoryUse memory() const;
  /// PCG iterations expected at parameters(), from the spread of the preconditioned spectrum that
  /// the last run saw (Lanczos), which grows exponentially with the move from the factor's shape.
  [[nodiscard]] double expected_iterations() const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

} // namespace tactus::fem
