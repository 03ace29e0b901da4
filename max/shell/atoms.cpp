#include "max/shell/atoms.hpp"

#include <string>

namespace tactus::max {

std::vector<Atom> to_atoms(long count, const t_atom* atoms) {
  std::vector<Atom> result;
  result.reserve(count > 0 ? static_cast<std::size_t>(count) : 0);
  for (long i = 0; i < count; ++i) {
    if (atoms[i].a_type == A_LONG)
      result.emplace_back(static_cast<double>(atoms[i].a_w.w_long));
    else if (atoms[i].a_type == A_FLOAT)
      result.emplace_back(atoms[i].a_w.w_float);
    else if (atoms[i].a_type == A_SYM)
      result.emplace_back(atoms[i].a_w.w_sym->s_name);
    else
      result.emplace_back("object");
  }
  return result;
}

void set_atom(t_atom& to, const Atom& atom) {
  if (atom.is_word)
    atom_setsym(&to, symbol_of(atom.word));
  else
    atom_setfloat(&to, atom.number);
}

std::vector<t_atom> to_max_atoms(std::span<const Atom> atoms) {
  std::vector<t_atom> list(atoms.size());
  for (std::size_t i = 0; i < atoms.size(); ++i)
    set_atom(list[i], atoms[i]);
  return list;
}

t_symbol* symbol_of(std::string_view word) { return gensym(std::string(word).c_str()); }

} // namespace tactus::max
