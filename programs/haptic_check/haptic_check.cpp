// haptic_check: looks for haptic devices, lets their owner feel one, and writes a report that can
// be pasted into an issue. docs/devices/README.md describes the procedure.
#include "devices/driver.hpp"
#include "programs/haptic_check/report.hpp"
#include "programs/haptic_check/terminal.hpp"

#include <cstdio>
#include <fstream>

namespace {

using namespace tactus;
using namespace tactus::haptic_check;

void print(const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    std::printf("%s\n", line.c_str());
}

/// The simulated device with a simulated hand.
std::unique_ptr<haptic::SimulatedDevice> simulation() {
  auto device = std::make_unique<haptic::SimulatedDevice>();
  haptic::SimulatedDevice::Settings settings;
  settings.hand.hold = haptic::HandSettings::Hold::kSpring;
  device->set(settings);
  return device;
}

int check(const Options& options, const std::vector<std::string>& drivers) {
  std::unique_ptr<haptic::Backend> device;
  haptic::SimulatedDevice* simulated = nullptr;
  if (options.device.driver == "sim") {
    auto made = simulation();
    simulated = made.get();
    device = std::move(made);
  } else if (const devices::Driver* driver = devices::find_driver(options.device.driver)) {
    device = driver->make(); // a setting may be wrong: open() reports it
    if (!device)
      return std::fprintf(stderr, "haptic_check: %s: %s\n", options.device.driver.c_str(),
                          driver->problem().c_str()),
             1;
  }
  if (!device)
    return std::fprintf(stderr, "haptic_check: unknown driver %s; --list shows all\n",
                        options.device.driver.c_str()),
           2;
  programs::DeviceOptions wanted = options.device;
  if (simulated)
    wanted.which.clear(); // there is only one simulated device
  if (const std::string refusal = programs::configure(*device, wanted); !refusal.empty())
    return std::fprintf(stderr, "haptic_check: %s\n", refusal.c_str()), 2;

  Session session(std::move(device), simulated);
  std::printf("Opening %s ", options.device.driver.c_str());
  std::fflush(stdout);
  std::string error = session.open();
  std::printf("%s\n", error.empty() ? "done" : "failed");
  if (!error.empty())
    std::fprintf(stderr, "haptic_check: %s\n", error.c_str());
  const haptic::Identity identity =
      simulated ? haptic::Identity{"", "simulated device", ""} : session.device().identity();
  std::vector<Finding> findings;
  double force_limit_n = 0;
  if (error.empty()) {
    std::printf("Ctrl-C switches the force off and exits. Keep your face away from the handle.\n");
    Stations stations(session, options);
    error = stations.run();
    findings = stations.findings();
    force_limit_n = stations.force_limit_n();
  }
  if (interrupted())
    error = "interrupted";
  const std::string text =
      report(options, {identity, session.device().caps()}, force_limit_n, findings, error, drivers);
  std::ofstream file(options.report);
  file << text;
  file.close();
  std::printf("\n%s\n", text.c_str());
  if (!file)
    return std::fprintf(stderr, "haptic_check: cannot write %s\n", options.report.c_str()), 1;
  std::printf("This report is also in %s; paste it into an issue.\n", options.report.c_str());
  return error.empty() ? 0 : 1;
}

} // namespace

int main(int count, char** words) {
  ParsedOptions parsed = parse_options(count, words);
  if (!parsed.error.empty())
    return std::fprintf(stderr, "haptic_check: %s\n", parsed.error.c_str()), 2;
  Options& options = parsed.options;
  if (options.help)
    return std::printf("%s", usage()), 0;
  programs::listen_for_interrupts(
      "\nhaptic_check: a call of the device's driver does not return; the "
      "program ends without it. Switch the device off and on\n");
  std::printf("Looking for devices\n");
  const std::vector<std::string> drivers = inventory();
  print(drivers);
  if (options.list)
    return 0;
  if (options.device.driver.empty()) {
    const Choice choice = first_ready();
    if (choice.driver.empty())
      return std::fprintf(stderr,
                          "haptic_check: no device is ready; see the remedies above, or try the "
                          "simulated device: --device sim\n"),
             1;
    options.device.driver = choice.driver;
    options.device.which = choice.which;
  }
  return check(options, drivers);
}
