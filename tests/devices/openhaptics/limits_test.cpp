#include "devices/openhaptics/limits.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <vector>

using namespace tactus;
using namespace tactus::devices::openhaptics;

namespace {

// What the stand-in answers: figures by value, boxes by value, and errors that wait.
std::map<Code, double> figures;
std::map<Code, std::vector<double>> boxes;
std::deque<Code> errors;
int axes = 3;

/// A library whose every figure is refused that has not been set above.
struct Library : HdLibrary {
  Library() {
    figures.clear();
    boxes.clear();
    errors.clear();
    axes = 3;
    get_doubles = [](Code value, double* answer) {
      if (figures.count(value))
        *answer = figures[value];
      else if (boxes.count(value))
        std::copy(boxes[value].begin(), boxes[value].end(), answer);
      else
        errors.push_back(0x0100);
    };
    get_integers = [](Code, int* answer) { *answer = axes; };
    get_error = [] {
      ErrorInfo error;
      if (!errors.empty()) {
        error.code = errors.front();
        errors.pop_front();
      }
      return error;
    };
  }
};

} // namespace

TEST_CASE("each model has CHAI3D's limits and the continuous force of its data sheet") {
  struct Row {
    const char* name;
    double peak, continuous, stiffness, damping, radius;
  };
  for (const Row& row :
       {Row{"PHANTOM Premium 3.0", 22, 3, 1000, 5, 0.25},
        Row{"PHANTOM Premium 1.5", 8.5, 1.4, 800, 5, 0.12},
        Row{"PHANTOM Desktop", 7.9, 1.75, 1000, 5, 0.10},
        Row{"PHANTOM OMNI", 3.3, 0.88, 700, 5, 0.10}, Row{"Touch X", 3.3, 0.88, 400, 4, 0.075},
        Row{"something new", 3.3, 0.88, 400, 4, 0.075}, Row{"", 3.3, 0.88, 400, 4, 0.075}}) {
    CAPTURE(row.name);
    const haptic::Caps caps = table_caps(row.name);
    CHECK(caps.peak_force_n == row.peak);
    CHECK(caps.continuous_force_n == row.continuous);
    CHECK(caps.stiffness_limit_n_per_m == row.stiffness);
    CHECK(caps.damping_limit_n_s_per_m == row.damping);
    CHECK(caps.workspace_min == Vec3{-1, -1, -1} * row.radius);
    CHECK(caps.workspace_max == Vec3{1, 1, 1} * row.radius);
    CHECK(caps.peak_torque_n_m == 0);
    CHECK(caps.has_velocity);
    CHECK(caps.has_buttons);
    CHECK(caps.needs_home);
    CHECK(caps.has_rotation);
    // Half a step of 450 an inch.
    CHECK(caps.position_noise_m == doctest::Approx(28.2e-6).epsilon(1e-3));
  }
}

TEST_CASE("a figure of the device counts, in its unit, within what such devices can be") {
  struct Figure {
    Code value;
    double haptic::Caps::*cap;
    double scale, least, most, otherwise; // of the library's unit; of ours
  };
  const haptic::Caps omni = table_caps("omni");
  for (const Figure& f :
       {Figure{kNominalMaxForce, &haptic::Caps::peak_force_n, 1, 0.1, 40, omni.peak_force_n},
        Figure{kNominalMaxStiffness, &haptic::Caps::stiffness_limit_n_per_m, 1e3, 50, 1e4,
               omni.stiffness_limit_n_per_m},
        Figure{kNominalMaxDamping, &haptic::Caps::damping_limit_n_s_per_m, 1e3, 0.1, 100,
               omni.damping_limit_n_s_per_m}}) {
    CAPTURE(f.value);
    const Library asked;
    CHECK(device_caps(asked, "omni").*f.cap == f.otherwise); // refused
    for (const double within : {1.01 * f.least, 0.99 * f.most}) {
      figures[f.value] = within / f.scale;
      CHECK(device_caps(asked, "omni").*f.cap == doctest::Approx(within));
    }
    for (const double beyond : {0.99 * f.least, 1.01 * f.most, 0.0, -1.0, double(NAN)}) {
      figures[f.value] = beyond / f.scale;
      CHECK(device_caps(asked, "omni").*f.cap == f.otherwise);
    }
  }
  // The continuous force: 0.05 to 40 N, and no more than the peak.
  const Library asked;
  figures[kNominalMaxForce] = 6;
  for (const auto& [answer, expected] :
       {std::pair{0.06, 0.06}, {5.9, 5.9}, {7.0, 6.0}, {0.04, 0.88}, {41.0, 0.88}}) {
    figures[kNominalMaxContinuousForce] = answer;
    CHECK(device_caps(asked, "omni").continuous_force_n == expected);
  }
}

