#include "max/shell/published.hpp"

#include "max/shell/atoms.hpp"

#include <utility>

namespace tactus::max {
namespace {

constexpr const char* kClassName = "tactus published 1"; // the layout of Entry is part of it

/// Max's region that all modules share: the registry has no lock of its own that we know of.
class Critical {
public:
  Critical() { critical_enter(nullptr); }
  ~Critical() { critical_exit(nullptr); }
  Critical(const Critical&) = delete;
  Critical& operator=(const Critical&) = delete;
};

/// The first module that publishes registers the class for all.
t_class* published_class(long size) {
  t_symbol* const space = gensym("nobox");
  t_symbol* const name = gensym(kClassName);
  if (t_class* known = class_findbyname(space, name))
    return known;
  t_class* made = class_new(kClassName, nullptr, nullptr, size, nullptr, A_NOTHING);
  class_register(space, made);
  return made;
}

} // namespace

/// Registered in the name space kClassName, where only these are.
struct PublishedObject::Entry {
  t_object object;
  std::shared_ptr<void>* what;
};

std::unique_ptr<PublishedObject> PublishedObject::make(std::string_view name,
                                                       std::shared_ptr<void> what) {
  const Critical all_modules;
  t_symbol* const space = gensym(kClassName);
  t_symbol* const symbol = symbol_of(name);
  if (object_findregistered(space, symbol))
    return nullptr;
  auto* entry = static_cast<Entry*>(object_alloc(published_class(sizeof(Entry))));
  if (!entry)
    return nullptr;
  entry->what = new std::shared_ptr<void>(std::move(what));
  object_register(space, symbol, entry);
  return std::unique_ptr<PublishedObject>(new PublishedObject(entry));
}

PublishedObject::~PublishedObject() {
  const std::unique_ptr<std::shared_ptr<void>> what(entry_->what); // ends outside of the region
  const Critical all_modules;
  object_unregister(entry_);
  entry_->what = nullptr;
  object_free(entry_);
}

std::shared_ptr<void> find_published(std::string_view name) {
  const Critical all_modules;
  auto* entry = static_cast<PublishedObject::Entry*>(
      object_findregistered(gensym(kClassName), symbol_of(name)));
  return entry && entry->what ? *entry->what : nullptr;
}

} // namespace tactus::max
