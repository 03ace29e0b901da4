// Classes, their methods and attributes, as ext_main declares them.
#include "max/stub/kernel.hpp"

#include <algorithm>
#include <cstdarg>

namespace tactus::stub {
namespace {
std::vector<t_class*> registered;

/// Reads variadic type codes up to the 0; a violation when they are no list of types.
std::vector<short> read_types(int first, va_list& rest, const std::string& what) {
  std::vector<short> types;
  for (int type = first; type != 0; type = va_arg(rest, int)) {
    if (type < A_LONG || type > A_CANT || types.size() == 7) {
      violation(what + ": the types do not end with 0, or one is none: " + std::to_string(type));
      return types;
    }
    types.push_back(static_cast<short>(type));
  }
  const bool alone =
      std::any_of(types.begin(), types.end(), [](short t) { return t == A_GIMME || t == A_CANT; });
  if (alone && types.size() > 1)
    violation(what + ": A_GIMME and A_CANT stand alone");
  return types;
}

/// What Max itself calls, with its own arguments, and what it calls with those of a message.
struct KnownMethod {
  std::string_view name;
  std::vector<short> types;
};
const std::vector<KnownMethod>& known_methods() {
  static const std::vector<KnownMethod> known{{"assist", {A_CANT}},
                                              {"dsp64", {A_CANT}},
                                              {"loadbang", {A_CANT}},
                                              {"dspstate", {A_CANT}},
                                              {"inletinfo", {A_CANT}},
                                              {"notify", {A_CANT}},
                                              {"dblclick", {A_CANT}},
                                              {"edclose", {A_CANT}},
                                              {"acceptsdrag_locked", {A_CANT}},
                                              {"acceptsdrag_unlocked", {A_CANT}},
                                              {"savestate", {A_CANT}},
                                              {"appendtodictionary", {A_CANT}},
                                              {"fileusage", {A_CANT}},
                                              {"multichanneloutputs", {A_CANT}},
                                              {"inputchanged", {A_CANT}},
                                              {"okclose", {A_CANT}},
                                              {"stringize", {A_CANT}},
                                              {"getvalueof", {A_CANT}},
                                              {"setvalueof", {A_CANT}},
                                              {"attr_modified", {A_CANT}},
                                              {"bang", {}},
                                              {"preset", {}},
                                              {"int", {A_LONG}},
                                              {"float", {A_FLOAT}},
                                              {"list", {A_GIMME}},
                                              {"anything", {A_GIMME}}};
  return known;
}

void check_method(const t_class& c, const std::string& name, const std::vector<short>& types) {
  const std::string what = "class_addmethod: " + c.name + ": " + name;
  static constexpr std::string_view kReserved[]{"signal", "userconnect", "nsiginlets", "enable"};
  if (std::find(std::begin(kReserved), std::end(kReserved), name) != std::end(kReserved))
    violation(what + " is a name that Max reserves");
  if (c.methods.count(name))
    violation(what + " is there twice");
  if (c.attribute(name))
    violation(what + " is an attribute too");
  const auto known = std::find_if(known_methods().begin(), known_methods().end(),
                                  [&](const KnownMethod& k) { return k.name == name; });
  const bool cannot = types == std::vector<short>{A_CANT};
  if (known == known_methods().end()) {
    if (cannot)
      violation(what + ": Max calls no method of this name (A_CANT)");
  } else if (types != known->types)
    violation(what + " has other types than Max's");
}

bool open_class(t_class* c, const char* function) {
  const auto* type = require<t_class>(c, function);
  if (type && type->registered)
    violation(std::string(function) + ": after class_register of " + type->name);
  return type != nullptr;
}
} // namespace

bool Attribute::saved() const {
  const auto found = properties.find("save");
  return found != properties.end() && found->second == "1";
}
t_class* find_class(std::string_view name) {
  for (t_class* c : registered)
    if (c->name == name)
      return c;
  return nullptr;
}
const std::vector<t_class*>& classes() { return registered; }

} // namespace tactus::stub

using namespace tactus::stub;

#if defined(__clang__) // Max's class_new has a short before its variadic arguments
#pragma clang diagnostic ignored "-Wvarargs"
#endif

const Method* t_class::find(std::string_view method_name) const {
  const auto found = methods.find(method_name);
  return found == methods.end() ? nullptr : &found->second;
}
Attribute* t_class::attribute(std::string_view attribute_name) const {
  for (Attribute* a : attributes)
    if (a->name == attribute_name)
      return a;
  return nullptr;
}

// The signature is Max's (max/abi/max_abi.h).
t_class* class_new(const char* name, method constructor, method destructor, long size, method menu,
                   short type, ...) {
  const ApiCall call("class_new", static_cast<unsigned>(Role::kMain));
  auto* c = new t_class;
  c->name = name ? name : "";
  add_record(c, c);
  const std::string what = "class_new: " + c->name;
  if (c->name.empty())
    violation("class_new: no name");
  if (!constructor)
    violation(what + ": no constructor");
  if (menu)
    violation(what + ": a menu function, which 64-bit Max does not know");
  if (!current_call() || current_call()->where != Where::kLoad)
    violation(what + ": outside ext_main");
  if (size < static_cast<long>(sizeof(t_object)))
    violation(what + ": the struct is smaller than t_object");
  va_list rest;
  va_start(rest, type);
  c->types = read_types(type, rest, what);
  va_end(rest);
  c->constructor = constructor;
  c->destructor = destructor;
  c->size = std::max(static_cast<std::size_t>(std::max(size, 0L)), sizeof(t_object));
  return c;
}

