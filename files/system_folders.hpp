#pragma once

#include <filesystem>
#include <vector>

/// Folders that the system knows: system_folders_posix.cpp, system_folders_windows.cpp.
namespace tactus {

/// The folder of the module that this code is part of; empty if unknown.
[[nodiscard]] std::filesystem::path own_folder();
/// The folders of PATH, in order. Without entries that mean the current folder, or on Windows are
/// relative: nothing is run from a patch's folder.
[[nodiscard]] std::vector<std::filesystem::path> folders_in_path();

} // namespace tactus
