#pragma once

#include <string>

/// Queries about the process that loaded this module, implemented in host_process_posix.cpp and
/// host_process_windows.cpp.
namespace tactus::pd {

/// The address of a function of the host; null if the host has no function of that name.
[[nodiscard]] void* host_symbol(const char* name) noexcept;

/// The folder of the module that contains this code, with slashes; empty if unknown.
[[nodiscard]] std::string module_folder();
[[nodiscard]] bool is_absolute(const std::string& path) noexcept;

/// The process's arguments, each with a zero byte before and after it.
[[nodiscard]] std::string command_line();

} // namespace tactus::pd
