#include "devices/hid/catalogue.hpp"
#include "devices/hid/hid.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <string>
#include <vector>

using namespace tactus::devices::hid;

namespace {

/// hidapi with these devices; kept here, since its functions carry no context.
std::deque<hid_device_info> devices;
int freed = 0;

struct Library : HidLibrary {
  Library() {
    devices.clear();
    freed = 0;
    enumerate = [](unsigned short vendor, unsigned short product) {
      CHECK(vendor == 0); // all of them
      CHECK(product == 0);
      for (std::size_t i = 0; i + 1 < devices.size(); ++i)
        devices[i].next = &devices[i + 1];
      return devices.empty() ? nullptr : &devices.front();
    };
    free_enumeration = [](hid_device_info* list) {
      ++freed;
      CHECK(list == (devices.empty() ? nullptr : &devices.front()));
    };
  }
};

hid_device_info info(const char* path, unsigned short vendor, unsigned short product,
                     unsigned short page, unsigned short usage) {
  hid_device_info made{};
  made.path = const_cast<char*>(path);
  made.vendor_id = vendor;
  made.product_id = product;
  made.usage_page = page;
  made.usage = usage;
  return made;
}

} // namespace

TEST_CASE("six-axis controllers come first, then joysticks and game pads, and nothing else") {
  Library library;
  devices.push_back(info("keyboard", 1, 1, 1, 6));
  devices.push_back(info("pad", 1, 2, 1, 5));
  devices.push_back(
      info("mouse", 0x46d, 0xc626, 1, 2)); // a known id, but it says that it is a mouse
  devices.push_back(info("six", 1, 3, 1, 8));
  devices.push_back(info("stick", 1, 4, 1, 4));
  devices.push_back(info("vendor's", 1, 5, 0xff00, 8));
  devices.push_back(info("silent navigator", 0x46d, 0xc626, 0, 0));
  devices.push_back(info("silent stranger", 0x46d, 0x1234, 0, 0));
  const auto paths = [](const std::vector<Entry>& entries) {
    std::string all;
    for (const Entry& entry : entries)
      all += entry.path + (entry.space_mouse ? "* " : " ");
    return all;
  };
  CHECK(paths(catalogue(library)) == "six* silent navigator* pad stick ");
  CHECK(freed == 1);
  CHECK(paths(catalogue(library, true)) ==
        "six* silent navigator* keyboard pad mouse stick vendor's silent stranger ");
  CHECK(freed == 2);
  devices.clear();
  CHECK(catalogue(library).empty());
}

TEST_CASE("a device with several collections is one, six-axis when one of them is") {
  for (const bool first : {true, false}) {
    Library library;
    devices.push_back(info("one", 1, 2, 1, first ? 8 : 4));
    devices.push_back(info("other", 1, 2, 1, 5));
    devices.push_back(info("one", 1, 2, 1, first ? 4 : 8));
    const auto entries = catalogue(library);
    REQUIRE(entries.size() == 2);
    CHECK(entries[0].path == "one");
    CHECK(entries[0].space_mouse);
    CHECK_FALSE(entries[1].space_mouse);
  }
}

TEST_CASE("names are ASCII, and the ids in hexadecimal where there is none") {
  Library library;
  devices.push_back(info("a", 0x046d, 0xc62b, 1, 8));
  devices.push_back(info("b", 0x256f, 0x0a9f, 1, 8));
  std::wstring maker = L"3Dconnexion", product = L"Maus \x00e4 \x1f~\x7f!", serial = L" 7";
  devices[1].manufacturer_string = maker.data();
  devices[1].product_string = product.data();
  devices[1].serial_number = serial.data();
  const auto entries = catalogue(library);
  REQUIRE(entries.size() == 2);
  CHECK(entries[0].identity.vendor == "046d");
  CHECK(entries[0].identity.model == "c62b");
  CHECK(entries[0].identity.serial == "");
  CHECK(entries[0].vendor == 0x046d);
  CHECK(entries[0].product == 0xc62b);
  CHECK(entries[1].identity.vendor == "3Dconnexion");
  CHECK(entries[1].identity.model == "Maus ? ?~?!");
  CHECK(entries[1].identity.serial == " 7");
  CHECK(entries[1].product == 0x0a9f);
}

#ifdef __linux__
TEST_CASE("permission is asked of the kernel's files alone") {
  Library library;
  devices.push_back(info("/nowhere/hidraw0", 1, 1, 1, 4));
  CHECK(catalogue(library).at(0).problem == "");
  library.hidraw = true;
  CHECK(catalogue(library).at(0).problem.find("udev") != std::string::npos);
  devices[0].path = const_cast<char*>("/dev/null");
  CHECK(catalogue(library).at(0).problem == "");
}
#endif

