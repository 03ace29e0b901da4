// modal_fem: from a body to its modes.
//
//   K u = omega^2 M u      K = ∫ B' C B dV      M = ∫ rho N' N dV
//
//   1. mesh     a swept shape, a file, or gmsh's curved tetrahedra of a CAD or surface model
//   2. check    units, inside-out elements, loose parts
//   3. assemble K and M, supports
//   4. solve    factor K + s M, block Lanczos
//   5. shape    derivatives of the frequencies by control points (--lattice)
//   6. radiate  sound of each mode in air, by boundary elements (--radiation body)
//   7. write    NAME.modal.npz, and CSV, VTU, a picture sheet
#include "fem/io/load.hpp"
#include "fem/io/modal_table.hpp"
#include "fem/io/text.hpp"
#include "programs/body/body_program.hpp"
#include "programs/body/output_files.hpp"
#include "programs/modal_fem/options.hpp"
#include "programs/modal_fem/outputs.hpp"
#include "programs/modal_fem/raw.hpp"
#include "programs/modal_fem/run.hpp"
#include "programs/modal_fem/serve.hpp"

#include <cstdio>
#include <numbers>

namespace {

using namespace tactus::fem;

void print(const ModalTable& table) {
  const Modes& modes = table.modes;
  std::printf("%zu rigid-body modes left out; mass %.6g kg of %s\n", modes.rigid, table.body.mass,
              names_of_materials(table.materials).c_str());
  const ModeRadiation& sound = table.radiation;
  std::printf("mode  frequency Hz  mult   T60 s   %s%s\n",
              sound.empty() ? "" : "T60 in air  efficiency  degree  ",
              table.metadata.relative_error.empty() ? "" : "estimated error %");
  for (std::size_t k = 0; k < modes.frequency_hz.size(); ++k) {
    std::printf("%4zu  %12.3f  %4d  %6.3g", k + 1, modes.frequency_hz[k], modes.multiplicity[k],
                decay_time(modes.frequency_hz[k], table.loss[k]));
    if (!sound.empty()) {
      const double loss =
          table.loss[k] + sound.decay_rate[k] / (std::numbers::pi * modes.frequency_hz[k]);
      std::printf("   %10.3g  %10.3g  %6d  ", decay_time(modes.frequency_hz[k], loss),
                  sound.efficiency[k], sound.max_degree[k]);
    }
    if (k < table.metadata.relative_error.size())
      std::printf("   %.2g", 100 * table.metadata.relative_error[k]);
    std::puts("");
  }
}

int run(const std::vector<std::string>& words) {
  const ModalOptions options = read_options(words);
  if (!options.sheet.empty() && options.output.empty())
    throw InputError("--sheet draws the table: expected also -o NAME.modal.npz");
  check_outputs(options);
  if (!options.sheet.empty())
    check_sheet("modal_sheet.py");
  ProgressLine progress(options.quiet);
  warn_of_unusual_constants(options, progress);
  Solved body = solve(options, progress);
  if (!body.solved)
    return 0; // only exported
  progress.stage("damping and the table", 0);
  ModalTable table = table_of(options, body, date_of_now());
  if (!table.shape.parameters.empty())
    table.metadata.command = words; // for `serve`
  print(table);
  if (options.import_values.empty() && table.modes.frequency_hz.size() > options.modes)
    std::printf(
        "%zu modes instead of %zu: the last ones have nearly equal frequencies, and the sound of a "
        "part of such a group would depend on the body's orientation\n",
        table.modes.frequency_hz.size(), options.modes);
  std::fflush(stdout);
  const auto begin = [&](const std::string& path) { progress.stage("writing " + path, 0); };
  if (!options.output.empty()) {
    begin(options.output);
    write_table(options.output, table);
  }
  if (!options.csv.empty()) {
    begin(options.csv);
    write_csv(options.csv, table);
  }
  if (!options.vtu.empty()) {
    begin(options.vtu);
    write_vtu(options.vtu, body.mesh, body.modes, 20);
  }
  if (!options.sheet.empty()) {
    begin(options.sheet);
    draw_sheet("modal_sheet.py", options.output, options.sheet);
  }
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  constexpr Command kCommands[] = {{"raw", run_raw}, {"serve", serve}};
  return body_program(
      argc, argv, "modal_fem", [] { return usage() + raw_usage(); }, kCommands, run);
}
