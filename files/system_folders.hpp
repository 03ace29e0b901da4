#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Folders and programs that the system knows: system_folders_posix.cpp,
/// system_folders_windows.cpp.
namespace tactus {

/// The folder of the module that this code is part of; empty if unknown.
[[nodiscard]] std::filesystem::path own_folder();
/// The folders of PATH, in order. Without entries that mean the current folder, or on Windows are
/// relative: nothing is run from a patch's folder.
[[nodiscard]] std::vector<std::filesystem::path> folders_in_path();

/// The path of a program: beside the module that this code is part of, else in PATH; or the `given`
/// program instead, a path if it has a slash (on Windows, a backslash too). Empty if there is none
/// that can be run.
[[nodiscard]] std::string find_program(const char* name, const std::string& given);
/// True for text that names a file and not a program to be looked for.
[[nodiscard]] bool is_program_path(const std::string& text);
/// The file that this path runs; empty if it cannot be run. Windows adds `.exe`.
[[nodiscard]] std::filesystem::path runnable(const std::filesystem::path& path);

} // namespace tactus
