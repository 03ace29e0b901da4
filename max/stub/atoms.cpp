// Symbols, one for each text, and atoms.
#include "max/stub/stub.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <mutex>

namespace tactus::stub {
namespace {
std::string number_text(double value) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  std::string result(text.data(), end);
  return std::isfinite(value) && result.find_first_of(".e") == result.npos ? result + ".0" : result;
}
t_atom atom(short type) {
  t_atom a{};
  a.a_type = type;
  return a;
}
} // namespace

t_symbol* symbol(std::string_view name) {
  static std::mutex mutex;
  static auto& symbols = *new std::map<std::string, t_symbol, std::less<>>;
  const std::lock_guard lock(mutex);
  const auto found = symbols.find(name);
  if (found != symbols.end())
    return &found->second;
  const auto added = symbols.emplace(name, t_symbol{}).first;
  added->second.s_name = const_cast<char*>(added->first.c_str());
  return &added->second;
}

std::string to_text(std::span<const t_atom> atoms) {
  std::string text;
  for (const t_atom& a : atoms) {
    if (!text.empty())
      text += ' ';
    if (a.a_type == A_LONG)
      text += std::to_string(a.a_w.w_long);
    else if (a.a_type == A_FLOAT)
      text += number_text(a.a_w.w_float);
    else if (const std::string_view word = a.a_w.w_sym->s_name;
             word.empty() || word.find(' ') != word.npos)
      text.append("\"").append(word).append("\"");
    else
      text += word;
  }
  return text;
}

t_atom long_atom(t_atom_long value) {
  t_atom a = atom(A_LONG);
  a.a_w.w_long = value;
  return a;
}
t_atom float_atom(double value) {
  t_atom a = atom(A_FLOAT);
  a.a_w.w_float = value;
  return a;
}
t_atom symbol_atom(std::string_view name) {
  t_atom a = atom(A_SYM);
  a.a_w.w_sym = symbol(name);
  return a;
}

t_atom to_atom(const std::string& word) {
  using Limits = std::numeric_limits<double>;
  if (word == "#nan" || word == "#inf" || word == "#-inf")
    return float_atom(word == "#nan"   ? Limits::quiet_NaN()
                      : word == "#inf" ? Limits::infinity()
                                       : -Limits::infinity());
  const char *const begin = word.data(), *const end = begin + word.size();
  long long whole = 0;
  if (!word.empty() && std::from_chars(begin, end, whole).ptr == end)
    return long_atom(static_cast<t_atom_long>(whole));
  double value = 0;
  if (word.find_first_not_of("+-.0123456789e") == word.npos && !word.empty() &&
      std::from_chars(begin, end, value).ptr == end)
    return float_atom(value);
  return symbol_atom(word);
}

} // namespace tactus::stub

using namespace tactus::stub;

t_symbol* gensym(const char* name) {
  const ApiCall api("gensym");
  return symbol(name);
}
t_max_err atom_setfloat(t_atom* a, double value) {
  *a = float_atom(value);
  return 0;
}
t_max_err atom_setsym(t_atom* a, const t_symbol* s) {
  *a = symbol_atom(s->s_name);
  return 0;
}
t_max_err atom_alloc(long* count, t_atom** atoms, char* allocated) {
  return atom_alloc_array(1, count, atoms, allocated);
}
/// Uses the caller's memory, of the size in *count, if the caller passes some. Otherwise allocates
/// memory that the caller must free.
t_max_err atom_alloc_array(long wanted, long* count, t_atom** atoms, char* allocated) {
  const ApiCall api("atom_alloc_array");
  *allocated = *atoms ? 0 : 1;
  if (*allocated) {
    *atoms = new t_atom[static_cast<std::size_t>(wanted)]();
    *count = wanted;
  }
  return 0;
}
