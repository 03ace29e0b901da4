#include "programs/haptic_check/stations.hpp"

#include "core/text.hpp"
#include "programs/haptic_check/terminal.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tactus::haptic_check {
namespace {

using haptic::State;

constexpr double kRise_s = 1.2; // a little longer than the motors' rise
constexpr double kHome_s = 60;
constexpr int kHomedPolls = 40; // number of polls, about 5 ms apart

std::string live(const haptic::Report& report) {
  const Vec3 mm = report.state.position * 1e3, f = report.force_n;
  return format("  position %7.1f %7.1f %7.1f mm   force %5.2f %5.2f %5.2f N   buttons %u", mm.x,
                mm.y, mm.z, f.x, f.y, f.z, report.state.buttons);
}

} // namespace

Stations::Stations(Session& session, const Options& options)
    : session_(session), options_(options), caps_(session.device().caps()),
      period_s_(1 / options.rate_hz) {
  const double peak_n = caps_.peak_force_n > 0 ? caps_.peak_force_n : 4;
  force_limit_n_ = std::min(peak_n, options.force_n.value_or(std::clamp(peak_n / 4, 1.0, 3.0)));
  const double limit = caps_.stiffness_limit_n_per_m;
  stiffness_n_per_m_ = limit > 0 ? std::clamp(0.3 * limit, 100.0, 500.0) : 300;
}

std::string Stations::run() {
  std::string error = look();
  if (caps_.axes_out == 0) {
    for (const char* name : {"wall", "sphere", "sine"})
      skip(name, "the device has no motors");
    return error;
  }
  for (auto station : {&Stations::wall, &Stations::sphere, &Stations::sines})
    if (error.empty() && !interrupted())
      error = (this->*station)();
  return error;
}

void Stations::skip(const std::string& name, const std::string& reason) {
  Finding finding;
  finding.name = name;
  finding.lines = {"skipped: " + reason};
  findings_.push_back(finding);
}

/// Moves the simulated hand; does nothing for a real device.
void Stations::move_simulated_hand(const Vec3& from, const Vec3& to, double period_s) {
  if (haptic::SimulatedDevice* device = session_.simulated())
    device->set_path(haptic::LinePath{from, to, period_s});
}

Vec3 Stations::current_position(std::string& error) {
  Session::Plan plan;
  plan.seconds = 0.2;
  plan.period_s = period_s_;
  const Recording recording = session_.run(plan, error);
  if (recording.records.empty() && error.empty())
    error = "the device sends no position: " + recording.trouble;
  return recording.records.empty() ? Vec3{} : recording.records.back().position;
}

std::string Stations::finish(Finding finding, const Recording& recording, bool has_force) {
  finding.ran = true;
  finding.intervals = intervals_of(recording.records, period_s_);
  finding.statistics = recording.statistics;
  finding.scheduling = recording.scheduling;
  if (!recording.trouble.empty())
    finding.lines.push_back("the device reported: " + recording.trouble);
  if (recording.latched)
    finding.lines.emplace_back(
        "the motors were stopped: the device reported a fault or stopped responding");
  if (has_force)
    finding.lines.push_back(
        format("chain: clamped %llu, slewed %llu, watchdog %llu, lowest energy %.3g mJ",
               static_cast<unsigned long long>(recording.counters.clamped),
               static_cast<unsigned long long>(recording.counters.slewed),
               static_cast<unsigned long long>(recording.counters.watchdog_trips),
               1e3 * recording.lowest_energy_j));
  if (recording.lost > 0)
    finding.lines.push_back(
        format("%llu ticks were not recorded: the computer is too busy for this program",
               static_cast<unsigned long long>(recording.lost)));
  for (const std::string& line : finding.lines)
    std::printf("  %s\n", line.c_str());
  finding.answer =
      ask("  Was this correct? Press Enter for yes, or describe what was odd (q to quit):",
          !options_.yes);
  const bool end = finding.answer == "q";
  findings_.push_back(std::move(finding));
  return end ? "ended by the user" : "";
}

