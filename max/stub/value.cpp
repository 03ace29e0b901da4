// The value of a whole box, as pattr and preset ask for it, and whom a box tells that it has
// changed.
#include "max/stub/kernel.hpp"

#include <algorithm>

namespace tactus::stub {
namespace {
using ValueGetter = t_max_err (*)(void*, long*, t_atom**);
using ValueSetter = t_max_err (*)(void*, long, t_atom*);

t_max_err ask_value(Object& object, const Method& m, long& count, t_atom*& atoms) {
  t_max_err error = 0;
  Call call{.where = Where::kGetter, .object = &object, .name = "getvalueof"};
  run_external(call, [&] { error = as<ValueGetter>(m.function)(object.header(), &count, &atoms); });
  return error;
}

/// Asks with memory for one atom, and a guard behind it.
void ask_value_into_memory(Object& object, const Method& m) {
  const Block memory(sizeof(t_atom));
  long count = 1;
  auto* atoms = reinterpret_cast<t_atom*>(memory.data());
  *atoms = long_atom(0);
  ask_value(object, m, count, atoms);
  if (reinterpret_cast<std::byte*>(atoms) != memory.data())
    violation("getvalueof does not use the atoms that it was given: use atom_alloc_array");
  else if (!memory.guards_intact() || count != 1)
    violation("getvalueof returns more atoms than it was given room for");
}
} // namespace

std::vector<t_atom> get_value(Object& object) {
  const HostWork work;
  const Method* m = object.type->find("getvalueof");
  if (!m)
    return {};
  long count = 0;
  t_atom* atoms = nullptr;
  if (ask_value(object, *m, count, atoms) != 0 || count < 1 || !atoms)
    return {};
  Record* record = find_record(atoms);
  if (!record || record->kind != Kind::kAtoms || !record->alive) {
    violation("getvalueof returns atoms that are not from atom_alloc_array");
    return {};
  }
  auto& allocated = static_cast<Atoms&>(*record);
  allocated.alive = false;
  std::vector<t_atom> value;
  if (!allocated.block.guards_intact() || static_cast<std::size_t>(count) > allocated.count)
    violation("getvalueof returns more atoms than atom_alloc_array gave");
  else if (check_atoms(count, atoms, "getvalueof"))
    value.assign(atoms, atoms + count);
  ask_value_into_memory(object, *m);
  return value;
}

bool set_value(Object& object, std::span<t_atom> atoms) {
  const HostWork work;
  const Method* m = object.type->find("setvalueof");
  if (!m)
    return false;
  Call call{.where = Where::kSetter, .object = &object, .name = "setvalueof"};
  run_external(call, [&] {
    as<ValueSetter>(m->function)(object.header(), static_cast<long>(atoms.size()), atoms.data());
  });
  return true;
}

bool ask_for_preset(Object& object) {
  const HostWork work;
  const Method* m = object.type->find("preset");
  if (!m)
    return false;
  Call call{.where = Where::kMessage, .object = &object, .name = "preset"};
  run_external(call, [&] { as<void (*)(void*)>(m->function)(object.header()); });
  return true;
}

} // namespace tactus::stub

using namespace tactus::stub;

t_max_err object_attr_touch(t_object* x, t_symbol* name) {
  const ApiCall api("object_attr_touch", static_cast<unsigned>(Role::kMain));
  Object* object = require_object(x, "object_attr_touch");
  if (!object || !check_symbol(name, "object_attr_touch"))
    return -1;
  const Attribute* attribute = object->type->attribute(name_of(name));
  if (!attribute) {
    violation("object_attr_touch: " + object->text() + " has no attribute " +
              std::string(name_of(name)));
    return -1;
  }
  // Whoever shows the attribute reads it again at once.
  print_line("shown: " + object->id + " " + attribute->name + " " +
             to_text(get_attribute(*object, *attribute)));
  return 0;
}

t_max_err object_notify(void* x, t_symbol* message, void*) {
  const ApiCall api("object_notify", static_cast<unsigned>(Role::kMain));
  const Object* object = require_object(x, "object_notify");
  if (!object || !check_symbol(message, "object_notify"))
    return -1;
  print_line("notified: " + object->id + " " + std::string(name_of(message)));
  return 0;
}
