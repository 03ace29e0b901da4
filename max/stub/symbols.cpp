// Symbols, one for each text, and atoms.
#include "max/stub/kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

namespace tactus::stub {
namespace {
constexpr std::size_t kBuckets = 4096;
std::array<std::atomic<Symbol*>, kBuckets> buckets{};

Symbol* find(Symbol* first, std::string_view name) {
  for (; first; first = first->next)
    if (first->name == name)
      return first;
  return nullptr;
}
std::string number_text(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  std::string result = text.data();
  if (std::isfinite(value) && result.find_first_of(".e") == std::string::npos)
    result += ".0";
  return result;
}
std::string word_text(std::string_view word) {
  if (!word.empty() && word.find_first_of(" \t\"\\\n") == std::string_view::npos)
    return std::string(word);
  std::string text = "\"";
  for (char c : word) {
    if (c == '"' || c == '\\')
      text += '\\';
    text += c;
  }
  return text + '"';
}
} // namespace

Symbol::Symbol(std::string text)
    : Record(kKind), name(std::move(text)), symbol{name.data(), nullptr} {}

t_symbol* symbol(std::string_view name) {
  std::atomic<Symbol*>& bucket = buckets[std::hash<std::string_view>{}(name) % kBuckets];
  Symbol* first = bucket.load(std::memory_order_acquire);
  if (Symbol* found = find(first, name))
    return &found->symbol;
  auto* fresh = new Symbol(std::string(name));
  add_record(&fresh->symbol, fresh);
  fresh->owner = nullptr;
  for (;;) {
    fresh->next = first;
    if (bucket.compare_exchange_weak(first, fresh, std::memory_order_acq_rel))
      return &fresh->symbol;
    if (Symbol* found = find(first, name)) // another thread was first
      return &found->symbol;
  }
}

std::string_view name_of(const t_symbol* s) { return s ? std::string_view(s->s_name) : "(null)"; }

bool check_symbol(const t_symbol* s, const char* function) {
  const Record* record = find_record(s);
  if (record && record->kind == Kind::kSymbol)
    return true;
  violation(std::string(function) + ": a symbol that is not from gensym");
  return false;
}

bool check_atoms(long count, const t_atom* atoms, const char* function) {
  const std::string start = std::string(function) + ": ";
  if (count < 0 || (count > 0 && !atoms)) {
    violation(start + "a wrong count of atoms: " + std::to_string(count));
    return false;
  }
  for (long i = 0; i < count; ++i) {
    const short type = atoms[i].a_type;
    if (type == A_SYM) {
      if (!check_symbol(atoms[i].a_w.w_sym, function))
        return false;
    } else if (type != A_LONG && type != A_FLOAT) {
      violation(start + "an atom of wrong type " + std::to_string(type));
      return false;
    }
  }
  return true;
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
    else
      text += word_text(name_of(a.a_w.w_sym));
  }
  return text;
}

t_atom long_atom(t_atom_long value) {
  t_atom a{};
  a.a_type = A_LONG;
  a.a_w.w_long = value;
  return a;
}
t_atom float_atom(double value) {
  t_atom a{};
  a.a_type = A_FLOAT;
  a.a_w.w_float = value;
  return a;
}
t_atom symbol_atom(std::string_view name) {
  t_atom a{};
  a.a_type = A_SYM;
  a.a_w.w_sym = symbol(name);
  return a;
}

} // namespace tactus::stub

using namespace tactus::stub;

t_symbol* gensym(const char* name) {
  const ApiCall call("gensym");
  if (!name)
    violation("gensym: null instead of a text");
  return symbol(name ? name : "");
}
t_max_err atom_setfloat(t_atom* a, double value) {
  if (!a)
    return -1;
  *a = float_atom(value);
  return 0;
}
t_max_err atom_setsym(t_atom* a, const t_symbol* s) {
  if (!a || !check_symbol(s, "atom_setsym"))
    return -1;
  a->a_type = A_SYM;
  a->a_w.w_sym = const_cast<t_symbol*>(s);
  return 0;
}
namespace {
t_max_err allocate(const char* function, long wanted, long* count, t_atom** atoms,
                   char* allocated) {
  if (wanted < 1 || !count || !atoms || !allocated) {
    violation(std::string(function) + ": null instead of an address, or no atoms");
    return -1;
  }
  *allocated = 0;
  if (*count > 0 && *atoms)
    return 0; // the caller's memory, which is as long as count says
  auto* fresh = new Atoms(static_cast<std::size_t>(wanted));
  add_record(fresh->block.data(), fresh);
  *count = wanted;
  *atoms = reinterpret_cast<t_atom*>(fresh->block.data());
  std::fill_n(*atoms, wanted, t_atom{});
  *allocated = 1;
  return 0;
}
} // namespace

t_max_err atom_alloc(long* count, t_atom** atoms, char* allocated) {
  const ApiCall call("atom_alloc");
  const t_max_err error = allocate("atom_alloc", 1, count, atoms, allocated);
  if (error == 0)
    *count = 1;
  return error;
}
t_max_err atom_alloc_array(long wanted, long* count, t_atom** atoms, char* allocated) {
  const ApiCall call("atom_alloc_array");
  return allocate("atom_alloc_array", wanted, count, atoms, allocated);
}
