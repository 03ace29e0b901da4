#include "programs/modal_fem/run.hpp"

#include "fem/io/exchange.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/surface.hpp"
#include "fem/modes/residual_compliance.hpp"
#include "programs/modal_fem/refine.hpp"
#include "programs/modal_fem/slepc_engine.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace tactus::fem {
namespace {

/// Conjugate gradients of the estimate stop when a step adds less of it.
constexpr double kSettle = .1;

void check_residual(const Order& order, const Material& material) {
  if (order.residual && !material.isotropic())
    throw Refusal("--residual needs an isotropic material, " + material.name + " is orthotropic");
}

std::string words_of(std::span<const Support> supports) {
  std::string words;
  for (const Support& support : supports)
    words += (words.empty() ? "" : "; ") + support.name;
  return words.empty() ? "free" : words;
}

/// The errors of modes that were found elsewhere: their factor has to be made here again, where
/// there is room for it.
void estimate_here(const Solved& body, ErrorEstimate& error, ProgressLine& progress,
                   const Forecast& forecast) {
  progress.stage("ordering the equations", 0);
  ShiftedFactor factor(*body.matrices, usual_shift(body.mesh, body.materials));
  if (const std::string beyond = forecast.beyond_here(factor.cost()); !beyond.empty()) {
    progress.say("warning: the errors are not estimated: " + beyond);
    return;
  }
  progress.stage("factorising", 0);
  factor.factorise();
  progress.stage("estimating errors", 0);
  error = estimate_errors(body.mesh, body.materials, *body.matrices, factor, body.modes, kSettle,
                          [&](double share) { progress.stage("estimating errors", share); });
}

/// The modes and their errors, with progress.
void find_modes_of(Solved& body, const Order& order, ErrorEstimate& error, ProgressLine& progress,
                   Forecast& forecast) {
  const std::size_t count = order.modes + (order.design.wanted ? kModesBeyond : 0);
  if (order.slepc) {
    body.modes = slepc_modes(body.mesh, body.materials, *body.matrices, count,
                             order.ranks > 0 ? order.ranks : 2, progress);
    estimate_here(body, error, progress, forecast);
    return;
  }
  if (!order.import_values.empty()) {
    body.modes = import_modes(order.import_values, order.import_vectors, body.mesh, *body.matrices);
    estimate_here(body, error, progress, forecast);
    return;
  }
  ModeSettings settings{.count = count};
  settings.report = [&](const std::string& stage, double share) {
    progress.stage(stage, share, stage == "factorising" ? forecast.factor_seconds() : 0);
  };
  settings.predict = [&](const FactorCost& cost) { forecast.factor(cost); };
  settings.inspect = [&](const Modes& modes, ShiftedFactor& factor) {
    progress.stage("estimating errors", 0);
    error = estimate_errors(body.mesh, body.materials, *body.matrices, factor, modes, kSettle,
                            [&](double share) { progress.stage("estimating errors", share); });
  };
  body.modes = find_modes(body.mesh, body.materials, *body.matrices, settings);
}

/// Leaves out all modes but the first.
void keep_first(Solved& body, std::size_t count) {
  Modes& modes = body.modes;
  modes.frequency_hz.resize(count);
  modes.shapes.resize(count * body.mesh.dofs());
  modes.multiplicity.resize(count);
  modes.residual.resize(count);
  body.relative_error.resize(std::min(count, body.relative_error.size()));
}

/// What can be refused without a mesh: names of files and materials.
void check_early(const Order& order) {
  for (const std::string& path : {order.is_file ? order.body : std::string(), order.profile,
                                  order.import_values, order.import_vectors})
    if (!path.empty())
      check_readable(path);
  for (const auto& [region, name] : order.materials)
    (void)find_material(name);
  if (order.is_file)
    return;
  const auto materials = materials_of(order, Mesh{}); // one region, as shapes have
  (void)elastic_matrix(materials[0]);
  check_residual(order, materials[0]);
}

void say_inaudible(const Solved& body, ProgressLine& progress) {
  const auto& f = body.modes.frequency_hz;
  if (f.empty())
    return;
  const std::string odd =
      words_of_inaudible(f.front(), f.back(), bounding_box(body.mesh.nodes).largest(), false);
  if (!odd.empty())
    progress.say("warning: " + odd);
}

constexpr double kBandLimit = 21000; // Hz: what a listener hears of forces between the modes

void radiate_into(Solved& body, const Order& order, ProgressLine& progress,
                  const Forecast& forecast) {
  RadiationSettings sound{.triangles = order.acoustic_triangles,
                          .ratios = order.ratios,
                          .air_density = order.air_density,
                          .sound_speed = order.sound_speed,
                          .memory_limit_bytes = forecast.budget().bytes(),
                          .band_limit_hz = kBandLimit};
  sound.report = [&](const std::string& stage, double share) { progress.stage(stage, share); };
  sound.say = [&](const std::string& sentence) { progress.say(sentence); };
  body.radiation = radiate(body.mesh, body.modes, sound);
  if (body.modes.frequency_hz.back() * order.ratios.back() > body.radiation.resolved_hz)
    progress.say(format("above %.0f Hz a wave in air has fewer than four acoustic elements: expect "
                        "more than 0.3 dB there, or take more --acoustic-triangles",
                        body.radiation.resolved_hz));
}

/// The mesh that stands next, checked and assembled.
Solved assembled(const Order& order, Refinement& refinement, ProgressLine& progress,
                 Forecast& forecast) {
  Solved body;
  progress.stage("meshing", 0);
  body.mesh = refinement.mesh();
  progress.stage("checking the mesh", 0);
  check(body.mesh);
  describe(body.mesh, progress, "frequencies 5 to 30 % too high");
  forecast.made(body.mesh);
  const Parts parts = connected_parts(body.mesh);
  if (parts.count > 1 && !order.several_parts)
    throw Refusal("the mesh falls into " + std::to_string(parts.count) +
                  " parts that share no node, expected one (allow it with --multi)");
  body.materials = materials_of(order, body.mesh);
  check_residual(order, body.materials[0]);
  const std::vector<Support> supports = supports_of(order, body.mesh);
  body.support_words = words_of(supports);
  progress.stage("assembling", 0);
  body.matrices =
      std::make_unique<Matrices>(assemble(body.mesh, body.materials, supports, [&](double share) {
        progress.stage("assembling", share);
      }));
  return body;
}

void export_files(const Order& order, const Solved& body, ProgressLine& progress) {
  if (!order.inp.empty()) {
    progress.stage("writing " + order.inp, 0);
    write_inp(order.inp, body.mesh, body.materials, supports_of(order, body.mesh), order.modes);
  }
  if (!order.petsc.empty()) {
    progress.stage("writing " + order.petsc, 0);
    write_petsc(order.petsc, *body.matrices);
  }
}

/// Refines until the tolerance is met or the next mesh cannot be had; then the last one stays.
void refine(Solved& body, const Order& order, Refinement& refinement, ErrorEstimate error,
            ProgressLine& progress, Forecast& forecast) {
  while (!refinement.finished(body.mesh, body.matrices->held, error)) {
    try {
      Solved next = assembled(order, refinement, progress, forecast);
      ErrorEstimate remaining;
      find_modes_of(next, order, remaining, progress, forecast);
      body = std::move(next);
      error = std::move(remaining);
    } catch (const std::bad_alloc&) {
      refinement.give_up("a finer mesh takes more memory than there is");
      break;
    } catch (const Refusal& refusal) {
      refinement.give_up(refusal.what());
      break;
    }
  }
  body.relative_error = std::move(error.relative);
}

} // namespace

