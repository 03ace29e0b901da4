// Objects: from object_alloc in a constructor to object_free.
#include "max/stub/audio.hpp"
#include "max/stub/kernel.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>

namespace tactus::stub {
namespace {
std::vector<Object*> living;

struct Patcher : Record {
  Patcher() : Record(Kind::kPatcher) { header.o_magic = kMagic; }
  t_object header{};
};
Patcher* make_patcher() {
  auto* fresh = new Patcher;
  add_record(&fresh->header, fresh);
  return fresh;
}
Patcher& main_patcher() {
  static Patcher& instance = *make_patcher();
  return instance;
}
Patcher& subpatcher() {
  static Patcher& instance = *make_patcher();
  return instance;
}
bool in_subpatcher = false;

/// What must be true of a box once its constructor is done.
void check_construction(Object& object) {
  const std::string start = object.text() + ": ";
  const t_class& c = *object.type;
  if (c.dsp && !object.dsp_set_up)
    violation(start + "the constructor did not call z_dsp_setup");
  if (!object.proxies.empty() && object.proxies.back()->id != 1)
    violation(start + "the leftmost proxy has the number " +
              std::to_string(object.proxies.back()->id) + ", expected 1");
  const auto dumpout = object.obex.find(symbol("dumpout"));
  if (dumpout != object.obex.end() && object.outlets.size() > 1 &&
      dumpout->second == reinterpret_cast<t_object*>(object.outlets.front()))
    violation(start + "dumpout is the leftmost outlet: make outlets from right to left");
  for (std::size_t i = 0; i < object.outlets.size(); ++i)
    if (!c.dsp && object.outlets[i]->signal())
      violation(start + "a signal outlet of a class without class_dspinit");
  for (std::size_t i = 0; i < object.outlets.size() && c.find("assist"); ++i) {
    const std::string text = assist_text(object, ASSIST_OUTLET, static_cast<long>(i));
    const bool says_signal = text.starts_with("(signal");
    if (says_signal != object.outlets[i]->signal() && (says_signal || text.starts_with('(')))
      violation(start + "outlet " + std::to_string(i) + " is " +
                (object.outlets[i]->signal() ? "a" : "no") +
                " signal outlet, but assist says: " + text);
  }
}

void* construct(t_class& c, Call& call, std::string_view name, std::span<t_atom> arguments) {
  void* made = nullptr;
  run_external(call, [&] {
    if (c.types == std::vector<short>{A_GIMME})
      made = as<void* (*)(t_symbol*, long, t_atom*)>(c.constructor)(
          symbol(name), static_cast<long>(arguments.size()), arguments.data());
    else
      made = c.types.empty() ? as<void* (*)()>(c.constructor)() : nullptr;
  });
  return made;
}

/// Whether one of the arguments is @ and the name of an attribute; @ and a message is the object's.
bool has_attribute_argument(const t_class& c, std::span<t_atom> arguments) {
  return std::any_of(arguments.begin(), arguments.end(), [&c](const t_atom& a) {
    return a.a_type == A_SYM && name_of(a.a_w.w_sym).substr(0, 1) == "@" &&
           c.attribute(name_of(a.a_w.w_sym).substr(1));
  });
}

void report(const t_object* x, const char* kind, const char* format, va_list& arguments) {
  std::array<char, 2048> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  const Record* record = x ? find_record(x) : nullptr;
  std::string owner = "nobody";
  if (record && record->kind == Kind::kObject)
    owner = static_cast<const Object*>(record)->text();
  else if (x && (!record || record->kind != Kind::kPatcher))
    violation(std::string("object_") + kind + ": not an object of Max");
  print_line(std::string(kind) + ": " + owner + ": " + text.data());
}
} // namespace

std::string Object::text() const { return type->name + (id.empty() ? "" : " " + id); }
const std::vector<Object*>& living_objects() { return living; }
t_object* patcher() { return &(in_subpatcher ? subpatcher() : main_patcher()).header; }
t_object* parent_patcher() { return in_subpatcher ? &main_patcher().header : nullptr; }
void use_subpatcher(bool yes) { in_subpatcher = yes; }

Object* require_object(const void* x, const char* function) {
  Object* object = require<Object>(x, function);
  if (object && object->header()->o_magic != kMagic)
    violation(std::string(function) + ": the header of " + object->text() + " was overwritten");
  return object;
}

Object* make_object(const std::string& id, std::string_view class_name,
                    std::span<t_atom> arguments) {
  t_class* c = find_class(class_name);
  if (!c) {
    print_error(nullptr, std::string(class_name) + ": no such object");
    return nullptr;
  }
  Call call{.where = Where::kConstruct, .name = id};
  symbol("#P")->s_thing = patcher();
  void* made = construct(*c, call, class_name, arguments);
  symbol("#P")->s_thing = nullptr;
  for (const Object* object : living)
    if (!object->constructed && object->alive && object->header() != made)
      violation("the constructor of " + object->text() +
                " did not free what it made and does not return");
  if (!made) {
    print_error(nullptr, std::string(class_name) + ": could not be made");
    return nullptr;
  }
  Object* object = require_object(made, "the constructor's result");
  if (!object)
    return nullptr;
  object->id = id;
  if (has_attribute_argument(*c, arguments) && !object->attributes_processed)
    violation(object->text() + ": attributes among the arguments, but no attr_args_process");
  check_construction(*object);
  object->constructed = true;
  return object;
}

void free_object(Object& object) {
  Call call{.where = Where::kFree, .object = &object};
  for (Object* other : living) // patch cords to it
    for (Outlet* outlet : other->outlets)
      std::erase_if(outlet->cords,
                    [&](const Outlet::Cord& cord) { return cord.receiver == &object; });
  if (object.type->destructor)
    run_external(call, [&] { object.type->destructor(object.header()); });
  if (object.type->dsp && object.dsp_set_up && !object.dsp_freed)
    violation(object.text() + ": z_dsp_free was not called by the free method");
  remove_from_chain(object);
  if (object.header()->o_magic != kMagic)
    violation(object.text() + ": its header was overwritten");
  if (!object.block.guards_intact())
    violation(object.text() + ": a write beyond its struct");
  report_leaks(&object);
  forget_owner(object);
  for (Outlet* outlet : object.outlets)
    outlet->alive = false;
  object.alive = false;
  object.block.bury();
  std::erase(living, &object);
}

} // namespace tactus::stub

