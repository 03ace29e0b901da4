#include "devices/driver.hpp"
#include "devices/hid/hid.hpp"

namespace tactus::devices {
namespace {

std::string problem() {
  std::string reason;
  static_cast<void>(hid::HidLibrary::get(hid::Transport::kAny, reason));
  return reason;
}

std::vector<Found> list() {
  std::vector<Found> found;
  std::string reason;
  hid::HidLibrary* library = hid::HidLibrary::get(hid::Transport::kAny, reason);
  if (!library)
    return found;
  for (const hid::Entry& entry : hid::catalogue(*library))
    found.push_back({"hid", static_cast<int>(found.size()), entry.identity,
                     entry.problem.empty() ? "ready" : entry.problem});
  return found;
}

std::unique_ptr<haptic::Backend> make() { return std::make_unique<hid::Hid>(); }

} // namespace

extern const Driver hid_driver;
const Driver hid_driver{"hid", "SpaceMouse family, joysticks, game pads; no force", problem, list,
                        make};

} // namespace tactus::devices
