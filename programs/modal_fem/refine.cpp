#include "programs/modal_fem/refine.hpp"

#include "fem/io/load.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/surface.hpp"

#include <algorithm>
#include <filesystem>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr int kMaxRounds = 7;
/// Largest number of unknowns unless --tolerance is given.
constexpr double kMaxUnknowns = 3e5;
/// Largest growth of the number of elements per round, since the orders of the error are only
/// estimates.
constexpr double kMaxGrowth = 12;
/// Element size times the highest wave number. Quadratic elements then have errors of some percent,
/// small enough for their fourth-power law to hold.
constexpr double kFirstPhase = 1.0;
/// As kFirstPhase, for a mesh that is not refined.
constexpr double kOnlyPhase = .6;

/// The area of a mesh's skin, m^2.
double outer_area(const Mesh& mesh) {
  const Surface skin = surface_of(mesh);
  double area = 0;
  for (const auto& t : skin.triangles) {
    const auto at = [&](std::size_t k) {
      return mesh.nodes[static_cast<std::size_t>(skin.node[static_cast<std::size_t>(t[k])])];
    };
    area += .5 * length(cross(at(1) - at(0), at(2) - at(0)));
  }
  return area;
}

} // namespace

Refinement::Refinement(const ModalOptions& options, ProgressLine& progress, Forecast& forecast)
    : options_(options), progress_(progress), forecast_(forecast) {
  const bool only_exports = options.output.empty() && options.csv.empty() && options.vtu.empty() &&
                            !(options.inp.empty() && options.petsc.empty());
  refines_ = options.tolerance > 0 && options.choice.h <= 0 && options.choice.layers <= 0 &&
             options.import_values.empty() && !options.slepc && !only_exports &&
             !(options.is_file && is_volume_mesh(options.body));
}

double Refinement::first_size(double volume, double skin, double largest, double modes) const {
  return (refines_ ? kFirstPhase : kOnlyPhase) /
         highest_wave_number(volume, skin, largest, first_material(options_),
                             static_cast<std::size_t>(modes));
}

Mesh Refinement::mesh() { return options_.is_file ? mesh_of_file() : mesh_of_shape(); }

Mesh Refinement::mesh_of_file() {
  LoadChoice load = load_choice(options_, progress_);
  load.size_for = [this](double volume, double skin, double largest) {
    return first_size(volume, skin, largest, static_cast<double>(options_.modes));
  };
  load.sizes = sizes_ ? &*sizes_ : nullptr;
  load.limits.memory_bytes = static_cast<std::uint64_t>(forecast_.budget().bytes());
  load.on_prediction = [this](const MeshSize& size, const auto& notify) { // called in the child
                                                                          // process
    std::function<MeshSize(double)> with_modes;
    if (options_.choice.h <= 0 && !sizes_)
      with_modes = [this, size](double modes) {
        const double largest = std::max({size.box.x, size.box.y, size.box.z});
        const double h = first_size(size.volume, size.skin_area, largest, modes);
        return size.height > 0 ? predict_swept_size(size.volume, size.skin_area, size.box,
                                                    size.height, h, std::ceil(size.height / h))
                               : resized_tetrahedra(size, h);
      };
    forecast_.mesh(
        size, [size](double h) { return resized_tetrahedra(size, h); }, with_modes, notify);
  };
  return load_body(options_.body, load);
}

std::vector<ProfilePoint> Refinement::profile() const {
  return options_.profile.empty() ? std::vector<ProfilePoint>{}
                                  : read_profile(options_.profile, options_.unit);
}

Mesh Refinement::mesh_of_shape() {
  const auto points = profile();
  const auto plan_for = [&](const MeshChoice& choice) {
    return plan_shape(options_.body, options_.dimensions, points, choice);
  };
  MeshChoice choice = options_.choice;
  std::function<MeshSize(double)> with_modes;
  if (round_ > 0) {
    choice.grid = &next_grid_;
  } else if (choice.h <= 0 && choice.layers <= 0) {
    // A mesh of few elements gives the body's volume and skin area.
    MeshChoice coarse;
    coarse.h = 1e12;
    coarse.sparse = true;
    const Mesh body = plan_for(coarse).make().mesh;
    choice.sparse = refines_;
    const auto size_for = [this, solid = volume(body), skin = outer_area(body),
                           largest = bounding_box(body.nodes).largest()](double modes) {
      return first_size(solid, skin, largest, modes);
    };
    choice.h = size_for(static_cast<double>(options_.modes));
    with_modes = [plan_for, choice, size_for](double modes) {
      MeshChoice other = choice;
      other.h = size_for(modes);
      return plan_for(other).size;
    };
  }
  const ShapePlan plan = plan_for(choice);
  const auto with_element_size = [&](double h) {
    MeshChoice other = options_.choice;
    other.h = h;
    return plan_for(other).size;
  };
  forecast_.mesh(plan.size, with_element_size, with_modes);
  progress_.stage("meshing", 0, forecast_.meshing_seconds());
  SweptBody body = plan.make();
  grid_ = std::move(body.grid);
  return std::move(body.mesh);
}

