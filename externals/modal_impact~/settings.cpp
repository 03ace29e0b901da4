#include "externals/modal_impact~/modal_impact~.hpp"

#include <initializer_list>
#include <string_view>
#include <vector>

/// The answer to `dump` for settings that are messages. Sending these messages back restores the
/// object.
namespace tactus::modal {

using namespace modal_impact;

namespace {

void post(Host& host, std::string_view name, std::initializer_list<Vec3> vectors,
          double unit = kMillimetre) {
  std::vector<Atom> list{name};
  for (const Vec3& v : vectors)
    for (int axis = 0; axis < 3; ++axis)
      list.emplace_back(v[axis] / unit);
  host.info(list);
}

} // namespace

void ModalImpact::post_damping(Host& host) const {
  std::vector<Atom> curve{"damping", "losscurve"};
  switch (settings_.damping) {
  case Damping::kTable:
    return host.info({"damping", "table"});
  case Damping::kLoss:
    return host.info({"damping", "loss", settings_.loss_factor});
  case Damping::kRayleigh:
    return host.info({"damping", "rayleigh", settings_.rayleigh_a_per_s, settings_.rayleigh_b_s});
  case Damping::kCurve:
    for (const auto& [frequency, loss] : settings_.loss_curve) {
      curve.emplace_back(frequency);
      curve.emplace_back(loss);
    }
    return host.info(curve);
  }
}

void ModalImpact::post_settings(Host& host) const {
  post_damping(host);
  const auto& l = settings_.listener;
  post(host, "listener", {l[0], l[1], l[2], l[3]});
  const Striker& s = body_.striker();
  host.info({"striker", s.mass_kg, s.radius_m, s.youngs_modulus_pa, s.poisson});
  host.info({"hardness", s.stiffness, s.exponent, s.loss_s_per_m});
  const Rub rub = body_.rub();
  const contact::FrictionLaw& f = rub.law;
  host.info({"friction", f.static_coefficient, f.dynamic_coefficient, f.stribeck_m_per_s,
             f.breakaway, f.stiffness_n_per_m, f.damping_ns_per_m, f.viscosity_ns_per_m,
             f.roughness});
  if (!normal_)
    host.info({"normal"});
  else
    post(host, "normal", {*normal_}, 1);
  const BodyModel* const model = body_.model();
  if (!model || model->loaded->surface.empty())
    return;
  const double size = model->settings.size;
  post(host, "point", {size * body_.point().position});
  if (!rub.placed) {
    host.info({"rub"});
  } else {
    const Vec3 position = size * rub.point.position;
    host.info({"rub", position.x / kMillimetre, position.y / kMillimetre, position.z / kMillimetre,
               rub.direction.x, rub.direction.y, rub.direction.z});
  }
  if (model->loaded->parts.empty()) {
    host.info({"board", "none"});
  } else {
    const Vec3& d = model->loaded->parts[LoadedTable::kBoard].displacement_m;
    host.info({"board", std::string_view(in_use_.board.name), d.x / kMillimetre, d.y / kMillimetre,
               d.z / kMillimetre});
  }
  std::vector<Atom> rest{"rest"};
  for (const Vec3& p : settings_.rest.point_m)
    for (int axis = 0; axis < 3; ++axis)
      rest.emplace_back(p[axis] / kMillimetre);
  host.info(rest);
}

} // namespace tactus::modal
