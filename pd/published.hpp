#pragma once

#include <memory>
#include <string_view>

/// What one module's object gives to those of another, through Pd's own table of names: modules
/// share no variables.
namespace tactus::pd {

/// A name that is taken until the end of this.
class PublishedObject {
public:
  /// Empty when another offer holds the name.
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

[[nodiscard]] std::shared_ptr<void> find_published(std::string_view name);

} // namespace tactus::pd
