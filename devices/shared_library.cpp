#include "devices/shared_library.hpp"

namespace tactus::devices {

std::string SharedLibrary::joined(std::span<const char* const> names) {
  std::string text;
  for (const char* name : names)
    text += std::string(text.empty() ? "" : ", ") + name;
  return text;
}

const char* SharedLibrary::missing() const noexcept {
  const char* first = nullptr;
  for (const LibraryFunction* function = last_; function; function = function->before_)
    if (function->needed_ == LibraryFunction::Needed::kYes && !function->address_)
      first = function->name_;
  return first;
}

bool SharedLibrary::load(std::span<const char* const> names) {
  handle_ = nullptr;
  found_ = false;
  for (const char* name : names) {
    std::string error;
    bool missing = false;
    handle_ = open(name, error, missing);
    if (handle_) {
      name_ = name;
      for (LibraryFunction* function = last_; function; function = function->before_)
        function->address_ = address(function->name_);
      return true;
    }
    if (!found_)
      error_ = error;
    found_ = found_ || !missing;
  }
  return false;
}

} // namespace tactus::devices
