// part_stress: from a loaded part to its stress, and how the stress follows the part's shape.
//
//   K u = f      sigma = C B u      d sigma / dp by the direct method
//
//   1. mesh      a swept shape, the lift arm, a file, or gmsh's curved tetrahedra of a CAD model
//   2. model     supports, loads, a lattice of control points around the part
//   3. solve     one factor for the displacement and for every parameter's derivative, or PETSc on
//                several processes for the displacement
//   4. move      control points, if requested: Taylor's series beside a new solution
//   5. write     NAME.stress.npz, VTU, CalculiX, a picture sheet
#include "fem/io/exchange.hpp"
#include "fem/io/text.hpp"
#include "fem/io/vtu.hpp"
#include "fem/modes/body.hpp"
#include "fem/statics/recovery.hpp"
#include "programs/body/body_program.hpp"
#include "programs/body/budget.hpp"
#include "programs/body/output_files.hpp"
#include "programs/part_stress/petsc_engine.hpp"
#include "programs/part_stress/picture.hpp"
#include "programs/part_stress/serve.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>

namespace {

using namespace tactus::fem;
using tactus::Vec3;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

std::size_t index_of_largest(std::span<const double> values) {
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

double volume_mean(std::span<const double> values, std::span<const double> volumes) {
  return std::inner_product(values.begin(), values.end(), volumes.begin(), 0.) /
         std::accumulate(volumes.begin(), volumes.end(), 0.);
}

/// Displacement over the part's length above which a warning says that linear elasticity is not
/// valid.
constexpr double kSmallDisplacement = 0.1;

void print_state(const char* when, const PictureState& s, std::span<const double> volumes) {
  const std::size_t at = s.peak, in = index_of_largest(s.at_elements);
  std::printf("%-7s von Mises: largest %.4g +- %.2g MPa (at nodes) at (%.4g, %.4g, %.4g) mm, "
              "%.4g +- %.2g MPa (at element centroids); mean %.4g +- %.2g MPa, by volume %.4g +- "
              "%.2g MPa\n"
              "        largest displacement %.5g mm; volume %.6g cm^3\n",
              when, 1e-6 * s.von_mises[at], 1e-6 * s.error[at], 1e3 * s.nodes[at].x,
              1e3 * s.nodes[at].y, 1e3 * s.nodes[at].z, 1e-6 * s.at_elements[in],
              1e-6 * std::abs(s.missing_at_elements[in]), 1e-6 * mean(s.at_elements),
              1e-6 * std::abs(mean(s.missing_at_elements)),
              1e-6 * volume_mean(s.at_elements, volumes),
              1e-6 * std::abs(volume_mean(s.missing_at_elements, volumes)),
              1e3 * s.max_displacement, 1e6 * s.volume);
  if (s.peak_away) {
    const std::size_t away = *s.peak_away;
    std::printf("        the largest is at a singularity (a concave edge, the border of a "
                "support, or a point force), where it grows with each refinement; elsewhere "
                "the largest is %.4g +- %.2g MPa at (%.4g, %.4g, %.4g) mm\n",
                1e-6 * s.von_mises[away], 1e-6 * s.error[away], 1e3 * s.nodes[away].x,
                1e3 * s.nodes[away].y, 1e3 * s.nodes[away].z);
  }
  const double share = s.max_displacement / bounding_box(s.nodes).largest();
  if (share > kSmallDisplacement)
    std::printf(
        "        the largest displacement is %.3g %% of the part's length: the linear equations "
        "are valid up to %g %%\n",
        100 * share, 100 * kSmallDisplacement);
}

/// RMS and largest difference, relative to the largest value.
std::array<double, 2> difference(std::span<const double> a, std::span<const double> b) {
  double sum = 0, max_difference = 0, scale = 0, squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i] - b[i]) * (a[i] - b[i]);
    squares += b[i] * b[i];
    max_difference = std::max(max_difference, std::abs(a[i] - b[i]));
    scale = std::max(scale, std::abs(b[i]));
  }
  return {std::sqrt(sum / squares), max_difference / scale};
}

