#pragma once

#include "max/abi/max_abi.h"

#include <string>
#include <string_view>
#include <vector>

/// Files and buffers by name, as Max users expect them to be found. Max's functions for this may
/// only be called in its main thread. In other threads, only files beside the patcher and files
/// given by their full path are found.
namespace tactus::max {

class Files {
public:
  /// For the main thread; the box must already exist.
  explicit Files(t_object* box);

  /// Full path, in UTF-8 with slashes, of an existing file. The name is tried as a full path,
  /// beside the patcher and in Max's search path, there also without its folders. Empty if there is
  /// no such file.
  [[nodiscard]] std::string find(std::string_view name);
  /// Full path for a file to be written; relative names are beside the patcher, or in Max's default
  /// folder while it has not been saved.
  [[nodiscard]] std::string to_write(std::string_view name);
  /// The first channel of a buffer~; false if there is none of this name. For the main thread.
  [[nodiscard]] bool read_buffer(std::string_view name, std::vector<double>& values) const;

private:
  void look_for_folder();

  t_object* box_;
  std::string folder_; ///< base of relative names, updated in the main thread
};

/// Whether this is Max's main thread, in which its file functions may be called.
[[nodiscard]] bool in_main_thread() noexcept;

} // namespace tactus::max