std::vector<Support> supports_of(const Order& order, const Mesh& mesh) {
  std::vector<Support> supports;
  if (order.places.empty())
    return supports;
  const Surface skin = surface_of(mesh);
  const double near = 1e-6 * bounding_box(mesh.nodes).largest();
  for (const Place& place : order.places) {
    Support support{place.words, {}, place.directions, place.stiffness};
    if (!place.set.empty()) {
      const auto at = mesh.node_sets.find(place.set);
      if (at == mesh.node_sets.end())
        throw Refusal("--" + place.words + ": the mesh has no node set of that name");
      support.nodes = at->second;
    } else {
      for (const int node : skin.node) {
        const Vector3& p = mesh.nodes[static_cast<std::size_t>(node)];
        if (place.plane >= 0 ? std::abs(p[place.plane] - place.level) <= near
                             : length(p - place.centre) <= place.radius + near)
          support.nodes.push_back(node);
      }
    }
    if (support.nodes.empty())
      throw Refusal("--" + place.words +
                    " meets no node of the body's skin: expected a place on it");
    supports.push_back(std::move(support));
  }
  return supports;
}

ModalTable table_of(const Order& order, const Solved& body, const std::string& created) {
  TableNotes notes;
  notes.body_name = std::filesystem::path(order.body).stem().string();
  notes.support = body.support_words;
  notes.relative_error = body.relative_error;
  notes.air_density = order.air_density;
  notes.air_speed = order.sound_speed;
  notes.created = created;
  return {body.mesh,
          body.materials,
          body.modes,
          mass_properties(body.mesh, body.materials),
          loss_factors(body.mesh, body.materials, *body.matrices, body.modes),
          order.output.empty()
              ? std::vector<double>{}
              : poisson_slopes(body.mesh, body.materials, *body.matrices, body.modes),
          notes,
          body.radiation,
          body.residual,
          body.shape};
}

