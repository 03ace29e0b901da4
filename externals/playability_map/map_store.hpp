#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactus::reed {

/// Cache of the last kMaxMaps finished maps, which can be written to a file and read from it. A
/// map's key is the text of its settings.
class MapStore {
public:
  /// Stores a map; replaces a map with the same key.
  void put(std::string key, std::vector<double> nodes);
  /// Returns null if there is no map with this key.
  [[nodiscard]] const std::vector<double>* find(const std::string& key) const noexcept;

  /// Writes all maps. Returns the error text, empty on success.
  [[nodiscard]] std::string write(const std::string& path) const;
  /// Adds the maps of a file. Returns the error text, empty on success.
  [[nodiscard]] std::string read(const std::string& path);
  [[nodiscard]] std::size_t size() const noexcept { return maps_.size(); }

private:
  static constexpr std::size_t kMaxMaps = 32;
  std::deque<std::pair<std::string, std::vector<double>>> maps_;
};

} // namespace tactus::reed
