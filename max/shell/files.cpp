#include "max/shell/files.hpp"

#include "files/utf8_path.hpp"
#include "max/shell/atoms.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <system_error>

namespace tactus::max {
namespace {

namespace fs = std::filesystem;
using PathText = std::array<char, MAX_PATH_CHARS>;

bool is_file(const fs::path& path) {
  std::error_code failed;
  return fs::is_regular_file(path, failed);
}

/// Max writes "Macintosh HD:/Users/..." on macOS; the system's functions expect "/Users/...".
std::string system_path(const char* of_max) {
  PathText conformed{};
  if (path_nameconform(of_max, conformed.data(), PATH_STYLE_SLASH, PATH_TYPE_BOOT) != 0)
    return of_max;
  return conformed.data();
}

/// Searches Max's search path.
std::string locate(std::string_view name) {
  PathText found{}, full{};
  if (name.empty() || name.size() >= MAX_FILENAME_CHARS)
    return {};
  std::copy(name.begin(), name.end(), found.begin());
  short folder = 0;
  t_fourcc type = 0;
  if (locatefile_extended(found.data(), &folder, &type, nullptr, 0) != 0 ||
      path_topathname(folder, found.data(), full.data()) != 0)
    return {};
  return system_path(full.data());
}

} // namespace

bool in_main_thread() noexcept { return systhread_ismainthread() != 0; }

Files::Files(t_object* box) : box_(box) { look_for_folder(); }

void Files::look_for_folder() {
  if (!in_main_thread())
    return;
  t_object* patcher = nullptr;
  if (object_obex_lookup(box_, gensym("#P"), &patcher) != 0)
    patcher = nullptr;
  for (; patcher; patcher = jpatcher_get_parentpatcher(patcher)) // goes up to the patcher that has
                                                                 // a file
    if (const t_symbol* file = jpatcher_get_filepath(patcher);
        file && file->s_name && *file->s_name) {
      folder_ = to_generic_utf8(utf8_path(system_path(file->s_name)).parent_path());
      return;
    }
  PathText full{};
  if (path_topathname(path_getdefault(), "", full.data()) == 0)
    folder_ = system_path(full.data());
}

std::string Files::find(std::string_view given) {
  // On macOS the name of a file dropped in Max begins with the name of its volume.
  const std::string name =
      given.find(":/") == given.npos ? std::string(given) : system_path(std::string(given).c_str());
  const fs::path path = utf8_path(name);
  if (path.is_absolute())
    return is_file(path) ? name : std::string();
  look_for_folder();
  if (const fs::path beside = utf8_path(folder_) / path; is_file(beside))
    return to_generic_utf8(beside);
  if (!in_main_thread())
    return {};
  std::string found = locate(name);
  if (found.empty() && path.has_parent_path())
    found = locate(to_generic_utf8(path.filename()));
  return found;
}

std::string Files::to_write(std::string_view name) {
  const fs::path path = utf8_path(name);
  if (path.is_absolute())
    return std::string(name);
  look_for_folder();
  return to_generic_utf8(utf8_path(folder_) / path);
}

bool Files::read_buffer(std::string_view name, std::vector<double>& values) const {
  if (!in_main_thread())
    return false;
  t_buffer_ref* reference = buffer_ref_new(box_, symbol_of(name));
  if (!reference)
    return false;
  bool was_read = false;
  if (t_buffer_obj* buffer = buffer_ref_getobject(reference)) {
    if (const float* samples = buffer_locksamples(buffer)) {
      const auto size = [](t_atom_long count) {
        return static_cast<std::size_t>(std::max<t_atom_long>(count, 0));
      };
      const std::size_t channels = std::max<std::size_t>(size(buffer_getchannelcount(buffer)), 1);
      values.resize(size(buffer_getframecount(buffer)));
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<double>(samples[i * channels]);
      buffer_unlocksamples(buffer);
      was_read = true;
    }
  }
  object_free(reference);
  return was_read;
}

} // namespace tactus::max