void write_fields(const std::string& path, const Mesh& mesh, const StaticModel& model,
                  const StaticSolution& solution) {
  const auto nodal = recovered_stress(mesh, model.materials, solution.displacement).at_nodes;
  const auto elemental = element_stress(mesh, model.materials, solution.displacement);
  const auto fields = [](std::span<const Stress> stresses) {
    std::array<std::vector<double>, 3> out;
    for (const Stress& s : stresses) {
      out[0].push_back(von_mises(s));
      out[1].push_back(max_shear(s));
      const auto p = principal(s);
      out[2].insert(out[2].end(), p.begin(), p.end());
    }
    return out;
  };
  const auto at_nodes = fields(nodal), at_elements = fields(elemental);
  const std::vector<VtuField> node_fields{{"displacement m", 3, solution.displacement},
                                          {"von Mises Pa", 1, at_nodes[0]},
                                          {"max shear Pa", 1, at_nodes[1]},
                                          {"principal stresses Pa", 3, at_nodes[2]}},
      element_fields{{"von Mises Pa", 1, at_elements[0]},
                     {"max shear Pa", 1, at_elements[1]},
                     {"principal stresses Pa", 3, at_elements[2]}};
  write_vtu(path, mesh, node_fields, element_fields);
}

StressMetadata metadata_of(const PartOptions& options, const std::vector<std::string>& words,
                           const Reanalysis& part, const PictureState& state) {
  StressMetadata metadata{.body_name = options.name(),
                          .created = date_of_now(),
                          .supports = {},
                          .loads = {},
                          .mass = mass_properties(part.mesh(), part.model().materials).mass,
                          .volume = state.volume,
                          .max_displacement = state.max_displacement,
                          .product_s = part.cost().product,
                          .solve_s = part.cost().solve,
                          .factor_s = part.cost().assembly + part.cost().factor,
                          .command = words};
  for (const SupportOptions& s : options.supports)
    metadata.supports.push_back(s.words);
  for (const LoadOptions& l : options.loads)
    metadata.loads.push_back(l.words);
  if (!(options.gravity == Vec3{}))
    metadata.loads.push_back(
        format("gravity %g,%g,%g", options.gravity.x, options.gravity.y, options.gravity.z));
  return metadata;
}

/// The problem to solve: a part, its model, and its change of shape.
struct Problem {
  const PartOptions& options;
  const std::vector<std::string>& words;
  const Mesh& mesh;
  const StaticModel& model;
  const DesignSpace& space;
  std::vector<double> requested; ///< parameters of the moved shape
};

/// The results at the last shape.
struct Outcome {
  std::vector<PictureState> states;
  Mesh mesh;
  StaticSolution solution;
  std::vector<double> parameters;
  std::vector<double> taylor; ///< stress at the centroids of the moved shape, or empty
  std::string memory;
};

void print_part(const Problem& problem, const StaticSolution& solution) {
  const DesignSpace& space = problem.space;
  const Vec3 reaction = support_force(problem.mesh, problem.model, solution);
  std::printf("mass %.6g kg of %s; %zu movable control points of %zu, %zu parameters; support "
              "reaction (%.5g, %.5g, %.5g) N\n",
              mass_properties(problem.mesh, problem.model.materials).mass,
              names_of_materials(problem.model.materials).c_str(), space.controls.size(),
              space.weights.control_points.size(), space.parameters.size(), reaction.x, reaction.y,
              reaction.z);
}

void print_cut(const ValidStep& step) {
  if (step.fraction < 1)
    std::printf("the move stops at %.1f %%: beyond it element %zu would be too distorted\n",
                100 * step.fraction, step.element + 1);
}

/// Solves with a factor in this process, which also gives the derivatives.
Outcome solve_in_process(const Problem& problem, ProgressLine& progress) {
  const auto& [options, words, mesh, model, space, requested] = problem;
  const bool derivatives = !options.output.empty() || !options.moves.empty();
  progress.stage("solving", 0);
  Reanalysis part(mesh, model, space.velocities, {.tolerance = 1e-8, .sensitivities = derivatives},
                  [&](double share) { progress.stage("solving", share); });
  const auto volumes = element_volumes(mesh);
  Outcome out;
  out.states.push_back(picture_of(mesh, model, part.solution(),
                                  {part.base_von_mises().begin(), part.base_von_mises().end()}));
  print_part(problem, part.solution());
  print_state("before", out.states[0], volumes);
  if (!options.output.empty()) {
    progress.stage("writing " + options.output, 0);
    write_stress_table(options.output,
                       {mesh, model.materials, part.base_von_mises(), part.base_max_shear(),
                        part.sensitivity(), volumes, space.parameters, space.weights,
                        space.lattice.points, space.trust, options.skin_edge,
                        metadata_of(options, words, part, out.states[0])});
  }
  if (!options.moves.empty()) {
    progress.stage("moving control points", 0);
    print_cut(part.move_to(requested));
    out.taylor = part.taylor().von_mises;
    const StressUpdate solved = part.solve();
    out.states.push_back(picture_of(part.mesh(), model, part.solution(), solved.von_mises));
    print_state("after", out.states[1], element_volumes(part.mesh()));
    const auto error = difference(out.taylor, solved.von_mises);
    std::printf("        the Taylor series differs by %.3g %% (root mean square), %.3g %% of the "
                "largest; solved again by %s in %.3g s, %d iterations\n",
                100 * error[0], 100 * error[1], name(solved.method), solved.seconds,
                solved.iterations);
  }
  out.mesh = part.mesh();
  out.solution = part.solution();
  out.parameters.assign(part.parameters().begin(), part.parameters().end());
  out.memory = format_bytes(part.memory().total());
  return out;
}

