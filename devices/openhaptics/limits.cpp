#include "devices/openhaptics/limits.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace tactus::devices::openhaptics {
namespace {

struct Model {
  std::string_view word; ///< in lower case, found in the model's name
  double peak_force_n, continuous_force_n, stiffness_n_per_m, damping_n_s_per_m, radius_m;
};

// CHAI3D 3.2, CPhantomDevices; the continuous force ("exertable for 24 hours") from the maker's
// specification sheets of the models. The first row whose word is in the model's name applies.
constexpr Model kModels[] = {
    {"premium 3", 22.0, 3.0, 1000.0, 5.0, 0.25}, {"premium", 8.5, 1.4, 800.0, 5.0, 0.12},
    {"desktop", 7.9, 1.75, 1000.0, 5.0, 0.10},   {"omni", 3.3, 0.88, 700.0, 5.0, 0.10},
    {"touch", 3.3, 0.88, 400.0, 4.0, 0.075},
};
constexpr Model kUnknown{"", 3.3, 0.88, 400.0, 4.0, 0.075};

// For the Premium models with six motors; CHAI3D's value.
constexpr double kTorque_n_m = 0.188;

// A position step at 450 steps per inch, the coarsest of the family.
constexpr double kStep_m = 0.0254 / 450;

bool contains(std::string_view name, std::string_view word) noexcept {
  return std::search(name.begin(), name.end(), word.begin(), word.end(), [](char a, char b) {
           return std::tolower(static_cast<unsigned char>(a)) == b;
         }) != name.end();
}

/// The device's own value, scaled, if it is plausible for such devices; else the default.
double query_limit(const HdLibrary& library, Code value, double scale, double min_value,
                   double max_value, double fallback) noexcept {
  double answer = 0;
  library.get_doubles(value, &answer);
  answer *= scale;
  const bool refused = library.take_errors() != kSuccess;
  return !refused && answer >= min_value && answer <= max_value ? answer : fallback;
}

bool ask_box(const HdLibrary& library, Code value, haptic::Caps& caps) noexcept {
  constexpr double kLongest_mm = 2000;
  double box[6] = {};
  library.get_doubles(value, box);
  if (library.take_errors() != kSuccess)
    return false;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box[axis], high = box[axis + 3];
    if (!(std::abs(low) < kLongest_mm && std::abs(high) < kLongest_mm && high - low > 1))
      return false;
  }
  caps.workspace_min = Vec3{box[0], box[1], box[2]} * 1e-3;
  caps.workspace_max = Vec3{box[3], box[4], box[5]} * 1e-3;
  return true;
}

} // namespace

haptic::Caps table_caps(std::string_view model) noexcept {
  const auto* found = std::find_if(std::begin(kModels), std::end(kModels),
                                   [&](const Model& one) { return contains(model, one.word); });
  const Model& known = found != std::end(kModels) ? *found : kUnknown;
  haptic::Caps caps;
  caps.peak_force_n = known.peak_force_n;
  caps.continuous_force_n = known.continuous_force_n;
  caps.stiffness_limit_n_per_m = known.stiffness_n_per_m;
  caps.damping_limit_n_s_per_m = known.damping_n_s_per_m;
  caps.workspace_min = Vec3{1, 1, 1} * -known.radius_m;
  caps.workspace_max = Vec3{1, 1, 1} * known.radius_m;
  caps.position_noise_m = kStep_m / 2;
  caps.has_velocity = caps.has_buttons = caps.needs_home = caps.has_rotation = true;
  return caps;
}

haptic::Caps device_caps(const HdLibrary& library, std::string_view model) noexcept {
  haptic::Caps caps = table_caps(model);
  static_cast<void>(library.take_errors());
  caps.peak_force_n = query_limit(library, kNominalMaxForce, 1, 0.1, 40, caps.peak_force_n);
  caps.continuous_force_n =
      std::min(caps.peak_force_n, query_limit(library, kNominalMaxContinuousForce, 1, 0.05, 40,
                                              caps.continuous_force_n));
  caps.stiffness_limit_n_per_m =
      query_limit(library, kNominalMaxStiffness, 1e3, 50, 1e4, caps.stiffness_limit_n_per_m);
  caps.damping_limit_n_s_per_m =
      query_limit(library, kNominalMaxDamping, 1e3, 0.1, 100, caps.damping_limit_n_s_per_m);
  int axes = 0;
  library.get_integers(kOutputAxes, &axes);
  if (library.take_errors() == kSuccess && axes == 6)
    caps.peak_torque_n_m = query_limit(library, kNominalMaxTorque, 1e-3, 0.01, 1, kTorque_n_m);
  if (!ask_box(library, kUsableWorkspace, caps))
    ask_box(library, kMaxWorkspace, caps);
  return caps;
}

} // namespace tactus::devices::openhaptics
