// The objects that externals get: classes, boxes, outlets and inlets. Checks that externals free
// them all.
#include "max/stub/stub.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace tactus::stub {
namespace {
constexpr intptr_t kMagic = 1758379419;
constexpr std::size_t kBefore = 16; // bytes before a box's struct
// Reachable until the end, so that a sanitizer reports only the leaks of externals.
auto& living = *new std::vector<Object*>;
auto& every_object = *new std::vector<Object*>;
auto& classes = *new std::vector<t_class*>;

/// The methods that Max itself calls, with its own arguments (A_CANT) or with a message's.
const std::map<std::string_view, std::vector<short>>& methods_of_max() {
  static const std::map<std::string_view, std::vector<short>> types{
      {"assist", {A_CANT}},
      {"dsp64", {A_CANT}},
      {"acceptsdrag_locked", {A_CANT}},
      {"acceptsdrag_unlocked", {A_CANT}},
      {"getvalueof", {A_CANT}},
      {"setvalueof", {A_CANT}},
      {"bang", {}},
      {"preset", {}},
      {"int", {A_LONG}},
      {"float", {A_FLOAT}},
      {"symbol", {A_SYM}},
      {"list", {A_GIMME}},
      {"anything", {A_GIMME}}};
  return types;
}

void check_method(const t_class& c, const std::string& name, const std::vector<short>& types) {
  const auto known = methods_of_max().find(name);
  const bool wrong = known == methods_of_max().end() ? types == std::vector<short>{A_CANT}
                                                     : types != known->second;
  if (wrong)
    violation(name + " has other types than Max's, or Max calls no such method");
  if (c.methods.count(name) || c.attribute(name))
    violation(name + " is there twice");
}

Object* in_constructor(void* x, const char* function) {
  Object* object = require_object(x, function);
  if (object && object->constructed)
    violation(std::string(function) + ": outside the constructor");
  return object;
}

/// Checks a box after its constructor.
void check_construction(Object& object) {
  const std::string start = object.text() + ": ";
  if (object.type->dsp && !object.in_chain)
    violation(start + "the constructor did not call z_dsp_setup");
  if (!object.proxies.empty() && object.proxies.back()->id != 1)
    violation(start + "the leftmost proxy is not that of inlet 1");
  if (object.dumpout && object.outlets.size() > 1 && object.dumpout == object.outlets.front())
    violation(start + "dumpout is the leftmost outlet: make outlets from right to left");
}

void report(const t_object* x, const char* kind, const char* format, va_list& arguments) {
  std::array<char, 2048> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  print_line(std::string(kind) + ": " + (x ? require_object(x, kind)->text() : "nobody") + ": " +
             text.data());
}

void* send(void* address, const char* function, std::string_view selector,
           std::span<const t_atom> atoms) {
  const ApiCall api(function);
  const Outlet* outlet = require<Outlet>(address, function);
  if (!outlet)
    return nullptr;
  if (outlet->signal)
    violation(std::string(function) + ": to a signal outlet");
  Call* call = current_call();
  if (!call || call->where == Where::kFree)
    violation(std::string(function) + ": nothing can be sent from here");
  for (; call; call = call->outer) {
    call->sent = true;
    if (call->held > 0)
      violation(std::string(function) + ": within a critical region");
  }
  const auto& all = outlet->owner->outlets;
  const auto index = std::find(all.begin(), all.end(), outlet) - all.begin();
  const std::string text = to_text(atoms);
  print_line("out: " + to_text(std::array{float_atom(now_ms())}) + " " + outlet->owner->id + " " +
             std::to_string(index) + " " + std::string(selector) +
             (text.empty() ? "" : " " + text));
  return nullptr;
}
} // namespace

void keep(Record& record) {
  record.owner = current_call() ? current_call()->object : nullptr;
  if (record.owner)
    record.owner->made.push_back(&record);
}

Record* require_record(const void* address, Kind kind, const char* function) {
  auto* record = static_cast<Record*>(const_cast<void*>(address));
  if (!record || record->kind != kind)
    violation(std::string(function) + (record ? ": of another kind of thing" : ": null"));
  else if (!record->alive)
    violation(std::string(function) + ": use of a thing after it was freed");
  else
    return record;
  return nullptr;
}

Object* require_object(const void* x, const char* function) {
  Object* object = nullptr;
  if (x)
    std::memcpy(&object, static_cast<const std::byte*>(x) - kBefore, sizeof object);
  if (object && object->alive && object->header()->z_ob.o_magic == kMagic)
    return object;
  violation(std::string(function) + ": not a living object");
  return nullptr;
}

std::string Object::text() const { return type->name + (id.empty() ? "" : " " + id); }
const std::vector<Object*>& living_objects() { return living; }

