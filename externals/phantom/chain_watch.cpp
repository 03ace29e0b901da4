#include "externals/phantom/chain_watch.hpp"

#include <cstdio>
#include <string>
#include <utility>

namespace tactus::phantom {
namespace {

std::string newtons(double force_n) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g N", force_n);
  return text;
}

} // namespace

bool ChainWatch::watch(const haptic::Report& report, double force_limit_n, std::string_view device,
                       const Reports& reports, Host& host) {
  const auto begins = [&](std::string_view word, bool now, bool& before) {
    if (now == std::exchange(before, now))
      return false;
    reports.send(kStatus, {"status", word, now ? 1.0 : 0.0}, host);
    return now;
  };
  const std::string name(device);
  if (begins("warm", report.derating, warm_))
    host.log(name + ": the motors are warm: force is limited to about " +
             newtons(report.derated_to_n) + " until they cool");
  if (begins("clipped", report.clipping, clipping_) && !std::exchange(clipping_logged_, true))
    host.log(name + ": " + newtons(report.asked_n) + " requested, limited to " +
             newtons(force_limit_n) +
             " (forcemax, or the device's peak); from now on only status clipped reports it");
  begins("braked", report.braking, braking_);
  return begins("frozen", report.frozen, frozen_);
}

} // namespace tactus::phantom
