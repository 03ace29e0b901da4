#pragma once

#define PD_CLASS_DEF // the functions themselves, not the macros that cast
#include <m_pd.h>

#include "tests/pd/host.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

// What Pd's header leaves open.

struct _class {
  struct Method {
    t_symbol* selector;
    t_method function;
    std::vector<t_atomtype> types;
  };
  t_symbol* name;
  t_method make, drop;
  std::size_t size;
  int main_signal_offset = 0; // without one the left inlet takes no signal
  std::vector<Method> methods{};
  t_method anything = nullptr;

  [[nodiscard]] const Method* method(std::string_view selector) const;
};

struct _inlet {
  t_pd* target;
  t_symbol *from, *to;
  t_float value = 0;
  [[nodiscard]] bool takes_signal() const { return to == gensym("signal"); }
};

struct _outlet {
  t_symbol* type;
  int index;
};

namespace tactus::test {

/// Pd 0.54's signal; its first three members are those of older Pds.
struct HostSignal {
  int length;
  t_sample* samples;
  t_float rate;
  int channels;
  std::vector<t_sample> owned;

  void set_channels(int count);
};

struct HostObject {
  t_pd* pd;
  t_class* type;
  std::vector<std::unique_ptr<t_inlet>> inlets{}; // right of the first
  std::vector<std::unique_ptr<t_outlet>> outlets{};
  std::vector<std::unique_ptr<HostSignal>> signals{}; // of the inlets, then of the outlets
  std::vector<t_int> chain{};
  double rate = 0;
  int frames = 0;

  [[nodiscard]] std::size_t signal_inlets() const;
  [[nodiscard]] std::size_t signal_outlets() const;
};

/// As a function of the type that it is: Pd keeps all as one.
template <class Function> Function* as(t_method method) {
  return reinterpret_cast<Function*>(method);
}
[[noreturn]] void die(const char* why);
[[nodiscard]] HostObject* host_of(const void* pd);
void record_error(const std::string& sentence);
void deliver_queue(); // of the newer host

} // namespace tactus::test
