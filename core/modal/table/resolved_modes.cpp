#include "core/modal/table/resolved_modes.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kRounding = 1e-6;

std::string share_refusal(std::span<const ModeShare> shares, std::size_t before, std::size_t now) {
  std::vector<double> before_sums(before, 0), now_sums(now, 0);
  for (const ModeShare& s : shares) {
    if (s.before >= before || s.now >= now || !(std::abs(s.share) <= 1 + kRounding))
      return "share of mode " + std::to_string(s.before) + " in mode " + std::to_string(s.now) +
             " is " + number_text(s.share) + ": expected -1..1 for modes below " +
             std::to_string(before) + " and " + std::to_string(now);
    before_sums[s.before] += s.share * s.share;
    now_sums[s.now] += s.share * s.share;
  }
  for (const auto* sums : {&before_sums, &now_sums})
    for (const double sum : *sums)
      if (!(sum <= 1 + kRounding))
        return "the squares of a mode's shares sum to " + number_text(sum) + ": expected at most 1";
  return {};
}

/// Maps the spherical waves of a table or its band, coefficients [row][offset[K]]: each new mode
/// gets the sum over its shares of the earlier modes' coefficients.
template <class Waves>
void map_waves(std::span<const ModeShare> shares, std::size_t rows, const Waves& before,
               Waves& now) {
  for (const ModeShare& s : shares)
    now.highest_degree[s.now] =
        std::max(now.highest_degree[s.now], before.highest_degree[s.before]);
  for (const std::int64_t d : now.highest_degree)
    now.offset.push_back(now.offset.back() + (d + 1) * (d + 1));
  const auto total = static_cast<std::size_t>(now.offset.back()),
             total_before = static_cast<std::size_t>(before.offset.back());
  now.coefficients.assign(rows * total, {});
  for (const ModeShare& s : shares) {
    const auto from = static_cast<std::size_t>(before.offset[s.before]),
               count = static_cast<std::size_t>(before.offset[s.before + 1]) - from,
               to = static_cast<std::size_t>(now.offset[s.now]);
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t c = 0; c < count; ++c)
        now.coefficients[row * total + to + c] +=
            static_cast<float>(s.share) * before.coefficients[row * total_before + from + c];
  }
}

void map_radiation(const ModalTable& before, std::span<const ModeShare> shares, ModalTable& now) {
  now.residual_compliance = before.residual_compliance;
  now.raw = before.raw;
  if (!before.radiation_decay_rate.empty()) {
    now.radiation_decay_rate.assign(now.modes(), 0);
    for (const ModeShare& s : shares)
      now.radiation_decay_rate[s.now] += s.share * s.share * before.radiation_decay_rate[s.before];
  }
  const MultipoleTable& old = before.multipoles;
  if (old.empty())
    return;
  MultipoleTable kept;
  kept.scales = old.scales;
  kept.centre = old.centre;
  kept.reference_radius_m = old.reference_radius_m;
  kept.highest_degree.assign(now.modes(), 0);
  kept.offset = {0};
  map_waves(shares, old.scales.size(), old, kept);
  if (!old.band.empty()) {
    kept.band.frequency_hz = old.band.frequency_hz;
    kept.band.highest_degree.assign(now.modes(), 0);
    kept.band.offset = {0};
    map_waves(shares, old.band.frequency_hz.size(), old.band, kept.band);
  }
  now.multipoles = std::move(kept);
}

bool same_parameters(const design::ShapeParameters& a, const design::ShapeParameters& b) {
  return a.control_point_m == b.control_point_m &&
         std::equal(a.parameters.begin(), a.parameters.end(), b.parameters.begin(),
                    b.parameters.end(), [](const auto& p, const auto& q) {
                      return p.control_point == q.control_point && p.axis == q.axis &&
                             p.low_m == q.low_m && p.high_m == q.high_m;
                    });
}

} // namespace

std::uint64_t max_answer_bytes(const ModalTable& before) noexcept {
  const std::uint64_t modes = before.modes() + 64, vertices = before.vertices(),
                      parameters = before.sensitivity.parameters(),
                      points = before.sensitivity.shape.control_point_m.size();
  return (1U << 20) + modes * (16 * modes + 12 * vertices + 8 * parameters + 64) + 16 * vertices +
         12 * before.triangle.size() + 48 * parameters + 24 * points;
}

std::string complete_resolved_modes(const ModalTable& before, ResolvedModes& resolved) {
  const ModalTable& now = resolved.table;
  if (now.vertices() != before.vertices() || now.triangle.size() != before.triangle.size())
    return "the answer's surface has " + std::to_string(now.vertices()) + " vertices and " +
           std::to_string(now.triangle.size()) + " triangles: expected the table's " +
           std::to_string(before.vertices()) + " and " + std::to_string(before.triangle.size());
  if (!same_parameters(now.sensitivity.shape, before.sensitivity.shape) ||
      now.sensitivity.solved_at_m.size() != before.sensitivity.parameters())
    return "the answer has other shape parameters: expected the table's " +
           std::to_string(before.sensitivity.parameters()) + " and their displacements";
  if (std::string refusal = share_refusal(resolved.share, before.modes(), now.modes());
      !refusal.empty())
    return refusal;
  // Quadrilaterals may be cut along their other diagonal now, but positions refer to the triangles
  // of the first table.
  resolved.table.triangle = before.triangle;
  map_radiation(before, resolved.share, resolved.table);
  resolved.table.has_mesh = before.has_mesh;
  return {};
}

} // namespace tactus::modal