void Refinement::plan(const Mesh& mesh, std::span<const std::uint8_t> constrained,
                      const ErrorEstimate& estimate, double target) {
  if (const auto swept = options_.is_file ? swept_layers(mesh) : std::nullopt)
    sizes_ = refined_swept_sizes(
        mesh, *swept, interval_errors(mesh, constrained, estimate, swept->intervals()), target);
  else if (options_.is_file)
    sizes_ = refined_sizes(mesh, element_errors(mesh, constrained, estimate), target);
  else
    next_grid_ = refined(
        grid_, interval_errors(mesh, constrained, estimate, grid_.first_interval(3)), target,
        round_ > 0 ? 1 : 2); // coarsens by 2 only once, since later this would undo the previous
                             // round
}

MeshSize Refinement::planned_size(const Mesh& mesh) const {
  if (options_.is_file)
    return scaled(size_of(mesh), sizes_->elements);
  MeshChoice choice = options_.choice;
  choice.grid = &next_grid_;
  return plan_shape(options_.body, options_.dimensions, profile(), choice).size;
}

void Refinement::give_up(const std::string& reason) {
  const auto worst = std::max_element(errors_.begin(), errors_.end());
  const auto above = std::count_if(errors_.begin(), errors_.end(),
                                   [&](double e) { return e > options_.tolerance; });
  progress_.notify(format("warning: %td of %zu modes have estimated errors above %.2g %%, up to "
                          "%.2g %% (mode %td): ",
                          above, errors_.size(), 100 * options_.tolerance, 100 * *worst,
                          worst - errors_.begin() + 1) +
                   reason);
}

bool Refinement::finished(const Mesh& mesh, std::span<const std::uint8_t> constrained,
                          const ErrorEstimate& estimate) {
  errors_ = estimate.relative;
  if (errors_.empty())
    return true;
  const auto at = std::max_element(errors_.begin(), errors_.end());
  const double worst = *at, tolerance = options_.tolerance;
  progress_.notify(
      format("largest estimated error %.2g %% (mode %td)", 100 * worst, at - errors_.begin() + 1));
  const auto leave = [&](const std::string& reason) {
    give_up(reason);
    return true;
  };
  if (worst <= tolerance || tolerance <= 0)
    return true;
  if (!refines_)
    return leave(options_.is_file && is_volume_mesh(options_.body)
                     ? "a volume mesh cannot be refined"
                 : options_.slepc || !options_.import_values.empty()
                     ? "the mesh of imported modes is not refined; use a smaller --h"
                     : "--h and --layers fix the mesh; without them it is refined");
  if (round_ + 1 >= kMaxRounds)
    return leave("the mesh was refined " + std::to_string(round_) + " times");
  // If the last mesh missed its target, the next target is lower by the same factor.
  if (round_ > 0)
    target_scale_ = std::clamp(target_scale_ * last_target_ / worst, .5, 1.0);
  last_target_ = (worst > 2 * tolerance ? .8 : .9) * tolerance;
  double target = target_scale_ * last_target_;
  const double last = static_cast<double>(mesh.elements.size());
  const double max_unknowns = options_.tolerance_given ? 1e9 : kMaxUnknowns;
  // The last mesh, its matrices and modes stay in memory until the next mesh's modes are found.
  forecast_.keep(bytes_of_results(size_of(mesh), static_cast<double>(options_.modes)));
  for (plan(mesh, constrained, estimate, target);; plan(mesh, constrained, estimate, target)) {
    const MeshSize size = planned_size(mesh);
    const std::string over_budget = forecast_.over_budget(size);
    if (over_budget.empty() && size.dofs() <= max_unknowns && size.elements <= kMaxGrowth * last)
      break;
    target *= 1.25;
    if (target > .8 * worst)
      return leave(!over_budget.empty()
                       ? over_budget
                       : format("a finer mesh would have about %.0f unknowns (allow them with "
                                "--tolerance)",
                                size.dofs()));
  }
  ++round_;
  return false;
}

} // namespace tactus::fem