std::string Stations::look() {
  std::printf("\n1. Position. The motors stay off. Move the handle to all corners and press each "
              "button.\n");
  static_cast<void>(ask("  Press Enter to begin:", !options_.yes));
  move_simulated_hand({-0.02, -0.01, -0.02}, {0.02, 0.01, 0.02}, 1);
  std::string error;
  Session::Plan plan;
  plan.period_s = period_s_;
  if (caps_.needs_home) {
    plan.seconds = kHome_s;
    plan.line = [this](const haptic::Report&) {
      const std::string trouble = session_.device().trouble();
      return "  " + (trouble.empty() ? std::string("waiting for the device") : trouble);
    };
    int homed_for = 0;
    plan.done = [&homed_for](const haptic::Report& report) {
      homed_for = report.tick.index > 0 && (report.state.flags & State::kHomed) ? homed_for + 1 : 0;
      return homed_for > kHomedPolls;
    };
    const Recording recording = session_.run(plan, error);
    if (!error.empty())
      return error;
    if (homed_for <= kHomedPolls && !interrupted())
      return "the device was not calibrated in time: " + recording.trouble;
  }
  plan.done = {};
  plan.seconds = options_.seconds;
  plan.line = live;
  const Recording recording = session_.run(plan, error);
  if (!error.empty())
    return error;
  if (recording.records.empty())
    return "the device sends no position: " + recording.trouble;
  const Motion motion = motion_of(recording.records);
  const Vec3 low = motion.lowest * 1e3, high = motion.highest * 1e3;
  Finding finding;
  finding.name = "position";
  finding.lines = {
      format("x %.1f..%.1f  y %.1f..%.1f  z %.1f..%.1f mm", low.x, high.x, low.y, high.y, low.z,
             high.z),
      format("largest speed %.2f m/s, smallest step %.4f mm, new readings in %.0f %% of the ticks",
             motion.max_speed_m_per_s, 1e3 * motion.min_step_m, 100 * motion.changed_fraction),
      format("buttons pressed 0x%x, failed readings %llu of %llu", motion.buttons,
             static_cast<unsigned long long>(recording.statistics.device_errors),
             static_cast<unsigned long long>(recording.statistics.ticks))};
  return finish(std::move(finding), recording, false);
}

Session::Plan Stations::with_motors() const {
  Session::Plan plan;
  plan.seconds = kRise_s + options_.seconds;
  plan.period_s = period_s_;
  plan.force_limit_n = force_limit_n_;
  plan.motors = true;
  plan.line = live;
  return plan;
}

haptic::Body Stations::body(const haptic::Shape& shape, const haptic::Pose& pose) {
  haptic::Body made;
  made.key = ++bodies_;
  made.shape = shape;
  made.pose = pose;
  made.material.stiffness_n_per_m = stiffness_n_per_m_;
  return made;
}

std::string Stations::wall() {
  const bool below = caps_.axes_out >= 3;
  std::printf(
      "\n2. Wall. THE MOTORS COME ON, up to %.1f N, rising within a second. Hold the handle, "
      "press it gently %s into a wall %.0f N/m stiff, and slide along it.\n",
      force_limit_n_, below ? "down" : "to the right", stiffness_n_per_m_);
  static_cast<void>(ask("  Hold the handle in the middle, then press Enter:", !options_.yes));
  std::string error;
  move_simulated_hand({}, {}, 1);
  const Vec3 start = current_position(error);
  if (!error.empty() || interrupted())
    return error;
  const Vec3 extent = caps_.workspace_max - caps_.workspace_min;
  const double gap = std::min(0.015, 0.15 * (below ? extent.y : extent.x));
  const Vec3 normal = below ? Vec3{0, 1, 0} : Vec3{-1, 0, 0};
  const Wall face{start - normal * gap, normal};
  move_simulated_hand(start, start - normal * (gap + 0.008), std::max(0.5, options_.seconds / 4));
  Session::Plan plan = with_motors();
  plan.scene.bodies = {body(haptic::Plane{}, {face.point, haptic::Rotation::from_z_to(normal)})};
  const Recording recording = session_.run(plan, error);
  if (!error.empty())
    return error;
  const WallResult result =
      wall_result(recording.records, face, kRise_s, force_limit_n_, period_s_);
  Finding finding;
  finding.name = "wall";
  if (result.ticks == 0)
    finding.lines = {"the wall was not touched"};
  else
    finding.lines = {
        format("%zu hits, %zu ticks in contact, deepest %.2f mm, largest force %.2f N",
               recording.hits, result.ticks, 1e3 * result.max_depth_m, result.max_force_n),
        format("force over depth %.0f N/m of %.0f requested, vibration %.1f um RMS",
               result.stiffness_n_per_m, stiffness_n_per_m_, 1e6 * result.vibration_rms_m)};
  return finish(std::move(finding), recording, true);
}