t_max_err class_addmethod(t_class* c, method function, const char* name, ...) {
  const ApiCall call("class_addmethod", static_cast<unsigned>(Role::kMain));
  if (!open_class(c, "class_addmethod") || !name)
    return -1;
  va_list rest;
  va_start(rest, name);
  const int first = va_arg(rest, int);
  std::vector<short> types = read_types(first, rest, "class_addmethod: " + c->name + ": " + name);
  va_end(rest);
  if (!function) {
    violation("class_addmethod: " + c->name + ": " + name + ": no function");
    return -1;
  }
  check_method(*c, name, types);
  c->methods[name] = {function, std::move(types)};
  return 0;
}

t_object* attribute_new(const char* name, t_symbol* type, long flags, method getter,
                        method setter) {
  const ApiCall call("attribute_new", static_cast<unsigned>(Role::kMain));
  auto* a = new Attribute;
  add_record(a, a);
  a->name = name ? name : "";
  const std::string what = "attribute_new: " + a->name;
  if (a->name.empty() || a->name.find(' ') != std::string::npos)
    violation(what + ": no name of an attribute");
  static constexpr std::string_view kTypes[]{"float64", "float32", "long",  "symbol",
                                             "atom",    "char",    "object"};
  if (check_symbol(type, "attribute_new")) {
    a->type = name_of(type);
    if (std::find(std::begin(kTypes), std::end(kTypes), a->type) == std::end(kTypes))
      violation(what + ": no type of attributes: " + a->type);
  }
  if (!getter)
    violation(what + ": no getter");
  if (!setter && (flags & 0x202) == 0)
    violation(what + ": no setter, and not marked opaque to setting");
  a->flags = flags;
  a->getter = getter;
  a->setter = setter;
  return reinterpret_cast<t_object*>(a);
}

t_max_err class_addattr(t_class* c, t_object* attribute) {
  const ApiCall call("class_addattr", static_cast<unsigned>(Role::kMain));
  auto* a = require<Attribute>(attribute, "class_addattr");
  if (!open_class(c, "class_addattr") || !a)
    return -1;
  const std::string what = "class_addattr: " + c->name + ": " + a->name;
  if (a->added)
    violation(what + ": it was added before");
  if (c->attribute(a->name))
    violation(what + " is there twice");
  if (c->find(a->name))
    violation(what + " is a method too");
  a->added = true;
  c->attributes.push_back(a);
  return 0;
}

t_max_err class_attr_addattr_parse(t_class* c, const char* attribute, const char* property,
                                   t_symbol* type, long, const char* text) {
  const ApiCall call("class_attr_addattr_parse", static_cast<unsigned>(Role::kMain));
  if (!open_class(c, "class_attr_addattr_parse") || !attribute || !property || !text)
    return -1;
  check_symbol(type, "class_attr_addattr_parse");
  const std::string what = "class_attr_addattr_parse: " + c->name + ": " + attribute;
  Attribute* a = c->attribute(attribute);
  if (!a) {
    violation(what + " is no attribute");
    return -1;
  }
  static constexpr std::string_view kKnown[]{
      "label",        "category", "save",      "style",      "order",      "default",
      "basic",        "enumvals", "invisible", "paint",      "units",      "filterclass",
      "saveatomname", "preserve", "obsolete",  "introduced", "sensitivity"};
  if (std::find(std::begin(kKnown), std::end(kKnown), property) == std::end(kKnown))
    violation(what + ": Max knows no property " + property);
  a->properties[property] = text;
  return 0;
}

t_max_err class_register(t_symbol* name_space, t_class* c) {
  const ApiCall call("class_register", static_cast<unsigned>(Role::kMain));
  if (!open_class(c, "class_register") || !check_symbol(name_space, "class_register"))
    return -1;
  const std::string what = "class_register: " + c->name;
  if (name_of(name_space) != "box" && name_of(name_space) != "nobox")
    violation(what + ": in the name space " + std::string(name_of(name_space)) + ", expected box");
  if (find_class(c->name))
    violation(what + ": there is a class of this name");
  if (c->dsp) {
    if (c->size < sizeof(t_pxobject)) {
      violation(what + ": the struct is smaller than t_pxobject");
      return -1; // its constructor would overrun memory
    }
    if (!c->find("dsp64"))
      violation(what + ": class_dspinit without a method dsp64");
    if (!c->destructor)
      violation(what + ": no free method, so no z_dsp_free");
  } else if (c->find("dsp64"))
    violation(what + ": a method dsp64 without class_dspinit");
  c->registered = true;
  registered.push_back(c);
  return 0;
}
