#include "max/shell/files.hpp"

#include "max/shell/atoms.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

namespace tactus::max {
namespace {

namespace fs = std::filesystem;
using PathText = std::array<char, MAX_PATH_CHARS>;

fs::path path_of(std::string_view text) {
  return {std::u8string(text.begin(), text.end())};
}
std::string text_of(const fs::path& path) {
  const std::u8string text = path.generic_u8string();
  return {text.begin(), text.end()};
}

bool is_file(const fs::path& path) {
  std::error_code failed;
  return fs::is_regular_file(path, failed);
}

/// Max writes "Macintosh HD:/Users/..." on macOS; the system's functions take "/Users/...".
std::string system_path(const char* of_max) {
  PathText conformed{};
  if (path_nameconform(of_max, conformed.data(), PATH_STYLE_SLASH, PATH_TYPE_BOOT) != 0)
    return of_max;
  return conformed.data();
}

/// Folder of the patcher that holds the box; empty if it has not been saved.
fs::path patcher_folder(t_object* box) {
  t_object* patcher = nullptr;
  if (object_obex_lookup(box, gensym("#P"), &patcher) != 0 || !patcher)
    return {};
  const t_symbol* file = jpatcher_get_filepath(patcher);
  if (!file || !file->s_name || !*file->s_name)
    return {};
  return path_of(system_path(file->s_name)).parent_path();
}

/// In Max's search path.
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

std::string find_file(t_object* box, std::string_view name) {
  const fs::path path = path_of(name);
  if (path.is_absolute())
    return is_file(path) ? std::string(name) : std::string();
  if (const fs::path folder = patcher_folder(box); !folder.empty() && is_file(folder / path))
    return text_of(folder / path);
  std::string found = locate(name);
  if (found.empty() && path.has_parent_path())
    found = locate(text_of(path.filename()));
  return found;
}

std::string new_file(t_object* box, std::string_view name) {
  const fs::path path = path_of(name);
  if (path.is_absolute())
    return std::string(name);
  fs::path folder = patcher_folder(box);
  if (PathText full{};
      folder.empty() && path_topathname(path_getdefault(), "", full.data()) == 0)
    folder = path_of(system_path(full.data()));
  return text_of(folder / path);
}

bool read_buffer(t_object* box, std::string_view name, std::vector<double>& values) {
  t_buffer_ref* reference = buffer_ref_new(box, symbol_of(name));
  if (!reference)
    return false;
  bool was_read = false;
  if (t_buffer_obj* buffer = buffer_ref_getobject(reference)) {
    if (const float* samples = buffer_locksamples(buffer)) {
      const auto channels = static_cast<std::size_t>(std::max<t_atom_long>(
          buffer_getchannelcount(buffer), 1));
      values.resize(static_cast<std::size_t>(std::max<t_atom_long>(buffer_getframecount(buffer), 0)));
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