/// Solves on several processes. Each solution starts from the displacement of the previous shape.
Outcome solve_on_processes(const Problem& problem, ProgressLine& progress) {
  const PartOptions& options = problem.options;
  const Mesh& mesh = problem.mesh;
  const StaticModel& model = problem.model;
  Outcome out{.states = {},
              .mesh = mesh,
              .solution = {},
              .parameters = problem.requested,
              .taylor = {},
              .memory = {}};
  const auto solve = [&](const char* when) {
    const StaticSystem system(out.mesh, model);
    out.solution =
        petsc_solution(out.mesh, system, out.solution.displacement, options.ranks, progress);
    if (out.states.empty())
      print_part(problem, out.solution);
    out.states.push_back(picture_of(
        out.mesh, model, out.solution,
        equivalent_stress(element_stress(out.mesh, model.materials, out.solution.displacement),
                          StressMeasure::von_mises)));
    print_state(when, out.states.back(), element_volumes(out.mesh));
    out.memory = format("mpirun -n %d", options.ranks);
  };
  solve("before");
  if (!options.moves.empty()) {
    const ValidStep step =
        valid_step(mesh, moved_nodes(mesh.nodes, problem.space.velocities, out.parameters));
    print_cut(step);
    for (double& p : out.parameters)
      p *= step.fraction;
    out.mesh.nodes = moved_nodes(mesh.nodes, problem.space.velocities, out.parameters);
    solve("after");
  }
  return out;
}

int run(const std::vector<std::string>& words) {
  const PartOptions options = read_options(words);
  if (options.petsc)
    check_petsc();
  check_outputs(options.outputs(), options);
  if (!options.sheet.empty())
    check_sheet("stress_sheet.py");
  const Clock::time_point start_time = Clock::now();
  ProgressLine progress(options.quiet);
  warn_of_unusual_constants(options, progress);
  if (!options.step.empty()) {
    write_step(options.step, options.lift_arm());
    if (options.outputs().size() == 1)
      return 0;
  }
  set_solver_threads(options.threads);
  const Mesh mesh = mesh_of(options, progress);
  if (options.list_faces)
    return 0;
  const StaticModel model = model_of(options, mesh);
  if (!options.inp.empty()) {
    progress.stage("writing " + options.inp, 0);
    write_static_inp(options.inp, mesh, model);
  }
  progress.stage("embedding the control lattice", 0);
  const DesignSpace space = design_space_of(options.design, mesh);
  const Problem problem{options, words, mesh, model, space, parameters_of(options.moves, space)};
  const Outcome out =
      options.petsc ? solve_on_processes(problem, progress) : solve_in_process(problem, progress);
  const double seconds = seconds_since(start_time);
  std::printf("        %zu elements (%s), %zu unknowns, %s, %.3g s\n", mesh.elements.size(),
              mesh.element_names().c_str(), mesh.dofs(), out.memory.c_str(), seconds);
  std::fflush(stdout);
  if (!options.vtu.empty()) {
    progress.stage("writing " + options.vtu, 0);
    write_fields(options.vtu, out.mesh, model, out.solution);
  }
  if (!options.sheet.empty()) {
    progress.stage("writing " + options.sheet, 0);
    PictureLabels labels{.title = options.name(),
                         .subtitle = {},
                         .parameters = out.parameters,
                         .taylor = out.taylor};
    const double mass = mass_properties(mesh, model.materials).mass;
    labels.subtitle =
        model.materials[0].name + format(", %.4g kg; %zu %s, %zu unknowns; %s, %.2g s", mass,
                                         mesh.elements.size(), mesh.element_names().c_str(),
                                         mesh.dofs(), out.memory.c_str(), seconds);
    draw_part(options.sheet, model, space, mesh, out.states, labels);
  }
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  constexpr Command kCommands[] = {{"serve", serve}};
  return body_program(argc, argv, "part_stress", usage, kCommands, run);
}
