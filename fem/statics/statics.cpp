#include "fem/statics/statics.hpp"

#include <algorithm>

namespace tactus::fem {

StaticSystem::StaticSystem(const Mesh& mesh, const StaticModel& model)
    : matrices(mesh), prescribed(mesh.dofs(), 0.0) {
  if (mesh.elements.empty())
    throw InputError("the mesh has no volume element, expected at least one");
  check_supported(mesh, model.fixed, model.springs);
  load = load_vector(mesh, model.materials, model.loads);
  assemble_stiffness(mesh, model.materials, -1, matrices);
  add_springs(mesh, model.springs, matrices);
  for (const FixedPatch& patch : model.fixed)
    for (const int node : patch.nodes)
      for (std::size_t i = 0; i < 3; ++i)
        if (patch.directions[i]) {
          const std::size_t dof = 3 * static_cast<std::size_t>(node) + i;
          const double given = patch.displacement_m[static_cast<int>(i)];
          if (matrices.constrained[dof] && prescribed[dof] != given)
            throw InputError("support " + patch.name + " moves node " + std::to_string(node + 1) +
                             " along " + "xyz"[i] +
                             " by another displacement than an earlier support");
          matrices.constrained[dof] = 1;
          prescribed[dof] = given;
        }
}

std::vector<double> StaticSystem::right_side() const {
  std::vector<double> right(load.size(), 0.0);
  if (std::any_of(prescribed.begin(), prescribed.end(), [](double x) { return x != 0; }))
    matrices.multiply_whole_stiffness(prescribed, right);
  for (std::size_t i = 0; i < right.size(); ++i)
    right[i] = matrices.constrained[i] ? 0 : load[i] - right[i];
  return right;
}

StaticSolution completed(const StaticSystem& system, std::vector<double> free_displacement) {
  StaticSolution solution;
  solution.displacement = std::move(free_displacement);
  auto& u = solution.displacement;
  const std::size_t n = u.size();
  for (std::size_t i = 0; i < n; ++i)
    if (system.matrices.constrained[i])
      u[i] = system.prescribed[i];
  solution.reaction.resize(n);
  system.matrices.multiply_whole_stiffness(u, solution.reaction);
  for (std::size_t i = 0; i < n; ++i) {
    solution.strain_energy += .5 * u[i] * solution.reaction[i];
    solution.reaction[i] =
        system.matrices.constrained[i] ? solution.reaction[i] - system.load[i] : 0;
  }
  return solution;
}

Vec3 sum_of_forces(std::span<const double> nodal) {
  Vec3 sum;
  for (std::size_t i = 0; i + 2 < nodal.size(); i += 3)
    sum += Vec3{nodal[i], nodal[i + 1], nodal[i + 2]};
  return sum;
}

Vec3 support_force(const Mesh& mesh, const StaticModel& model, const StaticSolution& solution) {
  return sum_of_forces(solution.reaction) -
         sum_of_forces(spring_forces(mesh, model.springs, solution.displacement));
}

StaticAnalysis solve_static(const Mesh& mesh, const StaticModel& model,
                            const std::function<void(const FactorCost&)>& predict) {
  StaticAnalysis analysis{StaticSystem(mesh, model), nullptr, {}};
  analysis.factor = std::make_unique<ShiftedFactor>(analysis.system.matrices, 0);
  if (predict)
    predict(analysis.factor->cost());
  analysis.factor->factorise();
  std::vector<double> u = analysis.system.right_side();
  analysis.factor->solve(u, u, 1);
  analysis.solution = completed(analysis.system, std::move(u));
  return analysis;
}

} // namespace tactus::fem
