#include "core/modal/body/body_model.hpp"
#include "core/modal/contact/rest_equilibrium.hpp"

#include <algorithm>
#include <cmath>

/// BodyModel: a body on its board: the contact points, their static loads and their kernels.
namespace tactus::modal {
namespace {

constexpr double kMinAlignment =
    0.1; // |sum of the directions| over their number: below it there is no common upward direction

} // namespace

double BodyModel::shape_scale_of(std::size_t part) const noexcept {
  return part == LoadedTable::kBoard ? board_shape_scale_ : shape_scale;
}

/// The contact force at a point pushes the body inwards. Up is the mean of these directions, so
/// that the weight presses the body onto its points however its axes are turned.
void BodyModel::find_resting_contacts() {
  if (loaded->parts.empty() || settings.rest.point_m.empty())
    return;
  const std::size_t count = settings.rest.point_m.size();
  if (count > RestSettings::kMaxPoints || mode.size() * count > ContactSolver::kMaxWork) {
    resting_refusal = std::to_string(count) + " points for " + std::to_string(mode.size()) +
                      " modes: expected at most " + std::to_string(RestSettings::kMaxPoints) +
                      " points, and " + std::to_string(ContactSolver::kMaxWork) +
                      " modes times points";
    return;
  }
  std::vector<RestingContact> found(count);
  std::vector<RigidGain> rigid;
  Vec3 up{};
  for (std::size_t i = 0; i < count; ++i) {
    RestingContact& rest = found[i];
    rest.on_body = loaded->nearest_on(0, settings.rest.point_m[i] * (1 / settings.size));
    rest.on_board = loaded->nearest_on(LoadedTable::kBoard, rest.on_body.position);
    largest_gap_m = std::max(largest_gap_m, settings.size * rest.on_board.distance);
    rest.direction = -rest.on_body.normal;
    rest.gain.resize(mode.size());
    gains(rest.on_body, -rest.direction, rest.gain);
    gains(rest.on_board, rest.direction, scratch);
    for (std::size_t k = 0; k < mode.size(); ++k)
      rest.gain[k] += scratch[k];
    rest.rigid = rigid_gains(rest.on_body, -rest.direction);
    rigid.push_back(rest.rigid);
    rest.law = settings.rest.law;
    rest.law.compliance_m_per_n =
        residual_compliance(rest.on_body) + residual_compliance(rest.on_board);
    up += rest.direction;
  }
  RigidGain load{};
  if (loaded->table.free && mass_kg > 0 && norm(up) > kMinAlignment * static_cast<double>(count))
    for (int axis = 0; axis < 3; ++axis)
      load[static_cast<std::size_t>(axis)] = -up[axis] / norm(up) * std::sqrt(mass_kg) * kGravity;
  const RestEquilibrium equilibrium(rigid, load,
                                    settings.rest.pressing_n / static_cast<double>(count));
  if (!equilibrium.balanced) {
    resting_refusal = "the body tips over: expected its centre of mass between the points, or a "
                      "pressing force (rest_force)";
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    RestingContact& rest = found[i];
    rest.preload_n = equilibrium.force_n[i];
    constexpr double kMaxIndentation = 1; // m
    if (const double depth = rest.law.penetration(rest.preload_n); !(depth < kMaxIndentation)) {
      resting_refusal = "the layer at a point that carries " + std::to_string(rest.preload_n) +
                        " N is compressed by more than 1 m: expected a larger rest_stiffness";
      return;
    }
  }
  rigid_basis_ = equilibrium.basis;
  resting_contacts = std::move(found);
}

/// A contact force acts on the body and, with the opposite sign, on the board, so its kernels are
/// the sum of those of both.
void BodyModel::make_resting_kernels() {
  std::vector<float> other;
  for (std::size_t i = 0; i < resting_contacts.size(); ++i) {
    const RestingContact& rest = resting_contacts[i];
    const std::size_t slot = resting_slot() + i;
    build_contact_kernels(slot, rest.on_body, -rest.direction, rest.gain); // modes of both
    for (std::size_t l = 0; l < settings.listeners; ++l) {
      if (!direct[l].on_surface())
        continue;
      std::vector<float>& elastic = contact_kernel[slot][l].elastic;
      other.resize(elastic.size());
      direct[l].assemble_moments(surface_gain(rest.on_board, rest.direction), other);
      for (std::size_t n = 0; n < other.size(); ++n)
        elastic[n] += other[n];
    }
  }
}

} // namespace tactus::modal
