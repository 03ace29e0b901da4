// falcon_double: runs a program in a world where a Novint Falcon is plugged in.
//
//   umockdev-wrapper falcon_double [OPTIONS] PROGRAM ARGUMENTS...
//     --loaded            the firmware is there already
//     --at FRAME COMMAND  that command (falcon_double.hpp) before the given run frame; may be
//     repeated
//     --do COMMAND        at once
//     --report FILE       the last state, name=value a line, at the end and every 100 ms
//     --stdin             commands from standard input, answers on standard output
//
// unplug takes the device off the bus; plug brings it back. Exit status: the program's.
#include "tests/devices/mock/child.hpp"
#include "tests/devices/mock/falcon_double.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>

namespace {

using tactus::mock::FalconDouble;
using tactus::mock::MockUsb;

tactus::mock::UsbDescription falcon() {
  tactus::mock::UsbDescription d;
  d.name = "1-1";
  d.vendor = 0x0403;
  d.product = 0xcb48;
  d.release = 0x0600;
  d.manufacturer = "FTDI";
  d.model = "FALCON HAPTIC";
  d.serial = "DOUBLE01";
  d.configuration = {9,    2, 32, 0, 1,    1, 0,  0x80, 45, 9, 4, 0,    0, 2,  0xff, 0xff,
                     0xff, 2, 7,  5, 0x81, 2, 64, 0,    0,  7, 5, 0x02, 2, 64, 0,    0};
  return d;
}

void report(FalconDouble& falcon_double, const std::string& file) {
  if (file.empty())
    return;
  std::string state = falcon_double.command("state");
  std::replace(state.begin(), state.end(), ' ', '\n');
  const std::string fresh = file + ".new";
  {
    std::ofstream out(fresh);
    out << state << "\n";
  }
  static_cast<void>(std::rename(fresh.c_str(), file.c_str())); // readers never see half a report
}

int usage() {
  std::fputs("umockdev-wrapper falcon_double [--loaded] [--at FRAME COMMAND] [--do COMMAND] "
             "[--report FILE] [--stdin] PROGRAM ARGUMENTS...\n",
             stderr);
  return 2;
}

} // namespace

int main(int count, char** words) try {
  bool loaded = false, from_stdin = false;
  std::string file;
  std::vector<std::pair<long, std::string>> schedule;
  int at = 1;
  for (; at < count && std::strncmp(words[at], "--", 2) == 0; ++at) {
    const std::string option = words[at];
    if (option == "--loaded")
      loaded = true;
    else if (option == "--stdin")
      from_stdin = true;
    else if (option == "--at" && at + 2 < count) {
      schedule.emplace_back(std::atol(words[at + 1]), words[at + 2]);
      at += 2;
    } else if (option == "--do" && at + 1 < count)
      schedule.emplace_back(0, words[++at]);
    else if (option == "--report" && at + 1 < count)
      file = words[++at];
    else
      return usage();
  }
  if (at >= count)
    return usage();

  UMockdevTestbed* bed = umockdev_testbed_new();
  if (!umockdev_in_mock_environment()) {
    std::fputs("falcon_double: start it through umockdev-wrapper\n", stderr);
    return 2;
  }
  FalconDouble falcon_double(loaded);
  int status = 0;
  {
    MockUsb usb(bed, falcon(), falcon_double);
    const auto answer = [&](const std::string& line) -> std::string {
      if (line == "unplug")
        usb.unplug();
      else if (line == "plug")
        usb.plug();
      else
        return falcon_double.command(line);
      return "ok";
    };
    for (const auto& [frame, line] : schedule)
      if (frame > 0)
        falcon_double.schedule(frame, line);
      else if (answer(line) == "?")
        return usage();
    int idle = 0;
    status = tactus::mock::run_child(
        words + at, answer,
        [&] {
          for (const std::string& line : falcon_double.take_requests())
            answer(line);
          if (++idle % 20 == 0)
            report(falcon_double, file);
        },
        from_stdin);
    report(falcon_double, file);
  }
  g_object_unref(bed);
  return status;
} catch (const std::exception& error) {
  std::fprintf(stderr, "falcon_double: %s\n", error.what());
  return 2;
}
