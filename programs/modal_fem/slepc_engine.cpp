#include "programs/modal_fem/slepc_engine.hpp"

#include "core/modal/table/modal_table.hpp"
#include "fem/io/exchange.hpp"
#include "fem/io/text.hpp"
#include "fem/modes/rigid.hpp"
#include "programs/body/budget.hpp"
#include "programs/body/mpi_run.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace tactus::fem {
namespace {

constexpr MpiEngine kSlepc{"--engine slepc", "slepc_solve", "SLEPc", "libslepc-real-dev"};
constexpr std::array kFiles{"matrices", "rigid", "values", "vectors"};

} // namespace

void check_slepc() { check_engine(kSlepc); }

Modes slepc_modes(const Mesh& mesh, std::span<const Material> materials, const Matrices& matrices,
                  std::size_t count, int ranks, ProgressLine& progress) {
  const std::size_t n = matrices.dofs();
  check_ranks(ranks, mesh.nodes.size());
  const std::vector<double> rigid = rigid_motions(mesh, matrices);
  const std::size_t constrained = static_cast<std::size_t>(
      std::count(matrices.constrained.begin(), matrices.constrained.end(), 1));
  // Requests a few more modes than needed, as find_modes() does; SLEPc finds at most as many as
  // exist.
  const std::size_t requested = std::min(count + 4, n - constrained - rigid.size() / n);
  const MpiRun slepc(kSlepc, kFiles);
  // Space for both triangles of both matrices, 9 + 3 entries of 12 bytes per pair of nodes, and for
  // the vectors.
  slepc.require_disk_space(2 * 12 * 12. * static_cast<double>(matrices.graph.row.size()) +
                           8. * static_cast<double>(n * (requested + 16)));
  progress.stage("exporting the matrices", 0);
  write_petsc(slepc.file("matrices"), matrices);
  write_petsc_vectors(slepc.file("rigid"), rigid, n);

  progress.stage("starting SLEPc", 0);
  double peak = 0;
  slepc.run(ranks,
            {slepc.file("matrices"), slepc.file("rigid"), slepc.file("values"),
             slepc.file("vectors"), std::to_string(requested), std::to_string(rigid.size() / n),
             format("%.17g", default_shift(mesh, materials))},
            progress, [&](const char* line) { std::sscanf(line, "peak %lf", &peak); });
  progress.notify(format("%d processes, at most ", ranks) + format_bytes(peak) + " each");

  progress.stage("importing the modes", 0);
  Modes modes = import_modes(slepc.file("values"), slepc.file("vectors"), mesh, matrices, false);
  keep_first(modes, modal::with_whole_groups(modes.frequency_hz, count));
  return modes;
}

} // namespace tactus::fem
