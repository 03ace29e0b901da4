#include "files/system_folders.hpp"

#include "files/utf8_path.hpp"

namespace tactus {

std::string find_program(const char* usual, const std::string& given) {
  if (is_program_path(given))
    return to_utf8(runnable(utf8_path(given)));
  const std::filesystem::path name = utf8_path(given.empty() ? usual : given);
  if (given.empty())
    if (const auto beside = runnable(own_folder() / name); !beside.empty())
      return to_utf8(beside);
  for (const std::filesystem::path& folder : folders_in_path())
    if (const auto found = runnable(folder / name); !found.empty())
      return to_utf8(found);
  return {};
}

} // namespace tactus
