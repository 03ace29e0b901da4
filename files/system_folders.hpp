#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Finds folders and programs; implemented in system_folders_posix.cpp and
/// system_folders_windows.cpp.
namespace tactus {

/// The folder of the module that contains this code; empty if unknown.
[[nodiscard]] std::filesystem::path own_folder();
/// The folders of PATH, in order, without entries that mean the current folder (on Windows without
/// relative ones), so that no program is run from a patch's folder.
[[nodiscard]] std::vector<std::filesystem::path> folders_in_path();

/// The path of a program: beside the module that contains this code, else in PATH. `given`, if not
/// empty, replaces the program; it is a path if it contains a slash (on Windows also a backslash).
/// Empty if no such program can be run.
[[nodiscard]] std::string find_program(const char* name, const std::string& given);
/// True if the text is a path, not a program name to be searched for.
[[nodiscard]] bool is_program_path(const std::string& text);
/// The file that this path runs; empty if it cannot be run. Windows adds `.exe`.
[[nodiscard]] std::filesystem::path runnable(const std::filesystem::path& path);

} // namespace tactus
