#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tactus::devices {

/// A shared library that is loaded at run time, so that a missing one gives an error text and not a
/// program that does not start. It stays loaded until the process ends: drivers' libraries keep
/// threads and state, and some fail when they are loaded a second time (CHAI3D leaves libHD open
/// for that reason, cPhantomDevice).
class SharedLibrary {
public:
  SharedLibrary() = default;
  SharedLibrary(const SharedLibrary&) = delete;
  SharedLibrary& operator=(const SharedLibrary&) = delete;

  /// Tries the names in order, all symbols resolved at once and kept from other libraries. False
  /// when none loads: error() is then why the first one that is there does not load; if none is
  /// there, the loader's message for the last name.
  bool load(std::span<const char* const> names);
  [[nodiscard]] const std::string& error() const noexcept { return error_; }
  /// After load() without success: whether a file of one of the names was there.
  [[nodiscard]] bool found() const noexcept { return found_; }
  /// The names as an error text lists them, with commas between.
  [[nodiscard]] static std::string joined(std::span<const char* const> names);
  /// The name that loaded.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// Sets the function pointer; null and false when the library has no such symbol.
  template <class Function> bool symbol(const char* symbol_name, Function*& function) noexcept {
    function = reinterpret_cast<Function*>(address(symbol_name));
    return function != nullptr;
  }

private:
  /// One library, or null after a reason; missing: there is no such file.
  /// shared_library_posix.cpp, shared_library_windows.cpp.
  [[nodiscard]] static void* open(const char* name, std::string& error, bool& missing);
  [[nodiscard]] void* address(const char* symbol_name) const noexcept;

  void* handle_ = nullptr;
  std::string name_, error_;
  bool found_ = false;
};

/// Finds the functions that a driver cannot do without.
class RequiredSymbols {
public:
  explicit RequiredSymbols(SharedLibrary& library) noexcept : library_(library) {}

  /// Sets the function pointer.
  template <class Function> void operator()(const char* name, Function*& function) noexcept {
    if (!library_.symbol(name, function) && !missing_)
      missing_ = name;
  }
  /// The first one that the library lacks, or null.
  [[nodiscard]] const char* missing() const noexcept { return missing_; }

private:
  SharedLibrary& library_;
  const char* missing_ = nullptr;
};

} // namespace tactus::devices