t_class* find_class(std::string_view name) {
  const auto found = std::find_if(classes.begin(), classes.end(),
                                  [&](const t_class* c) { return c->name == name; });
  return found == classes.end() ? nullptr : *found;
}

Object* make_object(const std::string& id, std::string_view class_name,
                    std::span<t_atom> arguments) {
  t_class* c = find_class(class_name);
  if (!c) {
    print_error(nullptr, std::string(class_name) + ": no such object");
    return nullptr;
  }
  Call call{.where = Where::kConstruct};
  const std::size_t before = living.size();
  void* made = nullptr;
  run_external(call, [&] {
    made = as<void* (*)(t_symbol*, long, t_atom*)>(c->constructor)(
        symbol(class_name), static_cast<long>(arguments.size()), arguments.data());
  });
  if (!made) {
    if (living.size() != before)
      violation(std::string(class_name) +
                ": the constructor did not free what it made and does not return");
    print_error(nullptr, std::string(class_name) + ": could not be made");
    return nullptr;
  }
  Object* object = require_object(made, "the constructor's result");
  object->id = id;
  check_construction(*object);
  object->constructed = true;
  return object;
}

void free_object(Object& object) {
  Call call{.where = Where::kFree, .object = &object};
  run_external(call, [&] { object.type->destructor(object.header()); });
  if (object.in_chain)
    violation("z_dsp_free was not called by the free method of " + object.text());
  for (Record* record : object.made)
    if (record->alive.exchange(false) && record->kind != Kind::kOutlet)
      violation("leak: " + object.text() + " did not free a proxy, clock, qelem or buffer_ref");
  forget_timers(object);
  object.alive = false;
  std::erase(living, &object);
}

} // namespace tactus::stub

using namespace tactus::stub;

#if defined(__clang__) // Max's class_new has a short before its variadic arguments
#pragma clang diagnostic ignored "-Wvarargs"
#endif

const t_class::Method* t_class::find(std::string_view method_name) const {
  const auto found = methods.find(method_name);
  return found == methods.end() ? nullptr : &found->second;
}
Attribute* t_class::attribute(std::string_view attribute_name) const {
  const auto found = std::find_if(attributes.begin(), attributes.end(),
                                  [&](const Attribute* a) { return a->name == attribute_name; });
  return found == attributes.end() ? nullptr : *found;
}

// The signature is Max's (max/abi/max_abi.h); every class of ours takes A_GIMME.
t_class* class_new(const char* name, method constructor, method destructor, long size, method,
                   short type, ...) {
  const ApiCall api("class_new", kMain);
  if (type != A_GIMME || !constructor || !destructor)
    violation("class_new: expected a constructor that takes A_GIMME, and a free method");
  auto* c = new t_class;
  c->name = name;
  c->constructor = constructor;
  c->destructor = destructor;
  c->size = static_cast<std::size_t>(size);
  return c;
}

t_max_err class_addmethod(t_class* c, method function, const char* name, ...) {
  const ApiCall api("class_addmethod", kMain);
  std::vector<short> types;
  va_list rest;
  va_start(rest, name);
  for (int type = va_arg(rest, int); type != A_NOTHING; type = va_arg(rest, int)) {
    if (type < 0 || type > A_CANT || types.size() == 7) {
      violation(c->name + ": the types of " + name + " do not end with 0");
      break;
    }
    types.push_back(static_cast<short>(type));
  }
  va_end(rest);
  check_method(*c, name, types);
  c->methods[name] = {function, std::move(types)};
  return 0;
}

t_object* attribute_new(const char* name, t_symbol* type, long, method getter, method setter) {
  const ApiCall api("attribute_new", kMain);
  auto* a = new Attribute;
  a->name = name;
  a->type = type->s_name;
  a->getter = getter;
  a->setter = setter;
  return reinterpret_cast<t_object*>(a);
}
t_max_err class_addattr(t_class* c, t_object* attribute) {
  const ApiCall api("class_addattr", kMain);
  auto* a = require<Attribute>(attribute, "class_addattr");
  if (c->find(a->name) || c->attribute(a->name))
    violation("class_addattr: " + a->name + " is there twice");
  c->attributes.push_back(a);
  return 0;
}
t_max_err class_attr_addattr_parse(t_class* c, const char* attribute, const char* property,
                                   t_symbol*, long, const char* text) {
  const ApiCall api("class_attr_addattr_parse", kMain);
  if (Attribute* a = c->attribute(attribute))
    a->properties[property] = text;
  else
    violation(std::string("class_attr_addattr_parse: there is no attribute ") + attribute);
  return 0;
}
t_max_err class_register(t_symbol*, t_class* c) {
  const ApiCall api("class_register", kMain);
  if (c->dsp != (c->find("dsp64") != nullptr))
    violation("class_register: class_dspinit and a method dsp64 go together");
  classes.push_back(c);
  return 0;
}

