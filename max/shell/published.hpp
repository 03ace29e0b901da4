#pragma once

#include <memory>
#include <string_view>

/// Shares an object of one external with other externals by name. Externals are separate modules
/// without common variables, so Max's symbol table carries the pointer. Any thread but audio's.
namespace tactus::max {

/// Publishes an object under a name until this is destroyed.
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

} // namespace tactus::max
