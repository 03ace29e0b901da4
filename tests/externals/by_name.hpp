#pragma once

#include "core/object.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

namespace tactus::test {

/// Sets a parameter of an object, as a message of that name does after its range has been checked.
template <class Object> void set(Object& object, std::string_view name, double value) {
  for (const Parameter& row : Object::declaration.parameters)
    if (row.name == name)
      return row.set(&object, value);
  FAIL("no such parameter: " << std::string(name));
}

template <class Object> [[nodiscard]] double get(const Object& object, std::string_view name) {
  for (const Parameter& row : Object::declaration.parameters)
    if (row.name == name)
      return row.get(&object);
  FAIL("no such parameter: " << std::string(name));
  return 0;
}

/// Sends a declared message.
template <class Object>
void send(Object& object, std::string_view name, std::span<const Atom> arguments, Host& host) {
  for (const Message& row : Object::declaration.messages)
    if (row.name == name)
      return row.run(&object, row, arguments, host);
  FAIL("no such message: " << std::string(name));
}
template <class Object>
void send(Object& object, std::string_view name, std::initializer_list<Atom> arguments,
          Host& host) {
  send(object, name, std::span<const Atom>(arguments.begin(), arguments.size()), host);
}

} // namespace tactus::test
