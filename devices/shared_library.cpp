#include "devices/shared_library.hpp"

namespace tactus::devices {

std::string SharedLibrary::joined(std::span<const char* const> names) {
  std::string text;
  for (const char* name : names)
    text += std::string(text.empty() ? "" : ", ") + name;
  return text;
}

bool SharedLibrary::load(std::span<const char* const> names) {
  handle_ = nullptr;
  for (const char* name : names) {
    error_.clear();
    handle_ = open(name, error_);
    if (handle_) {
      name_ = name;
      return true;
    }
  }
  return false;
}

} // namespace tactus::devices
