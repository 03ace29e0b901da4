// The stress of a reshaped cantilever: Taylor, gradients on the old factor and a new factor, beside
// analyse + factor + solve from nothing, in one run. CPU seconds of one thread.
//
//   bench_stress_reanalysis [elements across the beam, 4: 20k unknowns, 9: 200k]

#include "fem/design/reanalysis.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

using namespace tactus::fem;

namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The least CPU time of some runs.
template <class Work> double timed(int runs, Work&& work) {
  double best = 1e9;
  for (int i = 0; i < runs; ++i) {
    const double start = cpu_seconds();
    work();
    best = std::min(best, cpu_seconds() - start);
  }
  return best;
}

constexpr double kLength = .2, kHeight = .02;

/// 200 x 20 x 20 mm in cells of six tet10.
Mesh beam(int across) {
  static constexpr std::array<std::array<int, 4>, 6> kCells{
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
  static constexpr std::array<std::array<std::size_t, 2>, 6> kEdges{
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  // Corners and middles of edges all lie on a grid twice as fine.
  const int nx = 20 * across + 1, ny = 2 * across + 1;
  Mesh mesh;
  for (int k = 0; k < ny; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        mesh.nodes.push_back(
            {kLength * i / (nx - 1), kHeight * j / (ny - 1), kHeight * k / (ny - 1)});
  for (int k = 0; k < across; ++k)
    for (int j = 0; j < across; ++j)
      for (int i = 0; i < 10 * across; ++i)
        for (const auto& cell : kCells) {
          std::vector<std::array<int, 3>> at;
          for (const int c : cell)
            at.push_back({2 * (i + c % 2), 2 * (j + c / 2 % 2), 2 * (k + c / 4)});
          for (const auto& [a, b] : kEdges)
            at.push_back(
                {(at[a][0] + at[b][0]) / 2, (at[a][1] + at[b][1]) / 2, (at[a][2] + at[b][2]) / 2});
          std::vector<int> nodes;
          for (const auto& [x, y, z] : at)
            nodes.push_back(x + nx * (y + ny * z));
          mesh.add(Shape::tet10, nodes);
        }
  drop_unused_nodes(mesh);
  return mesh;
}

double relative(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(difference / size);
}

} // namespace

// One piece: the measurements in the order of the printed table, each on the state that the one
// before left.
int main(int count, char** arguments) {
  const int across = count > 1 ? std::atoi(arguments[1]) : 4;
  if (across < 1 || across > 20) {
    std::fprintf(stderr, "%s: expected 1 to 20 elements across the beam, got %s\n", arguments[0],
                 arguments[1]);
    return 2;
  }
  set_solver_threads(1);
  const Mesh mesh = beam(across);
  StaticModel model;
  Material steel;
  steel.density = 7850;
  steel.young_pa = {2.1e11, 0, 0};
  steel.poisson = {.3, 0, 0};
  model.materials = {steel};
  model.fixed = {{"wall", select_nodes(mesh, {OnPlane{{}, {1, 0, 0}}, 0}), {true, true, true}, {}}};
  model.loads = {TotalForce{
      "tip", select_faces(mesh, {OnPlane{{kLength, 0, 0}, {1, 0, 0}}, 0}), {0, 0, -100}}};
  const Lattice lattice{{{0, 0, 0}, {kLength, kHeight, kHeight}}, {3, 3, 3}, {2, 2, 2}};
  std::vector<int> controls;
  for (int c = 0; c < lattice.control_count(); ++c)
    controls.push_back(c);
  const auto velocities = design_velocities(embed(mesh, lattice), free_parameters(controls));
  const auto row = [&](double move) {
    std::vector<double> p(velocities.size(), 0.0);
    for (int j = 0; j < 3; ++j)
      p[3 * static_cast<std::size_t>(lattice.control(1, j, 2)) + 2] = move;
    return p;
  };
  const int runs = across > 5 ? 1 : 3;

  double sensitivities = 0, adjoint = 0;
  {
    StaticAnalysis base = solve_static(mesh, model);
    sensitivities = timed(1, [&] { (void)stress_sensitivity(mesh, model, base, velocities); });
    adjoint = timed(runs, [&] { (void)stress_scalar(mesh, model, base, {}, velocities); });
  }

  ReanalysisSettings settings;
  Reanalysis part(mesh, model, velocities, settings);
  const MemoryUse memory = part.memory();
  std::printf("%zu unknowns, %zu tet10, %zu control points, %zu parameters\n", mesh.dofs(),
              mesh.elements.size(), controls.size(), velocities.size());
  std::printf("memory: factor %.0f MB, matrix %.0f MB, sensitivities %.0f MB, mesh %.0f MB, "
              "together %.0f MB\n",
              memory.factor / 1e6, memory.matrix / 1e6, memory.sensitivities / 1e6,
              memory.mesh / 1e6, memory.total() / 1e6);
  const CostModel& cost = part.cost();
  std::printf("cost model (wall clock): product %.2f ms, solve %.2f ms, assembly %.1f ms, factor "
              "%.0f ms\n",
              1e3 * cost.product, 1e3 * cost.solve, 1e3 * cost.assembly, 1e3 * cost.factor);
  std::printf("sensitivities of all parameters: %.2f s CPU; gradient of a mean by the adjoint "
              "method %.3f s CPU\n\n",
              sensitivities, adjoint);
  std::fflush(stdout);

  settings.sensitivities = false;
  settings.max_past_solutions = 1; // a jump from the factor's shape, whatever was solved before
  auto jumping = std::make_unique<Reanalysis>(mesh, model, velocities, settings);
  Reanalysis& own = *jumping;
  const std::array tolerances{1e-3, 1e-6, 1e-8};
  std::printf("CPU milliseconds from moved control points to new stress of all elements (steps), "
              "error of von Mises in L2\n");
  std::printf("%6s | %-16s | %-22s | %-22s | %-22s | %8s | %8s | %6s\n", "move/H", "Taylor",
              "PCG 1e-3", "PCG 1e-6", "PCG 1e-8", "refactor", "full", "chosen");
  for (const double move : {-.05, -.1, -.2, -.4, .2}) {
    const auto to = row(move * kHeight), back = row(0);
    const Mesh moved = [&] {
      Mesh shape = mesh;
      shape.nodes = moved_nodes(mesh.nodes, velocities, to);
      return shape;
    }();
    std::vector<double> reference;
    const double full = timed(runs, [&] {
      const StaticAnalysis fresh = solve_static(moved, model);
      reference =
          equivalent_stress(element_stress(moved, model.materials, fresh.solution.displacement),
                            StressMeasure::von_mises);
    });
    part.move_to(to);
    StressUpdate taylor;
    const double taylor_time = timed(5, [&] { taylor = part.taylor(); });
    std::printf("%5.0f%% | %6.3f ms %.1e", 100 * move, 1e3 * taylor_time,
                relative(taylor.von_mises, reference));
    own.move_to(back);
    Refactorisation job = own.refactorisation();
    job.run();
    own.adopt(std::move(job));
    for (const double tolerance : tolerances) {
      own.set_tolerance(tolerance);
      StressUpdate update;
      double best = 1e9;
      for (int i = 0; i < runs; ++i) {
        own.move_to(back);
        (void)own.solve(Method::pcg);
        best = std::min(best, timed(1, [&] {
                          own.move_to(to);
                          update = own.solve(Method::pcg);
                        }));
      }
      std::printf(" | %5.0f ms (%2d) %.1e", 1e3 * best, update.iterations,
                  relative(update.von_mises, reference));
    }
    own.set_tolerance(ReanalysisSettings{}.tolerance);
    double refactor = 1e9;
    for (int i = 0; i < runs; ++i) {
      own.move_to(back);
      (void)own.solve(Method::pcg);
      refactor = std::min(refactor, timed(1, [&] {
                            own.move_to(to);
                            (void)own.solve(Method::refactor);
                          }));
    }
    own.move_to(back);
    (void)own.solve(Method::refactor);
    own.move_to(to);
    const StressUpdate chosen = own.solve();
    std::printf(" | %5.0f ms | %5.0f ms | %s\n", 1e3 * refactor, 1e3 * full, name(chosen.method));
    std::fflush(stdout);
  }
  jumping.reset();
  std::printf(
      "\nten steps of 2%% to -20%%, each from the %zu solutions before: CPU milliseconds a step, "
      "worst and mean (steps of the worst)\n",
      ReanalysisSettings{}.max_past_solutions);
  settings.max_past_solutions = ReanalysisSettings{}.max_past_solutions;
  for (const double tolerance : tolerances) {
    settings.tolerance = tolerance;
    Reanalysis dragged(mesh, model, velocities, settings);
    double worst = 0, sum = 0;
    int iterations = 0;
    for (int step = 1; step <= 10; ++step) {
      StressUpdate update;
      const double time = timed(1, [&] {
        dragged.move_to(row(-.02 * step * kHeight));
        update = dragged.solve(Method::pcg);
      });
      sum += time;
      worst = std::max(worst, time);
      iterations = std::max(iterations, update.iterations);
    }
    std::printf("PCG %g: %.0f ms, %.0f ms (%d)\n", tolerance, 1e3 * worst, 1e2 * sum, iterations);
    std::fflush(stdout);
  }
  return 0;
}