TEST_CASE("the six-axis controllers that are known by their ids") { // docs/devices/hid.md
  for (const int id :
       {0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625, 0xc626, 0xc627, 0xc628, 0xc629, 0xc62b}) {
    CHECK(is_known_space_mouse(0x046d, static_cast<std::uint16_t>(id)));
    CHECK_FALSE(is_known_space_mouse(0x256f, static_cast<std::uint16_t>(id)));
  }
  for (const int id :
       {0xc62e, 0xc62f, 0xc631, 0xc632, 0xc633, 0xc635, 0xc636, 0xc638, 0xc63a, 0xc641, 0xc652}) {
    CHECK(is_known_space_mouse(0x256f, static_cast<std::uint16_t>(id)));
    CHECK_FALSE(is_known_space_mouse(0x046d, static_cast<std::uint16_t>(id)));
  }
  int known = 0;
  for (int id = 0; id < 0x10000; ++id)
    known += is_known_space_mouse(0x046d, static_cast<std::uint16_t>(id)) +
             is_known_space_mouse(0x256f, static_cast<std::uint16_t>(id)) +
             is_known_space_mouse(0x046e, static_cast<std::uint16_t>(id));
  CHECK(known == 22);
}

TEST_CASE("a description is what the library says, at most 4096 bytes, or is not there") {
  Library library;
  CHECK_FALSE(describe(library, nullptr, "/dev/hidraw99"));
  static int answer = 0;
  library.get_report_descriptor = [](hid_device*, unsigned char* bytes, std::size_t room) {
    CHECK(room == 4096);
    // A joystick's X axis, 8 bits from 0 to 255 (HID 1.11, section 6.2.2).
    constexpr unsigned char kStick[] = {0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x09, 0x30, 0x15, 0x00,
                                        0x26, 0xff, 0x00, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02, 0xc0};
    if (answer < 0)
      return answer;
    std::copy(std::begin(kStick), std::end(kStick), bytes);
    return static_cast<int>(sizeof kStick);
  };
  CHECK(describe(library, nullptr, "/dev/hidraw99"));
  answer = -1;
  CHECK_FALSE(describe(library, nullptr, "/dev/hidraw99"));
}

TEST_CASE("settings are taken up to the ends of their ranges") {
  Hid device;
  const auto set = [&](std::initializer_list<std::string> words) {
    return device.configure(std::vector<std::string>(words));
  };
  for (const char* taken : {"0", "1000", "12.5"})
    CHECK(set({"speed", taken}) == "");
  for (const char* refused : {"1001", "-0.1", "nan"})
    CHECK(set({"speed", refused}).find("expected 0..1000 mm/s") != std::string::npos);
  for (const char* taken : {"0", "90"})
    CHECK(set({"deadzone", taken}) == "");
  for (const char* refused : {"90.5", "3 %"})
    CHECK(set({"deadzone", refused}).find("0..90 % of full deflection") != std::string::npos);
  for (const char* taken : {"0", "1"})
    CHECK(set({"led", taken}) == "");
  for (const char* refused : {"2", "0.5", "on"})
    CHECK(set({"led", refused}).find("expected 0 or 1") != std::string::npos);
  for (const char* taken : {"any", "hidraw", "libusb"})
    CHECK(set({"transport", taken}) == "");
  CHECK(set({"transport", "pigeon"}).find("expected") != std::string::npos);
  CHECK(set({"mapping", "sideways"}).find("expected") != std::string::npos);
  CHECK(set({"mapping", "rate", "x"}).find("hid: setting mapping: expected") == 0);
  for (const auto& words : {std::vector<std::string>{}, {"speed"}, {"dance", "1"}})
    CHECK(device.configure(words).find("expected") != std::string::npos);
  // As a rate there is no largest error of a reading.
  REQUIRE(set({"mapping", "rate"}) == "");
  CHECK(device.caps().position_noise_m == 0);
  REQUIRE(set({"mapping", "position"}) == "");
  CHECK(device.caps().workspace_min.y == -0.05);
  CHECK(device.caps().workspace_max.z == 0.05);
  CHECK(device.trouble() == "");
  tactus::haptic::State state;
  CHECK_FALSE(device.read({}, state)); // nothing is open
  CHECK_FALSE(device.write({}));
}