using namespace tactus::stub;

void* object_alloc(t_class* c) {
  const ApiCall api("object_alloc", static_cast<unsigned>(Role::kMain));
  t_class* type = require<t_class>(c, "object_alloc");
  if (!type)
    return nullptr;
  Call* call = current_call();
  if (!call || call->where != Where::kConstruct)
    violation("object_alloc: outside a constructor");
  if (!type->registered)
    violation("object_alloc: " + type->name + " was not registered");
  auto* object = new Object(type, type->size);
  add_record(object->block.data(), object);
  object->owner = nullptr;
  t_object& header = *object->header();
  header = {nullptr, kMagic, nullptr, nullptr};
  if (type->dsp && type->size >= sizeof(t_pxobject)) {
    auto& px = *reinterpret_cast<t_pxobject*>(object->block.data());
    px = {header, 0, nullptr, 0, 0, 0};
  }
  if (call)
    call->object = object;
  living.push_back(object);
  return object->block.data();
}

t_max_err object_free(void* x) {
  const ApiCall api("object_free");
  Record* record = find_record(x);
  if (!record) {
    violation(x ? "object_free: not an object that Max gave" : "object_free: null");
    return -1;
  }
  if (!record->alive) {
    violation(std::string("object_free: double free of ") + kind_name(record->kind));
    return -1;
  }
  const Call* call = current_call();
  switch (record->kind) {
  case Kind::kObject: {
    auto& object = static_cast<Object&>(*record);
    if (object.constructed || !call || call->where != Where::kConstruct)
      violation("object_free: a box is freed by its patcher only");
    else
      free_object(object);
    return 0;
  }
  case Kind::kClock:
    free_clock(*record);
    return 0;
  case Kind::kProxy:
    if (static_cast<Proxy*>(record)->of_dsp)
      violation("object_free: a proxy of z_dsp_setup, which z_dsp_free frees");
    record->alive = false;
    return 0;
  case Kind::kBufferRef:
    record->alive = false;
    return 0;
  default:
    violation(std::string("object_free does not free this kind: ") + kind_name(record->kind));
    return -1;
  }
}

t_max_err object_obex_store(void* x, t_symbol* key, t_object* value) {
  const ApiCall api("object_obex_store", static_cast<unsigned>(Role::kMain));
  Object* object = require_object(x, "object_obex_store");
  if (!object || !check_symbol(key, "object_obex_store"))
    return -1;
  if (name_of(key) == "dumpout" && !require<Outlet>(value, "object_obex_store"))
    return -1;
  object->obex[key] = value;
  return 0;
}
t_max_err object_obex_lookup(void* x, t_symbol* key, t_object** value) {
  const ApiCall api("object_obex_lookup");
  Object* object = require_object(x, "object_obex_lookup");
  if (!object || !value || !check_symbol(key, "object_obex_lookup"))
    return -1;
  *value = nullptr;
  if (name_of(key) == "#P")
    *value = patcher();
  else if (const auto found = object->obex.find(key); found != object->obex.end())
    *value = found->second;
  return *value ? 0 : -1;
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
