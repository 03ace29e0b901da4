#include "externals/footstep~/surface_store.hpp"

#include "files/recipe.hpp"
#include "files/utf8_path.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

namespace tactus::footstep {
namespace {

constexpr std::streamsize kMaxBytes = 100000;

bool read_text(const std::string& path, std::string& text) {
  std::ifstream file(utf8_path(path), std::ios::binary);
  text.resize(static_cast<std::size_t>(kMaxBytes) + 1);
  file.read(text.data(), kMaxBytes + 1);
  const std::streamsize size = file.gcount();
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(size, 0)));
  return !file.bad() && size > 0 && size <= kMaxBytes;
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
  if (!read_text(path, text)) {
    host.error("surface " + std::string(name) + ": it is no text of less than 100 kB");
    return nullptr;
  }
  std::string error_text;
  auto surface = from_text(name, text, error_text);
  if (!surface)
    host.error("surface " + std::string(name) + ": " + error_text);
  return surface;
}

} // namespace tactus::footstep