std::string Stations::sphere() {
  if (caps_.axes_out < 3) {
    skip("sphere", "the device has fewer than three motors");
    return {};
  }
  const Vec3 extent = caps_.workspace_max - caps_.workspace_min;
  const double radius = std::min(0.02, 0.2 * std::min({extent.x, extent.y, extent.z}));
  std::printf(
      "\n3. Sphere. THE MOTORS COME ON, up to %.1f N. A ball of %.0f mm radius lies under the "
      "handle: feel its roundness from all sides.\n",
      force_limit_n_, 1e3 * radius);
  static_cast<void>(ask("  Hold the handle in the middle, then press Enter:", !options_.yes));
  std::string error;
  move_simulated_hand({}, {}, 1);
  const Vec3 start = current_position(error);
  if (!error.empty() || interrupted())
    return error;
  const double gap = std::min(0.008, 0.1 * extent.y);
  const Vec3 centre = start - Vec3{0, radius + gap, 0};
  move_simulated_hand(start, start - Vec3{-0.2 * radius, gap + 0.005, 0},
                      std::max(0.5, options_.seconds / 4));
  Session::Plan plan = with_motors();
  plan.scene.bodies = {body(haptic::Sphere{radius}, {centre, {}})};
  const Recording recording = session_.run(plan, error);
  if (!error.empty())
    return error;
  double max_depth = 0;
  std::vector<double> angles;
  for (const Record& record : recording.records) {
    const Vec3 out = record.position - centre;
    const double force = norm(record.force_n), away = norm(out);
    if (force < 0.05 || away >= radius || away < 0.5 * radius)
      continue;
    max_depth = std::max(max_depth, radius - away);
    const double cosine = dot(record.force_n, out) / (force * away);
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi);
  }
  Finding finding;
  finding.name = "sphere";
  std::sort(angles.begin(), angles.end());
  if (angles.empty())
    finding.lines = {"the ball was not touched"};
  else
    finding.lines = {
        format("%zu hits, %zu ticks in contact, deepest %.2f mm", recording.hits, angles.size(),
               1e3 * max_depth),
        format("angle between force and radius: median %.1f degrees, 95 %% below %.1f degrees,",
               angles[angles.size() / 2], angles[angles.size() * 19 / 20]),
        "including the braking force of the passivity control"};
  return finish(std::move(finding), recording, true);
}

std::string Stations::sines() {
  const double amplitude = std::min(0.5, 0.3 * force_limit_n_);
  std::printf("\n4. Sine. THE MOTORS COME ON. The handle pushes to and fro along x with %.2f N: "
              "slowly, then as a hum, then as a tone. Hold it loosely.\n",
              amplitude);
  static_cast<void>(ask("  Hold the handle in the middle, then press Enter:", !options_.yes));
  move_simulated_hand({}, {}, 1);
  std::vector<double> frequencies;
  const double rate_hz = std::min(options_.rate_hz, caps_.rate_hz);
  for (const double hz : {5.0, 40.0, 150.0})
    if (hz <= rate_hz / 5)
      frequencies.push_back(hz);
  if (frequencies.empty()) {
    skip("sine", "the device accepts too few forces a second");
    return {};
  }
  Session::Plan plan = with_motors();
  const double length = options_.seconds / static_cast<double>(frequencies.size());
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    const double from_s = kRise_s + length * static_cast<double>(i);
    plan.sines.push_back({frequencies[i], amplitude, from_s, from_s + length});
  }
  std::string error;
  const Recording recording = session_.run(plan, error);
  if (!error.empty())
    return error;
  Finding finding;
  finding.name = "sine";
  for (const Sines::Part& part : plan.sines) {
    // Excludes the beginning with its transient and the end with its fade-out.
    const double from_s = part.from_s + Sines::kFade_s + 0.35 * length;
    const double to_s = part.to_s - Sines::kFade_s;
    const auto at = [&](double time_s) {
      return std::lower_bound(recording.records.begin(), recording.records.end(), time_s,
                              [&](const Record& record, double limit_s) {
                                return static_cast<double>(record.index) * period_s_ < limit_s;
                              });
    };
    const auto begin = at(from_s), end = at(to_s);
    const Response response = begin < end
                                  ? response_at({&*begin, static_cast<std::size_t>(end - begin)},
                                                part.frequency_hz, period_s_)
                                  : Response{};
    if (response.force_n > 0)
      finding.lines.push_back(format(
          "%.0f Hz: %.3f N moves the handle %.4f mm, %.4f mm/N, %.0f degrees", part.frequency_hz,
          response.force_n, 1e3 * response.motion_m, 1e3 * response.motion_m / response.force_n,
          response.phase_rad * 180 / std::numbers::pi));
    else
      finding.lines.push_back(
          format("%.0f Hz: the recording is too short to measure", part.frequency_hz));
  }
  return finish(std::move(finding), recording, true);
}

} // namespace tactus::haptic_check
