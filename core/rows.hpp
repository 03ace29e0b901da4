#pragma once

#include "core/declaration.hpp"
#include "core/object.hpp"

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

/// Rows of a declaration: a parameter with the member that it sets, a message with the function
/// that carries it out. A struct nested in the object, so that it may name private members:
///
///   struct Drum::Rows {
///     static constexpr std::array parameters{
///         member<&Drum::settings_, &Settings::mass_kg>.row("mass", "kg", 1e-5, 1000, "its mass"),
///         property<&Drum::gain, &Drum::set_gain>.row("gain", "", 5, 0, 1e5, "of the sound"),
///     };
///     static constexpr std::array messages{
///         realtime(action<&Drum::strike>("strike", "v", 1, 1, "strikes with v m/s")),
///     };
///   };
///
/// A parameter's initial value is that of the member in a default-constructed struct; a row of
/// numbers may state another one after the unit. A member may be a number, a switch (bool, 0 or 1)
/// or an enumeration in the order of the row's words.
namespace tactus {
namespace rows {

/// Class and type of a data member or a member function.
template <auto member> struct MemberOf;
template <class Class, class Type, Type Class::*member> struct MemberOf<member> {
  using Owner = Class;
  using Value = Type;
};

template <class Value> constexpr Value value_of(double number) noexcept {
  if constexpr (std::same_as<Value, bool>)
    return number >= 0.5;
  else if constexpr (std::floating_point<Value>)
    return static_cast<Value>(number);
  else
    return static_cast<Value>(static_cast<int>(number));
}

/// Makes rows from an Access, which gets and sets one number of an object. Access has Object,
/// get(object), set(object, number) and, if the initial value is constant, initial().
template <class Access> struct Maker {
  static constexpr Parameter row(std::string_view name, std::string_view unit, double initial,
                                 double lowest, double highest, std::string_view text) {
    return with_access({name, unit, initial, lowest, highest, text});
  }
  static constexpr Parameter row(std::string_view name, std::string_view unit, double lowest,
                                 double highest, std::string_view text) {
    return row(name, unit, Access::initial(), lowest, highest, text);
  }
  /// A row whose value is one of these words.
  static constexpr Parameter row(std::string_view name, std::span<const std::string_view> choices,
                                 std::string_view text, double initial = Access::initial()) {
    Parameter made = row(name, "", initial, 0, static_cast<double>(choices.size() - 1), text);
    made.choices = choices;
    return made;
  }
  /// A row whose value is one of these numbers, in ascending order.
  static constexpr Parameter row(std::string_view name, std::span<const double> values,
                                 std::string_view text) {
    Parameter made = row(name, "", values.front(), values.back(), text);
    made.values = values;
    return made;
  }
  /// A row whose value is a switch.
  static constexpr Parameter row(std::string_view name, std::string_view text,
                                 double initial = Access::initial()) {
    return row(name, "", initial, 0, 1, text);
  }
  /// A row for the parameter `seed`; the text names what it seeds.
  template <Literal text> static constexpr Parameter seed() {
    return with_access(seed_parameter<text>());
  }

  /// A Maker whose rows also call this function of the object after a change of the value.
  template <auto function> static constexpr auto then() { return Maker<Then<function>>(); }
  /// A Maker whose rows set a member in seconds (rad, m, ...) that the user gives in thousandths.
  static constexpr auto milli() { return Maker<Milli>(); }

private:
  template <auto function> struct Then : Access {
    static constexpr void set(typename Access::Object& object, double number) {
      const double before = Access::get(object);
      Access::set(object, number);
      if (Access::get(object) != before)
        (object.*function)();
    }
  };
  struct Milli : Access {
    static constexpr double initial() { return 1e3 * Access::initial(); }
    static constexpr double get(const typename Access::Object& object) {
      return 1e3 * Access::get(object);
    }
    static constexpr void set(typename Access::Object& object, double number) {
      Access::set(object, 1e-3 * number);
    }
  };
  static constexpr Parameter with_access(Parameter made) {
    using Object = typename Access::Object;
    made.set = [](void* object, double number) {
      Access::set(*static_cast<Object*>(object), number);
    };
    made.get = [](const void* object) -> double {
      return Access::get(*static_cast<const Object*>(object));
    };
    made.owner = &kOwner<Object>;
    return made;
  }
};

/// A member, or a member of a member.
template <auto first, auto... rest> struct MemberAccess {
  using Object = typename MemberOf<first>::Owner;
  template <class O> static constexpr auto& of(O& object) {
    if constexpr (sizeof...(rest) == 0)
      return object.*first;
    else
      return MemberAccess<rest...>::of(object.*first);
  }
  static constexpr double get(const Object& object) { return static_cast<double>(of(object)); }
  static constexpr void set(Object& object, double number) {
    auto& member = of(object);
    member = value_of<std::remove_reference_t<decltype(member)>>(number);
  }
  /// The value in the innermost struct, default-constructed.
  static constexpr double initial() {
    if constexpr (sizeof...(rest) == 0)
      return static_cast<double>(Object{}.*first);
    else
      return MemberAccess<rest...>::initial();
  }
};

/// A member of a struct. The object returns the struct by a getter, and a setter is given the whole
/// struct when the number has changed.
template <auto getter, auto setter, auto... path> struct FieldAccess {
  using Object = typename MemberOf<setter>::Owner;
  using Member = MemberAccess<path...>;
  static constexpr double get(const Object& object) { return Member::get((object.*getter)()); }
  static constexpr void set(Object& object, double number) {
    typename Member::Object changed = (object.*getter)();
    const double before = Member::get(changed);
    Member::set(changed, number);
    if (Member::get(changed) != before)
      (object.*setter)(changed);
  }
  static constexpr double initial() { return Member::initial(); }
};

/// A number with a getter and a setter; with a path, those of a member of the object.
template <auto getter, auto setter, auto... path> struct PropertyAccess;
template <auto getter, auto setter> struct PropertyAccess<getter, setter> {
  using Object = typename MemberOf<setter>::Owner;
  static constexpr double get(const Object& object) {
    return static_cast<double>((object.*getter)());
  }
  static constexpr void set(Object& object, double number) { set_by(setter, object, number); }

private:
  template <class Result, class Owner, class Value>
  static constexpr void set_by(Result (Owner::*function)(Value), Object& object, double number) {
    (object.*function)(value_of<std::remove_cvref_t<Value>>(number));
  }
  template <class Result, class Owner, class Value>
  static constexpr void set_by(Result (Owner::*function)(Value) noexcept, Object& object,
                               double number) {
    (object.*function)(value_of<std::remove_cvref_t<Value>>(number));
  }
};
template <auto getter, auto setter, auto first, auto... rest>
struct PropertyAccess<getter, setter, first, rest...> {
  using Object = typename MemberOf<first>::Owner;
  using Inner = PropertyAccess<getter, setter>;
  static constexpr double get(const Object& object) {
    return Inner::get(MemberAccess<first, rest...>::of(object));
  }
  static constexpr void set(Object& object, double number) {
    Inner::set(MemberAccess<first, rest...>::of(object), number);
  }
};

template <auto handler, class Object>
constexpr void carry_out(Object& object, const Message& row, std::span<const Atom> arguments,
                         Host& host) {
  if constexpr (requires { (object.*handler)(row, arguments, host); })
    (object.*handler)(row, arguments, host);
  else if constexpr (requires { (object.*handler)(arguments, host); })
    (object.*handler)(arguments, host);
  else if constexpr (requires { (object.*handler)(host); })
    (object.*handler)(host);
  else if constexpr (requires { (object.*handler)(arguments[0], host); })
    (object.*handler)(arguments[0], host);
  else {
    static_cast<void>(row);
    (object.*handler)();
  }
}

} // namespace rows

template <auto... path> inline constexpr rows::Maker<rows::MemberAccess<path...>> member{};
template <auto getter, auto setter, auto... path>
inline constexpr rows::Maker<rows::FieldAccess<getter, setter, path...>> field{};
template <auto getter, auto setter, auto... path>
inline constexpr rows::Maker<rows::PropertyAccess<getter, setter, path...>> property{};

/// The rows of a struct as rows of an object that returns the struct by a getter, and whose setter
/// is given the whole struct when a number has changed.
template <auto getter, auto setter, const auto& table>
[[nodiscard]] constexpr auto rows_of_field() {
  using Object = typename rows::MemberOf<setter>::Owner;
  constexpr std::size_t count = std::tuple_size_v<std::remove_cvref_t<decltype(table)>>;
  std::array<Parameter, count> made{};
  std::copy(table.begin(), table.end(), made.begin());
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    ((made[i].set =
          [](void* object, double number) {
            auto& self = *static_cast<Object*>(object);
            auto changed = (self.*getter)();
            const double before = table[i].get(&changed);
            table[i].set(&changed, number);
            if (table[i].get(&changed) != before)
              (self.*setter)(changed);
          }),
     ...);
    ((made[i].get = [](const void* object) -> double {
       return table[i].get(&(static_cast<const Object*>(object)->*getter)());
     }),
     ...);
  }
  (std::make_index_sequence<count>());
  for (Parameter& parameter : made)
    parameter.owner = &kOwner<Object>;
  return made;
}

