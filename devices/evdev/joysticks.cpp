#include "devices/evdev/joysticks.hpp"

#include "core/text.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include <linux/input.h>
#include <unistd.h>

namespace tactus::devices::evdev {
namespace {

std::string first_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

int number_of(const Joystick& joystick) noexcept {
  const auto digits = joystick.node.find_last_not_of("0123456789") + 1;
  return to_number<int>(std::string_view(joystick.node).substr(digits)).value_or(0);
}

} // namespace

bool bit(std::string_view bitmap, unsigned number) noexcept {
  constexpr unsigned kWord = 8 * sizeof(long);
  for (unsigned skip = number / kWord;; --skip) {
    const auto blank = bitmap.find_last_of(' ');
    const std::string_view word =
        blank == std::string_view::npos ? bitmap : bitmap.substr(blank + 1);
    if (skip == 0) {
      unsigned long bits = 0;
      std::from_chars(word.data(), word.data() + word.size(), bits, 16);
      return (bits >> (number % kWord) & 1u) != 0;
    }
    if (blank == std::string_view::npos)
      return false;
    bitmap = bitmap.substr(0, blank);
  }
}

std::vector<Joystick> joysticks() {
  std::vector<Joystick> all;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/input", failed)) {
    const std::string file = entry.path().filename().string();
    const auto device = entry.path() / "device";
    if (file.rfind("event", 0) != 0 ||
        !bit(first_line(device / "capabilities" / "ff"), FF_CONSTANT))
      continue;
    Joystick one{"/dev/input/" + file, first_line(device / "name"), first_line(device / "uniq")};
    one.allowed = access(one.node.c_str(), R_OK | W_OK) == 0;
    all.push_back(one);
  }
  std::sort(all.begin(), all.end(),
            [](const Joystick& a, const Joystick& b) { return number_of(a) < number_of(b); });
  return all;
}

} // namespace tactus::devices::evdev
