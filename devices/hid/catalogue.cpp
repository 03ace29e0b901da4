#include "devices/hid/catalogue.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#ifndef _WIN32
#include <unistd.h>
#endif

namespace tactus::devices::hid {
namespace {

constexpr std::uint16_t kLogitech = 0x046d, k3dconnexion = 0x256f;
// docs/devices/hid.md names them. 3Dconnexion's mice and keyboards (c650..c658, c664, c665, c668)
// are not here.
constexpr std::array<std::uint16_t, 11> kOfLogitech{0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625,
                                                    0xc626, 0xc627, 0xc628, 0xc629, 0xc62b};
constexpr std::array<std::uint16_t, 11> kOf3dconnexion{
    0xc62e, 0xc62f, 0xc631, 0xc632, 0xc633, 0xc635, 0xc636, 0xc638, 0xc63a, 0xc641, 0xc652};

template <std::size_t N>
bool among(const std::array<std::uint16_t, N>& ids, std::uint16_t id) noexcept {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

// Names are wide characters; characters outside ASCII become question marks.
std::string narrow(const wchar_t* text) {
  std::string result;
  for (; text && *text; ++text)
    result += *text >= 32 && *text < 127 ? static_cast<char>(*text) : '?';
  return result;
}

std::string hexadecimal(std::uint16_t id) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (int shift = 12; shift >= 0; shift -= 4)
    text += kDigits[static_cast<std::size_t>(id >> shift & 15)];
  return text;
}

std::string problem_of(const HidLibrary& library, const std::string& path) {
#ifndef _WIN32
  if (library.hidraw && access(path.c_str(), R_OK | W_OK) != 0)
    return "no permission: install tactus's udev rules and plug the device in again";
#else
  static_cast<void>(library);
  static_cast<void>(path);
#endif
  return {};
}

bool is_usage(const hid_device_info& info, Usage usage) noexcept {
  return info.usage_page == kDesktopPage && info.usage == static_cast<std::uint16_t>(usage);
}

} // namespace

bool is_known_space_mouse(std::uint16_t vendor, std::uint16_t product) noexcept {
  return (vendor == kLogitech && among(kOfLogitech, product)) ||
         (vendor == k3dconnexion && among(kOf3dconnexion, product));
}

bool is_early_space_mouse(std::uint16_t vendor, std::uint16_t product) noexcept {
  constexpr std::array<std::uint16_t, 3> kEarly{0xc603, 0xc606, 0xc640};
  return vendor == kLogitech && among(kEarly, product);
}

std::vector<Entry> catalogue(HidLibrary& library, bool all) {
  std::vector<Entry> entries;
  hid_device_info* list = library.enumerate(0, 0);
  for (const hid_device_info* info = list; info; info = info->next) {
    const bool silent = info->usage_page == 0; // this transport reports no usages
    const bool six = is_usage(*info, Usage::kMultiAxis) ||
                     (silent && is_known_space_mouse(info->vendor_id, info->product_id));
    const bool stick = is_usage(*info, Usage::kJoystick) || is_usage(*info, Usage::kGamepad);
    if (!six && !stick && !all)
      continue;
    const std::string path = info->path ? info->path : "";
    const auto same = std::find_if(entries.begin(), entries.end(),
                                   [&](const Entry& entry) { return entry.path == path; });
    if (same != entries.end()) { // one device with several collections
      same->space_mouse = same->space_mouse || six;
      continue;
    }
    Entry entry;
    entry.path = path;
    entry.vendor = info->vendor_id;
    entry.product = info->product_id;
    entry.identity = {narrow(info->manufacturer_string), narrow(info->product_string),
                      narrow(info->serial_number)};
    if (entry.identity.vendor.empty())
      entry.identity.vendor = hexadecimal(info->vendor_id);
    if (entry.identity.model.empty())
      entry.identity.model = hexadecimal(info->product_id);
    entry.space_mouse = six;
    entry.problem = problem_of(library, path);
    entries.push_back(std::move(entry));
  }
  library.free_enumeration(list);
  std::stable_partition(entries.begin(), entries.end(),
                        [](const Entry& entry) { return entry.space_mouse; });
  return entries;
}

std::optional<ReportDescriptor> describe(HidLibrary& library, hid_device* device,
                                         [[maybe_unused]] const std::string& path) {
  constexpr std::size_t kMaxBytes = 4096; // as the kernel and hidapi allow
  std::vector<std::uint8_t> bytes;
  if (library.get_report_descriptor) {
    bytes.resize(kMaxBytes);
    const int length = library.get_report_descriptor(device, bytes.data(), bytes.size());
    bytes.resize(static_cast<std::size_t>(std::max(length, 0)));
  }
#ifdef __linux__
  if (bytes.empty() && library.hidraw) {
    const std::string name = path.substr(path.rfind('/') + 1);
    std::ifstream in("/sys/class/hidraw/" + name + "/device/report_descriptor", std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
    bytes.resize(std::min(bytes.size(), kMaxBytes));
  }
#endif
  if (bytes.empty())
    return std::nullopt;
  return parse_report_descriptor(bytes);
}

} // namespace tactus::devices::hid
