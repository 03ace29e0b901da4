#include "programs/modal_fem/run.hpp"

#include "core/modal/table/modal_table.hpp"
#include "fem/io/exchange.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/surface.hpp"
#include "fem/modes/residual_compliance.hpp"
#include "fem/modes/rigid.hpp"
#include "programs/modal_fem/refine.hpp"
#include "programs/modal_fem/slepc_engine.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <new>

namespace tactus::fem {
namespace {

/// The estimate's conjugate gradients stop when a step adds less than this fraction of the
/// estimate.
constexpr double kSettle = .1;

void check_residual(const ModalOptions& options, const Material& material) {
  if (options.residual && !material.isotropic())
    throw InputError("--residual: expected an isotropic material, " + material.name +
                     " is orthotropic");
}

std::string supports_text(std::span<const Support> supports) {
  std::string words;
  for (const Support& support : supports)
    words += (words.empty() ? "" : "; ") + support.name;
  return words.empty() ? "free" : words;
}

/// Estimates the errors of modes that were computed elsewhere. The factor for this is computed
/// here, if memory allows.
void estimate_in_process(const Solved& body, ErrorEstimate& error, ProgressLine& progress,
                         const Forecast& forecast) {
  progress.stage("ordering the equations", 0);
  ShiftedFactor factor(*body.matrices, default_shift(body.mesh, body.materials));
  if (const std::string over_budget = forecast.over_budget_in_process(factor.cost());
      !over_budget.empty()) {
    progress.notify("warning: the errors are not estimated: " + over_budget);
    return;
  }
  progress.stage("factorising", 0);
  factor.factorise();
  progress.stage("estimating errors", 0);
  error =
      estimate_errors(body.mesh, body.materials, *body.matrices, factor, body.modes,
                      {kSettle, [&](double share) { progress.stage("estimating errors", share); }});
}

/// Computes the modes and their errors, and reports progress.
void find_modes_of(Solved& body, const ModalOptions& options, ErrorEstimate& error,
                   ProgressLine& progress, Forecast& forecast) {
  const std::size_t count = options.modes + (options.design.requested ? kModesBeyond : 0);
  if (options.slepc) {
    body.modes = slepc_modes(body.mesh, body.materials, *body.matrices, count,
                             options.ranks > 0 ? options.ranks : 2, progress);
    estimate_in_process(body, error, progress, forecast);
    return;
  }
  if (!options.import_values.empty()) {
    body.modes =
        import_modes(options.import_values, options.import_vectors, body.mesh, *body.matrices);
    estimate_in_process(body, error, progress, forecast);
    return;
  }
  ModeSettings settings{.count = count};
  settings.report = [&](const std::string& stage, double share) {
    progress.stage(stage, share, stage == "factorising" ? forecast.factor_seconds() : 0);
  };
  settings.predict = [&](const FactorCost& cost) { forecast.factor(cost); };
  settings.inspect = [&](const Modes& modes, ShiftedFactor& factor) {
    progress.stage("estimating errors", 0);
    error = estimate_errors(
        body.mesh, body.materials, *body.matrices, factor, modes,
        {kSettle, [&](double share) { progress.stage("estimating errors", share); }});
  };
  body.modes = find_modes(body.mesh, body.materials, *body.matrices, settings);
}

/// Keeps only the first modes.
void keep_first(Solved& body, std::size_t count) {
  keep_first(body.modes, count);
  body.relative_error.resize(std::min(count, body.relative_error.size()));
}

/// Checks that need no mesh: names of files and materials.
void check_early(const ModalOptions& options) {
  for (const std::string& path : {options.is_file ? options.body : std::string(), options.profile,
                                  options.import_values, options.import_vectors})
    if (!path.empty())
      check_readable(path);
  for (const auto& [region, name] : options.materials)
    (void)find_material(name);
  if (options.is_file)
    return;
  const auto materials = materials_of(options, Mesh{}); // shapes have one region
  (void)elastic_matrix(materials[0]);
  check_residual(options, materials[0]);
}

void warn_of_inaudible_modes(const Solved& body, const ModalOptions& options,
                             ProgressLine& progress) {
  const auto& f = body.modes.frequency_hz;
  if (f.empty())
    return;
  const std::string odd = inaudible_text(
      f.front(), f.back(), bounding_box(body.mesh.nodes).largest(), options.unit_of_body(), false);
  if (!odd.empty())
    progress.notify("warning: " + odd);
}

constexpr double kBandLimit =
    21000; // Hz, upper limit of the band for forced vibration between the modes

void radiate_into(Solved& body, const ModalOptions& options, ProgressLine& progress,
                  const Forecast& forecast) {
  RadiationSettings sound{.triangles = options.acoustic_triangles,
                          .ratios = options.ratios,
                          .air_density = options.air_density,
                          .sound_speed = options.sound_speed,
                          .memory_limit_bytes = forecast.budget().bytes(),
                          .band_limit_hz = kBandLimit};
  sound.report = [&](const std::string& stage, double share) { progress.stage(stage, share); };
  sound.notify = [&](const std::string& sentence) { progress.notify(sentence); };
  body.radiation = radiate(body.mesh, body.modes, sound);
  if (body.modes.frequency_hz.back() * options.ratios.back() > body.radiation.resolved_hz)
    progress.notify(
        format("above %.0f Hz a wavelength in air has fewer than four acoustic elements: expect "
               "errors above 0.3 dB there, or use more --acoustic-triangles",
               body.radiation.resolved_hz));
}

/// Makes, checks and assembles the next mesh.
Solved assembled(const ModalOptions& options, Refinement& refinement, ProgressLine& progress,
                 Forecast& forecast) {
  Solved body;
  progress.stage("meshing", 0);
  body.mesh = refinement.mesh();
  progress.stage("checking the mesh", 0);
  check(body.mesh);
  describe(body.mesh, progress, "frequencies 5 to 30 % too high");
  forecast.made(body.mesh);
  const Parts parts = connected_parts(body.mesh);
  if (parts.count > 1 && !options.several_parts)
    throw InputError("the mesh has " + std::to_string(parts.count) +
                     " parts that share no node, expected one (allow more with --multi)");
  body.materials = materials_of(options, body.mesh);
  check_residual(options, body.materials[0]);
  const std::vector<Support> supports = supports_of(options, body.mesh);
  body.support_text = supports_text(supports);
  progress.stage("assembling", 0);
  body.matrices =
      std::make_unique<Matrices>(assemble(body.mesh, body.materials, supports, [&](double share) {
        progress.stage("assembling", share);
      }));
  const auto& held = body.matrices->constrained;
  if (std::all_of(held.begin(), held.end(), [](auto h) { return h != 0; }))
    throw InputError("the supports fix every node: expected a movable part");
  return body;
}

void export_files(const ModalOptions& options, const Solved& body, ProgressLine& progress) {
  if (!options.inp.empty()) {
    progress.stage("writing " + options.inp, 0);
    const std::size_t rigid = rigid_motions(body.mesh, *body.matrices).size() /
                              body.mesh.dofs(); // the analysis in the exported file includes the
                                                // constrained ones
    write_inp(options.inp, body.mesh, body.materials, supports_of(options, body.mesh),
              options.modes + rigid);
  }
  if (!options.petsc.empty()) {
    progress.stage("writing " + options.petsc, 0);
    write_petsc(options.petsc, *body.matrices);
  }
}

/// Refines until the tolerance is met or the next mesh cannot be made; the last mesh is then kept.
void refine(Solved& body, const ModalOptions& options, Refinement& refinement, ErrorEstimate error,
            ProgressLine& progress, Forecast& forecast) {
  while (!refinement.finished(body.mesh, body.matrices->constrained, error)) {
    try {
      Solved next = assembled(options, refinement, progress, forecast);
      ErrorEstimate remaining;
      find_modes_of(next, options, remaining, progress, forecast);
      body = std::move(next);
      error = std::move(remaining);
    } catch (const std::bad_alloc&) {
      refinement.give_up("not enough memory for a finer mesh");
      break;
    } catch (const InputError& refusal) {
      refinement.give_up(refusal.what());
      break;
    }
  }
  body.relative_error = std::move(error.relative);
}

std::string names_of_sets(const Mesh& mesh) {
  std::string names;
  for (const auto& [name, nodes] : mesh.node_sets)
    names += (names.empty() ? ": expected " : ", ") + printable(name, 60);
  return names;
}

} // namespace

std::vector<Support> supports_of(const ModalOptions& options, const Mesh& mesh) {
  std::vector<Support> supports;
  if (options.fixed_regions.empty())
    return supports;
  const Surface skin = surface_of(mesh);
  const double near = 1e-6 * bounding_box(mesh.nodes).largest();
  for (const FixedRegion& fixed_region : options.fixed_regions) {
    Support support{fixed_region.words, {}, fixed_region.directions, fixed_region.stiffness};
    if (!fixed_region.set.empty()) {
      const auto at = mesh.node_sets.find(fixed_region.set);
      if (at == mesh.node_sets.end())
        throw InputError("--" + fixed_region.words + ": the mesh has no node set of that name" +
                         names_of_sets(mesh));
      support.nodes = at->second;
    } else {
      for (const int node : skin.node) {
        const Vec3& p = mesh.nodes[static_cast<std::size_t>(node)];
        if (fixed_region.plane >= 0 ? std::abs(p[fixed_region.plane] - fixed_region.level) <= near
                                    : length(p - fixed_region.centre) <= fixed_region.radius + near)
          support.nodes.push_back(node);
      }
    }
    if (support.nodes.empty())
      throw InputError("--" + fixed_region.words +
                       " selects no node of the body's skin: expected a region of it");
    supports.push_back(std::move(support));
  }
  return supports;
}

ModalTable table_of(const ModalOptions& options, const Solved& body, const std::string& created) {
  TableMetadata metadata;
  metadata.body_name = std::filesystem::path(options.body).stem().string();
  metadata.support = body.support_text;
  metadata.relative_error = body.relative_error;
  metadata.air_density = options.air_density;
  metadata.air_speed = options.sound_speed;
  metadata.created = created;
  return {body.mesh,
          body.materials,
          body.modes,
          mass_properties(body.mesh, body.materials),
          loss_factors(body.mesh, body.materials, *body.matrices, body.modes),
          options.output.empty()
              ? std::vector<double>{}
              : poisson_slopes(body.mesh, body.materials, *body.matrices, body.modes),
          metadata,
          body.radiation,
          body.residual,
          body.shape};
}

Solved solve_moved(const ModalOptions& options, Mesh moved, std::span<const Material> materials,
                   std::span<const Support> supports, const DesignSpace& space,
                   std::vector<double> displacement) {
  Solved body;
  body.mesh = std::move(moved);
  body.materials.assign(materials.begin(), materials.end());
  body.support_text = supports_text(supports);
  body.matrices = std::make_unique<Matrices>(assemble(body.mesh, materials, supports));
  body.modes =
      find_modes(body.mesh, materials, *body.matrices, {.count = options.modes + kModesBeyond});
  const std::size_t count = std::min(options.modes, body.modes.frequency_hz.size());
  body.shape =
      shape_derivatives(space, body.mesh, materials, body.modes, count, std::move(displacement));
  keep_first(body, count);
  body.solved = true;
  return body;
}

Solved solve(const ModalOptions& options, ProgressLine& progress) {
  check_early(options);
  if (options.slepc)
    check_slepc();
  set_solver_threads(options.threads);
  Forecast forecast(options, progress);
  Refinement refinement(options, progress, forecast);
  Solved body = assembled(options, refinement, progress, forecast);
  const bool only_exports = options.output.empty() && options.csv.empty() && options.vtu.empty() &&
                            !(options.inp.empty() && options.petsc.empty());
  if (!only_exports) {
    ErrorEstimate error;
    find_modes_of(body, options, error, progress, forecast);
    refine(body, options, refinement, std::move(error), progress, forecast);
  }
  export_files(options, body, progress);
  if (only_exports)
    return body;
  body.solved = true;
  if (options.design.requested) {
    const std::size_t count = modal::with_whole_groups(body.modes.frequency_hz, options.modes);
    body.shape =
        shape_derivatives(options.design, body.mesh, body.materials, body.modes, count, progress);
    keep_first(body, count);
  }
  warn_of_inaudible_modes(body, options, progress);
  if (options.residual)
    body.residual = residual_compliance(
        body.mesh, body.materials, *body.matrices, body.modes, kCompliancePoints,
        [&](double share) { progress.stage("compliance beyond the modes", share); });
  if (options.radiation)
    radiate_into(body, options, progress, forecast);
  progress.notify(format("%zu right-hand sides solved", body.modes.solves));
  return body;
}

} // namespace tactus::fem
