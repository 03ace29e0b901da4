#include "core/published.hpp"

#include <string>

#include <m_pd.h>

namespace tactus {
namespace {

constexpr const char* kClassName = "tactus offer";

/// Each module registers its own class; modules recognise each other's classes by the name.
t_class* published_class(std::size_t size) {
  static t_class* const made =
      class_new(gensym(kClassName), nullptr, nullptr, size, CLASS_PD, A_NULL);
  return made;
}

t_symbol* symbol_of(std::string_view name) {
  return gensym(("tactus offer " + std::string(name)).c_str());
}

} // namespace

/// The object to which the name's symbol is bound.
struct PublishedObject::Entry {
  t_pd pd; // must be first, because the symbol points to it
  t_symbol* symbol;
  std::shared_ptr<void> what;
};

std::unique_ptr<PublishedObject> PublishedObject::make(std::string_view name,
                                                       std::shared_ptr<void> what) {
  t_symbol* symbol = symbol_of(name);
  if (symbol->s_thing)
    return nullptr;
  auto* entry = new Entry{published_class(sizeof(Entry)), symbol, std::move(what)};
  pd_bind(&entry->pd, symbol);
  return std::unique_ptr<PublishedObject>(new PublishedObject(entry));
}

PublishedObject::~PublishedObject() {
  pd_unbind(&entry_->pd, entry_->symbol);
  delete entry_;
}

std::shared_ptr<void> find_published(std::string_view name) {
  const t_symbol* symbol = symbol_of(name);
  if (!symbol->s_thing || std::string_view(class_getname(*symbol->s_thing)) != kClassName)
    return nullptr;
  return reinterpret_cast<PublishedObject::Entry*>(symbol->s_thing)->what;
}

} // namespace tactus