/// Both tables, one after the other.
template <class Row, std::size_t one, std::size_t other>
[[nodiscard]] constexpr std::array<Row, one + other> joined(const std::array<Row, one>& first,
                                                            const std::array<Row, other>& second) {
  std::array<Row, one + other> all{};
  std::copy(first.begin(), first.end(), all.begin());
  std::copy(second.begin(), second.end(), all.begin() + one);
  return all;
}

/// Makes the message call a function of the object or, with more than one pointer, of that member.
/// The function takes (row, arguments, host), (arguments, host), (host), (first argument, host) or
/// nothing.
template <auto first, auto... rest> [[nodiscard]] constexpr Message action(Message message) {
  using Object = typename rows::MemberOf<first>::Owner;
  message.run = [](void* object, const Message& row, std::span<const Atom> arguments, Host& host) {
    auto& self = *static_cast<Object*>(object);
    if constexpr (sizeof...(rest) == 0)
      rows::carry_out<first>(self, row, arguments, host);
    else
      rows::carry_out<rest...>(self.*first, row, arguments, host);
  };
  message.owner = &kOwner<Object>;
  return message;
}
template <auto... path>
[[nodiscard]] constexpr Message action(std::string_view name, std::string_view arguments,
                                       std::size_t min_arguments, std::size_t max_arguments,
                                       std::string_view text) {
  return action<path...>(Message{name, arguments, min_arguments, max_arguments, text});
}

} // namespace tactus
