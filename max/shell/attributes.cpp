#include "max/shell/attributes.hpp"

#include "core/declaration_text.hpp"
#include "max/shell/atoms.hpp"
#include "max/shell/guarded.hpp"
#include "max/shell/max_object.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tactus::max {
namespace {

constexpr std::size_t kMaxParameters = 96;

t_max_err set_parameter(Instance* instance, std::size_t index, long count, const t_atom* atoms) {
  guarded(instance, [&](MaxObject& object) {
    object.message(object.declaration().parameters[index].name, to_atoms(count, atoms));
  });
  return 0; // a refused value has had its error, and the old one stays
}

t_max_err get_parameter(Instance* instance, std::size_t index, long* count, t_atom** atoms) {
  char was_allocated = 0;
  if (const t_max_err failed = atom_alloc(count, atoms, &was_allocated); failed != 0)
    return failed;
  guarded(instance, [&](const MaxObject& object) { set_atom(**atoms, object.parameter(index)); });
  return 0;
}

std::vector<std::size_t> stored_parameters(const Declaration& declaration) {
  std::vector<std::size_t> stored;
  for (std::size_t i = 0; i < declaration.parameters.size(); ++i)
    if (declaration.parameters[i].stored)
      stored.push_back(i);
  return stored;
}

// The value of the whole box, which pattr, autopattr and pattrstorage keep: that of each parameter
// that a host may keep.
t_max_err get_value(Instance* instance, long* count, t_atom** atoms) {
  guarded(instance, [&](const MaxObject& object) {
    const std::vector<std::size_t> stored = stored_parameters(object.declaration());
    const auto size = static_cast<long>(stored.size());
    char was_allocated = 0;
    if (atom_alloc_array(size, count, atoms, &was_allocated) != 0)
      return;
    *count = was_allocated ? size : std::min(*count, size); // not beyond the caller's own memory
    for (long i = 0; i < *count; ++i)
      set_atom((*atoms)[i], object.parameter(stored[static_cast<std::size_t>(i)]));
  });
  return 0;
}
t_max_err set_value(Instance* instance, long count, t_atom* atoms) {
  guarded(instance, [&](MaxObject& object) {
    const std::vector<std::size_t> stored = stored_parameters(object.declaration());
    const std::vector<Atom> values = to_atoms(count, atoms);
    if (values.size() > stored.size())
      throw std::invalid_argument("the stored value has " + std::to_string(values.size()) +
                                  " numbers: expected at most " + std::to_string(stored.size()) +
                                  ", one for each parameter");
    for (std::size_t i = 0; i < values.size(); ++i)
      object.message(object.declaration().parameters[stored[i]].name, {values[i]});
  });
  return 0;
}

// Max tells a setter the attribute as an object of its own, whose name only a variadic function
// would tell: so each parameter has functions of its own.
template <std::size_t index> t_max_err set(Instance* instance, void*, long count, t_atom* atoms) {
  return set_parameter(instance, index, count, atoms);
}
template <std::size_t index> t_max_err get(Instance* instance, void*, long* count, t_atom** atoms) {
  return get_parameter(instance, index, count, atoms);
}
struct Accessors {
  t_max_err (*get)(Instance*, void*, long*, t_atom**);
  t_max_err (*set)(Instance*, void*, long, t_atom*);
};
template <std::size_t... index>
constexpr std::array<Accessors, sizeof...(index)> accessors(std::index_sequence<index...>) {
  return {{{&get<index>, &set<index>}...}};
}
constexpr auto kAccessors = accessors(std::make_index_sequence<kMaxParameters>{});

std::string in_quotes(std::string_view text) { return '"' + std::string(text) + '"'; }

/// What an enumeration shows; empty for an ordinary number.
std::string menu(const Parameter& parameter) {
  std::string words;
  for (const std::string_view choice : parameter.choices)
    words += (words.empty() ? "" : " ") + std::string(choice);
  for (const double value : parameter.values)
    words += (words.empty() ? "" : " ") + number_text(value);
  return words;
}

} // namespace

void add_attributes(t_class* handle, const Declaration& declaration) {
  if (declaration.parameters.size() > kMaxParameters)
    throw std::length_error("more parameters than kMaxParameters");
  if (!stored_parameters(declaration).empty()) {
    class_addmethod(handle, method_of(&get_value), "getvalueof", A_CANT, 0);
    class_addmethod(handle, method_of(&set_value), "setvalueof", A_CANT, 0);
  }
  for (std::size_t i = 0; i < declaration.parameters.size(); ++i) {
    const Parameter& parameter = declaration.parameters[i];
    const std::string name(parameter.name);
    const char* type = parameter.choices.empty() ? "float64" : "symbol";
    class_addattr(handle, attribute_new(name.c_str(), gensym(type), 0, method_of(kAccessors[i].get),
                                        method_of(kAccessors[i].set)));
    const auto describe = [&](const char* what, const char* kind, const std::string& text) {
      class_attr_addattr_parse(handle, name.c_str(), what, gensym(kind), 0, text.c_str());
    };
    describe(
        "label", "symbol",
        in_quotes(parameter.unit.empty() ? name : name + " (" + std::string(parameter.unit) + ")"));
    describe("category", "symbol", "Parameters");
    describe("order", "long", std::to_string(i + 1));
    if (parameter.stored)
      describe("save", "long", "1");
    if (const std::string words = menu(parameter); !words.empty()) {
      describe("style", "symbol", "enum");
      describe("enumvals", "atom", words);
    }
  }
}

} // namespace tactus::max
