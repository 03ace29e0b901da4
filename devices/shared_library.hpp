#pragma once

#include <span>
#include <string>

namespace tactus::devices {

class LibraryFunction;

/// A shared library that is loaded at run time, so that a missing library causes an error text
/// instead of a program that does not start. It stays loaded until the process ends: drivers'
/// libraries keep threads and state, and some fail when they are loaded a second time (CHAI3D
/// leaves libHD open for that reason, cPhantomDevice).
class SharedLibrary {
public:
  SharedLibrary() = default;
  SharedLibrary(const SharedLibrary&) = delete;
  SharedLibrary& operator=(const SharedLibrary&) = delete;

  /// Tries the names in order and finds the functions. All symbols are resolved at once and hidden
  /// from other libraries. Returns false if no name loads. error() is then the reason for the first
  /// name that has a file; if no name has one, it is the loader's message for the last name.
  bool load(std::span<const char* const> names);
  [[nodiscard]] const std::string& error() const noexcept { return error_; }
  /// After load() has failed: whether one of the names had a file.
  [[nodiscard]] bool found() const noexcept { return found_; }
  /// The names separated by commas, for error texts.
  [[nodiscard]] static std::string joined(std::span<const char* const> names);
  /// The name of the loaded library.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// The first required function that the library lacks, or null.
  [[nodiscard]] const char* missing() const noexcept;
  /// Sets the function pointer; null and false when the library has no such symbol.
  template <class Function> bool symbol(const char* symbol_name, Function*& function) noexcept {
    function = reinterpret_cast<Function*>(address(symbol_name));
    return function != nullptr;
  }

private:
  friend class LibraryFunction;
  /// Returns a library, or null with the reason in `error`; sets `missing` to true if there is no
  /// such file. Implemented in shared_library_posix.cpp and shared_library_windows.cpp.
  [[nodiscard]] static void* open(const char* name, std::string& error, bool& missing);
  [[nodiscard]] void* address(const char* symbol_name) const noexcept;

  void* handle_ = nullptr;
  LibraryFunction* last_ = nullptr; // the function declared last
  std::string name_, error_;
  bool found_ = false;
};

/// The part of Function that does not depend on its type.
class LibraryFunction {
public:
  enum class Needed { kYes, kNo };
  LibraryFunction(SharedLibrary& library, const char* name, Needed needed) noexcept
      : before_(library.last_), name_(name), needed_(needed) {
    library.last_ = this;
  }
  LibraryFunction(const LibraryFunction&) = delete;
  LibraryFunction& operator=(const LibraryFunction&) = delete;

protected:
  friend SharedLibrary;
  LibraryFunction* before_; // the library's function declared before this one
  const char* name_;
  Needed needed_;
  void* address_ = nullptr;
};

/// A function of a library: null until the library is loaded, or if the library has no function of
/// that name. `F` is the function's type, such as int(char id).
template <class F> class Function final : public LibraryFunction {
public:
  Function(SharedLibrary& library, const char* name, Needed needed = Needed::kYes) noexcept
      : LibraryFunction(library, name, needed) {}
  Function& operator=(F* function) noexcept {
    address_ = reinterpret_cast<void*>(function);
    return *this;
  }
  /// Takes the other's function but keeps this one's name.
  Function& operator=(const Function& other) noexcept { return *this = static_cast<F*>(other); }
  operator F*() const noexcept { return reinterpret_cast<F*>(address_); }
};

} // namespace tactus::devices
