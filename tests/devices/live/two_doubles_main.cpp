// two_doubles: runs a program in a world where a Novint Falcon, its firmware loaded, and a
// SpaceNavigator are plugged in.
//
//   umockdev-wrapper two_doubles --report FILE PROGRAM ARGUMENTS...
//
// Commands from standard input: "falcon COMMAND" and "mouse COMMAND" as the doubles know them, and
// unplug and plug of either. FILE is the Falcon's state, every 100 ms and at the end. Exit status:
// the program's.
#include "tests/devices/mock/child.hpp"
#include "tests/devices/mock/falcon_double.hpp"
#include "tests/devices/mock/hid_double.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>

namespace {

using namespace tactus::mock;

UsbDescription falcon() {
  UsbDescription d;
  d.name = "1-1"; // the SpaceNavigator has 1-2
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
  std::string state = falcon_double.command("state");
  std::replace(state.begin(), state.end(), ' ', '\n');
  const std::string fresh = file + ".new";
  {
    std::ofstream out(fresh);
    out << state << "\n";
  }
  static_cast<void>(std::rename(fresh.c_str(), file.c_str())); // readers never see half a report
}

} // namespace

int main(int count, char** words) try {
  if (count < 4 || std::strcmp(words[1], "--report") != 0) {
    std::fputs("umockdev-wrapper two_doubles --report FILE PROGRAM ARGUMENTS...\n", stderr);
    return 2;
  }
  const std::string file = words[2];
  UMockdevTestbed* bed = umockdev_testbed_new();
  if (!umockdev_in_mock_environment()) {
    std::fputs("two_doubles: start it through umockdev-wrapper\n", stderr);
    return 2;
  }
  int status = 0;
  {
    FalconDouble falcon_double(true);
    MockUsb usb(bed, falcon(), falcon_double);
    HidrawDouble mouse(bed, space_navigator());
    const auto answer = [&](const std::string& line) -> std::string {
      const auto blank = line.find(' ');
      const std::string to = line.substr(0, blank),
                        what = blank == std::string::npos ? "" : line.substr(blank + 1);
      if (to == "mouse")
        return mouse.command(what);
      if (to != "falcon")
        return "?";
      if (what != "unplug" && what != "plug")
        return falcon_double.command(what);
      what == "plug" ? usb.plug() : usb.unplug();
      return "ok";
    };
    int idle = 0;
    status = run_child(
        words + 3, answer,
        [&] {
          if (++idle % 20 == 0)
            report(falcon_double, file);
        },
        true);
    report(falcon_double, file);
  }
  g_object_unref(bed);
  return status;
} catch (const std::exception& error) {
  std::fprintf(stderr, "two_doubles: %s\n", error.what());
  return 2;
}
