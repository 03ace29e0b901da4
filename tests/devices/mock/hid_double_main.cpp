// hid_double: runs a program in a world where a HID device is plugged in.
//
//   umockdev-wrapper hid_double [--libusb] [--stdin] navigator|compact|pad PROGRAM ARGUMENTS...
//
// The device is a hidraw node or, with --libusb, a USB device. The program may send the commands of
// hid_double.hpp, unplug and plug, and with --stdin so may who started it; TACTUS_DOUBLE_KIND and
// TACTUS_DOUBLE_TRANSPORT in its environment say what it will find. Exit status: the program's.
#include "tests/devices/mock/child.hpp"
#include "tests/devices/mock/hid_double.hpp"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

namespace {

int usage() {
  std::fputs("umockdev-wrapper hid_double [--libusb] [--stdin] navigator|compact|pad PROGRAM "
             "ARGUMENTS...\n",
             stderr);
  return 2;
}

template <class Double>
int run(UMockdevTestbed* bed, const std::string& kind, char** arguments, bool from_stdin) {
  Double device(bed, kind == "pad"       ? tactus::mock::game_pad()
                     : kind == "compact" ? tactus::mock::space_mouse_compact()
                                         : tactus::mock::space_navigator());
  return tactus::mock::run_child(
      arguments, [&](const std::string& line) { return device.command(line); }, [] {}, from_stdin);
}

} // namespace

int main(int count, char** words) try {
  int at = 1;
  const auto option = [&](const char* name) {
    const bool given = at < count && std::string(words[at]) == name;
    at += given;
    return given;
  };
  const bool libusb = option("--libusb"), from_stdin = option("--stdin");
  if (at + 1 >= count)
    return usage();
  const std::string kind = words[at++];
  if (kind != "navigator" && kind != "compact" && kind != "pad")
    return usage();
  setenv("TACTUS_DOUBLE_KIND", kind.c_str(), 1);
  setenv("TACTUS_DOUBLE_TRANSPORT", libusb ? "libusb" : "hidraw", 1);
  UMockdevTestbed* bed = tactus::mock::new_test_bed();
  if (!umockdev_in_mock_environment()) {
    std::fputs("hid_double: start it through umockdev-wrapper\n", stderr);
    return 2;
  }
  const int status = libusb ? run<tactus::mock::UsbHidDouble>(bed, kind, words + at, from_stdin)
                            : run<tactus::mock::HidrawDouble>(bed, kind, words + at, from_stdin);
  g_object_unref(bed);
  return status;
} catch (const std::exception& error) {
  std::fprintf(stderr, "hid_double: %s\n", error.what());
  return 2;
}
