#pragma once
#include "programs/body/body_options.hpp"

namespace tactus::fem {

/// A file that the program will write.
struct Output {
  const char* option;
  std::string path; ///< empty: none
  double bytes = 0; ///< approximate size
};

/// Refuses, before any work, output files that could not be written: a missing or closed folder, a
/// folder or device in the file's place, one name for two files, the body's own file. Touches no
/// existing file.
void check_outputs(std::span<const Output>, const BodyOptions&);

/// The same for one file.
void check_output(const std::string& option, const std::string& path);

/// Refuses outputs for which the disk has no space.
void check_disk_space(std::span<const Output>);

/// Refuses at the start if draw_sheet() would fail at the end: it needs Debian's Python with
/// matplotlib, and the script beside this program.
void check_sheet(const std::string& script);

/// Draws a picture of a table with the Python script beside this program; `more` words follow the
/// names of both files.
void draw_sheet(const std::string& script, const std::string& table, const std::string& picture,
                const std::vector<std::string>& more = {});

/// "2026-11-28T14:05:09Z", for a table; empty where SOURCE_DATE_EPOCH is set, so that equal bodies
/// are equal files.
[[nodiscard]] std::string date_of_now();

} // namespace tactus::fem
