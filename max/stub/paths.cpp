// Max's search path. Texts go out in whole buffers of the documented size, so that one that is too
// small is overrun where a sanitizer sees it.
#include "files/utf8_path.hpp"
#include "max/stub/kernel.hpp"

#include <algorithm>

namespace tactus::stub {
namespace {
namespace fs = std::filesystem;
std::vector<std::string> folders; // by path number minus 1
std::string patcher_path;

short number_of(const std::string& folder) {
  const std::lock_guard lock(kernel_mutex());
  for (std::size_t i = 0; i < folders.size(); ++i)
    if (folders[i] == folder)
      return static_cast<short>(i + 1);
  folders.push_back(folder);
  return static_cast<short>(folders.size());
}
void give(const std::string& text, char* to, std::size_t size) {
  std::fill_n(to, size, '\0');
  std::copy_n(text.data(), std::min(text.size(), size - 1), to);
}
/// The folders that Max looks into: the patcher's first.
std::vector<std::string> searched() {
  std::vector<std::string> all;
  if (!patcher_path.empty())
    all.push_back(to_generic_utf8(utf8_path(patcher_path).parent_path()));
  const std::lock_guard lock(kernel_mutex());
  for (const std::string& folder : folders)
    all.push_back(folder);
  return all;
}
} // namespace

void add_search_path(const std::string& folder) {
  number_of(to_generic_utf8(fs::absolute(utf8_path(folder))));
}
void set_patcher_path(const std::string& path, bool in_subpatcher) {
  patcher_path = path.empty() ? "" : to_generic_utf8(fs::absolute(utf8_path(path)));
  use_subpatcher(in_subpatcher);
}

} // namespace tactus::stub

using namespace tactus::stub;
using tactus::to_generic_utf8;
using tactus::utf8_path;

short locatefile_extended(char* name, short* path, t_fourcc* type, const t_fourcc*, short) {
  const ApiCall api("locatefile_extended", static_cast<unsigned>(Role::kMain));
  if (!name || !path || !type) {
    violation("locatefile_extended: null instead of an address");
    return -1;
  }
  const std::string wanted = name;
  std::vector<fs::path> candidates;
  if (utf8_path(wanted).is_absolute())
    candidates.push_back(utf8_path(wanted));
  else
    for (const std::string& folder : searched())
      candidates.push_back(utf8_path(folder) / utf8_path(wanted));
  std::error_code error;
  for (const fs::path& candidate : candidates)
    if (fs::is_regular_file(candidate, error)) {
      *path = number_of(to_generic_utf8(candidate.parent_path()));
      *type = 0;
      give(to_generic_utf8(candidate.filename()), name, MAX_FILENAME_CHARS);
      return 0;
    }
  return -1;
}

short path_getdefault() {
  const ApiCall api("path_getdefault", static_cast<unsigned>(Role::kMain));
  return number_of(to_generic_utf8(fs::current_path()));
}

short path_topathname(short path, const char* file, char* to) {
  const ApiCall api("path_topathname", static_cast<unsigned>(Role::kMain));
  std::string folder;
  {
    const std::lock_guard lock(kernel_mutex());
    if (path >= 1 && static_cast<std::size_t>(path) <= folders.size())
      folder = folders[static_cast<std::size_t>(path) - 1];
  }
  if (folder.empty() || !file || !to) {
    violation("path_topathname: path " + std::to_string(path) + " is none that Max gave, or null");
    return -1;
  }
  give(*file ? folder + "/" + file : folder, to, MAX_PATH_CHARS);
  return 0;
}

short path_nameconform(const char* from, char* to, long style, long type) {
  const ApiCall api("path_nameconform", static_cast<unsigned>(Role::kMain));
  if (!from || !to) {
    violation("path_nameconform: null instead of a text");
    return -1;
  }
  if (style < 0 || style > 5 || type < 0 || type > 5)
    violation("path_nameconform: no style or type of paths: " + std::to_string(style) + " " +
              std::to_string(type));
  give(from, to, MAX_PATH_CHARS);
  return 0;
}

t_symbol* jpatcher_get_filepath(t_object* p) {
  const ApiCall api("jpatcher_get_filepath");
  if (p != patcher() && (!p || p != parent_patcher()))
    violation("jpatcher_get_filepath: not a patcher");
  return symbol(p == patcher() && parent_patcher() ? "" : patcher_path);
}
t_object* jpatcher_get_parentpatcher(t_object* p) {
  const ApiCall api("jpatcher_get_parentpatcher");
  if (p != patcher() && (!p || p != parent_patcher()))
    violation("jpatcher_get_parentpatcher: not a patcher");
  return p == patcher() ? parent_patcher() : nullptr;
}
