#include "fem/design/reanalysis.hpp"

#include "fem/design/conjugate_gradients.hpp"
#include "fem/design/moving_system.hpp"
#include "fem/design/past_solutions.hpp"
#include "fem/statics/gradient.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace tactus::fem {
namespace {

class Stopwatch {
public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// The growth used until a run has measured it. A stretch s along one axis and a compression along
/// another change an element's stiffness by up to (1 + s)^4 and (1 - s)^4, so the condition number
/// of the preconditioned matrix is about ((1 + s) / (1 - s))^4, whose logarithm grows by 8 s.
constexpr double kFirstGrowth = 8; // d log(condition) / ds

/// Number of iterations that reduces the error by `tolerance` at a condition number, by the
/// classical bound.
double iterations_for(double condition, double tolerance) {
  if (!(condition > 1 + 1e-12))
    return 1;
  const double root = std::sqrt(condition), rate = (root - 1) / (root + 1);
  return std::max(1.0, std::log(tolerance / 2) / std::log(rate));
}

} // namespace

const char* name(Method method) noexcept {
  static constexpr std::array kNames{"taylor", "combined", "pcg", "refactor"};
  return kNames[static_cast<std::size_t>(method)];
}

struct Refactorisation::Implementation {
  std::unique_ptr<ShiftedFactor> factor;
  std::vector<Vec3> nodes; ///< nodes of the factorised shape
  bool done = false;
};

Refactorisation::Refactorisation() : impl_(std::make_unique<Implementation>()) {}
Refactorisation::Refactorisation(Refactorisation&&) noexcept = default;
Refactorisation::~Refactorisation() = default;

void Refactorisation::run() {
  impl_->factor->factorise();
  impl_->factor->prepare();
  impl_->done = true;
}

struct Reanalysis::Implementation {
  Mesh mesh;
  StaticModel model;
  std::vector<DesignVelocity> velocities;
  ReanalysisSettings settings;
  std::vector<Vec3> original; ///< nodes at parameters 0
  Stopwatch factor_watch;     ///< runs since the first factorisation began
  StaticAnalysis analysis;
  MovingSystem moving;
  PastSolutions past;
  std::vector<double> parameters, base_parameters;
  std::vector<Vec3> factor_nodes; ///< the shape of analysis.factor
  std::vector<double> base_von_mises, base_max_shear;
  StressSensitivity sensitivity;
  CostModel cost;
  double growth = kFirstGrowth; ///< d log(condition) / d(displacement gradient)
  double iteration_ratio = 1;   ///< measured iterations relative to the bound

  Implementation(Mesh given, StaticModel own_model, std::vector<DesignVelocity> own_velocities,
                 const ReanalysisSettings& own_settings)
      : mesh(std::move(given)), model(std::move(own_model)), velocities(std::move(own_velocities)),
        settings(own_settings), original(mesh.nodes),
        analysis(solve_static(mesh, model, [this](const FactorCost&) { factor_watch = {}; })),
        moving(mesh, model, analysis.system), past(settings.max_past_solutions),
        parameters(velocities.size(), 0.0), base_parameters(parameters), factor_nodes(mesh.nodes) {
    cost.factor = factor_watch.seconds();
    past.add(free_displacement());
  }

  /// The last solution with zeros in constrained directions.
  [[nodiscard]] std::vector<double> free_displacement() const {
    std::vector<double> u = analysis.solution.displacement;
    for (std::size_t i = 0; i < u.size(); ++i)
      if (analysis.system.matrices.constrained[i])
        u[i] = 0;
    return u;
  }

  /// Largest displacement gradient at the centroids between the factor's shape and the present one.
  [[nodiscard]] double stretch() const {
    std::vector<double> step(mesh.dofs());
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      for (int i = 0; i < 3; ++i)
        step[3 * n + static_cast<std::size_t>(i)] = mesh.nodes[n][i] - factor_nodes[n][i];
    double largest = 0;
    PointGradients at;
    for (const Element& e : mesh.elements) {
      const auto nodes = mesh.nodes_of(e);
      gradients(mesh, e, at_centroid(e.shape), at);
      const Tensor l = field_gradient(at, gather(step, nodes), nodes.size());
      largest = std::max(largest, std::sqrt(contraction(l, l)));
    }
    return largest;
  }

  void fill_stress(StressUpdate& update) const {
    const auto stress = element_stress(mesh, model.materials, analysis.solution.displacement);
    update.von_mises = equivalent_stress(stress, StressMeasure::von_mises);
    update.max_shear = equivalent_stress(stress, StressMeasure::max_shear);
  }

