#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

/// Shares an object of one external with other externals by name. Externals are separate modules
/// without common variables, so the host's symbol table carries the pointer: each shell defines
/// PublishedObject and find_published() with this table. Any thread but the audio thread may use
/// them.
namespace tactus {

/// Publishes an object under a name for as long as this PublishedObject exists.
class PublishedObject {
public:
  /// Null when the name is taken.
  static std::unique_ptr<PublishedObject> make(std::string_view name, std::shared_ptr<void> what);
  ~PublishedObject();
  PublishedObject(const PublishedObject&) = delete;
  PublishedObject& operator=(const PublishedObject&) = delete;

private:
  struct Entry;
  explicit PublishedObject(Entry* entry) : entry_(entry) {}
  Entry* entry_;
  friend std::shared_ptr<void> find_published(std::string_view name);
};

/// Null when nothing is published under the name.
[[nodiscard]] std::shared_ptr<void> find_published(std::string_view name);

/// What one object publishes (Host::publish()).
class PublishedObjects {
public:
  /// Null withdraws what is published under the name. False if the name is taken, or if there is
  /// nothing to withdraw.
  bool publish(std::string_view name, const std::shared_ptr<void>& what) {
    if (!what)
      return all_.erase(std::string(name)) > 0;
    auto made = PublishedObject::make(name, what);
    return made && all_.emplace(std::string(name), std::move(made)).second;
  }

private:
  std::map<std::string, std::unique_ptr<PublishedObject>> all_;
};

} // namespace tactus
