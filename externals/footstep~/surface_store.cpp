#include "externals/footstep~/surface_store.hpp"

#include "files/file_bytes.hpp"
#include "files/recipe.hpp"

#include <cstdint>
#include <utility>

namespace tactus::footstep {
namespace {

constexpr std::uint64_t kMaxBytes = 100000;

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
    std::string sentence = "surface " + std::string(name) +
                           ": file not found beside the patch or in the search path; or use";
    for (const BuiltInSurface& surface : built_in_surfaces())
      sentence += " " + std::string(surface.name);
    host.error(sentence);
    return nullptr;
  }
  std::string text;
  std::string error_text = files::read_file(path, text, kMaxBytes);
  auto surface = error_text.empty() ? from_text(name, text, error_text) : nullptr;
  if (!surface)
    host.error("surface " + std::string(name) + ": " + error_text);
  return surface;
}

} // namespace tactus::footstep
