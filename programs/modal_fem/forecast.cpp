#include "programs/modal_fem/forecast.hpp"

#include "fem/io/text.hpp"
#include "fem/modes/dense.hpp"
#include "programs/modal_fem/outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

namespace tactus::fem {
namespace {

constexpr double kMinAudible_hz = 20, kMaxAudible_hz = 20000;

std::string format_frequency(double hz) {
  return hz < 1e3 ? format("%.3g Hz", hz) : format("%.3g kHz", hz / 1e3);
}

} // namespace

std::string inaudible_text(double lowest_hz, double highest_hz, double largest, double unit,
                           bool estimated) {
  const bool high = lowest_hz > kMaxAudible_hz;
  if (!high && !(highest_hz < kMinAudible_hz))
    return {};
  std::string text = "no mode is audible: the ";
  text += (high ? "first is " : "last is ") + std::string(estimated ? "expected near " : "at ") +
          format_frequency(high ? lowest_hz : highest_hz) + ", as the body is " +
          format_length(largest) + " long";
  // Frequencies are proportional to 1 / size. Finds the other units of length that would make the
  // first mode audible.
  std::string better;
  for (const LengthUnit& to : kUnits) {
    const double scale = to.metres / unit, first = lowest_hz / scale;
    if (unit <= 0 || scale == 1 || first < kMinAudible_hz || first > kMaxAudible_hz / 4)
      continue;
    better += (better.empty() ? "" : ", ") + std::string("--unit ") + std::string(to.name) +
              " would make it " + format_length(largest * scale) + " and " +
              format_frequency(first);
  }
  if (!better.empty())
    text += "; if its lengths are not in " + name_of_unit(unit) + ": " + better;
  return text;
}

Forecast::Forecast(const ModalOptions& options, ProgressLine& progress)
    : options_(options), progress_(progress), budget_(options.memory_bytes),
      flops_(dense_flops_per_second()) {}

Workload Forecast::workload(const MeshSize& mesh) const {
  Workload work{.mesh = mesh,
                .modes = static_cast<double>(options_.modes),
                .residual = options_.residual,
                .estimated = !options_.slepc,
                .factor_elsewhere = options_.slepc,
                .flops_per_second = flops_,
                .retained_bytes = retained_bytes_};
  if (options_.radiation) {
    work.acoustic_triangles = static_cast<double>(options_.acoustic_triangles);
    constexpr double kBandSolutions = 42; // number for a body of 10 cm; at most about 65
    work.solutions = work.modes * static_cast<double>(options_.ratios.size()) + kBandSolutions;
  }
  return work;
}

void Forecast::check_budget(const std::optional<FactorCost>& exact) {
  Budget::WithElementSize with_element_size;
  if (with_element_size_)
    with_element_size = [this](double h) { return workload(with_element_size_(h)); };
  Budget::WithModes with_modes;
  if (with_modes_)
    with_modes = [this](double modes) {
      Workload work = workload(with_modes_(modes));
      work.modes = modes;
      return work;
    };
  const std::string body =
      options_.is_file ? std::filesystem::path(options_.body).filename().string() : options_.body;
  budget_.check_budget(body, workload(size_), with_element_size, with_modes, options_.unit, exact);
}

void Forecast::warn_of_unusual_size(const Notify& notify) {
  if (size_warned_ || !(size_.volume > 0))
    return;
  size_warned_ = true;
  const auto tell = [&](const std::string& sentence) {
    if (notify)
      notify(sentence);
    else
      progress_.notify(sentence);
  };
  double speed = 0;
  for (const auto& [region, name] : options_.materials)
    speed = std::max(speed, find_material(name).bar_speed());
  if (!(speed > 0))
    speed = find_material(options_.default_material).bar_speed();
  const double first = estimated_frequency(size_.box, size_.volume, speed);
  // The estimate is accurate within a factor of three. The last mode lies below its number times
  // the first.
  const double last = 3 * first * static_cast<double>(options_.modes);
  const double largest = std::max({size_.box.x, size_.box.y, size_.box.z});
  const double lowest = first / 3 > kMaxAudible_hz ? first : std::min(first, kMaxAudible_hz);
  const std::string odd =
      inaudible_text(lowest, std::max(last, lowest), largest, options_.unit_of_body(), true);
  if (!odd.empty())
    tell("warning: " + odd);
  else
    warn_of_unusual_length(options_, largest, tell);
}

void Forecast::mesh(const MeshSize& size, const std::function<MeshSize(double)>& with_element_size,
                    const std::function<MeshSize(double)>& with_modes, const Notify& notify) {
  size_ = size;
  with_element_size_ = with_element_size;
  with_modes_ = with_modes;
  warn_of_unusual_size(notify);
  check_budget({});
  check_disk_space(options_, size_);
  // A swept shape takes 1 us per node made, gmsh 40 us per tetrahedron (Delaunay, optimised,
  // quadratic).
  meshing_s_ = size.nodes_on_planes < 1 ? 4e-5 * size.elements : 1e-6 * size.nodes_made;
}

void Forecast::made(const Mesh& mesh, double) {
  const MeshSize planned = size_;
  size_ = size_of(mesh);
  if (!options_.is_file)
    size_.cells = planned.cells; // the section's cells, which are nearer than an equivalent block
  size_.skin_area = planned.skin_area;
  size_.h = planned.h;
  warn_of_unusual_size({});
  check_budget({});
  check_disk_space(options_, size_);
}

std::string Forecast::over_budget(const MeshSize& size) const {
  const Cost cost = predict_cost(workload(size));
  if (cost.bytes <= budget_.bytes())
    return {};
  return "a finer mesh of " + format("%.0f", size.dofs()) + " unknowns would take " +
         format_bytes(cost.bytes) + ", expected at most " + format_bytes(budget_.bytes()) +
         (options_.memory_bytes > 0 ? " (--memory)"
                                    : ", half of the free memory: allow more with --memory");
}

std::string Forecast::over_budget_in_process(const FactorCost& cost) const {
  Workload work = workload(size_);
  work.estimated = true;
  work.factor_elsewhere = false;
  const double bytes = predict_cost(work, cost).bytes;
  return bytes <= budget_.bytes() ? std::string()
                                  : "they need a factorisation in this process, which would take " +
                                        format_bytes(bytes) + ", expected at most " +
                                        format_bytes(budget_.bytes()) + " (--memory)";
}

void Forecast::factor(const FactorCost& cost) {
  check_budget(cost);
  const Cost all = predict_cost(workload(size_), cost);
  factor_s_ = all.factor_seconds;
  progress_.notify("about " + format_bytes(all.bytes) + " and " + format_seconds(all.seconds) +
                   format(" needed (factor: %.3g entries)", cost.entries));
}

} // namespace tactus::fem