  void measure_cost() {
    const Matrices& m = analysis.system.matrices;
    std::vector<double> x = analysis.solution.displacement, y(x.size());
    const auto best_of = [](int times, auto&& work) {
      double best = std::numeric_limits<double>::infinity();
      for (int i = 0; i < times; ++i) {
        const Stopwatch watch;
        work();
        best = std::min(best, watch.seconds());
      }
      return best;
    };
    cost.product = best_of(3, [&] { m.multiply_stiffness(x, y, 1); });
    cost.solve = best_of(3, [&] { analysis.factor->precondition(y, x); });
    Matrices copy = m;
    cost.assembly = best_of(1, [&] { assemble_stiffness(mesh, model.materials, -1, copy); });
  }

  void take_factor(std::unique_ptr<ShiftedFactor> factor, std::vector<Vec3> nodes) {
    analysis.factor = std::move(factor);
    factor_nodes = std::move(nodes);
  }

  void solve_directly() {
    auto factor = std::make_unique<ShiftedFactor>(*analysis.factor, analysis.system.matrices, 0);
    factor->factorise();
    take_factor(std::move(factor), mesh.nodes);
    std::vector<double> u = analysis.system.right_side();
    analysis.factor->solve(u, u, 1);
    accept(std::move(u));
  }

  void accept(std::vector<double> u) {
    past.add(u);
    analysis.solution = completed(analysis.system, std::move(u));
  }

  [[nodiscard]] double expected_iterations() const {
    const double bound = iterations_for(std::exp(growth * stretch()), settings.tolerance);
    return std::max(1.0, iteration_ratio * bound);
  }

