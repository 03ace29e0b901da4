#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactus::reed {

/// Finished maps, found again by the text of everything they depend on. Holds the last few in
/// memory; any of them can be kept in a file.
class MapStore {
public:
  void put(std::string key, std::vector<double> nodes);
  [[nodiscard]] const std::vector<double>* find(const std::string& key) const noexcept;

  /// Writes all maps held; a sentence when that fails, else empty.
  [[nodiscard]] std::string write(const std::string& path) const;
  /// Adds the maps of a file; a sentence when it is not a file of maps, else empty.
  [[nodiscard]] std::string read(const std::string& path);
  [[nodiscard]] std::size_t size() const noexcept { return maps_.size(); }

private:
  static constexpr std::size_t kMaxMaps = 32;
  std::deque<std::pair<std::string, std::vector<double>>> maps_;
};

} // namespace tactus::reed