Solved solve_moved(const Order& order, Mesh moved, std::span<const Material> materials,
                   std::span<const Support> supports, const DesignSpace& space,
                   std::vector<double> displacement) {
  Solved body;
  body.mesh = std::move(moved);
  body.materials.assign(materials.begin(), materials.end());
  body.support_words = words_of(supports);
  body.matrices = std::make_unique<Matrices>(assemble(body.mesh, materials, supports));
  body.modes =
      find_modes(body.mesh, materials, *body.matrices, {.count = order.modes + kModesBeyond});
  const std::size_t count = std::min(order.modes, body.modes.frequency_hz.size());
  body.shape =
      shape_derivatives(space, body.mesh, materials, body.modes, count, std::move(displacement));
  keep_first(body, count);
  body.solved = true;
  return body;
}

Solved solve(const Order& order, ProgressLine& progress) {
  check_early(order);
  if (order.slepc)
    check_slepc();
  set_solver_threads(order.threads);
  Forecast forecast(order, progress);
  Refinement refinement(order, progress, forecast);
  Solved body = assembled(order, refinement, progress, forecast);
  const bool only_exports = order.output.empty() && order.csv.empty() && order.vtu.empty() &&
                            !(order.inp.empty() && order.petsc.empty());
  if (!only_exports) {
    ErrorEstimate error;
    find_modes_of(body, order, error, progress, forecast);
    refine(body, order, refinement, std::move(error), progress, forecast);
  }
  export_files(order, body, progress);
  if (only_exports)
    return body;
  body.solved = true;
  if (order.design.wanted) {
    const std::size_t count = std::min(order.modes, body.modes.frequency_hz.size());
    body.shape =
        shape_derivatives(order.design, body.mesh, body.materials, body.modes, count, progress);
    keep_first(body, count);
  }
  say_inaudible(body, progress);
  if (order.residual)
    body.residual = residual_compliance(
        body.mesh, body.materials, *body.matrices, body.modes, kCompliancePlaces,
        [&](double share) { progress.stage("compliance beyond the modes", share); });
  if (order.radiation)
    radiate_into(body, order, progress, forecast);
  progress.say(format("%zu right-hand sides solved", body.modes.solves));
  return body;
}

} // namespace tactus::fem
