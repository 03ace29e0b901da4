#include "core/declaration_text.hpp"
#include "externals/modal_impact~/modal_impact~.hpp"

#include <algorithm>
#include <string>
#include <utility>

/// ModalImpact: messages that change the shape of the body.
namespace tactus::modal {

using namespace modal_impact;

namespace {

constexpr std::size_t kMaxListed = 128; // maximum number of control points that `info` lists

} // namespace

const design::ShapeParameters* ModalImpact::shape_parameters(std::string_view message, Host& host) {
  if (!table_) {
    host.error(std::string(message) + ": no body is loaded: send load NAME first");
    return nullptr;
  }
  const ShapeSensitivity& sensitivity = table_->table.sensitivity;
  if (sensitivity.empty()) {
    host.error(std::string(message) +
               ": this table has no shape parameters: expected one with domega2_dp");
    return nullptr;
  }
  return &sensitivity.shape;
}

std::vector<double> ModalImpact::shape_displacement_m(const design::ShapeParameters& shape) const {
  std::vector<double> displacement = settings_.shape_displacement_m;
  displacement.resize(shape.parameters.size());
  return displacement;
}

void ModalImpact::set_shape(Numbers n, Host& host) {
  const auto* shape = shape_parameters("shape", host);
  if (!shape)
    return;
  if (n.size() != shape->parameters.size())
    return host.error("shape: " + std::to_string(n.size()) + " numbers: expected " +
                      std::to_string(shape->parameters.size()) +
                      ", one for each shape parameter of the table");
  std::vector<double> displacement(n.size());
  for (std::size_t p = 0; p < n.size(); ++p)
    displacement[p] = std::clamp(n[p] * kMillimetre / settings_.size, shape->parameters[p].low_m,
                                 shape->parameters[p].high_m);
  deform(std::move(displacement), *shape, host);
}

void ModalImpact::set_control_point(Numbers n, Host& host) {
  const auto* shape = shape_parameters("cp", host);
  if (!shape)
    return;
  if (const std::string refusal =
          control_point_refusal(shape->parameters, shape->control_point_m.size(), n[0]);
      !refusal.empty())
    return host.error("cp: " + refusal);
  const auto point = static_cast<std::size_t>(n[0]);
  std::vector<double> displacement = shape_displacement_m(*shape);
  const Vec3 position = Vec3{n[1], n[2], n[3]} * (kMillimetre / settings_.size);
  displace(shape->parameters, point, position - shape->control_point_m[point], displacement);
  deform(std::move(displacement), *shape, host);
}

void ModalImpact::deform(std::vector<double> displacement, const design::ShapeParameters& shape,
                         Host& host) {
  if (displacement == shape_displacement_m(shape))
    return; // nothing moves
  const std::vector<Vec3> moved = control_point_offsets_m(displacement);
  const auto largest = std::max_element(
      moved.begin(), moved.end(), [](const Vec3& a, const Vec3& b) { return norm(a) < norm(b); });
  const bool beyond = norm(*largest) > shape.trust_m * (1 + 1e-9);
  const bool solves =
      table_->body().table.has_mesh && !solver_unavailable_ && resolve_ == Resolve::kAuto;
  if (!warned_of_trust_ && beyond && !solves) {
    warned_of_trust_ = true;
    host.log("control point " + std::to_string(largest - moved.begin()) + " is moved by " +
             number_text(1000 * norm(*largest)) + " mm, beyond the table's " +
             number_text(1000 * shape.trust_m) +
             " mm: frequencies are extrapolated (reported once)");
  }
  settings_.shape_displacement_m = std::move(displacement);
  rebuild_model();
  shape_moved(beyond, host);
}

void ModalImpact::post_shape(Host& host) const {
  const ShapeSensitivity& sensitivity = table_->table.sensitivity;
  if (sensitivity.empty())
    return;
  const double mm = settings_.size / kMillimetre;
  const design::ShapeParameters& shape = sensitivity.shape;
  const std::vector<double> displacement = shape_displacement_m(shape);
  std::vector<Atom> list{"shape"};
  for (const double d : displacement)
    list.emplace_back(mm * d);
  host.info(list);
  std::size_t listed = 0;
  for (std::size_t c = 0; c < shape.control_point_m.size() && listed < kMaxListed; ++c) {
    if (std::none_of(shape.parameters.begin(), shape.parameters.end(),
                     [c](const design::DesignParameter& p) { return p.control_point == c; }))
      continue;
    ++listed;
    const Vec3 position =
        mm * (shape.control_point_m[c] + displacement_of(shape.parameters, c, displacement));
    host.info({"cp", static_cast<double>(c), position.x, position.y, position.z});
  }
}

} // namespace tactus::modal
