// falcon_double: runs a program in a world where a Novint Falcon is plugged in.
//
//   umockdev-wrapper falcon_double [OPTIONS] PROGRAM ARGUMENTS...
//     --loaded            the firmware is there already
//     --do COMMAND        that command (falcon_double.hpp) at once; may be repeated
//     --report FILE       the last state, name=value a line, at the end and every 100 ms
//     --stdin             commands from standard input, answers on standard output
//
// unplug takes the device off the bus; plug brings it back. Exit status: the program's.
#include "tests/devices/mock/child.hpp"
#include "tests/devices/mock/falcon_double.hpp"

#include <cstdio>
#include <cstring>
#include <exception>

namespace {

using tactus::mock::FalconDouble;
using tactus::mock::MockUsb;

int usage() {
  std::fputs("umockdev-wrapper falcon_double [--loaded] [--do COMMAND] "
             "[--report FILE] [--stdin] PROGRAM ARGUMENTS...\n",
             stderr);
  return 2;
}

} // namespace

int main(int count, char** words) try {
  bool loaded = false, from_stdin = false;
  std::string file;
  std::vector<std::string> at_once;
  int at = 1;
  for (; at < count && std::strncmp(words[at], "--", 2) == 0; ++at) {
    const std::string option = words[at];
    if (option == "--loaded")
      loaded = true;
    else if (option == "--stdin")
      from_stdin = true;
    else if (option == "--do" && at + 1 < count)
      at_once.emplace_back(words[++at]);
    else if (option == "--report" && at + 1 < count)
      file = words[++at];
    else
      return usage();
  }
  if (at >= count)
    return usage();

  UMockdevTestbed* bed = tactus::mock::new_test_bed();
  if (!umockdev_in_mock_environment()) {
    std::fputs("falcon_double: start it through umockdev-wrapper\n", stderr);
    return 2;
  }
  FalconDouble falcon_double(loaded);
  int status = 0;
  {
    MockUsb usb(bed, tactus::mock::falcon_description(), falcon_double);
    const auto answer = [&](const std::string& line) -> std::string {
      if (line == "unplug")
        usb.unplug();
      else if (line == "plug")
        usb.plug();
      else
        return falcon_double.command(line);
      return "ok";
    };
    for (const std::string& line : at_once)
      if (answer(line) == "?")
        return usage();
    int idle = 0;
    status = tactus::mock::run_child(
        words + at, answer,
        [&] {
          if (++idle % 20 == 0)
            falcon_double.report(file);
        },
        from_stdin);
    falcon_double.report(file);
  }
  g_object_unref(bed);
  return status;
} catch (const std::exception& error) {
  std::fprintf(stderr, "falcon_double: %s\n", error.what());
  return 2;
}
