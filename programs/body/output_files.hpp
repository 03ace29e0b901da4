#pragma once
#include "programs/body/body_options.hpp"

namespace tactus::fem {

/// A file that the program will write.
struct Output {
  const char* option;
  std::string path; ///< empty for none
  double bytes = 0; ///< approximate size
};

/// Refuses, before any work, output files that could not be written: a missing or read-only folder,
/// a folder or device with the file's name, one name for two files, or the body's own file. Changes
/// no existing file.
void check_outputs(std::span<const Output>, const BodyOptions&);

/// As check_outputs(), for one file.
void check_output(const std::string& option, const std::string& path);

/// Refuses outputs for which the disk has no space.
void check_disk_space(std::span<const Output>);

/// Refuses at the start if draw_sheet() would fail at the end: it needs Debian's Python with
/// matplotlib, and the script beside this program.
void check_sheet(const std::string& script);

/// Draws a picture of a table with the Python script beside this program; the words `more` follow
/// the names of both files.
void draw_sheet(const std::string& script, const std::string& table, const std::string& picture,
                const std::vector<std::string>& more = {});

/// "2026-11-28T14:05:09Z", for a table; empty if SOURCE_DATE_EPOCH is set, so that equal bodies
/// give equal files.
[[nodiscard]] std::string date_of_now();

} // namespace tactus::fem
