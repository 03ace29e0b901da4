#include "devices/force_dimension/limits.hpp"

#include <algorithm>

namespace tactus::devices::force_dimension {
namespace {

// Forces, torques, stiffness, damping and radius: CHAI3D 3.2, CDeltaDevices; types of the newer
// 3-axis models: the SDK's public bindings. CHAI3D does not list sigma.3, which has the figures of
// sigma.7. No figure of lambda is public; it has the smallest figures of all models with such
// motors.
constexpr Model kModels[] = {
    {33, "omega.3", 12, 5000, 30, 0.075},           {34, "omega.6", 12, 5000, 30, 0.075},
    {36, "omega.6", 12, 5000, 30, 0.075},           {35, "omega.7", 12, 5000, 30, 0.075, 0, 8},
    {37, "omega.7", 12, 5000, 30, 0.075, 0, 8},     {63, "delta.3", 20, 5000, 30, 0.15},
    {64, "delta.6", 20, 5000, 30, 0.15, 0.2},       {206, "sigma.3", 12, 4000, 30, 0.075},
    {106, "sigma.6+", 12, 4000, 30, 0.09, 0.2},     {107, "sigma.6+", 12, 4000, 30, 0.09, 0.2},
    {104, "sigma.7", 12, 4000, 30, 0.075, 0.2, 8},  {105, "sigma.7", 12, 4000, 30, 0.075, 0.2, 8},
    {203, "lambda.3", 12, 4000, 30, 0.075},         {108, "lambda.7", 12, 4000, 30, 0.075, 0.2, 8},
    {109, "lambda.7", 12, 4000, 30, 0.075, 0.2, 8}, {60, "Falcon", 8, 3000, 20, 0.04},
};
constexpr Model kUnknown{0, "unknown", 8, 3000, 20, 0.04};

} // namespace

const Model& model_of(int type, std::string_view name) noexcept {
  const auto* found = std::find_if(std::begin(kModels), std::end(kModels),
                                   [type](const Model& model) { return model.type == type; });
  if (found == std::end(kModels))
    found = std::find_if(std::begin(kModels), std::end(kModels), [name](const Model& model) {
      return name.find(model.name) != std::string_view::npos;
    });
  return found != std::end(kModels) ? *found : kUnknown;
}

haptic::Caps caps_of(const Model& model) noexcept {
  haptic::Caps caps;
  caps.peak_force_n = model.peak_force_n;
  caps.stiffness_limit_n_per_m = model.stiffness_n_per_m;
  caps.damping_limit_n_s_per_m = model.damping_n_s_per_m;
  caps.workspace_min = Vec3{1, 1, 1} * -model.radius_m;
  caps.workspace_max = Vec3{1, 1, 1} * model.radius_m;
  caps.peak_torque_n_m = model.peak_torque_n_m;
  caps.peak_grip_n = model.peak_grip_n;
  caps.position_noise_m = 1e-5;
  caps.has_velocity = true;
  caps.needs_home = true;
  return caps;
}

} // namespace tactus::devices::force_dimension