TEST_CASE("only a device of six motors has torque: its own figure, else CHAI3D's") {
  const Library asked;
  figures[kNominalMaxTorque] = 300; // mN m
  CHECK(device_caps(asked, "premium").peak_torque_n_m == 0);
  axes = 6;
  CHECK(device_caps(asked, "premium").peak_torque_n_m == doctest::Approx(0.3));
  for (const auto& [answer, expected] :
       {std::pair{9.0, 0.188}, {11.0, 0.011}, {990.0, 0.99}, {1010.0, 0.188}}) {
    figures[kNominalMaxTorque] = answer;
    CHECK(device_caps(asked, "premium").peak_torque_n_m == doctest::Approx(expected));
  }
}

TEST_CASE("the workspace is the box of dependable force, else the whole one, else the table's") {
  const Library asked;
  const haptic::Caps table = table_caps("omni");
  CHECK(device_caps(asked, "omni").workspace_min == table.workspace_min);
  boxes[kMaxWorkspace] = {-210, -110, -85, 210, 205, 130};
  haptic::Caps caps = device_caps(asked, "omni");
  CHECK(norm(caps.workspace_min - Vec3{-0.21, -0.11, -0.085}) < 1e-12);
  CHECK(norm(caps.workspace_max - Vec3{0.21, 0.205, 0.13}) < 1e-12);
  boxes[kUsableWorkspace] = {-80, -60, -35, 80, 60, 35};
  caps = device_caps(asked, "omni");
  CHECK(norm(caps.workspace_max - Vec3{0.08, 0.06, 0.035}) < 1e-12);
  // What is no box: flat, turned round, larger than any device, not a number.
  for (const std::vector<double>& wrong : {std::vector<double>{-80, -60, -35, 80, 60, -34},
                                           {80, -60, -35, -80, 60, 35},
                                           {-80, -60, -35, 80, 2001, 35},
                                           {-2001, -60, -35, 80, 60, 35},
                                           {-80, NAN, -35, 80, 60, 35}}) {
    boxes[kUsableWorkspace] = wrong;
    CHECK(norm(device_caps(asked, "omni").workspace_max - Vec3{0.21, 0.205, 0.13}) < 1e-12);
  }
  boxes[kUsableWorkspace] = {-1999, -60, -35, 1999, 60, -33.9}; // just one
  CHECK(norm(device_caps(asked, "omni").workspace_max - Vec3{1.999, 0.06, -0.0339}) < 1e-12);
}

TEST_CASE("of several errors the most serious is reported, warm motors beside it") {
  const Library asked;
  const auto worst = [&](std::deque<Code> piled, bool* warm = nullptr) {
    errors = std::move(piled);
    const Code code = asked.take_errors(warm);
    CHECK(errors.empty());
    return code;
  };
  CHECK(worst({}) == kSuccess);
  // A silent or faulty device before what switches force off, before heat, before too much force.
  CHECK(worst({kTooMuchForce, kWarmMotors}) == kWarmMotors);
  CHECK(worst({kWarmMotors, kTooMuchForce}) == kWarmMotors);
  for (const Code off : {kTooMuchImpulse, kTooMuchVelocity, kForceError, kTimerError}) {
    CHECK(worst({kWarmMotors, off, kTooMuchForce}) == off);
    for (const Code dead : {kNoAnswer, kDeviceFault}) {
      CHECK(worst({off, dead}) == dead);
      CHECK(worst({dead, off}) == dead);
    }
  }
  CHECK(worst({kForceError, kTooMuchVelocity}) == kForceError); // the first of equals
  bool warm = false;
  CHECK(worst({kTooMuchForce, kNoAnswer}, &warm) == kNoAnswer);
  CHECK_FALSE(warm);
  CHECK(worst({kWarmMotors, kNoAnswer}, &warm) == kNoAnswer);
  CHECK(warm);
  // A pile that never ends is left: 32 of it are looked at.
  errors.assign(1000, kForceError);
  CHECK(asked.take_errors() == kForceError);
  CHECK(errors.size() == 1000 - 32);
}
