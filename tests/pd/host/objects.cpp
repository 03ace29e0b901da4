// Symbols, classes, objects, inlets and outlets.
#include "tests/pd/host/internal.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <map>

t_pdinstance pd_maininstance;

namespace tactus::test {
namespace {

std::map<std::string, t_symbol> symbols;
std::vector<std::unique_ptr<t_class>> classes;
std::map<const void*, HostObject> living;

HostObject& owner_of(const void* pd) {
  if (HostObject* const object = host_of(pd))
    return *object;
  die("an object that does not live");
}

std::vector<t_atom> to_pd(const MessageAtoms& given) {
  std::vector<t_atom> atoms(given.size() + 1); // a pointer to none is still one
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (given[i].is_word)
      SETSYMBOL(&atoms[i], gensym(given[i].text.c_str()));
    else
      SETFLOAT(&atoms[i], static_cast<t_float>(given[i].number));
  }
  return atoms;
}

void call(const _class::Method& m, t_pd* pd, t_symbol* selector, int count, t_atom* atoms) {
  if (m.types[0] == A_GIMME)
    as<void(t_pd*, t_symbol*, int, t_atom*)>(m.function)(pd, selector, count, atoms);
  else if (m.types[0] != A_FLOAT || m.types[1] != A_NULL)
    die("a method with arguments that this host does not know");
  else if (count && atoms[0].a_type != A_FLOAT)
    record_error("bad arguments for message");
  else
    as<void(t_pd*, t_floatarg)>(m.function)(pd, count ? atoms[0].a_w.w_float : 0);
}

} // namespace

void die(const char* why) {
  std::fprintf(stderr, "stub host: %s\n", why);
  std::abort();
}

HostObject* host_of(const void* pd) {
  const auto found = living.find(pd);
  return found == living.end() ? nullptr : &found->second;
}

HostObject* Box::make(std::string_view name, const MessageAtoms& arguments) {
  t_symbol* const wanted = gensym(std::string(name).c_str());
  const auto type = std::find_if(classes.begin(), classes.end(),
                                 [&](const auto& known) { return known->name == wanted; });
  if (type == classes.end())
    die(wanted->s_name);
  std::vector<t_atom> given = to_pd(arguments);
  return host_of(as<void*(t_symbol*, int, t_atom*)>((*type)->make)(
      wanted, static_cast<int>(arguments.size()), given.data()));
}

void Box::Deleter::operator()(HostObject* object) const { pd_free(object->pd); }

std::size_t Box::inlets() const { return 1 + object_->inlets.size(); }

void Box::send(std::size_t inlet, std::string_view selector, const MessageAtoms& atoms) {
  std::vector<t_atom> given = to_pd(atoms);
  const auto count = static_cast<int>(atoms.size());
  t_symbol* s = gensym(std::string(selector).c_str());
  if (inlet == 0)
    return pd_typedmess(object_->pd, s, count, given.data());
  t_inlet& i = *object_->inlets[inlet - 1];
  if (s == gensym("list") && count == 1 && given[0].a_type == A_FLOAT)
    s = gensym("float");
  if (i.takes_signal() && s == gensym("float"))
    i.value = given[0].a_w.w_float;
  else if (s == i.from || (i.from == gensym("list") && s == gensym("float")))
    pd_typedmess(i.target, i.to, count, given.data());
  else
    record_error("inlet: expected another type of message");
}

} // namespace tactus::test

using namespace tactus::test;

const _class::Method* _class::method(std::string_view selector) const {
  for (const Method& m : methods)
    if (m.selector->s_name == selector)
      return &m;
  return nullptr;
}

t_symbol* gensym(const char* name) {
  const auto [found, added] = symbols.try_emplace(name);
  if (added)
    found->second.s_name = found->first.c_str();
  return &found->second;
}

t_class* class_new(t_symbol* name, t_newmethod make, t_method drop, std::size_t size, int,
                   t_atomtype, ...) { // classes under test take A_GIMME
  return classes.emplace_back(new _class{name, reinterpret_cast<t_method>(make), drop, size}).get();
}

#pragma GCC diagnostic ignored "-Wvarargs" // Pd declares it so: an enumeration is passed as int
void class_addmethod(t_class* c, t_method function, t_symbol* selector, t_atomtype first, ...) {
  std::vector<t_atomtype> types{first};
  std::va_list rest;
  va_start(rest, first);
  while (types.back() != A_NULL)
    types.push_back(static_cast<t_atomtype>(va_arg(rest, int)));
  va_end(rest);
  c->methods.push_back({selector, function, types});
}
void class_addanything(t_class* c, t_method f) { c->anything = f; }
void class_domainsignalin(t_class* c, int offset) { c->main_signal_offset = offset; }
const char* class_getname(const t_class* c) { return c->name->s_name; }

t_pd* pd_new(t_class* c) {
  auto* const pd = static_cast<t_pd*>(std::calloc(1, c->size));
  *pd = c;
  living.emplace(pd, HostObject{pd, c});
  return pd;
}

void pd_free(t_pd* pd) {
  as<void(t_pd*)>(owner_of(pd).type->drop)(pd);
  living.erase(pd);
  std::free(pd);
}

t_inlet* inlet_new(t_object* owner, t_pd* target, t_symbol* from, t_symbol* to) {
  return owner_of(owner).inlets.emplace_back(new _inlet{target, from, to}).get();
}

t_outlet* outlet_new(t_object* owner, t_symbol* type) {
  auto& outlets = owner_of(owner).outlets;
  return outlets.emplace_back(new _outlet{type, static_cast<int>(outlets.size())}).get();
}

/// To an object, by Pd's rules for classes with an anything method.
void pd_typedmess(t_pd* pd, t_symbol* selector, int count, t_atom* atoms) {
  const t_class& c = **pd;
  // As Pd's default method for lists: a class without a method for what a short list stands for
  // gets the list as it is.
  if (selector == gensym("list") && count == 1 && atoms[0].a_type == A_FLOAT &&
      c.main_signal_offset)
    selector = gensym("float");
  if (selector == gensym("float") && c.main_signal_offset) {
    *reinterpret_cast<t_float*>(reinterpret_cast<char*>(pd) + c.main_signal_offset) =
        count ? atoms[0].a_w.w_float : 0;
    return;
  }
  const _class::Method* const m = c.method(selector->s_name);
  if (m && m->types[0] != A_CANT)
    call(*m, pd, selector, count, atoms);
  else
    as<void(t_pd*, t_symbol*, int, t_atom*)>(c.anything)(pd, selector, count, atoms);
}

/// To an inlet of an object.
void pd_float(t_pd* x, t_float number) {
  for (auto& [pd, object] : living)
    for (auto& inlet : object.inlets)
      if (static_cast<void*>(inlet.get()) == x && inlet->takes_signal()) {
        inlet->value = number;
        return;
      }
  die("pd_float to what is no signal inlet");
}

// Names hold one thing: what is bound here takes care of that itself.
void pd_bind(t_pd* thing, t_symbol* s) {
  if (s->s_thing)
    die("pd_bind to a name that is taken");
  s->s_thing = thing;
}
void pd_unbind(t_pd* thing, t_symbol* s) {
  if (s->s_thing != thing)
    die("pd_unbind of what is not bound");
  s->s_thing = nullptr;
}
