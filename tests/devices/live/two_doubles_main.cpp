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

#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

namespace {

using namespace tactus::mock;

} // namespace

int main(int count, char** words) try {
  if (count < 4 || std::strcmp(words[1], "--report") != 0) {
    std::fputs("umockdev-wrapper two_doubles --report FILE PROGRAM ARGUMENTS...\n", stderr);
    return 2;
  }
  const std::string file = words[2];
  UMockdevTestbed* bed = new_test_bed();
  if (!umockdev_in_mock_environment()) {
    std::fputs("two_doubles: start it through umockdev-wrapper\n", stderr);
    return 2;
  }
  int status = 0;
  {
    FalconDouble falcon_double(true);
    MockUsb usb(bed, falcon_description(), falcon_double);
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
            falcon_double.report(file);
        },
        true);
    falcon_double.report(file);
  }
  g_object_unref(bed);
  return status;
} catch (const std::exception& error) {
  std::fprintf(stderr, "two_doubles: %s\n", error.what());
  return 2;
}
