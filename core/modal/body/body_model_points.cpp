#include "core/modal/body/body_model.hpp"

#include <algorithm>
#include <cmath>

/// BodyModel: response to a force at a point of the surface: gains, compliance and contact law.
namespace tactus::modal {

void BodyModel::gains(const SurfacePoint& point, const Vec3& direction,
                      std::span<double> gain) const noexcept {
  const ModalTable& table = loaded->table;
  const std::size_t count = std::min(gain.size(), mode.size());
  if (loaded->shape.empty()) {
    std::fill_n(gain.begin(), count, shape_scale);
    return;
  }
  std::array<const float*, 3> at;
  std::array<std::array<float, 3>, 3> push;
  const double scale = shape_scale_of(loaded->part_of_triangle(point.triangle));
  for (std::size_t i = 0; i < 3; ++i) {
    const auto vertex = static_cast<std::size_t>(table.triangle[point.triangle][i]);
    at[i] = loaded->shape.data() + vertex * table.modes() * 3;
    const Vec3 share = -scale * point.weight[i] * direction;
    push[i] = {static_cast<float>(share.x), static_cast<float>(share.y),
               static_cast<float>(share.z)};
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t first = 3 * mode[k];
    float sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const float* const shape = at[i] + first;
      sum += push[i][0] * shape[0] + push[i][1] * shape[1] + push[i][2] * shape[2];
    }
    gain[k] = static_cast<double>(sum);
  }
}

bool BodyModel::moves_along(const SurfacePoint& point, const Vec3& direction) const noexcept {
  constexpr double kRounding = 1e-5; // rounding of single precision, over the whole motion
  double along = 0, whole = 0;
  for (const std::int32_t vertex : loaded->table.triangle[point.triangle])
    for (std::size_t k = 0; k < loaded->table.modes(); ++k) {
      const float* const shape =
          loaded->shape.data() + 3 * (static_cast<std::size_t>(vertex) * loaded->table.modes() + k);
      const Vec3 motion{shape[0], shape[1], shape[2]};
      along = std::max(along, std::abs(dot(motion, direction)));
      whole = std::max(whole, norm(motion));
    }
  return along > kRounding * whole || whole == 0;
}

std::array<double, ContactSolver::kRigid>
BodyModel::rigid_gains(const SurfacePoint& point, const Vec3& direction) const noexcept {
  std::array<double, ContactSolver::kRigid> gain{};
  const ModalTable& table = loaded->table;
  if (!table.free || !(mass_kg > 0) || loaded->part_of_triangle(point.triangle) != 0)
    return gain;
  const Vec3 push = -direction;
  for (int axis = 0; axis < 3; ++axis)
    gain[static_cast<std::size_t>(axis)] = push[axis] / std::sqrt(mass_kg);
  const auto project = [this](const RigidGain& g) {
    return resting_contacts.empty() ? g : ContactSolver::project(g, rigid_basis_);
  };
  const auto& t = table.inertia_kg_m2;
  if (!(t[0].x > 0))
    return project(gain);
  // With I = L L^T (Cholesky), L^-1 times the moment about the centre acts on unit inertia.
  const double scale = mass_kg / table.mass_kg * settings.size * settings.size;
  const double l00 = std::sqrt(t[0].x * scale), l10 = t[1].x * scale / l00,
               l20 = t[2].x * scale / l00;
  const double square = t[1].y * scale - l10 * l10;
  if (!(square > 0))
    return project(gain);
  const double l11 = std::sqrt(square), l21 = (t[2].y * scale - l20 * l10) / l11;
  const double rest = t[2].z * scale - l20 * l20 - l21 * l21;
  if (!(rest > 0))
    return project(gain);
  const Vec3 turn = cross(settings.size * (point.position - table.centre_of_mass_m), push);
  gain[3] = turn.x / l00;
  gain[4] = (turn.y - l10 * gain[3]) / l11;
  gain[5] = (turn.z - l20 * gain[3] - l21 * gain[4]) / std::sqrt(rest);
  return project(gain);
}

double BodyModel::residual_compliance(const SurfacePoint& point) const noexcept {
  const ModalTable& table = loaded->table;
  if (table.residual_compliance.empty())
    return 0;
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    sum +=
        point.weight[i] *
        static_cast<double>(
            table.residual_compliance[static_cast<std::size_t>(table.triangle[point.triangle][i])]);
  const double modulus = table.material.youngs_modulus_pa;
  const bool as_in_table = loaded->part_of_triangle(point.triangle) != 0 || !(modulus > 0);
  return sum * (as_in_table ? 1 : modulus / youngs_modulus_pa) / settings.size;
}

SurfacePoint BodyModel::nearest(const Vec3& position_m) const noexcept {
  if (loaded->surface.empty())
    return {};
  SurfacePoint point = loaded->surface.nearest(position_m * (1 / settings.size));
  point.distance *= settings.size;
  return point;
}

double BodyModel::modulus_at(const SurfacePoint& point) const noexcept {
  if (loaded->part_of_triangle(point.triangle) == 0) {
    const Material& own = loaded->table.material; // its directions keep their ratios
    return own.orthotropy
               ? own.modulus_along(point.normal) * youngs_modulus_pa / own.youngs_modulus_pa
               : youngs_modulus_pa;
  }
  const double modulus =
      loaded->parts[LoadedTable::kBoard].loaded->table.material.modulus_along(point.normal);
  return modulus > 0 ? modulus : youngs_modulus_pa;
}

double BodyModel::poisson_at(const SurfacePoint& point) const noexcept {
  return loaded->part_of_triangle(point.triangle) == 0
             ? poisson
             : loaded->parts[LoadedTable::kBoard].loaded->table.material.poisson;
}

bool BodyModel::recoils(const SurfacePoint& point) const noexcept {
  return !resting_contacts.empty() && loaded->part_of_triangle(point.triangle) == 0;
}

contact::ImpactLaw BodyModel::impact_law(const Striker& striker, double speed_m_per_s,
                                         const SurfacePoint& point) const noexcept {
  contact::ImpactLaw law{contact::hertz_stiffness(striker.radius_m, striker.youngs_modulus_pa,
                                                  striker.poisson, modulus_at(point),
                                                  poisson_at(point)),
                         1.5, 0};
  if (striker.stiffness > 0) {
    law.stiffness = striker.stiffness;
    law.exponent = striker.exponent;
    law.dissipation_s_per_m = striker.loss_s_per_m;
  }
  if (striker.restitution < 1)
    law.dissipation_s_per_m = contact::dissipation_for(striker.restitution, speed_m_per_s);
  return law;
}

void BodyModel::set_force_point(const ForcePoint& point) noexcept {
  gains(point.point, point.direction, scratch);
  bank.set_gain(0, std::span<const double>(scratch).first(audible_modes));
  for (std::size_t k = 0; k < mode.size(); ++k)
    force_gain[k] = static_cast<float>(scratch[k]);
  force_rigid = recoils(point.point) ? rigid_gains(point.point, point.direction) : RigidGain{};
}

} // namespace tactus::modal
