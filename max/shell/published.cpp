#include "core/published.hpp"

#include "max/shell/atoms.hpp"

#include <string>
#include <utility>

namespace tactus {
namespace {

/// The symbol's name contains the layout of the struct that it points to.
t_symbol* published_symbol(std::string_view name) {
  return max::symbol_of("tactus published 1 " + std::string(name));
}

/// Max's critical region, shared by all modules.
class Critical {
public:
  Critical() { critical_enter(nullptr); }
  ~Critical() { critical_exit(nullptr); }
  Critical(const Critical&) = delete;
  Critical& operator=(const Critical&) = delete;
};

} // namespace

/// Bound to the name's symbol. It begins as Max's objects do, but without their magic number, so
/// that Max ignores messages sent to the symbol.
struct PublishedObject::Entry {
  t_object header;
  t_symbol* symbol;
  std::shared_ptr<void> what;
};

std::unique_ptr<PublishedObject> PublishedObject::make(std::string_view name,
                                                       std::shared_ptr<void> what) {
  t_symbol* symbol = published_symbol(name);
  auto entry = std::make_unique<Entry>(Entry{{}, symbol, std::move(what)});
  const Critical all_modules;
  if (symbol->s_thing)
    return nullptr;
  symbol->s_thing = &entry->header;
  return std::unique_ptr<PublishedObject>(new PublishedObject(entry.release()));
}

PublishedObject::~PublishedObject() {
  {
    const Critical all_modules;
    entry_->symbol->s_thing = nullptr;
  }
  delete entry_; // outside the critical region, since this may destroy the shared object
}

std::shared_ptr<void> find_published(std::string_view name) {
  const t_symbol* symbol = published_symbol(name);
  const Critical all_modules;
  return symbol->s_thing ? reinterpret_cast<PublishedObject::Entry*>(symbol->s_thing)->what
                         : nullptr;
}

} // namespace tactus
