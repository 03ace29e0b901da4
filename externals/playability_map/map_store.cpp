#include "externals/playability_map/map_store.hpp"

#include "files/file_bytes.hpp"
#include "files/utf8_path.hpp"

#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>

namespace tactus::reed {
namespace {

constexpr const char* kHeading = "tactus playability maps 1";
constexpr std::size_t kMaxNodes = 1u << 20;

} // namespace

void MapStore::put(std::string key, std::vector<double> nodes) {
  for (auto& [stored, nodes_held] : maps_)
    if (stored == key) {
      nodes_held = std::move(nodes);
      return;
    }
  if (maps_.size() == kMaxMaps)
    maps_.pop_front();
  maps_.emplace_back(std::move(key), std::move(nodes));
}

const std::vector<double>* MapStore::find(const std::string& key) const noexcept {
  for (const auto& [stored, nodes] : maps_)
    if (stored == key)
      return &nodes;
  return nullptr;
}

std::string MapStore::write(const std::string& path) const {
  std::ofstream file(utf8_path(path));
  file << kHeading << '\n' << std::setprecision(std::numeric_limits<double>::max_digits10);
  for (const auto& [key, nodes] : maps_) {
    file << key << '\n' << nodes.size() << '\n';
    for (const double node : nodes)
      file << node << '\n';
  }
  file.flush();
  return file ? "" : "cannot write " + path;
}

std::string MapStore::read(const std::string& path) {
  std::ifstream file = files::open_file(path);
  std::string line;
  if (!file || !std::getline(file, line))
    return "cannot read " + path;
  if (line != kHeading)
    return path + " is not a file of playability maps";
  std::string key;
  while (std::getline(file, key)) {
    std::size_t count = 0;
    if (!(file >> count) || count > kMaxNodes)
      return path + " is damaged";
    std::vector<double> nodes(count);
    for (double& node : nodes)
      if (!(file >> node))
        return path + " is damaged";
    std::getline(file, line);
    put(std::move(key), std::move(nodes));
  }
  return "";
}

} // namespace tactus::reed
