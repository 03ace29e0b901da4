#include "externals/footstep~/surface_store.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

namespace tactus::footstep {
namespace {

constexpr std::streamsize kMostBytes = 100000;

bool read_text(const std::string& path, std::string& text) {
  std::ifstream file(path, std::ios::binary);
  text.resize(static_cast<std::size_t>(kMostBytes) + 1);
  file.read(text.data(), kMostBytes + 1);
  const std::streamsize size = file.gcount();
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(size, 0)));
  return !file.bad() && size > 0 && size <= kMostBytes;
}

} // namespace

std::shared_ptr<const Surface> SurfaceStore::of_text(std::string_view name, std::string_view text,
                                                     std::string& complaint) {
  for (const auto& surface : known_)
    if (surface->name == name && surface->text == text)
      return surface;
  auto made = std::make_shared<Surface>();
  complaint = read_recipe(text, made->recipe);
  if (!complaint.empty())
    return nullptr;
  made->name = name;
  made->text = text;
  made->id = ++last_id_;
  if (known_.size() == kKept)
    known_.erase(known_.begin());
  known_.push_back(made);
  return made;
}

std::shared_ptr<const Surface> SurfaceStore::built_in(std::string_view name) {
  std::string complaint;
  for (const BuiltInSurface& surface : built_in_surfaces())
    if (surface.name == name)
      return of_text(name, surface.text, complaint);
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
  std::string complaint;
  auto surface = of_text(name, text, complaint);
  if (!surface)
    host.error("surface " + std::string(name) + ": " + complaint);
  return surface;
}

} // namespace tactus::footstep