  void learn(const CgReport& report) {
    const double s = stretch();
    if (report.iterations < 2 || !(s > 1e-6) || !(report.condition > 1))
      return;
    growth = std::log(report.condition) / s;
    iteration_ratio = report.iterations / iterations_for(report.condition, settings.tolerance);
  }
};

Reanalysis::Reanalysis(Mesh mesh, StaticModel model, std::vector<DesignVelocity> velocities,
                       ReanalysisSettings settings, const Progress& progress)
    : impl_(std::make_unique<Implementation>(std::move(mesh), std::move(model),
                                             std::move(velocities), settings)) {
  impl_->measure_cost();
  StressUpdate base;
  impl_->fill_stress(base);
  impl_->base_von_mises = std::move(base.von_mises);
  impl_->base_max_shear = std::move(base.max_shear);
  if (settings.sensitivities)
    impl_->sensitivity =
        stress_sensitivity(impl_->mesh, impl_->model, impl_->analysis, impl_->velocities, progress);
}

Reanalysis::~Reanalysis() = default;

ValidStep Reanalysis::move_to(std::span<const double> parameters) {
  const auto target = moved_nodes(impl_->original, impl_->velocities, parameters);
  const ValidStep step = valid_step(impl_->mesh, target);
  if (step.fraction == 1) {
    impl_->parameters.assign(parameters.begin(), parameters.end());
    impl_->mesh.nodes = target;
    return step;
  }
  for (std::size_t k = 0; k < parameters.size(); ++k)
    impl_->parameters[k] += step.fraction * (parameters[k] - impl_->parameters[k]);
  impl_->mesh.nodes = moved_nodes(impl_->original, impl_->velocities, impl_->parameters);
  return step;
}

StressUpdate Reanalysis::taylor() const {
  const Stopwatch watch;
  StressUpdate update;
  update.residual = std::numeric_limits<double>::quiet_NaN();
  update.von_mises = impl_->base_von_mises;
  update.max_shear = impl_->base_max_shear;
  const std::size_t elements = update.von_mises.size();
  if (impl_->sensitivity.von_mises.size() != impl_->velocities.size() * elements)
    throw InputError("the Taylor update needs sensitivities, which were not requested");
  for (std::size_t k = 0; k < impl_->parameters.size(); ++k) {
    const double step = impl_->parameters[k] - impl_->base_parameters[k];
    if (step == 0)
      continue;
    const float* mises = &impl_->sensitivity.von_mises[k * elements];
    const float* shear = &impl_->sensitivity.max_shear[k * elements];
    for (std::size_t e = 0; e < elements; ++e) {
      update.von_mises[e] += step * static_cast<double>(mises[e]);
      update.max_shear[e] += step * static_cast<double>(shear[e]);
    }
  }
  update.seconds = watch.seconds();
  return update;
}

StressUpdate Reanalysis::solve(Method method) {
  if (method == Method::taylor)
    return taylor();
  const Stopwatch watch;
  StressUpdate update;
  update.method = method;
  auto& analysis = impl_->analysis;
  impl_->moving.update(impl_->mesh, impl_->model, analysis.system);
  if (method != Method::refactor) {
    const std::vector<double> right = analysis.system.right_side();
    std::vector<double> u(right.size());
    if (method == Method::combined) {
      update.residual =
          combined_approximations(analysis.system.matrices, *analysis.factor, right, u);
    } else {
      impl_->past.start(analysis.system.matrices, right, u);
      const CgReport report =
          conjugate_gradients(analysis.system.matrices, *analysis.factor, right, u,
                              impl_->settings.tolerance, impl_->settings.max_iterations);
      impl_->learn(report);
      update.iterations = report.iterations;
      update.residual = report.residual;
      update.refactor_recommended =
          report.iterations > impl_->settings.refactor_iterations ||
          report.iterations * (impl_->cost.product + impl_->cost.solve) > impl_->cost.factor;
      if (!report.converged)
        update.method = Method::refactor;
    }
    if (update.method != Method::refactor)
      impl_->accept(std::move(u));
  }
  if (update.method == Method::refactor) {
    impl_->solve_directly();
    update.residual = 0;
    update.refactor_recommended = false;
  }
  impl_->fill_stress(update);
  update.seconds = watch.seconds();
  return update;
}

StressUpdate Reanalysis::solve() {
  const CostModel& cost = impl_->cost;
  const double iterative = (impl_->expected_iterations() + 1) * (cost.product + cost.solve);
  return solve(iterative < cost.factor + cost.solve ? Method::pcg : Method::refactor);
}

void Reanalysis::set_tolerance(double tolerance) noexcept { impl_->settings.tolerance = tolerance; }

Refactorisation Reanalysis::refactorisation() {
  impl_->moving.update(impl_->mesh, impl_->model, impl_->analysis.system);
  Refactorisation job;
  job.impl_->factor =
      std::make_unique<ShiftedFactor>(*impl_->analysis.factor, impl_->analysis.system.matrices, 0);
  job.impl_->nodes = impl_->mesh.nodes;
  return job;
}

void Reanalysis::adopt(Refactorisation job) {
  if (!job.impl_ || !job.impl_->done || job.impl_->nodes.size() != impl_->mesh.nodes.size())
    throw InputError("the factorisation is not finished or belongs to another part");
  impl_->take_factor(std::move(job.impl_->factor), std::move(job.impl_->nodes));
}

void Reanalysis::rebase(const Progress& progress) {
  StressUpdate update = solve(Method::refactor);
  impl_->base_von_mises = std::move(update.von_mises);
  impl_->base_max_shear = std::move(update.max_shear);
  impl_->base_parameters = impl_->parameters;
  if (impl_->settings.sensitivities)
    impl_->sensitivity =
        stress_sensitivity(impl_->mesh, impl_->model, impl_->analysis, impl_->velocities, progress);
}

std::span<const double> Reanalysis::parameters() const noexcept { return impl_->parameters; }
const Mesh& Reanalysis::mesh() const noexcept { return impl_->mesh; }
const StaticModel& Reanalysis::model() const noexcept { return impl_->model; }
const StaticSolution& Reanalysis::solution() const noexcept { return impl_->analysis.solution; }
const StressSensitivity& Reanalysis::sensitivity() const noexcept { return impl_->sensitivity; }
std::span<const double> Reanalysis::base_von_mises() const noexcept {
  return impl_->base_von_mises;
}
std::span<const double> Reanalysis::base_max_shear() const noexcept {
  return impl_->base_max_shear;
}
std::span<const double> Reanalysis::base_parameters() const noexcept {
  return impl_->base_parameters;
}
const CostModel& Reanalysis::cost() const noexcept { return impl_->cost; }
double Reanalysis::expected_iterations() const { return impl_->expected_iterations(); }

MemoryUse Reanalysis::memory() const {
  const StaticSystem& system = impl_->analysis.system;
  const NodeGraph& graph = system.matrices.graph;
  MemoryUse use;
  use.factor = impl_->analysis.factor->memory_bytes();
  use.matrix = static_cast<double>(8 * system.matrices.stiffness.size() + 8 * graph.row.size() +
                                   8 * graph.start.size()) +
               impl_->moving.bytes() + impl_->past.bytes();
  use.sensitivities = 4. * static_cast<double>(impl_->sensitivity.von_mises.size() +
                                               impl_->sensitivity.max_shear.size());
  use.mesh = static_cast<double>(2 * sizeof(Vec3) * impl_->mesh.nodes.size() +
                                 4 * impl_->mesh.connectivity.size() +
                                 sizeof(Element) * impl_->mesh.elements.size());
  for (const DesignVelocity& v : impl_->velocities)
    use.mesh += static_cast<double>((4 + sizeof(Vec3)) * v.node.size());
  return use;
}

} // namespace tactus::fem
