#include "externals/footstep~/surface_store.hpp"

#include "files/recipe.hpp"
#include "files/utf8_path.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

namespace tactus::footstep {
namespace {

constexpr std::streamsize kMaxBytes = 100000;

/// Reads the whole file into text; returns what is wrong with it, or an empty string.
std::string read_text(const std::string& path, std::string& text) {
  std::ifstream file(utf8_path(path), std::ios::binary);
  text.resize(static_cast<std::size_t>(kMaxBytes) + 1);
  file.read(text.data(), kMaxBytes + 1);
  const std::streamsize size = file.gcount();
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(size, 0)));
  if (size > kMaxBytes)
    return "expected a text of at most 100 kB";
  return file.eof() ? "" : "the file cannot be read";
}

} // namespace

std::shared_ptr<const Surface> SurfaceStore::from_text(std::string_view name, std::string_view text,
                                                       std::string& error_text) {
  for (const auto& surface : cache_)
    if (surface->name == name && surface->text == text)
      return surface;
  auto made = std::make_shared<Surface>();
  error_text = files::read_recipe(text, made->recipe);
  if (!error_text.empty())
    return nullptr;
  made->name = name;
  made->text = text;
  made->id = ++last_id_;
  if (cache_.size() == kMaxCachedRecipes)
    cache_.erase(cache_.begin());
  cache_.push_back(made);
  return made;
}

std::shared_ptr<const Surface> SurfaceStore::built_in(std::string_view name) {
  std::string error_text;
  for (const BuiltInSurface& surface : built_in_surfaces())
    if (surface.name == name)
      return from_text(name, surface.text, error_text);
  return nullptr;
}

std::shared_ptr<const Surface> SurfaceStore::find(std::string_view name, Host& host) {
  if (auto surface = built_in(name))
    return surface;
  std::string path = host.find_file(name);
  if (path.empty() && !name.ends_with(".txt"))
    path = host.find_file(std::string(name) + ".txt");
  if (path.empty()) {
    std::string sentence = "surface " + std::string(name) + ": no file, and none of";
    for (const BuiltInSurface& surface : built_in_surfaces())
      sentence += " " + std::string(surface.name);
    host.error(sentence);
    return nullptr;
  }
  std::string text;
  std::string error_text = read_text(path, text);
  auto surface = error_text.empty() ? from_text(name, text, error_text) : nullptr;
  if (!surface)
    host.error("surface " + std::string(name) + ": " + error_text);
  return surface;
}

} // namespace tactus::footstep
