#pragma once

#include "core/object.hpp"
#include "max/abi/max_abi.h"

#include <span>
#include <string_view>
#include <vector>

/// Converts between Max's atoms and the core's.
namespace tactus::max {

/// Words point to Max's symbols, which live as long as Max.
[[nodiscard]] std::vector<Atom> to_atoms(long count, const t_atom* atoms);
void set_atom(t_atom& to, const Atom& atom);
[[nodiscard]] std::vector<t_atom> to_max_atoms(std::span<const Atom> atoms);

/// As gensym(), for a word that does not end in a zero.
[[nodiscard]] t_symbol* symbol_of(std::string_view word);

/// Max stores every function as one untyped pointer type.
template <class Function> [[nodiscard]] method method_of(Function* function) {
  return reinterpret_cast<method>(reinterpret_cast<void (*)()>(function));
}

} // namespace tactus::max
