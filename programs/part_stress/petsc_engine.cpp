#include "programs/part_stress/petsc_engine.hpp"

#include "fem/io/exchange.hpp"
#include "fem/io/text.hpp"
#include "programs/body/budget.hpp"
#include "programs/body/mpi_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace tactus::fem {
namespace {

constexpr MpiEngine kPetsc{"--engine petsc", "petsc_solve", "PETSc", "libpetsc-real-dev"};
constexpr std::array kFiles{"matrix", "vectors", "solution"};
constexpr std::size_t kMaxProcessesListed = 8;

struct Process {
  double bytes = 0, seconds = 0;
};

/// A text such as "2 processes: 142 MB and 1.9 s, 139 MB and 1.8 s".
std::string process_list_text(std::span<const Process> processes) {
  std::string text =
      format(processes.size() == 1 ? "%zu process: " : "%zu processes: ", processes.size());
  for (std::size_t k = 0; k < std::min(processes.size(), kMaxProcessesListed); ++k)
    text += (k > 0 ? ", " : "") + format_bytes(processes[k].bytes) +
            format(" and %.2g s", processes[k].seconds);
  if (processes.size() > kMaxProcessesListed) {
    const auto largest =
        std::max_element(processes.begin(), processes.end(),
                         [](const Process& a, const Process& b) { return a.bytes < b.bytes; });
    text += " ..., at most " + format_bytes(largest->bytes);
  }
  return text;
}

double norm(std::span<const double> x) {
  double sum = 0;
  for (const double v : x)
    sum += v * v;
  return std::sqrt(sum);
}

/// ||f - K u|| / ||f||, recomputed from the returned solution. Refuses a residual that is too
/// large.
double checked_residual(const Matrices& m, const std::vector<double>& u,
                        const std::vector<double>& right) {
  std::vector<double> left(m.dofs());
  m.multiply_stiffness(u, left, 1);
  for (std::size_t i = 0; i < left.size(); ++i)
    left[i] = right[i] - left[i];
  const double size = norm(right), residual = size > 0 ? norm(left) / size : norm(left);
  if (!(residual <= 10 * kPetscTolerance))
    throw InputError(format("--engine petsc failed: its solution has a residual of %.1e of the "
                            "load, expected %.0e",
                            residual, kPetscTolerance));
  return residual;
}

} // namespace

void check_petsc() { check_engine(kPetsc); }

StaticSolution petsc_solution(const Mesh& mesh, const StaticSystem& system,
                              std::span<const double> start, int ranks, ProgressLine& progress) {
  const Matrices& m = system.matrices;
  const std::size_t n = m.dofs(), nodes = m.graph.node_count();
  check_ranks(ranks, nodes);
  const MpiRun petsc(kPetsc, kFiles);
  // Space for both triangles, 9 entries of 12 bytes per pair of nodes, and for the vectors.
  petsc.require_disk_space(2 * 9 * 12. * static_cast<double>(m.graph.row.size()) +
                           8. * 4 * static_cast<double>(n));
  progress.stage("exporting the equations", 0);
  write_petsc(petsc.file("matrix"), m);
  const std::vector<double> right = system.right_side();
  std::vector<double> vectors(3 * n, 0.0); // f, the initial displacement, the nodes
  std::copy(right.begin(), right.end(), vectors.begin());
  for (std::size_t i = 0; i < start.size(); ++i)
    vectors[n + i] = m.constrained[i] ? 0 : start[i];
  for (std::size_t k = 0; k < nodes; ++k)
    for (int i = 0; i < 3; ++i)
      vectors[2 * n + 3 * k + static_cast<std::size_t>(i)] = mesh.nodes[k][i];
  write_petsc_vectors(petsc.file("vectors"), vectors, n);

  progress.stage("starting PETSc", 0);
  std::vector<Process> processes(static_cast<std::size_t>(ranks));
  int iterations = 0;
  petsc.run(ranks,
            {petsc.file("matrix"), petsc.file("vectors"), petsc.file("solution"),
             format("%.17g", kPetscTolerance)},
            progress, [&](const char* line) {
              std::size_t rank = 0;
              Process process;
              if (std::sscanf(line, "process %zu %lf %lf", &rank, &process.bytes,
                              &process.seconds) == 3 &&
                  rank < processes.size())
                processes[rank] = process;
              else
                std::sscanf(line, "iterations %d", &iterations);
            });
  std::vector<double> u = read_petsc_vector(petsc.file("solution"), n);
  for (std::size_t i = 0; i < n; ++i)
    if (m.constrained[i])
      u[i] = 0;
  const double residual = checked_residual(m, u, right);
  progress.notify(format("PETSc: %d iterations to %.1e; ", iterations, residual) +
                  process_list_text(processes));
  return completed(system, std::move(u));
}

} // namespace tactus::fem
