#include "core/modal/table/loaded_table.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

/// Decay rate of a mode, 1/s, from the table's decay rates or else its loss factors.
double decay_rate_of(const ModalTable& table, std::size_t mode) {
  return table.decay_rate.empty()
             ? std::numbers::pi * table.frequency_hz[mode] * table.loss_factor[mode]
             : table.decay_rate[mode];
}

template <class T> T value_or_zero(const std::vector<T>& values, std::size_t i) {
  return values.empty() ? T{} : values[i];
}

} // namespace

LoadedTable::LoadedTable(ModalTable read) : table(std::move(read)) {
  if (table.triangle.empty())
    return;
  surface.build(table.vertex_m, table.triangle);
  radiating.build(table, surface);
  order_shapes();
}

LoadedTable::LoadedTable(ModalTable solved, const LoadedTable& before,
                         std::vector<ModeShare> shares)
    : LoadedTable(std::move(solved)) {
  share = std::move(shares);
  predecessor_ = before.serial_;
}

LoadedTable::LoadedTable(const std::shared_ptr<const LoadedTable>& body, const LoadedTable& before)
    : LoadedTable(body, before.parts[kBoard].loaded, before.parts[kBoard].displacement_m) {
  const auto number = [](std::size_t mode) { return static_cast<std::uint32_t>(mode); };
  for (const ModeShare& s : body->share)
    share.push_back(
        {number(before.parts[0].mode[s.before]), number(parts[0].mode[s.now]), s.share});
  for (std::size_t k = 0; k < parts[kBoard].mode.size(); ++k)
    share.push_back({number(before.parts[kBoard].mode[k]), number(parts[kBoard].mode[k]), 1});
  predecessor_ = before.serial_;
}

std::uint64_t LoadedTable::next_serial() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

void LoadedTable::order_shapes() {
  const std::size_t modes = table.modes(), vertices = table.vertices();
  if (table.shape.empty())
    return;
  shape.resize(table.shape.size());
  constexpr std::size_t kTile = 32; // both sides of a tile stay in the cache
  for (std::size_t k0 = 0; k0 < modes; k0 += kTile)
    for (std::size_t v0 = 0; v0 < vertices; v0 += kTile)
      for (std::size_t k = k0; k < std::min(k0 + kTile, modes); ++k)
        for (std::size_t v = v0; v < std::min(v0 + kTile, vertices); ++v)
          std::copy_n(table.shape.data() + (k * vertices + v) * 3, 3,
                      shape.data() + (v * modes + k) * 3);
  table.shape = {};
}

std::string LoadedTable::refusal(const LoadedTable& body, const LoadedTable& board) {
  if (board.shape.empty())
    return "the table has no mode shapes: expected one with phi, xyz and tri";
  if (body.shape.empty())
    return "the body's own table has no mode shapes: expected one with phi, xyz and tri";
  if (board.table.free)
    return "the body of this table has no supports (bc \"" + board.table.boundary +
           "\"): expected the modes of a supported board";
  if (const std::size_t modes = body.table.modes() + board.table.modes(); modes > kMaxModes)
    return std::to_string(modes) + " modes of body and board: expected at most " +
           std::to_string(kMaxModes);
  return {};
}

LoadedTable::LoadedTable(std::shared_ptr<const LoadedTable> body,
                         std::shared_ptr<const LoadedTable> board, const Vec3& displacement_m) {
  const std::array<const ModalTable*, 2> own{&body->table, &board->table};
  parts.resize(2);
  parts[0].loaded = std::move(body);
  parts[1] = {std::move(board), displacement_m, own[0]->vertices(), own[0]->triangle.size(), {}};
  table.mass_kg = own[0]->mass_kg;
  table.centre_of_mass_m = own[0]->centre_of_mass_m;
  table.inertia_kg_m2 = own[0]->inertia_kg_m2;
  table.free = own[0]->free;
  table.body_name = own[0]->body_name;
  table.boundary = own[0]->boundary;
  table.material = own[0]->material;
  table.air_density_kg_per_m3 = own[0]->air_density_kg_per_m3;
  table.sound_speed_m_per_s = own[0]->sound_speed_m_per_s;

  std::vector<std::pair<double, std::pair<std::size_t, std::size_t>>> order; // Hz, part, mode
  for (std::size_t p = 0; p < 2; ++p) {
    parts[p].mode.resize(own[p]->modes());
    for (std::size_t k = 0; k < own[p]->modes(); ++k)
      order.push_back({own[p]->frequency_hz[k], {p, k}});
  }
  std::sort(order.begin(), order.end());
  for (const auto& [frequency, source] : order) {
    const auto [p, k] = source;
    parts[p].mode[k] = table.frequency_hz.size();
    part_of_mode.push_back(static_cast<std::uint8_t>(p));
    table.frequency_hz.push_back(frequency);
    table.decay_rate.push_back(decay_rate_of(*own[p], k));
    table.radiation_decay_rate.push_back(value_or_zero(own[p]->radiation_decay_rate, k));
    table.poisson_slope.push_back(value_or_zero(own[p]->poisson_slope, k));
  }
  for (std::size_t p = 0; p < 2; ++p) {
    const auto first = static_cast<std::int32_t>(parts[p].first_vertex);
    for (std::size_t v = 0; v < own[p]->vertices(); ++v) {
      table.vertex_m.push_back(own[p]->vertex_m[v] + parts[p].displacement_m);
      table.residual_compliance.push_back(value_or_zero(own[p]->residual_compliance, v));
    }
    for (const auto& t : own[p]->triangle)
      table.triangle.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  const std::size_t modes = table.modes();
  if (const ShapeSensitivity& of_body = own[0]->sensitivity; !of_body.empty()) {
    table.sensitivity.shape = of_body.shape;
    table.sensitivity.solved_at_m = of_body.solved_at_m;
    table.sensitivity.eigenvalue_slope.assign(of_body.parameters() * modes, 0);
    for (std::size_t p = 0; p < of_body.parameters(); ++p)
      for (std::size_t k = 0; k < own[0]->modes(); ++k)
        table.sensitivity.eigenvalue_slope[p * modes + parts[0].mode[k]] =
            of_body.eigenvalue_slope[p * own[0]->modes() + k];
  }
  shape.assign(table.vertices() * modes * 3, 0);
  for (const Part& part : parts)
    for (std::size_t v = 0; v < part.loaded->table.vertices(); ++v)
      for (std::size_t k = 0; k < part.mode.size(); ++k)
        std::copy_n(part.loaded->shape.data() + (v * part.mode.size() + k) * 3, 3,
                    shape.data() + ((part.first_vertex + v) * modes + part.mode[k]) * 3);
  surface.build(table.vertex_m, table.triangle);
}

SurfacePoint LoadedTable::nearest_on(std::size_t part, const Vec3& point_m) const noexcept {
  if (parts.empty())
    return surface.nearest(point_m);
  const Part& p = parts[part];
  SurfacePoint point = p.loaded->surface.nearest(point_m - p.displacement_m);
  point.position += p.displacement_m;
  point.triangle += p.first_triangle;
  return point;
}

} // namespace tactus::modal
