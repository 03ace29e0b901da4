// Outlets, and the proxies of right inlets.
#include "max/stub/audio.hpp"
#include "max/stub/kernel.hpp"

#include <array>

namespace tactus::stub {
namespace {
constexpr int kMaxDepth = 200; // of messages that a message causes
constinit thread_local int depth = 0;

Object* owner_in_constructor(void* x, const char* function) {
  Object* object = require_object(x, function);
  if (object &&
      (object->constructed || !current_call() || current_call()->where != Where::kConstruct)) {
    violation(std::string(function) + ": outside the constructor of " + object->text());
    return nullptr;
  }
  return object;
}

void check_type(const Outlet& outlet, const char* function, std::string_view selector) {
  if (outlet.signal())
    violation(std::string(function) + ": to a signal outlet");
  else if (!outlet.type.empty() && outlet.type != selector && outlet.type != "anything")
    violation(std::string(function) + ": " + std::string(selector) + " to an outlet of type " +
              outlet.type);
}

void* send(void* address, const char* function, std::string_view selector,
           std::span<t_atom> atoms) {
  const ApiCall api(function);
  Outlet* outlet = require<Outlet>(address, function);
  if (!outlet)
    return nullptr;
  check_type(*outlet, function, selector);
  Call* call = current_call();
  if (!call)
    violation(std::string(function) + ": outside any call of Max");
  else if (call->where == Where::kFree || call->where == Where::kLoad ||
           call->where == Where::kAssist)
    violation(std::string(function) + ": nothing can be sent from here");
  for (Call* c = call; c; c = c->outer) {
    c->sent = true;
    if (c->critical > 0)
      violation(std::string(function) + ": within a critical region");
  }
  Object& object = *outlet->owner;
  std::size_t index = 0;
  while (index < object.outlets.size() && object.outlets[index] != outlet)
    ++index;
  const std::string text = to_text(atoms);
  print_line("out: " + to_text(std::array{float_atom(now_ms())}) + " " + object.id + " " +
             std::to_string(index) + " " + std::string(selector) +
             (text.empty() ? "" : " " + text));
  if (depth >= kMaxDepth) {
    print_error(&object, "stack overflow: its messages come back to it");
    return nullptr;
  }
  ++depth;
  const std::vector<t_atom> copy(atoms.begin(), atoms.end());
  for (const Outlet::Cord& cord : outlet->cords) {
    std::vector<t_atom> own = copy;
    send_message(*cord.receiver, cord.inlet, selector, own);
  }
  --depth;
  return nullptr;
}
} // namespace
} // namespace tactus::stub

using namespace tactus::stub;

void* outlet_new(void* x, const char* type) {
  const ApiCall api("outlet_new", static_cast<unsigned>(Role::kMain));
  Object* object = owner_in_constructor(x, "outlet_new");
  if (!object)
    return nullptr;
  auto* outlet = new Outlet;
  add_record(outlet, outlet);
  outlet->owner = object;
  outlet->type = type ? type : "";
  static constexpr std::array<std::string_view, 8> kTypes{
      "", "signal", "bang", "int", "float", "list", "anything", "multichannelsignal"};
  bool known = false;
  for (std::string_view t : kTypes)
    known = known || t == outlet->type;
  if (!known)
    violation("outlet_new: no type of outlets: " + outlet->type);
  object->outlets.insert(object->outlets.begin(), outlet);
  return outlet;
}
void* outlet_bang(void* outlet) { return send(outlet, "outlet_bang", "bang", {}); }
void* outlet_float(void* outlet, double value) {
  t_atom a = float_atom(value);
  return send(outlet, "outlet_float", "float", {&a, 1});
}
void* outlet_list(void* outlet, t_symbol* s, short count, t_atom* atoms) {
  const HostWork work;
  if (s && check_symbol(s, "outlet_list") && name_of(s) != "list")
    violation("outlet_list: a selector other than list");
  if (!check_atoms(count, atoms, "outlet_list"))
    return nullptr;
  return send(outlet, "outlet_list", "list", {atoms, static_cast<std::size_t>(count)});
}
void* outlet_anything(void* outlet, t_symbol* s, short count, t_atom* atoms) {
  const HostWork work;
  if (!check_symbol(s, "outlet_anything") || !check_atoms(count, atoms, "outlet_anything"))
    return nullptr;
  return send(outlet, "outlet_anything", name_of(s), {atoms, static_cast<std::size_t>(count)});
}

void* proxy_new(void* x, long id, long* inlet) {
  const ApiCall api("proxy_new", static_cast<unsigned>(Role::kMain));
  Object* object = owner_in_constructor(x, "proxy_new");
  if (!object)
    return nullptr;
  const std::string start = "proxy_new: " + object->text() + ": ";
  if (object->dsp_set_up)
    violation(start + "after z_dsp_setup, so it is left of the signal inlets");
  if (!object->proxies.empty() && id != object->proxies.back()->id - 1)
    violation(start + "inlet " + std::to_string(id) + " after " +
              std::to_string(object->proxies.back()->id) + ": make inlets from right to left");
  if (id < 1 || !inlet)
    violation(start + "no inlet, or nowhere to write its number");
  auto* proxy = new Proxy;
  add_record(proxy, proxy);
  proxy->owner = object;
  proxy->id = id;
  proxy->inlet = inlet;
  object->proxies.push_back(proxy);
  return proxy;
}

long proxy_getinlet(t_object* x) {
  const ApiCall api("proxy_getinlet");
  Object* object = require_object(x, "proxy_getinlet");
  const Call* call = current_call();
  if (!call || (!call->has_inlet && call->where != Where::kSetter))
    violation("proxy_getinlet: outside a message");
  else if (call->object != object)
    violation("proxy_getinlet: of another object than the message's");
  else if (call->sent)
    violation("proxy_getinlet: after an outlet was used, which may have changed it");
  return call ? call->inlet : 0;
}
