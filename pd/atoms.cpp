#include "pd/atoms.hpp"

#include <string>

namespace tactus::pd {

std::vector<Atom> to_atoms(int count, const t_atom* atoms) {
  std::vector<Atom> result;
  result.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    if (atoms[i].a_type == A_FLOAT)
      result.emplace_back(static_cast<double>(atoms[i].a_w.w_float));
    else if (atoms[i].a_type == A_SYMBOL)
      result.emplace_back(atoms[i].a_w.w_symbol->s_name);
    else
      result.emplace_back("pointer");
  }
  return result;
}

std::vector<t_atom> to_pd_atoms(std::span<const Atom> atoms) {
  std::vector<t_atom> list(atoms.size());
  for (std::size_t i = 0; i < atoms.size(); ++i) {
    if (atoms[i].is_word)
      SETSYMBOL(&list[i], gensym(std::string(atoms[i].word).c_str()));
    else
      SETFLOAT(&list[i], static_cast<t_float>(atoms[i].number));
  }
  return list;
}

} // namespace tactus::pd
