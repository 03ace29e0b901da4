#include "programs/haptic_check/report.hpp"

#include "core/text.hpp"
#include "devices/driver.hpp"

#include <algorithm>
#include <cstdio>
#include <thread>

#ifndef _WIN32
#include <sys/utsname.h>
#endif

namespace tactus::haptic_check {
namespace {

/// Adds a limit of the device; 0 means that the device does not state the limit.
void add_limit(std::string& text, const char* name, const char* unit, int digits, double limit) {
  if (limit > 0)
    text += format("%s %.*f %s", name, digits, limit, unit);
  else
    text += format("%s not stated", name);
}

std::string machine() {
  std::string text = "tactus " TACTUS_VERSION;
#ifndef _WIN32
  utsname name{};
  if (uname(&name) == 0)
    text += std::string(", ") + name.sysname + " " + name.release + ", " + name.machine;
#endif
  return text + ", " + std::to_string(std::thread::hardware_concurrency()) + " processors";
}

void add_loop(std::string& text, const Finding& finding) {
  if (!finding.ran || finding.intervals.number == 0)
    return;
  const Intervals& all = finding.intervals;
  const auto& late = finding.statistics.lateness;
  const auto& work = finding.statistics.work;
  text += format(
      "  loop: %s, %.1f Hz, interval +- %.0f us, longest %.2f ms, overruns %llu, skipped %llu\n",
      finding.scheduling.c_str(), 1 / all.mean_s, 1e6 * all.deviation_s, 1e3 * all.max_s,
      static_cast<unsigned long long>(finding.statistics.overruns),
      static_cast<unsigned long long>(finding.statistics.skipped));
  text += format("  late p50 %.0f p99 %.0f max %.0f us; work p50 %.0f p99 %.0f max %.0f us\n",
                 1e6 * late.quantile_s(0.5), 1e6 * late.quantile_s(0.99), 1e6 * late.max_s(),
                 1e6 * work.quantile_s(0.5), 1e6 * work.quantile_s(0.99), 1e6 * work.max_s());
}

void add_histogram(std::string& text, const std::vector<Finding>& findings) {
  std::array<std::size_t, Intervals::kEdges_s.size()> counts{};
  std::size_t total = 0;
  for (const Finding& finding : findings)
    for (std::size_t i = 0; i < counts.size(); ++i) {
      counts[i] += finding.intervals.counts[i];
      total += finding.intervals.counts[i];
    }
  if (total == 0)
    return;
  text += "\n[jitter] deviation of an interval from the period, all stations\n";
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double share = static_cast<double>(counts[i]) / static_cast<double>(total);
    const bool last = i + 1 == counts.size();
    const double edge_us = 1e6 * Intervals::kEdges_s[last ? i - 1 : i];
    text +=
        format("  %s %5.0f us %9zu %6.2f %% ", last ? ">=" : " <", edge_us, counts[i], 100 * share);
    text += std::string(static_cast<std::size_t>(40 * share + 0.5), '#') + "\n";
  }
}

} // namespace

std::vector<std::string> inventory() {
  std::vector<std::string> lines = {"sim: a simulated handle in a simulated hand"};
  for (const devices::Driver* driver : devices::drivers()) {
    const std::string name(driver->name);
    lines.push_back(name + ": " + std::string(driver->summary));
    const std::string problem = driver->problem();
    const auto found = problem.empty() ? driver->list() : std::vector<devices::Found>();
    if (!problem.empty())
      lines.push_back("  not available: " + problem);
    else if (found.empty())
      lines.emplace_back("  none found");
    for (const devices::Found& one : found)
      lines.push_back("  " + name + ":" + std::to_string(one.index) + "  " + one.identity.vendor +
                      (one.identity.vendor.empty() ? "" : " ") + one.identity.model + "  " +
                      one.state);
  }
  return lines;
}

Choice first_ready() {
  for (const devices::Driver* driver : devices::drivers())
    if (driver->problem().empty())
      for (const devices::Found& one : driver->list())
        if (one.state == "ready")
          return {std::string(driver->name), std::to_string(one.index)};
  return {};
}

std::string report(const Options& options, const DeviceDescription& device, double force_limit_n,
                   const std::vector<Finding>& findings, const std::string& error,
                   const std::vector<std::string>& drivers) {
  const auto& [identity, caps] = device;
  std::string text = "haptic_check report\n" + machine() + "\n";
  text += "device: " + options.device.driver + ", " + identity.vendor +
          (identity.vendor.empty() ? "" : " ") + identity.model +
          (identity.serial.empty() ? "" : ", has a serial number") + "\n";
  const Vec3 low = caps.workspace_min * 1e3, high = caps.workspace_max * 1e3;
  text += format("axes %d in, %d out; limits:", caps.axes_in, caps.axes_out);
  add_limit(text, " peak", "N", 2, caps.peak_force_n);
  add_limit(text, ", continuous", "N", 2, caps.continuous_force_n);
  add_limit(text, ", stiffness", "N/m", 0, caps.stiffness_limit_n_per_m);
  add_limit(text, ", damping", "N s/m", 1, caps.damping_limit_n_s_per_m);
  text += "\n";
  text += format("workspace x %.0f..%.0f y %.0f..%.0f z %.0f..%.0f mm; rate %.0f Hz; velocity %s\n",
                 low.x, high.x, low.y, high.y, low.z, high.z, caps.rate_hz,
                 caps.has_velocity ? "measured" : "estimated");
  text += format("requested: %.0f Hz, at most %.2f N, %.1f s for each station\n", options.rate_hz,
                 force_limit_n, options.seconds);
  for (const auto& words : options.device.settings) {
    text += "set:";
    for (const std::string& word : words)
      text += " " + word;
    text += "\n";
  }
  if (!error.empty())
    text += "\nENDED EARLY: " + error + "\n";
  for (const Finding& finding : findings) {
    text += "\n[" + finding.name + "]\n";
    for (const std::string& line : finding.lines)
      text += "  " + line + "\n";
    add_loop(text, finding);
    if (!finding.answer.empty())
      text += "  user: " + finding.answer + "\n";
  }
  add_histogram(text, findings);
  text += "\n[drivers]\n";
  for (const std::string& line : drivers)
    text += "  " + line + "\n";
  return text;
}

} // namespace tactus::haptic_check
