#include "programs/modal_fem/forecast.hpp"

#include "fem/io/words.hpp"
#include "fem/modes/dense.hpp"
#include "programs/modal_fem/outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

namespace tactus::fem {
namespace {

constexpr double kLowestAudible = 20, kHighestAudible = 20000;

std::string words_of_length(double metres) {
  return metres < 1e-3 ? format("%.3g um", 1e6 * metres)
         : metres < 1  ? format("%.3g mm", 1e3 * metres)
                       : format("%.4g m", metres);
}

std::string words_of_frequency(double hz) {
  return hz < 1e3 ? format("%.3g Hz", hz) : format("%.3g kHz", hz / 1e3);
}

} // namespace

std::string words_of_inaudible(double lowest_hz, double highest_hz, double largest,
                               bool estimated) {
  const bool high = lowest_hz > kHighestAudible;
  if (!high && !(highest_hz < kLowestAudible))
    return {};
  std::string text = "no mode is audible: the ";
  text += (high ? "first is " : "last is ") + std::string(estimated ? "expected near " : "at ") +
          words_of_frequency(high ? lowest_hz : highest_hz) + ", as the body is " +
          words_of_length(largest) + " long";
  // Frequencies go as 1 / size. Which other unit of length would make the first mode audible?
  struct Unit {
    const char* name;
    double metres;
  };
  constexpr std::array<Unit, 5> kUnits{
      {{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 25.4e-3}, {"m", 1}}};
  std::string better;
  for (const Unit& from : kUnits)
    for (const Unit& to : kUnits) {
      const double scale = to.metres / from.metres, first = lowest_hz / scale;
      if (from.metres != 1e-3 || scale == 1 || first < kLowestAudible ||
          first > kHighestAudible / 4)
        continue;
      better += (better.empty() ? "" : ", ") + std::string("--unit ") + to.name +
                " would make it " + words_of_length(largest * scale) + " and " +
                words_of_frequency(first);
    }
  if (!better.empty())
    text += "; if its lengths are not in mm: " + better;
  return text;
}

Forecast::Forecast(const Order& order, ProgressLine& progress)
    : order_(order), progress_(progress), budget_(order.memory_bytes),
      flops_(dense_flops_per_second()) {}

Workload Forecast::workload(const MeshSize& mesh) const {
  Workload work{.mesh = mesh,
                .modes = static_cast<double>(order_.modes),
                .residual = order_.residual,
                .estimated = !order_.slepc,
                .factor_elsewhere = order_.slepc,
                .flops_per_second = flops_,
                .kept_bytes = kept_bytes_};
  if (order_.radiation) {
    work.acoustic_triangles = static_cast<double>(order_.acoustic_triangles);
    constexpr double kBandSolutions = 42; // of a body of 10 cm; some 65 at most
    work.solutions = work.modes * static_cast<double>(order_.ratios.size()) + kBandSolutions;
  }
  return work;
}

void Forecast::hold(const std::optional<FactorCost>& exact) {
  Budget::Resized resized;
  if (resized_)
    resized = [this](double h) { return workload(resized_(h)); };
  Budget::Fewer fewer;
  if (fewer_)
    fewer = [this](double modes) {
      Workload work = workload(fewer_(modes));
      work.modes = modes;
      return work;
    };
  const std::string body =
      order_.is_file ? std::filesystem::path(order_.body).filename().string() : order_.body;
  budget_.hold(body, workload(size_), resized, fewer, order_.unit, exact);
}

void Forecast::say_odd_size(const Say& say) {
  if (said_ || !(size_.volume > 0))
    return;
  said_ = true;
  const auto tell = [&](const std::string& sentence) {
    if (say)
      say(sentence);
    else
      progress_.say(sentence);
  };
  double speed = 0;
  for (const auto& [region, name] : order_.materials)
    speed = std::max(speed, find_material(name).bar_speed());
  if (!(speed > 0))
    speed = find_material(order_.standard_material).bar_speed();
  const double first = estimated_frequency(size_.box, size_.volume, speed);
  // An estimate is right within a factor of three; modes lie closer than they are numbered.
  const double last = 3 * first * static_cast<double>(order_.modes);
  const double largest = std::max({size_.box.x, size_.box.y, size_.box.z});
  const std::string odd = words_of_inaudible(first / 3 > kHighestAudible ? first : 1e3,
                                             last < kLowestAudible ? last : 1e3, largest, true);
  if (!odd.empty())
    tell("warning: " + odd);
  else if (largest > 20 || largest < 1e-4)
    tell("warning: the body is " + words_of_length(largest) +
         " long; are its lengths in the unit you meant? (--unit um|mm|cm|m|in)");
}

void Forecast::mesh(const MeshSize& size, const std::function<MeshSize(double)>& resized,
                    const std::function<MeshSize(double)>& fewer, const Say& say) {
  size_ = size;
  resized_ = resized;
  fewer_ = fewer;
  say_odd_size(say);
  hold({});
  check_room(order_, size_);
  // Swept: a microsecond a node made. gmsh: 40 us a tetrahedron, Delaunay, optimised, quadratic.
  meshing_s_ = size.nodes_on_planes < 1 ? 4e-5 * size.elements : 1e-6 * size.nodes_made;
}

void Forecast::made(const Mesh& mesh, double) {
  const MeshSize planned = size_;
  size_ = size_of(mesh);
  if (!order_.is_file)
    size_.cells = planned.cells; // of the section: nearer than the equivalent block
  size_.skin_area = planned.skin_area;
  size_.h = planned.h;
  say_odd_size({});
  hold({});
  check_room(order_, size_);
}

std::string Forecast::beyond(const MeshSize& size) const {
  const Cost cost = foretell(workload(size));
  if (cost.bytes <= budget_.bytes())
    return {};
  return "a finer mesh of " + format("%.0f", size.dofs()) + " unknowns would take " +
         words_of_bytes(cost.bytes) + ", expected at most " + words_of_bytes(budget_.bytes()) +
         (order_.memory_bytes > 0 ? " (--memory)"
                                  : ", half of what is free: give more with --memory");
}

std::string Forecast::beyond_here(const FactorCost& cost) const {
  Workload work = workload(size_);
  work.estimated = true;
  work.factor_elsewhere = false;
  const double bytes = foretell(work, cost).bytes;
  return bytes <= budget_.bytes()
             ? std::string()
             : "they need the factor here, which would take " + words_of_bytes(bytes) +
                   ", expected at most " + words_of_bytes(budget_.bytes()) + " (--memory)";
}

void Forecast::factor(const FactorCost& cost) {
  hold(cost);
  const Cost all = foretell(workload(size_), cost);
  factor_s_ = all.factor_seconds;
  progress_.say("about " + words_of_bytes(all.bytes) + " and " + words_of_seconds(all.seconds) +
                format(" ahead (factor: %.3g entries)", cost.entries));
}

} // namespace tactus::fem
