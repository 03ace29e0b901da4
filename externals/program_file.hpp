#pragma once

#include <filesystem>
#include <string>

namespace tactus {

/// The path of a program: beside the module that this code is part of, else in PATH; or the `given`
/// program instead, a path if it has a slash (on Windows, a backslash too). Empty if there is none
/// that can be run.
[[nodiscard]] std::string find_program(const char* name, const std::string& given);

// What each system answers: program_file_posix.cpp, program_file_windows.cpp.

/// True for text that names a file and not a program to be looked for.
[[nodiscard]] bool is_program_path(const std::string& text);
/// The file that this path runs; empty if it cannot be run. Windows adds `.exe`.
[[nodiscard]] std::filesystem::path runnable(const std::filesystem::path& path);

} // namespace tactus
