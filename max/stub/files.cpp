// Max's search path, the patcher's file, and buffer~ contents by name.
#include "files/utf8_path.hpp"
#include "max/stub/stub.hpp"

#include <algorithm>

/// One buffer~: frames by channels, interleaved.
struct t_buffer_obj {
  long channels;
  std::vector<float> samples;
};
struct t_buffer_ref : tactus::stub::Record {
  static constexpr tactus::stub::Kind kKind = tactus::stub::Kind::kBufferRef;
  t_buffer_ref() : Record(kKind) {}
  std::string name{};
};

namespace tactus::stub {
namespace {
namespace fs = std::filesystem;
std::vector<std::string> folders; // indexed by path number
std::string patcher_file;
bool in_subpatcher = false;
t_object main_patcher{}, subpatcher{};
std::map<std::string, t_buffer_obj> buffers;

short number_of(const std::string& folder) {
  const auto found = std::find(folders.begin(), folders.end(), folder);
  if (found == folders.end()) {
    folders.push_back(folder);
    return static_cast<short>(folders.size() - 1);
  }
  return static_cast<short>(found - folders.begin());
}
/// Writes a whole buffer of the documented size, so that a sanitizer detects a buffer that is too
/// small.
void give(const std::string& text, char* to, std::size_t size) {
  std::fill_n(to, size, '\0');
  std::copy_n(text.data(), std::min(text.size(), size - 1), to);
}
} // namespace

void add_search_path(const std::string& folder) {
  number_of(to_generic_utf8(fs::absolute(utf8_path(folder))));
}
void set_patcher(const std::string& path, bool within_subpatcher) {
  patcher_file = to_generic_utf8(fs::absolute(utf8_path(path)));
  in_subpatcher = within_subpatcher;
}
t_object* patcher() { return in_subpatcher ? &subpatcher : &main_patcher; }
void make_buffer(const std::string& name, long channels, const std::vector<float>& samples) {
  buffers[name] = {channels, samples};
}

} // namespace tactus::stub

using namespace tactus::stub;
using tactus::to_generic_utf8;
using tactus::utf8_path;

short locatefile_extended(char* name, short* path, t_fourcc*, const t_fourcc*, short) {
  const ApiCall api("locatefile_extended", kMain);
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const fs::path file = utf8_path(folders[i]) / utf8_path(name);
    if (!fs::is_regular_file(file))
      continue;
    *path = number_of(to_generic_utf8(file.parent_path()));
    give(to_generic_utf8(file.filename()), name, MAX_FILENAME_CHARS);
    return 0;
  }
  return -1;
}
short path_getdefault() {
  const ApiCall api("path_getdefault", kMain);
  return number_of(to_generic_utf8(fs::current_path()));
}
short path_topathname(short path, const char* file, char* to) {
  const ApiCall api("path_topathname", kMain);
  const std::string& folder = folders.at(static_cast<std::size_t>(path));
  give(*file ? folder + "/" + file : folder, to, MAX_PATH_CHARS);
  return 0;
}
short path_nameconform(const char* from, char* to, long, long) {
  const ApiCall api("path_nameconform", kMain);
  give(from, to, MAX_PATH_CHARS);
  return 0;
}
t_symbol* jpatcher_get_filepath(t_object* p) {
  const ApiCall api("jpatcher_get_filepath");
  return symbol(p == &main_patcher ? patcher_file : "");
}
t_object* jpatcher_get_parentpatcher(t_object* p) {
  const ApiCall api("jpatcher_get_parentpatcher");
  return p == &subpatcher ? &main_patcher : nullptr;
}

t_buffer_ref* buffer_ref_new(t_object*, t_symbol* name) {
  const ApiCall api("buffer_ref_new", kMain);
  auto* reference = new t_buffer_ref;
  keep(*reference);
  reference->name = name->s_name;
  return reference;
}
t_buffer_obj* buffer_ref_getobject(t_buffer_ref* reference) {
  const ApiCall api("buffer_ref_getobject");
  const auto found = buffers.find(require<t_buffer_ref>(reference, "buffer_ref_getobject")->name);
  return found == buffers.end() ? nullptr : &found->second;
}
float* buffer_locksamples(t_buffer_obj* buffer) {
  const ApiCall api("buffer_locksamples");
  ++current_call()->held;
  return buffer->samples.data();
}
void buffer_unlocksamples(t_buffer_obj*) {
  const ApiCall api("buffer_unlocksamples");
  --current_call()->held;
}
t_atom_long buffer_getchannelcount(t_buffer_obj* buffer) { return buffer->channels; }
t_atom_long buffer_getframecount(t_buffer_obj* buffer) {
  return static_cast<t_atom_long>(buffer->samples.size()) / buffer->channels;
}
