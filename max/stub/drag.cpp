// A file that is dragged onto a box: the box is asked, names the message that it wants, and gets
// it.
#include "max/stub/kernel.hpp"

#include <utility>

namespace tactus::stub {
namespace {
/// The drag that a box is asked about. The function that asks has it on its stack.
struct Drag {
  t_object header{};
  Object* receiver;
  std::string message{};
};
constinit Drag* asked = nullptr; // of the main thread alone
} // namespace

bool drop_file(Object& object, std::string_view state, const std::string& file) {
  const std::string name = "acceptsdrag_" + std::string(state);
  const Method* handler = object.type->find(name);
  if (!handler)
    return false;
  Drag drag{.receiver = &object};
  t_atom_long accepted = 0;
  asked = &drag;
  Call call{.where = Where::kMessage, .object = &object, .name = name};
  run_external(call, [&] {
    accepted = as<t_atom_long (*)(void*, t_object*, t_object*)>(handler->function)(
        object.header(), &drag.header, nullptr);
  });
  asked = nullptr;
  if ((accepted != 0) == drag.message.empty())
    violation(name + (accepted ? ": accepts, but names no message by jdrag_object_add"
                               : ": refuses, but named a message by jdrag_object_add"));
  if (accepted == 0 || drag.message.empty())
    return false;
  t_atom word = symbol_atom(file);
  send_message(object, 0, drag.message, {&word, 1});
  return true;
}

} // namespace tactus::stub

using namespace tactus::stub;

void jdrag_object_add(t_object* drag, t_object* receiver, t_symbol* message) {
  const ApiCall api("jdrag_object_add", static_cast<unsigned>(Role::kMain));
  if (!asked || drag != &asked->header) {
    violation("jdrag_object_add: not the drag that the box is asked about");
    return;
  }
  const Object* object = require_object(receiver, "jdrag_object_add");
  if (!object || !check_symbol(message, "jdrag_object_add"))
    return;
  const Method* handler = object->type->find(name_of(message));
  if (!handler)
    handler = object->type->find("anything");
  if (object != asked->receiver)
    violation("jdrag_object_add: for another object than the box that is asked");
  else if (!handler || handler->types == std::vector<short>{A_CANT})
    violation("jdrag_object_add: " + object->text() + " has no message " + message->s_name);
  else
    asked->message = message->s_name;
}