void* object_alloc(t_class* c) {
  const ApiCall api("object_alloc", kMain);
  auto* object = new Object;
  object->type = require<t_class>(c, "object_alloc");
  auto* memory = static_cast<std::byte*>(std::malloc(kBefore + c->size));
  std::memset(memory, 0xCD, kBefore + c->size); // because Max does not set the memory to zero
  std::memcpy(memory, &object, sizeof object);
  object->memory = memory + kBefore;
  object->header()->z_ob = {nullptr, kMagic, nullptr, nullptr};
  if (c->dsp)
    *object->header() = {object->header()->z_ob, 0, nullptr, 0, 0, 0};
  current_call()->object = object;
  living.push_back(object);
  every_object.push_back(object);
  return object->memory;
}

t_max_err object_free(void* x) {
  const ApiCall api("object_free");
  if (Call* call = current_call(); call && call->object && call->object->memory == x) {
    if (call->where != Where::kConstruct)
      violation("object_free: a box is freed by its patcher only");
    else
      free_object(*std::exchange(call->object, nullptr));
    return 0;
  }
  auto* record = static_cast<Record*>(x);
  if (!record || !record->alive.exchange(false))
    violation("object_free: null, or freed twice");
  else if (record->kind == Kind::kClock)
    free_clock(*record);
  else if (record->kind != Kind::kProxy && record->kind != Kind::kBufferRef)
    violation("object_free does not free this kind of thing");
  return 0;
}

t_max_err object_obex_store(void* x, t_symbol*, t_object* outlet) { // supports only dumpout
  const ApiCall api("object_obex_store", kMain);
  require_object(x, "object_obex_store")->dumpout = require<Outlet>(outlet, "object_obex_store");
  return 0;
}
t_max_err object_obex_lookup(void* x, t_symbol*, t_object** value) { // supports only the patcher
  const ApiCall api("object_obex_lookup");
  require_object(x, "object_obex_lookup");
  *value = patcher();
  return 0;
}

void object_post(t_object* x, const char* format, ...) {
  const ApiCall api("object_post");
  va_list arguments;
  va_start(arguments, format);
  report(x, "post", format, arguments);
  va_end(arguments);
}
void object_error(t_object* x, const char* format, ...) {
  const ApiCall api("object_error");
  va_list arguments;
  va_start(arguments, format);
  report(x, "error", format, arguments);
  va_end(arguments);
}

void* outlet_new(void* x, const char* type) {
  const ApiCall api("outlet_new", kMain);
  Object* object = in_constructor(x, "outlet_new");
  auto* outlet = new Outlet;
  keep(*outlet);
  outlet->signal = type && std::string_view(type) == "signal";
  object->outlets.insert(object->outlets.begin(), outlet);
  return outlet;
}
void* outlet_bang(void* outlet) { return send(outlet, "outlet_bang", "bang", {}); }
void* outlet_float(void* outlet, double value) {
  return send(outlet, "outlet_float", "float", std::array{float_atom(value)});
}
void* outlet_list(void* outlet, t_symbol*, short count, t_atom* atoms) {
  return send(outlet, "outlet_list", "list", {atoms, static_cast<std::size_t>(count)});
}
void* outlet_anything(void* outlet, t_symbol* s, short count, t_atom* atoms) {
  return send(outlet, "outlet_anything", s->s_name, {atoms, static_cast<std::size_t>(count)});
}

void* proxy_new(void* x, long id, long* inlet) {
  const ApiCall api("proxy_new", kMain);
  Object* object = in_constructor(x, "proxy_new");
  if (object->in_chain || (!object->proxies.empty() && id != object->proxies.back()->id - 1))
    violation(
        "proxy_new: make inlets from right to left, and the signal inlets last, with z_dsp_setup");
  if (id < 1 || !inlet)
    violation("proxy_new: no inlet, or nowhere to write its number");
  auto* proxy = new Proxy;
  keep(*proxy);
  proxy->id = id;
  proxy->inlet = inlet;
  object->proxies.push_back(proxy);
  return proxy;
}
long proxy_getinlet(t_object* x) {
  const ApiCall api("proxy_getinlet");
  const Call* call = current_call();
  if (!call || call->inlet < 0 || call->object != require_object(x, "proxy_getinlet"))
    violation("proxy_getinlet: outside a message to the object");
  else if (call->sent)
    violation("proxy_getinlet: after an outlet was used, which may have changed it");
  return call ? call->inlet : 0;
}
